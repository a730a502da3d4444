// The readings' noise and how well the equations hold, matched to the innovations e and their variances V.
//
//   sigma   of a reading, grows where e_k^2 > V and shrinks where it is less
//   misfit  of an equation in 20 ms, grows where E_k E_{k-1} > 0.1 V and shrinks where it is less: what the equations
//           leave out lasts, noise does not
//
// E is the sum of the innovations in 20 ms, V that of their variances: steps of 5 ms have four times the noise in their
// rates, in which what lasts would not be seen from one step to the next. Steps of 20 ms and more are taken one by one.
//
// Both begin with the stated values: sigma stays between 0.02 and 10 times that, misfit between it and 100 times it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <gripline/types.hpp>

#include "common/learning/difference_rls.hpp"
#include "common/reference_step.hpp"

namespace gripline::elm_rls {

inline constexpr int channels = 3;                    // vx, vy and the yaw rate: a reading, and its rate's equation
inline constexpr double error_time = reference_step;  // [s] that what an equation leaves out is taken to last at least

class NoiseMatching {
 public:
  /// The stated values, per channel: `sigma` [m/s, m/s, rad/s], `misfit` [m/s2, m/s2, rad/s2].
  struct Stated {
    std::array<double, channels> sigma, misfit;
  };
  explicit NoiseMatching(const Stated& stated) : stated_(stated), sigma_(stated.sigma), misfit_(stated.misfit) {}

  const double* sigma() const { return sigma_.data(); }
  double misfit(int channel) const { return misfit_[channel]; }

  /// Of a step of dt [s].
  void match(int c, const learning::DifferenceRls::Innovation& innovation, double dt) {
    const double ratio = std::min(4.0, square(innovation.error) / innovation.variance);
    const double largest = 10 * stated_.sigma[c];
    sigma_[c] = std::clamp(sigma_[c] * std::exp(0.5 * sigma_gain * (ratio - 1.0)), smallest_sigma * largest, largest);
    Sum& sum = sum_[c];
    sum.error += innovation.error;
    sum.variance += innovation.variance;
    sum.time += dt;
    constexpr double rounding = 1e-9;
    if (sum.time < (1.0 - rounding) * error_time) return;
    const double product = sum.error * last_error_[c] / sum.variance;
    last_error_[c] = sum.error;
    sum = {};
    const double least = stated_.misfit[c];
    misfit_[c] =
        std::clamp(misfit_[c] * std::exp(misfit_gain * (std::clamp(product, -2.0, 2.0) - 0.1)), least, 100 * least);
  }
  /// What comes next does not follow an innovation that was matched: in one channel, in all.
  void break_sequence(int channel) {
    last_error_[channel] = 0;
    sum_[channel] = {};
  }
  void break_sequence() {
    last_error_ = {};
    sum_ = {};
  }
  void start_over() { *this = NoiseMatching(stated_); }

 private:
  static constexpr double sigma_gain = 0.01;      // per step
  static constexpr double misfit_gain = 0.02;     // per error_time
  static constexpr double smallest_sigma = 2e-3;  // of the largest: 0.02 of the stated one

  /// Of the innovations since misfit was last matched.
  struct Sum {
    double error = 0, variance = 0, time = 0;
  };

  Stated stated_;
  std::array<double, channels> sigma_, misfit_;
  std::array<Sum, channels> sum_ = {};
  std::array<double, channels> last_error_ = {};
};

}  // namespace gripline::elm_rls
