// Look-back adaptation: a bank of Pacejka tyre models, of which the one is used that predicted the last steps best.
//
//   F_axle(slip) = D sin(C atan(B slip)),  (B, C, D) of every model and axle drawn around a centre
//   error_i(k)  = |(x, y, yaw, vx) predicted by model i for step k - observed|^2,
//   model = argmin of its mean over W steps
//   mu          = mean D of the best ten models over the static load, averaged over 20 steps
//
// `lla_privileged` is as published: the centre is the true tyre, resistance is the true one, and the first W steps
// drive with the true model. `lla` knows neither: its centre is B = 4, C = 1.4, D = mu_init times the static axle load,
// and resistance is what is left of vx' over the last second. Widths as published: B 20 %, C 10 %, D 50 % standard
// deviation.
// Source: AL-Sunni, Almubarak, Horng, Dolan, "LLA-MPC: Fast Adaptive Control for Autonomous Racing" (IROS 2025,
// arXiv 2505.19512).
#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include "common/learning/single_track.hpp"
#include "common/learning/straight_drive.hpp"
#include "common/learning/tyre_correction.hpp"
#include "common/vehicle/magic_formula.hpp"

namespace {

using namespace gripline;
using namespace gripline::learning;
using vehicle::AxleTyres;
using vehicle::MagicFormula;

/// Pose [m, m, rad] and velocities in the car's axes [m/s, m/s, rad/s], or their rates.
struct PlanarState {
  double x, y, yaw, vx, vy, omega;
};
PlanarState advanced(const PlanarState& s, const PlanarState& rate, double h) {
  return {s.x + h * rate.x,   s.y + h * rate.y,   s.yaw + h * rate.yaw,
          s.vx + h * rate.vx, s.vy + h * rate.vy, s.omega + h * rate.omega};
}

/// The magic formula through a curve: its slope at zero and its peak are kept, C is found by search.
template <class F>
MagicFormula through(F&& curve, double peak) {
  const double slope = curve(1e-4) / 1e-4;
  MagicFormula best{slope / (1.3 * peak), 1.3, peak};
  double least = INFINITY;
  for (int step = 0; step <= 10000; ++step) {
    const double C = 1.0 + 1e-4 * step;
    const MagicFormula one{slope / (C * peak), C, peak};
    double error = 0.0;
    for (int i = 1; i < 16; ++i) error += square(one.force(0.05 * i) - curve(0.05 * i));
    if (error < least) least = error, best = one;
  }
  return best;
}

class LookBack : public AutoDiffEffect<LookBack, Estimator> {
 public:
  struct Params {
    int models = 20000, window = 10, best = 10, average = 20;
    double spread_B = 0.2, spread_C = 0.1, spread_D = 0.5;
    double centre_B = 4.0, centre_C = 1.4;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple{param("models", &P::models, "1", {10, 1000000}, "models in the bank"),
                      param("window", &P::window, "1", {1, 1000}, "length of the window [control steps]"),
                      param("best", &P::best, "1", {1, 1000}, "models averaged for the friction"),
                      param("average", &P::average, "1", {1, 1000}, "steps over which the friction is averaged"),
                      param("spread_B", &P::spread_B, "1", {0, 10}, "relative standard deviation of B"),
                      param("spread_C", &P::spread_C, "1", {0, 10}, "relative standard deviation of C"),
                      param("spread_D", &P::spread_D, "1", {0, 10}, "relative standard deviation of D"),
                      param("centre_B", &P::centre_B, "1/rad", {0.1, 100}, "centre of B without ground truth"),
                      param("centre_C", &P::centre_C, "1", {0.5, 3}, "centre of C without ground truth")};
  }

  LookBack(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        drive_(context),
        truth_(context.truth),
        random_(context.seed),
        terms_{.model_has_tyres = drive_.model_has_tyres(), .v_min = car_.v_min} {
    // Not static_axle_loads(): its other order of the factors would change results in the last digits.
    const double weight = car_.m * gravity / (car_.lf + car_.lr);
    load_[0] = weight * car_.lr;
    load_[1] = weight * car_.lf;
    centre_ = truth_ != nullptr ? true_model() : generic_model(context.mu_init);
    if (truth_ != nullptr) learn_true_resistance();
    bank_.reserve(static_cast<std::size_t>(params.models));
    for (int i = 0; i < params.models; ++i) bank_.push_back({draw(centre_.front), draw(centre_.rear)});
    errors_.assign(bank_.size() * static_cast<std::size_t>(params.window), 0.0);
    sums_.assign(bank_.size(), 0.0);
    order_.resize(bank_.size());
    chosen_ = centre_;
    mu_[0] = centre_.front.D / load_[0];
    mu_[1] = centre_.rear.D / load_[1];
    history_.assign(static_cast<std::size_t>(params.average), {mu_[0], mu_[1]});
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < car_.v_min) return;
    const StraightDrive::Rates drive = drive_.at(0.5 * (k.x.vx + k.x_next.vx), k.u.d - k.d_lag, k.at);
    double* const errors = errors_.data() + static_cast<std::size_t>(seen_ % params_.window) * bank_.size();
    for (std::size_t i = 0; i < bank_.size(); ++i) {
      const double error = error_of(bank_[i], k, drive);
      sums_[i] += error - errors[i];
      errors[i] = error;
    }
    ++seen_;
    if (truth_ == nullptr) learn_resistance(k, drive);
    if (seen_ <= params_.window) return;
    choose();
  }

  Belief belief() const override { return {mu_[0], mu_[1]}; }

  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    const MagicFormula& tyre = axle == Axle::front ? chosen_.front : chosen_.rear;
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = tyre.force(slip[i]);
    std::fill(sigma.begin(), sigma.end(), 0.0);
    return true;
  }

  template <class T>
  void act(Point<T>& p) const {
    correct_body(p.q, p.at, terms_, [this](Axle axle, const T& slip) {
      return axle == Axle::front ? chosen_.front.force(slip) : chosen_.rear.force(slip);
    });
  }

 private:
  double normal() {
    const double u = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
    const double v = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
  }
  /// A model drawn around a centre, each number kept within a tenth and ten times it.
  MagicFormula draw(const MagicFormula& c) {
    const auto one = [&](double centre, double spread) {
      return std::clamp(centre * (1.0 + spread * normal()), 0.1 * centre, 10.0 * centre);
    };
    const double B = one(c.B, params_.spread_B), C = one(c.C, params_.spread_C), D = one(c.D, params_.spread_D);
    return {B, C, D};
  }
  AxleTyres generic_model(double mu) const {
    return {{params_.centre_B, params_.centre_C, mu * load_[0]}, {params_.centre_B, params_.centre_C, mu * load_[1]}};
  }
  AxleTyres true_model() const {
    const auto curve = [this](Axle axle) {
      return [this, axle](double slip) { return truth_->tyre_force(axle, slip); };
    };
    return {through(curve(Axle::front), truth_->mu(Axle::front) * load_[0]),
            through(curve(Axle::rear), truth_->mu(Axle::rear) * load_[1])};
  }
  /// What the nominal model lacks of the true resistance: both cars rolling straight without drive, at two speeds.
  void learn_true_resistance() {
    const auto missing = [this](double v) {
      Quantities<double> q{};
      q.vx = v;
      const Place at;
      Points<double> points;
      points.n = 1;
      points.q = &q;
      points.at = &at;
      return truth_->accelerations(points) ? -car_.m * (q.ax - drive_.at(v, 0.0, at).forward) : 0.0;
    };
    const double slow = missing(0.5 * car_.v_ref), fast = missing(car_.v_ref);
    terms_.resistance.Cd = (fast - slow) / (0.75 * square(car_.v_ref));
    terms_.resistance.Cr0 = fast - terms_.resistance.Cd * square(car_.v_ref);
  }

  PlanarState rates(const AxleTyres& tyres, const PlanarState& s, const StraightDrive::Rates& drive,
                    double delta) const {
    const BodyVelocity body = {s.vx, s.vy, s.omega};
    const Slips slip = slips(body, delta, car_);
    const double resistance = terms_.resistance.Cr0 + terms_.resistance.Cd * square(s.vx);
    const AxleForces forces = {drive.load_front * tyres.front.force(slip.front),
                               drive.load_rear * tyres.rear.force(slip.rear)};
    const BodyVelocity rate = body_rates(body, delta, drive.forward, drive.side, forces, resistance, car_);
    const double cosine = std::cos(s.yaw), sine = std::sin(s.yaw);
    return {s.vx * cosine - s.vy * sine, s.vx * sine + s.vy * cosine, s.omega, rate.vx, rate.vy, rate.omega};
  }

  /// One step of the classical Runge-Kutta method; drive, bank and axle loads are those at the mean speed, the
  /// steering angle is what the nominal model says acts in the middle.
  PlanarState predict(const AxleTyres& tyres, const Sample& k, const StraightDrive::Rates& drive) const {
    const PlanarState s = {k.x.x, k.x.y, k.x.yaw, k.x.vx, k.x.vy, k.x.omega};
    const double delta = k.x_next.delta - k.delta_lag;
    return runge_kutta_step(s, k.dt, [&](const PlanarState& at) { return rates(tyres, at, drive, delta); });
  }

  double error_of(const AxleTyres& tyres, const Sample& k, const StraightDrive::Rates& drive) const {
    const PlanarState p = predict(tyres, k, drive);
    return square(p.x - k.x_next.x) + square(p.y - k.x_next.y) + square(p.yaw - k.x_next.yaw) +
           square(p.vx - k.x_next.vx);
  }

  /// What the chosen model leaves of vx', as a constant resistance, with the memory of a second.
  void learn_resistance(const Sample& k, const StraightDrive::Rates& drive) {
    const double missing = (predict(chosen_, k, drive).vx - k.x_next.vx) / k.dt;
    terms_.resistance.Cr0 = std::max(0.0, terms_.resistance.Cr0 + std::min(1.0, k.dt) * car_.m * missing);
  }

  void choose() {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    const auto count = std::min<std::size_t>(static_cast<std::size_t>(params_.best), order_.size());
    std::partial_sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count), order_.end(),
                      [this](std::size_t a, std::size_t b) { return sums_[a] < sums_[b]; });
    chosen_ = bank_[order_[0]];
    double front = 0.0, rear = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      front += bank_[order_[i]].front.D / static_cast<double>(count);
      rear += bank_[order_[i]].rear.D / static_cast<double>(count);
    }
    history_[static_cast<std::size_t>(seen_ % params_.average)] = {front / load_[0], rear / load_[1]};
    mu_[0] = mu_[1] = 0.0;
    for (const auto& [front_mu, rear_mu] : history_) {
      mu_[0] += front_mu / static_cast<double>(history_.size());
      mu_[1] += rear_mu / static_cast<double>(history_.size());
    }
  }

  Params params_;
  Car car_;
  StraightDrive drive_;
  const Truth* truth_;
  std::mt19937_64 random_;
  CorrectionTerms terms_;    // no friction ellipse
  double load_[2] = {0, 0};  // static, front and rear [N]
  AxleTyres centre_{}, chosen_{};
  std::vector<AxleTyres> bank_;
  std::vector<double> errors_, sums_;               // window x models; sums over the window
  std::vector<std::size_t> order_;                  // of the models, those with the least errors first
  std::vector<std::pair<double, double>> history_;  // of mu, front and rear: a ring of the steps averaged
  double mu_[2] = {1, 1};
  std::int64_t seen_ = 0;
};

/// Refuses to run without the truth, where it would be `lla`.
class PrivilegedLookBack final : public LookBack {
 public:
  PrivilegedLookBack(const PluginContext& context, const Params& params) : LookBack(context, params) {
    if (context.truth == nullptr)
      throw std::runtime_error("lla_privileged needs the truth of a world; there is none here");
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<LookBack>("lla", "1.0", "look-back adaptation over a bank of tyre models"),
                 gripline::describe<PrivilegedLookBack>(
                     "lla_privileged", "1.0", "look-back adaptation, its bank centred on the true tyres, as published")
                     .needs_truth())
