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

/// A gradient in its usual unit: degrees of steering more for each g.
inline double degrees_per_g(double gradient) { return gradient * gravity * 180.0 / std::numbers::pi; }
/// "understeers by 0.52 deg/g" or "oversteers by ...".
std::string cornering_text(double gradient);

/// The understeer gradient: in a steady corner the road wheels turn by L / R + gradient * lateral acceleration (Milliken
/// and Milliken, Race Car Vehicle Dynamics, section 5.3; Gillespie, Fundamentals of Vehicle Dynamics, equation 6-15).
/// Below 0 the car oversteers.
struct SteadyTurning {
  double gradient = 0, low = 0, high = 0;  // with its 95 % interval [rad s2/m]
  std::size_t blocks = 0;                  // stretches of 10 s that it is of, three or more
  struct Corner {
    double vx = 0, omega = 0;  // [m/s], [rad/s], means over a window
  };
  std::vector<Corner> corners;
  /// "understeers by 0.52 deg/g (0.43 to 0.61)", "oversteers by ..." or, where the interval holds 0, "neither surely
  /// understeers nor oversteers (-0.1 to 0.2 deg/g)".
  std::string text() const;
  /// The gradient that a car would show in the same corners whose road wheels turn by `angle` [rad] more than L / R, by
  /// corner. Where tyres are not quite linear, this is what `gradient` is to be compared with.
  double gradient_of(std::span<const double> angle) const;

  std::vector<double> of_ratio, of_gradient;  // by corner: what its angle adds to the two factors below
};

/// How late the yaw-rate channel is on the clock of the steering [s], and how well that is known.
struct Lateness {
  double value = 0, low = 0, high = 0;
};

/// Of all logs together, by least squares over windows of five wheelbases at `v_ref`:
///   delta = ratio (L omega / vx) + slope (vx omega) + a constant of each log + a share of omega',
/// the last of which holds yaw inertia and a part of what is late; gradient = slope / ratio, so that a steering ratio or
/// offset that the log has wrong is none of it. Windows that are far off (the car slides, the log jumps) do not count.
///
/// The interval is by the t distribution of blocks, in which errors may be alike (Liang and Zeger, Biometrika 73, 1986).
/// It holds the lateness's own interval, and standard deviations of 0.05 gradient and 0.025 L / v_ref^2, since corners are
/// not quite steady: simulated cars that weave and brake show their gradients to that.
///
/// Windows count from half of `v_ref` on, below which the gradient hardly moves the steering, and up to 4 m/s2 across.
/// Nothing where steering, speed or turning are not there, or too little is driven so to tell the gradient from the
/// ratio. `wheelbase` [m], `v_ref` [m/s].
///
/// A road that is banked the same way in all corners passes for oversteer, a steering map that bends for either.
std::optional<SteadyTurning> steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                                            const Lateness& yaw_rate = {});

}  // namespace gripline::measured
