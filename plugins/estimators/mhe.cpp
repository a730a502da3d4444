// Tyre parameters by regularised moving-horizon estimation with decaying weights: the adaptation of AD-MPCC.
//
//   F_axle(slip) = load mu sin(C atan(B slip));  p = (log B, C, log mu) of both axles, Cr0 / (m g), Cd v_ref^2 / (m g)
//
//   J(p) = sum_i lambda^i sum_c (r_c(i; p) / sigma_c)^2      i = 0 (newest) .. horizon - 1
//        + sum_j ((p_j - last_j) / change_j)^2               what the estimate may change in one step
//        + sum_j ((p_j - prior_j) / spread_j)^2              what is commonly known of tyres
//
// r_c is the error of predicting vx, vy and the yaw rate one step ahead by the equations of step_path.hpp, whose slips
// are taken once, when the step is new, under the estimate of that time. J is lowered by Gauss-Newton steps from the
// last estimate, each kept within the bounds and halved until J falls; the inverse of its Hessian is the covariance of
// the estimate.
// Source of the scheme: AD-MPCC (arXiv 2607.00141, 2026); of the regularised horizon: Rao, Rawlings, Mayne,
// "Constrained state estimation for nonlinear discrete-time systems", IEEE Trans. Automatic Control 48 (2003).
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <vector>

#include "common/learning/step_path.hpp"
#include "common/learning/tyre_correction.hpp"
#include "common/vehicle/axle_loads.hpp"
#include "common/vehicle/magic_formula.hpp"

namespace {

using namespace gripline;
using namespace gripline::learning;
using vehicle::AxleTyres;

constexpr int unknowns = 8;
using Unknowns = Eigen::Matrix<double, unknowns, 1>;
using Hessian = Eigen::Matrix<double, unknowns, unknowns>;
enum Index { log_B = 0, shape_C = 1, log_mu = 2, per_axle = 3, rolling = 6, drag = 7 };

/// Side force over static load at one slip, with its derivatives by log B, C and log mu.
struct TyreForce {
  double value;
  Eigen::Vector3d slope;
};
TyreForce tyre_force_of(const Unknowns& p, int first, double slip) {
  const double B = std::exp(p[first + log_B]), C = p[first + shape_C], mu = std::exp(p[first + log_mu]);
  const double angle = std::atan(B * slip);
  const double sine = mu * std::sin(C * angle), cosine = mu * std::cos(C * angle);
  return {sine, {cosine * C * B * slip / (1.0 + square(B * slip)), cosine * angle, sine}};
}

/// The sums of J: value, half its gradient, and the Gauss-Newton part of half its Hessian.
struct Cost {
  double value = 0;
  Unknowns gradient = Unknowns::Zero();
  Hessian hessian = Hessian::Zero();

  void add(double residual, const Unknowns& slope, double weight) {
    value += weight * square(residual);
    gradient += weight * residual * slope;
    hessian.noalias() += (weight * slope) * slope.transpose();
  }
};

class MovingHorizon final : public AutoDiffEffect<MovingHorizon, Estimator> {
 public:
  struct Params {
    int horizon = 50, iterations = 2;
    double decay = 0.95;
    double sigma_v = 0.01, sigma_omega = 0.05;
    double change = 0.02;
    double stiffness = 6.0, stiffness_spread = 0.7, shape = 1.4, shape_spread = 0.2;
    double friction = 0, friction_spread = 0.5;
    double ellipse = 0, drive_front = 0, brake_front = 0;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple_cat(
        std::tuple{
            param("horizon", &P::horizon, "1", {1, 1000}, "length of the horizon, back in time [control steps]"),
            param("iterations", &P::iterations, "1", {1, 20}, "Gauss-Newton steps in a control step"),
            param("decay", &P::decay, "1", {0.01, 1}, "weight of a step over that of the step after it"),
            param("sigma_v", &P::sigma_v, "m/s", {1e-6, 10}, "error of vx and vy predicted one step ahead"),
            param("sigma_omega", &P::sigma_omega, "rad/s", {1e-6, 10},
                  "error of the yaw rate predicted one step ahead"),
            param("change", &P::change, "1", {1e-6, 10},
                  "standard deviation of the change of log mu, log B and C in one step"),
            param("stiffness", &P::stiffness, "1/rad", {0.5, 50}, "stiffness factor B of a tyre: median of the prior"),
            param("stiffness_spread", &P::stiffness_spread, "1", {0.01, 2}, "standard deviation of log B"),
            param("shape", &P::shape, "1", {1.05, 2}, "shape factor C of a tyre: mean of the prior"),
            param("shape_spread", &P::shape_spread, "1", {0.001, 1}, "standard deviation of C"),
            param("friction", &P::friction, "1", {0, 5}, "friction that the prior expects; 0: the stack's mu_init"),
            param("friction_spread", &P::friction_spread, "1", {0.01, 2}, "standard deviation of its logarithm")},
        ellipse_parameters<P>());
  }

  MovingHorizon(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        drive_(context),
        terms_{.model_has_tyres = drive_.model_has_tyres(),
               .v_min = car_.v_min,
               .ellipse = {params.ellipse, params.drive_front, params.brake_front}},
        load_(vehicle::static_axle_loads(car_)) {
    const double mu = params.friction > 0 ? params.friction : context.mu_init;
    for (const int first : {0, static_cast<int>(per_axle)}) {
      prior_.segment<per_axle>(first) << std::log(params.stiffness), params.shape, std::log(mu);
      spread_.segment<per_axle>(first) << params.stiffness_spread, params.shape_spread, params.friction_spread;
      change_.segment<per_axle>(first).setConstant(params.change);
    }
    prior_.tail<2>().setZero();
    spread_.tail<2>().setConstant(largest_resistance);
    change_.tail<2>().setConstant(0.1 * params.change);
    steps_.resize(static_cast<std::size_t>(params.horizon));
    start_over();
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < car_.v_min || k.dt <= 0.0) return;
    const auto force = [this](Axle axle, double slip) { return curve(axle).force(slip); };
    const LearnedCar car{car_, drive_, terms_, force};
    steps_[next_] = {step_path(k, car, true), k.dt};
    next_ = (next_ + 1) % steps_.size();
    count_ = std::min(count_ + 1, steps_.size());
    last_ = p_;
    for (int i = 0; i < params_.iterations; ++i) descend();
    read_unknowns();
    if (!p_.allFinite()) start_over();
  }

  Belief belief() const override {
    const double front = tyres_.front.D / load_.front, rear = tyres_.rear.D / load_.rear;
    return {front, rear, front * deviation_[0], rear * deviation_[1]};
  }

  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    const int first = axle == Axle::front ? 0 : static_cast<int>(per_axle);
    const Eigen::Matrix3d covariance = covariance_.block<per_axle, per_axle>(first, first);
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = curve(axle).force(slip[i]);
    for (std::size_t i = 0; i < sigma.size(); ++i) {
      const Eigen::Vector3d slope = tyre_force_of(p_, first, slip[i]).slope;
      sigma[i] = load_.of(axle) * std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
    }
    return true;
  }

  template <class T>
  void act(Point<T>& p) const {
    correct_body(p.q, p.at, terms_, [this](Axle axle, const T& slip) { return curve(axle).force(slip); });
  }

 private:
  static constexpr double largest_resistance = 0.1;  // spread of the prior, of the weight
  static constexpr int halvings = 6;

  struct Step {
    StepPath path;
    double dt = 0;  // [s]
  };

  const vehicle::MagicFormula& curve(Axle axle) const { return axle == Axle::front ? tyres_.front : tyres_.rear; }

  void start_over() {
    p_ = last_ = prior_;
    covariance_ = spread_.array().square().matrix().asDiagonal();
    count_ = next_ = 0;
    read_unknowns();
  }

  static Unknowns bounded(Unknowns p) {
    for (const int first : {0, static_cast<int>(per_axle)}) {
      p[first + log_B] = std::clamp(p[first + log_B], std::log(0.5), std::log(50.0));
      p[first + shape_C] = std::clamp(p[first + shape_C], 1.05, 2.0);
      p[first + log_mu] = std::clamp(p[first + log_mu], std::log(0.02), std::log(5.0));
    }
    return p;
  }

  /// The errors of one step, predicted with p: rates times the length of the step.
  void add_step(const Step& step, const Unknowns& p, double weight, Cost& cost) const {
    const StepPath& path = step.path;
    double front = 0, rear = 0;
    Eigen::Vector3d front_slope = Eigen::Vector3d::Zero(), rear_slope = Eigen::Vector3d::Zero();
    for (int i = 0; i < path_points; ++i) {
      const TyreForce f = tyre_force_of(p, 0, path.slip[i].front), r = tyre_force_of(p, per_axle, path.slip[i].rear);
      const double wf = path_weights[i] * path.load_front * load_.front,
                   wr = path_weights[i] * path.load_rear * load_.rear;
      front += wf * f.value;
      rear += wr * r.value;
      front_slope += wf * f.slope;
      rear_slope += wr * r.slope;
    }
    const double weight_force = car_.m * gravity, speed = path.mean_square_speed() / square(car_.v_ref);
    const auto error = [&](double loss, double by_front, double by_rear, double by_resistance, double scale,
                           double sigma) {
      Unknowns slope = Unknowns::Zero();
      slope.head<per_axle>() = (scale * by_front) * front_slope;
      slope.segment<per_axle>(per_axle) = (scale * by_rear) * rear_slope;
      slope[rolling] = scale * by_resistance * weight_force;
      slope[drag] = slope[rolling] * speed;
      const double resistance = by_resistance * weight_force * (p[rolling] + p[drag] * speed);
      cost.add(scale * (loss + by_front * front + by_rear * rear + resistance), slope, weight / square(sigma));
    };
    error(path.drive_loss, path.sine, 0.0, 1.0, step.dt / car_.m, params_.sigma_v);
    error(path.side, -path.cosine, -1.0, 0.0, step.dt / car_.m, params_.sigma_v);
    error(path.moment, -car_.lf * path.cosine, car_.lr, 0.0, step.dt / car_.Iz, params_.sigma_omega);
  }

  Cost cost_of(const Unknowns& p) const {
    Cost cost;
    double weight = 1.0;
    for (std::size_t i = 0; i < count_; ++i, weight *= params_.decay)
      add_step(steps_[(next_ + steps_.size() - 1 - i) % steps_.size()], p, weight, cost);
    for (int j = 0; j < unknowns; ++j) {
      const Unknowns unit = Unknowns::Unit(j);
      cost.add(p[j] - last_[j], unit, 1.0 / square(change_[j]));
      cost.add(p[j] - prior_[j], unit, 1.0 / square(spread_[j]));
    }
    return cost;
  }

  /// One Gauss-Newton step, halved until the cost falls.
  void descend() {
    const Cost here = cost_of(p_);
    const Eigen::LLT<Hessian> factor(here.hessian);
    // What the window and the prior say: the pull to the last estimate is no evidence.
    Hessian known = here.hessian;
    known.diagonal().array() -= change_.array().square().inverse();
    covariance_ = known.llt().solve(Hessian::Identity());
    const Unknowns step = -factor.solve(here.gradient);
    double length = 1.0;
    for (int i = 0; i < halvings; ++i, length *= 0.5) {
      const Unknowns trial = bounded(p_ + length * step);
      if (cost_of(trial).value > here.value) continue;
      p_ = trial;
      return;
    }
  }

  void read_unknowns() {
    const auto tyre = [this](int first, double load) {
      return vehicle::MagicFormula{std::exp(p_[first + log_B]), p_[first + shape_C],
                                   load * std::exp(p_[first + log_mu])};
    };
    tyres_ = {tyre(0, load_.front), tyre(per_axle, load_.rear)};
    terms_.peaks = {tyres_.front.D, tyres_.rear.D};
    const double weight = car_.m * gravity;
    terms_.resistance = {p_[rolling] * weight, p_[drag] * weight / square(car_.v_ref)};
    for (int axle = 0; axle < 2; ++axle) {
      const int j = axle * per_axle + log_mu;
      deviation_[axle] = std::sqrt(std::max(0.0, covariance_(j, j)));
    }
  }

  Params params_;
  Car car_;
  StraightDrive drive_;
  CorrectionTerms terms_;
  vehicle::AxleLoads load_;  // static [N]
  Unknowns prior_, spread_, change_, p_, last_;
  Hessian covariance_;
  double deviation_[2] = {0, 0};  // of log mu
  AxleTyres tyres_{};
  std::vector<Step> steps_;  // ring, the newest before next_
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<MovingHorizon>("mhe", "1.0",
                                                   "tyre parameters by regularised moving-horizon estimation"))
