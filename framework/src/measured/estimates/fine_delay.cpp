#include "measured/estimates/fine_delay.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace gripline::measured {
namespace {

/// Prefix sums of what was not read.
std::vector<std::size_t> missing_before(std::span<const double> values) {
  std::vector<std::size_t> missing(values.size() + 1, 0);
  for (std::size_t k = 0; k < values.size(); ++k) missing[k + 1] = missing[k] + (std::isnan(values[k]) ? 1 : 0);
  return missing;
}

/// A signal and its integral between samples, linear within a step.
class Integral {
 public:
  Integral(std::span<const double> rate, double dt)
      : rate_(rate), dt_(dt), sum_(rate.size(), 0.0), missing_(missing_before(rate)) {
    for (std::size_t k = 1; k < rate.size(); ++k) {
      const double step = 0.5 * dt * (rate[k] + rate[k - 1]);
      sum_[k] = sum_[k - 1] + (std::isnan(step) ? 0.0 : step);
    }
  }
  /// Whether the rate was read all the way between two times, in steps.
  bool known(double from, double to) const {
    if (!(from >= 0.0) || !(to < static_cast<double>(rate_.size() - 1))) return false;
    return missing_[static_cast<std::size_t>(from)] == missing_[static_cast<std::size_t>(to) + 2];
  }
  double rate(double at) const {
    const auto [k, f] = split(at);
    return std::lerp(rate_[k], rate_[k + 1], f);
  }
  double sum(double at) const {
    const auto [k, f] = split(at);
    return sum_[k] + dt_ * (f * rate_[k] + 0.5 * f * f * (rate_[k + 1] - rate_[k]));
  }

 private:
  static std::pair<std::size_t, double> split(double at) {
    const auto k = static_cast<std::size_t>(at);
    return {k, at - static_cast<double>(k)};
  }
  std::span<const double> rate_;
  double dt_;
  std::vector<double> sum_;
  std::vector<std::size_t> missing_;
};

}  // namespace

std::optional<double> fine_delay(std::span<const double> rate, std::span<const double> sum, double dt, double start) {
  constexpr double window = 0.5;  // [s]
  constexpr std::size_t fewest = 50;
  constexpr int rounds = 3;
  const auto w = static_cast<std::size_t>(std::max(1.0, std::round(window / dt)));
  if (rate.size() < w + 2 || sum.size() < w + 1) return std::nullopt;
  const Integral integral(rate, dt);
  const std::vector<std::size_t> missing = missing_before(sum);
  double delay = start;
  for (int round = 0; round < rounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::size_t count = 0;
    for (std::size_t k = 0; k + w < sum.size(); ++k) {
      const double change = sum[k + w] - sum[k], from = static_cast<double>(k) + delay / dt,
                   to = from + static_cast<double>(w);
      if (missing[k] != missing[k + w + 1] || !integral.known(from, to)) continue;
      const double predicted = integral.sum(to) - integral.sum(from);
      const Eigen::Vector3d by(integral.rate(to) - integral.rate(from), predicted, static_cast<double>(w) * dt);
      normal += by * by.transpose();
      right += (change - predicted) * by;
      ++count;
    }
    if (count < fewest) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix3d> solved(normal);
    const Eigen::Vector3d move = solved.solve(right);
    if (solved.info() != Eigen::Success || !move.allFinite()) return std::nullopt;
    delay += move[0];
  }
  return delay;
}

}  // namespace gripline::measured
