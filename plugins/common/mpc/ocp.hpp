// The optimal control problem that the model-predictive controllers solve: the paper's, complete.
//
//   minimise  sum_k=1..N  e_k' Q_k e_k + q_yaw (yaw_k - yaw_ref_k)^2 + q_v (vx_k - v_ref_k)^2
//           + terminal weights at k = N
//           + sum_k=0..N-1  r_d (d_k - d_k-1)^2 + r_ddelta (dt ddelta_k)^2 + regularization (d_k^2 + (dt ddelta_k)^2)
//           + sum_k=1..N  slack eps_k^2 + slack_linear eps_k
//   subject to  x_0 as observed, d_-1 the throttle of the step before,   x_k+1 = f(x_k, u_k)
//               d_min <= d_k <= d_max,  |ddelta_k| <= ddelta_max,  delta_min_k <= delta_k <= delta_max_k
//               -right_k + tighten - eps_k <= n_k . (p_k - p_ref_k) <= left_k - tighten + eps_k,   eps_k >= 0
//
// with e_k = p_k - p_ref_k, Q_k = diag(q_x, q_y) + R_k diag(q_lag, q_contour) R_k' (R_k turns to the reference's
// heading) and n_k the reference's normal. The published cost is q_x = q_y = 1, r_d = 5e-3, r_ddelta = 1, everything
// else 0. The printed equation is completed: the slack is summed over k, eps >= 0, norms are squared.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>

#include <gripline/plugin.hpp>

namespace gripline::mpc {

struct OcpParams {
  int horizon = 20;
  double q_x = 1, q_y = 1, q_lag = 0, q_contour = 0, q_yaw = 0, q_v = 0;
  double p_x = 0, p_y = 0, p_yaw = 0, p_v = 0;
  double r_d = 5e-3, r_ddelta = 1, regularization = 1e-6;
  bool track_bounds = true, slope = true;
  double tighten = 0, slack = 1e3, slack_linear = 0;
};

/// The declarations of OcpParams, for a controller's parameters().
constexpr auto ocp_parameters() {
  using P = OcpParams;
  return std::tuple{
      param("horizon", &P::horizon, "1", {1, 500}, "steps N that are looked ahead"),
      param("q_x", &P::q_x, "1/m2", {0, 1e6}, "weight of the position error along the world's x"),
      param("q_y", &P::q_y, "1/m2", {0, 1e6}, "weight of the position error along the world's y"),
      param("q_lag", &P::q_lag, "1/m2", {0, 1e6}, "weight of the position error along the reference"),
      param("q_contour", &P::q_contour, "1/m2", {0, 1e6}, "weight of the position error across the reference"),
      param("q_yaw", &P::q_yaw, "1/rad2", {0, 1e6}, "weight of the heading error"),
      param("q_v", &P::q_v, "s2/m2", {0, 1e6}, "weight of the speed error"),
      param("p_x", &P::p_x, "1/m2", {0, 1e6}, "weight added to q_x at the end of the horizon"),
      param("p_y", &P::p_y, "1/m2", {0, 1e6}, "weight added to q_y at the end of the horizon"),
      param("p_yaw", &P::p_yaw, "1/rad2", {0, 1e6}, "weight added to q_yaw at the end of the horizon"),
      param("p_v", &P::p_v, "s2/m2", {0, 1e6}, "weight added to q_v at the end of the horizon"),
      param("r_d", &P::r_d, "1", {0, 1e6}, "weight of the change of throttle per step"),
      param("r_ddelta", &P::r_ddelta, "1/rad2", {0, 1e6}, "weight of the change of steering per step"),
      param("regularization", &P::regularization, "1", {1e-9, 1}, "small weight of both inputs themselves"),
      param("track_bounds", &P::track_bounds, "1", {0, 1}, "whether the track's edges bound the plan, softly"),
      param("slope", &P::slope, "1", {0, 1}, "whether the prediction sees grade and bank of the road ahead"),
      param("tighten", &P::tighten, "m", {0, 10},
            "metres kept from both edges (a planner's tighten: widths of the car)"),
      param("slack", &P::slack, "1/m2", {1e-6, 1e9}, "weight of the squared excess over an edge"),
      param("slack_linear", &P::slack_linear, "1/m", {0, 1e9}, "weight of the excess over an edge")};
}

/// Cost and constraints of the state at stage k = 1 .. N.
struct OcpStage {
  double x = 0, y = 0, yaw = 0, v = 0;  // reference [m, m, rad, m/s]; yaw unwrapped so that it continues the car's
  double q_xx = 0, q_xy = 0, q_yy = 0;  // Q_k [1/m2]
  double q_yaw = 0, q_v = 0;
  double normal_x = 0, normal_y = 0;      // n_k
  double edge_lower = 0, edge_upper = 0;  // of n_k . p_k [m]; infinite without track bounds
  double delta_min = 0, delta_max = 0;    // [rad]

  /// n_k . p_k of a state [m].
  double across(const double* state) const { return normal_x * state[0] + normal_y * state[1]; }
  /// `sum` plus the tracking cost of a state, term by term.
  double add_tracking_cost(double sum, const double* state) const {
    const double ex = state[0] - x, ey = state[1] - y;
    return sum + q_xx * ex * ex + 2 * q_xy * ex * ey + q_yy * ey * ey + q_yaw * square(state[2] - yaw) +
           q_v * square(state[3] - v);
  }
  /// Derivatives of the tracking cost by x, y, yaw, vx.
  std::array<double, 4> tracking_gradient(const double* state) const {
    const double ex = state[0] - x, ey = state[1] - y;
    return {2 * (q_xx * ex + q_xy * ey), 2 * (q_xy * ex + q_yy * ey), 2 * q_yaw * (state[2] - yaw),
            2 * q_v * (state[3] - v)};
  }
};

/// One instance of the problem. set() fills it; the solvers read it. Nothing is allocated after the first set().
class Ocp {
 public:
  Ocp(const OcpParams& params, const Car& car, double dt)
      : params_(params),
        car_(car),
        dt_(dt),
        stages_(static_cast<std::size_t>(params.horizon) + 1),
        places_(static_cast<std::size_t>(params.horizon)) {}

  /// The problem seen at `now`: `references` are N + 1 points, the first for now.
  void set(const Observation& now, std::span<const RefPoint> references, const Prediction& model) {
    x0_.resize(static_cast<std::size_t>(model.states()));
    model.start(now.x, x0_);
    throttle_before_ = now.d;
    double yaw_near = now.x.yaw;
    for (int k = 0; k <= horizon(); ++k) {
      const RefPoint& r = references[static_cast<std::size_t>(k)];
      if (k < horizon()) {
        Place& at = places_[static_cast<std::size_t>(k)];
        at = r.at;
        if (!params_.slope) at.grade = at.bank = 0.0;
      }
      OcpStage& s = stages_[static_cast<std::size_t>(k)];
      s = stage_for(r, k == horizon());
      s.yaw = yaw_near = yaw_near + std::remainder(r.yaw - r.beta - yaw_near, 2.0 * std::numbers::pi);
      // A steering angle beyond its limit (sensed, or the limit was changed) may return at the steering's rate.
      s.delta_max = std::max(car_.delta_max, std::abs(now.x.delta) - k * dt_ * car_.ddelta_max);
      s.delta_min = -s.delta_max;
    }
  }

  /// Bounds the commanded steering angle to `largest` [rad] beside the course of the front axle as it moves in `x`,
  /// rows of a plan [N+1][states], as far as the steering's rate allows from the present angle on: the slip of the axle
  /// once its wheels stand as commanded. Where the rear axle slips by more than `rear` [rad] there, as in a spin that
  /// begins, the bound on the side that turns the car further in falls with what is too much, to none at twice that
  /// slip and to as much to the other side at three times.
  void bound_front_slip(std::span<const double> x, double largest,
                        double rear = std::numeric_limits<double>::infinity()) {
    const std::size_t n = x0_.size();
    const double reach = dt_ * car_.ddelta_max, spare = 0.05 * reach;  // solvers need an interior
    double low = x0_[6], high = x0_[6];                                // that can be reached within the bounds
    for (int k = 1; k <= horizon(); ++k) {
      const double* row = x.data() + static_cast<std::size_t>(k) * n;
      OcpStage& s = stages_[static_cast<std::size_t>(k)];
      low -= reach;
      high += reach;
      if (row[3] > 2.0 * car_.v_min) {
        const double course = std::atan2(row[4] + car_.lf * row[5], row[3]);
        const double room = std::min(2.0 * spare, s.delta_max - s.delta_min);
        const double slip = std::atan2(car_.lr * row[5] - row[4], row[3]);  // of the rear axle
        const double inward = std::max(largest * std::min(2.0 - std::abs(slip) / rear, 1.0), room - largest);
        const double to_right = slip < 0.0 ? inward : largest, to_left = slip > 0.0 ? inward : largest;
        const double least = std::clamp(course - to_right, s.delta_min, s.delta_max - room);
        const double most = std::clamp(course + to_left, s.delta_min + room, s.delta_max);
        s.delta_min = std::min(least, high - spare);
        s.delta_max = std::max(most, low + spare);
      }
      low = std::max(low, s.delta_min);
      high = std::min(high, s.delta_max);
    }
  }

  int horizon() const { return params_.horizon; }
  int states() const { return static_cast<int>(x0_.size()); }
  double dt() const { return dt_; }
  const OcpParams& params() const { return params_; }
  const Car& car() const { return car_; }
  /// k = 1 .. N.
  const OcpStage& stage(int k) const { return stages_[static_cast<std::size_t>(k)]; }
  /// x_0 [states].
  std::span<const double> start() const { return x0_; }
  std::span<const Place> places() const { return places_; }
  /// The throttle of the control step before, d_-1.
  double throttle_before() const { return throttle_before_; }

  /// Weights of the inputs' squares as the solvers need them: r_ddelta on ddelta itself.
  double weight_ddelta() const { return (params_.r_ddelta + params_.regularization) * dt_ * dt_; }

  /// Cost of a stage's inputs; `d_before` is the throttle of the stage before.
  double input_cost(double d_before, double d, double ddelta) const {
    return params_.r_d * square(d - d_before) + params_.regularization * square(d) + weight_ddelta() * square(ddelta);
  }
  /// Cost of a slack eps >= 0.
  double slack_cost(double eps) const { return (params_.slack * eps + params_.slack_linear) * eps; }
  /// Tracking cost and edge penalty of a state, the slack at its best value.
  double state_cost(const OcpStage& s, const double* x) const {
    const double edge = s.across(x);
    const double eps = std::max({0.0, edge - s.edge_upper, s.edge_lower - edge});
    return s.add_tracking_cost(0.0, x) + slack_cost(eps);
  }
  /// Cost of rows x [N+1][states] and u [N][2], each slack at its best value.
  double cost(std::span<const double> x, std::span<const double> u) const {
    const std::size_t n = x0_.size();
    double total = 0, before = throttle_before_;
    for (std::size_t k = 0; k + 1 < stages_.size(); ++k) {
      total += input_cost(before, u[2 * k], u[2 * k + 1]);
      before = u[2 * k];
      total += state_cost(stages_[k + 1], x.data() + (k + 1) * n);
    }
    return total;
  }

 private:
  OcpStage stage_for(const RefPoint& r, bool last) const {
    const OcpParams& p = params_;
    const double c = std::cos(r.yaw), s = std::sin(r.yaw);
    OcpStage stage;
    stage.x = r.x;
    stage.y = r.y;
    stage.v = r.v;
    stage.q_xx = p.q_x + p.q_lag * c * c + p.q_contour * s * s + (last ? p.p_x : 0.0);
    stage.q_xy = (p.q_lag - p.q_contour) * c * s;
    stage.q_yy = p.q_y + p.q_lag * s * s + p.q_contour * c * c + (last ? p.p_y : 0.0);
    stage.q_yaw = p.q_yaw + (last ? p.p_yaw : 0.0);
    stage.q_v = p.q_v + (last ? p.p_v : 0.0);
    stage.normal_x = -s;
    stage.normal_y = c;
    const double here = -s * r.x + c * r.y;
    const double unbounded = std::numeric_limits<double>::infinity();
    // On a road narrower than both margins the bounds meet in the middle.
    const double middle = 0.5 * (r.left - r.right);
    stage.edge_lower = p.track_bounds ? here + std::min(p.tighten - r.right, middle) : -unbounded;
    stage.edge_upper = p.track_bounds ? here + std::max(r.left - p.tighten, middle) : unbounded;
    return stage;
  }

  OcpParams params_;
  Car car_;
  double dt_;
  double throttle_before_ = 0;
  std::vector<double> x0_;
  std::vector<OcpStage> stages_;
  std::vector<Place> places_;
};

}  // namespace gripline::mpc
