// Drives towards a point ahead, at the planned speed: for training laps and as a simple reference.
//
//   kappa = 2 sin(eta) / l                rear axle to target: distance l, angle eta off the car's axis
//   delta = atan((lf + lr) kappa) + k_yaw (v kappa - omega)                        the second term for tyres that slip
//   a     = k_p (v_ref - v) + k_i int(v_ref - v) + (v_ref' - v_ref) / dt,   d from the nominal model so that v' = a
//
// Source: Coulter (1992), "Implementation of the pure pursuit path tracking algorithm"; the target is where the
// reference leaves a circle of radius lookahead + lookahead_time v around the rear axle.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gripline/plugin.hpp>

namespace {

using namespace gripline;

class PurePursuit final : public Controller {
 public:
  struct Params {
    int horizon = 40;
    double lookahead = 1.5;
    double lookahead_time = 0.05;
    double k_yaw = 0.04;
    double k_p = 8.0;
    double k_i = 4.0;
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("horizon", &Params::horizon, "1", {2, 500}, "reference points asked for beside the first"),
        param("lookahead", &Params::lookahead, "1", {0.1, 100}, "distance to the target at rest, in wheelbases"),
        param("lookahead_time", &Params::lookahead_time, "s", {0, 10}, "growth of that distance with speed"),
        param("k_yaw", &Params::k_yaw, "s", {0, 10}, "steering per error of yaw rate"),
        param("k_p", &Params::k_p, "1/s", {0, 1e3}, "acceleration per error of speed"),
        param("k_i", &Params::k_i, "1/s2", {0, 1e3}, "acceleration per integrated error of speed")};
  }

  PurePursuit(const PluginContext& context, const Params& params) : car_(context.car), dt_(context.dt), k_(params) {}

  int horizon() const noexcept override { return k_.horizon + 1; }

  Command control(const Observation& now, std::span<const RefPoint> horizon, Prediction& model) override {
    const double delta = std::clamp(steering(now.x, horizon), -car_.delta_max, car_.delta_max);
    Command command;
    command.u.ddelta = std::clamp((delta - now.x.delta) / dt_, -car_.ddelta_max, car_.ddelta_max);
    command.u.d = throttle(now, horizon, model);
    return command;
  }

 private:
  double steering(const State& x, std::span<const RefPoint> horizon) const {
    const double cosine = std::cos(x.yaw), sine = std::sin(x.yaw);
    const double wheelbase = car_.lf + car_.lr;
    const double rear_x = x.x - car_.lr * cosine, rear_y = x.y - car_.lr * sine;
    const double radius = k_.lookahead * wheelbase + k_.lookahead_time * std::max(0.0, x.vx);
    const auto distance = [&](const RefPoint& r) { return std::hypot(r.x - rear_x, r.y - rear_y); };
    std::size_t k = 1;
    while (k + 1 < horizon.size() && distance(horizon[k]) < radius) ++k;
    // Along the last chord to the circle, or beyond the end of a horizon that is too short (a car at rest).
    const RefPoint &p = horizon[k - 1], &q = horizon[k];
    const double near = distance(p), far = distance(q);
    double target_x = q.x, target_y = q.y;
    if (far >= radius && near < radius) {
      const double share = (radius - near) / (far - near);
      target_x = p.x + (q.x - p.x) * share;
      target_y = p.y + (q.y - p.y) * share;
    } else if (far < radius) {
      target_x = q.x + (radius - far) * std::cos(q.yaw);
      target_y = q.y + (radius - far) * std::sin(q.yaw);
    }
    const double along = (target_x - rear_x) * cosine + (target_y - rear_y) * sine;
    const double across = -(target_x - rear_x) * sine + (target_y - rear_y) * cosine;
    const double l2 = along * along + across * across;
    if (along <= 0.0) return across >= 0.0 ? car_.delta_max : -car_.delta_max;  // the target lies behind: turn around
    const double kappa = 2.0 * across / std::max(l2, 1e-12);
    return std::atan(wheelbase * kappa) + k_.k_yaw * (x.vx * kappa - x.omega);
  }

  double throttle(const Observation& now, std::span<const RefPoint> horizon, Prediction& model) {
    const double v = now.x.vx, v_ref = horizon[1].v;
    const double planned = horizon.size() > 2 ? (horizon[2].v - horizon[1].v) / dt_ : 0.0;
    const double error = v_ref - v;
    const double wanted = planned + k_.k_p * error + k_.k_i * integral_;
    // v' is linear in d on either side of zero.
    const auto rate = [&](double d) { return model.rates(now.x, Input{d, 0.0}, now.at).vx; };
    const double free = rate(0.0);
    const double end = wanted >= free ? car_.d_max : car_.d_min;
    const double gain = end != 0.0 ? (rate(end) - free) / end : 0.0;
    double d = gain > 1e-9 ? (wanted - free) / gain : end;
    const bool saturated = !(gain > 1e-9) || d > car_.d_max || d < car_.d_min;
    d = std::clamp(d, car_.d_min, car_.d_max);
    if (!saturated) integral_ += error * dt_;
    return d;
  }

  Car car_;
  double dt_;
  Params k_;
  double integral_ = 0.0;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<PurePursuit>("pure_pursuit", "1.0", "pure pursuit with a speed controller"))
