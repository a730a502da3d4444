#include "calibrate/fit/handling.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "car/instant.hpp"

namespace gripline::calibrate {
namespace {

/// One car at one instant on a flat road, its effects' memories steady.
class OneInstant {
 public:
  OneInstant(const OneInstant&) = delete;  // it points into itself
  OneInstant(const StagedCar& car, std::span<const double> params)
      : car_(car), memory_(static_cast<std::size_t>(car.memory())), memory_rate_(memory_.size()) {
    batch_.n = 1;
    batch_.motion = motion_.data();
    batch_.command = &command_;
    batch_.memory = memory_.data();
    batch_.memory_rate = memory_rate_.data();
    batch_.motion_rate = rate_.data();
    batch_.at = &at_;
    batch_.params = params.data();
    batch_.history = &past_;
  }
  void set(double vx, double vy, double omega, double delta) {
    motion_ = {0, 0, 0, vx, vy, omega};
    command_ = {0, delta, 0};
    given_ = {0, delta};
    if (!memory_.empty()) car_.start_memory(batch_, memory_.data());
  }
  Quantities<double> quantities() const {
    Quantities<double> q{};
    car_.quantities(batch_, &q);
    return q;
  }
  /// Rates of vy and omega.
  std::array<double, 2> turning() {
    car_.rates(batch_);
    return {rate_[4], rate_[5]};
  }

 private:
  const StagedCar& car_;
  std::array<double, motion_size> motion_{}, rate_{};
  ActingCommand<double> command_{};
  CommandSample<double> given_{};
  History<double> past_ = always(given_);
  Place at_;
  std::vector<double> memory_, memory_rate_;
  CarBatch<double> batch_;
};

/// Front less rear slip angle in a steady corner at this speed and yaw rate; none where no steering keeps the car
/// there.
std::optional<double> slip_difference(OneInstant& car, double vx, double omega) {
  constexpr int most_steps = 20;
  constexpr double nudge = 1e-6, still = 1e-9;  // [m/s and rad; m/s2 and rad/s2]
  car.set(vx, 0.0, omega, 0.0);
  const Quantities<double> axles = car.quantities();
  double vy = omega * axles.lr, delta = omega * (axles.lf + axles.lr) / vx;  // where no tyre slips
  for (int step = 0; step < most_steps; ++step) {
    car.set(vx, vy, omega, delta);
    const auto here = car.turning();
    if (!std::isfinite(here[0]) || !std::isfinite(here[1])) return std::nullopt;
    if (std::abs(here[0]) < still && std::abs(here[1]) < still) {
      const Quantities<double> q = car.quantities();
      return q.slip_front - q.slip_rear;
    }
    car.set(vx, vy + nudge, omega, delta);
    const auto by_vy = car.turning();
    car.set(vx, vy, omega, delta + nudge);
    const auto by_delta = car.turning();
    const double a = (by_vy[0] - here[0]) / nudge, b = (by_delta[0] - here[0]) / nudge;
    const double c = (by_vy[1] - here[1]) / nudge, d = (by_delta[1] - here[1]) / nudge;
    const double determinant = a * d - b * c;
    if (!(std::abs(determinant) > 0.0)) return std::nullopt;
    vy -= (d * here[0] - b * here[1]) / determinant;
    delta -= (a * here[1] - c * here[0]) / determinant;
  }
  return std::nullopt;
}

/// Widens [low, high] by the middle 95 % of `values`.
void widen(std::vector<double> values, double& low, double& high) {
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  low = std::min(low, values[values.size() / 40]);
  high = std::max(high, values[values.size() - 1 - values.size() / 40]);
}

/// Friction of the front and the rear axle, and of both together.
std::array<double, 3> mu_of(const StagedCar& car, double vx, std::span<const double> params) {
  OneInstant instant(car, params);
  instant.set(vx, 0, 0, 0);
  const Quantities<double> q = instant.quantities();
  const double weight = q.m * gravity, length = q.lf + q.lr;
  return {q.peak_front / (weight * q.lr / length), q.peak_rear / (weight * q.lf / length),
          (q.peak_front + q.peak_rear) / weight};
}

}  // namespace

Friction friction_of(const StagedCar& car, const Car& constants, std::span<const double> params,
                     std::span<const std::vector<double>> bootstrap_draws,
                     std::span<const std::vector<double>> posterior_draws) {
  Friction friction;
  const auto mu = mu_of(car, constants.v_ref, params);
  friction.known = std::isfinite(mu[2]) && mu[2] > 0.0;
  if (!friction.known) return friction;
  friction.front = mu[0], friction.rear = mu[1], friction.total = mu[2];
  friction.total_low = friction.total_high = mu[2];
  for (const auto& set : {bootstrap_draws, posterior_draws}) {
    std::vector<double> totals;
    for (const auto& p : set) totals.push_back(mu_of(car, constants.v_ref, p)[2]);
    widen(std::move(totals), friction.total_low, friction.total_high);
  }
  return friction;
}

std::optional<double> understeer_angle(const StagedCar& car, std::span<const double> params, double vx, double omega) {
  if (!(mu_of(car, vx, params)[2] > 0.0)) return std::nullopt;
  OneInstant instant(car, params);
  return slip_difference(instant, vx, omega);
}

std::optional<double> gradient_in(const measured::SteadyTurning& logs, const StagedCar& car,
                                  std::span<const double> params) {
  std::vector<double> angles;
  for (const measured::SteadyTurning::Corner& corner : logs.corners) {
    const auto angle = understeer_angle(car, params, corner.vx, corner.omega);
    if (!angle) return std::nullopt;
    angles.push_back(*angle);
  }
  return logs.gradient_of(angles);
}

std::string corners_text(const measured::SteadyTurning& logs, const std::optional<double>& given) {
  std::string text = "In gentle corners the car " + logs.text();
  if (!given) return text + ".";
  const bool agrees = *given >= logs.low && *given <= logs.high;
  text += agrees ? "; the world given agrees, it " : "; the world given does not agree, it ";
  return text + measured::cornering_text(*given) + ".";
}

std::string no_understeer_text(const std::string& why_not) {
  return "understeer: not determined by these logs; " + why_not;
}

}  // namespace gripline::calibrate
