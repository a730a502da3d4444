// The fastest speed along a given closed line: corners first, then what drive and brakes can connect.
//
//   v_i <= v_corner(kappa_i)                     tyres and steering in a steady turn
//   d(v^2)/ds <= 2 a_drive,  >= -2 a_brake       with (a_x / (mu g))^2 + (a_y / (mu g))^2 <= 1 for the tyres
//
// Kalaria, Lin, Dolan take one profile times sqrt(mu); here every mu has its own, since drive, brakes and steering do
// not scale with friction. Forward and backward passes as in Velenis, Tsiotras (2005), "Optimal velocity profile
// generation for given acceleration limits".
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/planning/car_limits.hpp"
#include "common/planning/closed_line.hpp"
#include "common/planning/planned_friction.hpp"

namespace gripline::planning {

struct ProfileOptions {
  double B = 3.0, C = 1.3;  // shape of the generic tyre
  double combined = 1.0;    // share of the drive and brake force that counts in the friction circle
};

/// Speeds [m/s] at the samples of the line, as fast as the limits allow at this friction.
inline std::vector<double> speed_profile(const ClosedLine& line, const DriveLimits& limits, const CornerLimits& corner,
                                         double mu, double combined) {
  const std::size_t n = line.size();
  const double ds = line.spacing(), lateral_limit = corner.lateral_limit(mu);
  std::vector<double> v(n);
  for (std::size_t i = 0; i < n; ++i) v[i] = corner.speed(mu, line.samples()[i].kappa, line.samples()[i].bank);

  // Longitudinal force left to the tyres beside their lateral one.
  const auto left_over = [&](double speed, const LinePoint& p) {
    if (combined <= 0.0) return std::numeric_limits<double>::infinity();
    const double lateral = (speed * speed * p.kappa - gravity * std::sin(p.bank)) / lateral_limit;
    return lateral_limit * std::sqrt(std::max(0.0, 1.0 - lateral * lateral)) / combined;
  };
  const auto passive = [&](double speed, const LinePoint& p) {
    return limits.coast(speed) - corner.drag(mu, speed, p.kappa, p.bank) - gravity * std::sin(p.grade);
  };
  // Two rounds each way: the slowest corner, whose speed stays as it is, is met in the first, so that every speed is
  // final after the second.
  for (std::size_t k = 0; k < 2 * n; ++k) {
    const std::size_t i = k % n, j = (k + 1) % n;
    const LinePoint& p = line.samples()[i];
    const double a = passive(v[i], p) + std::min(limits.drive(v[i]), left_over(v[i], p));
    v[j] = std::min(v[j], std::sqrt(std::max(1e-6, v[i] * v[i] + 2.0 * a * ds)));
  }
  for (std::size_t k = 2 * n; k > 0; --k) {
    const std::size_t i = k % n, j = (k - 1) % n;
    const LinePoint& p = line.samples()[i];
    const double a = std::min(limits.brake(v[i]), left_over(v[i], p)) - passive(v[i], p);
    v[j] = std::min(v[j], std::sqrt(std::max(1e-6, v[i] * v[i] + 2.0 * a * ds)));
  }
  return v;
}

/// Profiles over a grid of mu, interpolated linearly. Above the grid its end holds; below it the first profile is
/// driven more slowly (speed_share).
class ProfileLibrary {
 public:
  ProfileLibrary(const ClosedLine& line, const Car& car, const DriveLimits& limits, const ProfileOptions& options,
                 std::span<const double> mus)
      : mus_(mus.begin(), mus.end()) {
    const CornerLimits corner(car, equal_friction(1.0, car, options.B, options.C), limits.top_speed());
    for (const double mu : mus_) profiles_.push_back(speed_profile(line, limits, corner, mu, options.combined));
  }

  std::span<const double> profile(std::size_t i) const { return profiles_[i]; }

  /// The profiles on either side of a friction, and the share of their speeds that it allows.
  struct AtFriction {
    Bracket profiles;
    double share = 1;
  };
  AtFriction select(double mu) const {
    if (mus_.size() == 1 || !(mu > mus_.front())) return {{0, 0, 0.0}, speed_share(mu, mus_.front())};
    if (mu >= mus_.back()) return {{mus_.size() - 1, mus_.size() - 1, 0.0}};
    const auto above = static_cast<std::size_t>(std::upper_bound(mus_.begin(), mus_.end(), mu) - mus_.begin());
    return {{above - 1, above, (mu - mus_[above - 1]) / (mus_[above] - mus_[above - 1])}};
  }
  double speed(const AtFriction& mu, const Bracket& place) const {
    const auto along = [&](std::size_t i) {
      const std::vector<double>& v = profiles_[i];
      return v[place.first] + (v[place.second] - v[place.first]) * place.weight;
    };
    const auto& [first, second, weight] = mu.profiles;
    const double v = along(first);
    return mu.share * (weight > 0.0 ? v + (along(second) - v) * weight : v);
  }

 private:
  std::vector<double> mus_;
  std::vector<std::vector<double>> profiles_;
};

}  // namespace gripline::planning
