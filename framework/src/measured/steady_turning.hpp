// How a car answers its steering in gentle corners, read off its logs: no model of a car has a say in it.
#pragma once

#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "measured/session.hpp"

namespace gripline::measured {

/// delta = ratio L omega / vx + gradient vx omega + a constant of each log + a share of omega', which holds what is late
/// (Milliken and Milliken, Race Car Vehicle Dynamics, section 5.3; Gillespie, Fundamentals of Vehicle Dynamics, equation
/// 6-15).
struct SteadyTurning {
  double gradient = 0, low = 0, high = 0;  // understeer gradient with its 95 % interval [rad s2/m]; below 0: oversteer
  double ratio = 0;                        // steering as the log has it over what the road wheels turn by
  std::size_t stretches = 0;               // of 10 s, three or more
  struct Corner {
    double vx = 0, omega = 0;  // [m/s], [rad/s], means over a window
  };
  std::vector<Corner> corners;      // what it is of
  std::vector<double> of_gradient;  // by corner: what its steering adds to `gradient` [s2/m]
  /// "understeers by 0.52 deg/g (0.43 to 0.61)", "oversteers by ..." or, where the interval holds 0, "neither surely
  /// understeers nor oversteers (-0.1 to 0.2 deg/g)".
  std::string text() const;
  /// The gradient that a car would show in the same corners whose road wheels turn by `angle` [rad] more than L / R, by
  /// corner: to be compared with `gradient` where tyres are not quite linear.
  double gradient_of(std::span<const double> angle) const;
};

/// A gradient in its usual unit: degrees of steering more for each g.
inline double degrees_per_g(double gradient) { return gradient * gravity * 180.0 / std::numbers::pi; }

/// Of all logs together, by least squares over windows of five wheelbases at `v_ref`, without those far off (the car
/// slides, the log jumps). The interval holds for errors that are alike within 10 s, is by the t distribution, and has a
/// twentieth of the gradient for corners that are not quite steady.
/// Windows count from half of `v_ref` on, below which the gradient hardly moves the steering, and up to 4 m/s2 across,
/// where tyres are linear. Nothing where a log's steering, speed or turning is not there, or too little of it is driven
/// so. `wheelbase` [m], `v_ref` [m/s]; `yaw_rate_late`: by how much the yaw-rate channel is [s].
///
/// A road that is banked the same way in all corners passes for oversteer, and a steering map that bends for either.
std::optional<SteadyTurning> steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                                            double yaw_rate_late);

}  // namespace gripline::measured
