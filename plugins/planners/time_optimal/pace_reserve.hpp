// The share of a planned speed that is driven.
//
//   pace' = b (1 - r (1 - pace + pace_fall v)),   r = kept + (1 - kept) min(1, fall(mu) / fall(friction))
//   fall(mu) = E[max(0, mu - M)] / mu,   M ~ N(friction, spread^2)
//
// What is kept back of a speed is for friction that falls at once, which shows only when the car has begun to run wide.
// The longer a car needs to slow down to what it then can, the wider it runs meanwhile, and that time grows with speed.
// The less friction is believed, the less is left to lose; until it is trusted, r is 1. Laps are solved for mu_lo at
// least: where less is believed, b = sqrt(mu / mu_lo) of their speeds is driven, mu the least friction since which it
// could have risen no further; else b is 1, also where less than mu_lo is planned for to be sure of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/planning/planned_friction.hpp"
#include "planners/time_optimal/lap_parameters.hpp"

namespace gripline::time_optimal {

class PaceReserve {
 public:
  /// `top`: largest speed that is planned [m/s]. Throws where driven speeds would not rise with planned ones, or with
  /// the friction that they are planned for, whose root they follow.
  PaceReserve(const LapParams& params, double top) : k_(params) { check(top); }

  /// Frictions that may be below those that laps are solved for.
  struct Low {
    double driven;  // rises as slowly as what is planned for
    double there;   // that is believed
  };
  /// What is planned for, what is less than that, and whether it is trusted.
  void set(double mu, const Low& low, bool trusted) {
    reserve_ = trusted ? at(mu) : 1.0;
    below_ = planning::speed_share(low.driven, k_.mu_lo);
    rising_ = below_ / planning::speed_share(low.there, k_.mu_lo);
  }
  /// The share of a planned speed [m/s] that is driven.
  double pace(double v) const { return below_ * with(reserve_, v); }
  /// Of the friction that there is, the square of this is used: the car drives below its limit by what it keeps back,
  /// and where friction has risen faster than what is driven.
  double use_of_friction(double v) const { return rising_ * with(reserve_, v); }

 private:
  /// Mean of the fall from mu to a friction drawn from N(pace_friction, pace_spread^2), over mu; rises are none.
  double mean_fall(double mu) const {
    const double z = (mu - k_.pace_friction) / k_.pace_spread;
    const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    return k_.pace_spread * (density + z * below) / mu;
  }
  /// What is kept back of speeds at this friction over what is at pace_friction.
  double at(double mu) const {
    const double fall = mean_fall(std::max(mu, k_.mu_lo)) / mean_fall(k_.pace_friction);
    return k_.pace_kept + (1.0 - k_.pace_kept) * std::min(1.0, fall);
  }
  double with(double reserve, double v) const { return 1.0 - reserve * (1.0 - k_.pace + k_.pace_fall * v); }
  void check(double top) const {
    if (2.0 * k_.pace_fall * top > k_.pace)
      throw std::invalid_argument(
          "\"pace_fall\" is so large that faster plans would be driven more slowly: at most pace / (2 v) "
          "at the largest speed v, here " +
          std::to_string(0.5 * k_.pace / top) + " s/m");
    constexpr int count = 200;
    double last = 0;
    for (int i = 0; i <= count; ++i) {
      const double mu = std::lerp(k_.mu_lo, std::max(k_.mu_lo, k_.mu_hi), static_cast<double>(i) / count);
      const double driven = std::sqrt(mu) * with(at(mu), top);
      if (driven < last)
        throw std::invalid_argument("\"pace_kept\" is so small that less friction would be driven faster, at " +
                                    std::to_string(mu) + ": larger, or a larger \"pace_spread\" or \"pace\"");
      last = driven;
    }
  }

  LapParams k_;
  double reserve_ = 1;
  double below_ = 1;   // share of a lap's speed that is driven at less friction than it is solved for
  double rising_ = 1;  // that share over what friction would allow now
};

}  // namespace gripline::time_optimal
