// How a car answers its steering in gentle corners, read off its logs without a model of the car.
#pragma once

#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "measured/session/session.hpp"

namespace gripline::measured {

/// A gradient in its usual unit: degrees of the road wheels more for each g.
inline double degrees_per_g(double gradient) { return gradient * gravity * 180.0 / std::numbers::pi; }
/// "understeers by 0.52 deg/g" or "oversteers by ...".
std::string cornering_text(double gradient);

/// The understeer gradient: in a steady corner the road wheels turn by L / R + gradient * lateral acceleration
/// (Milliken and Milliken, Race Car Vehicle Dynamics, section 5.3; Gillespie, Fundamentals of Vehicle Dynamics,
/// equation 6-15). Below 0 the car oversteers.
struct SteadyTurning {
  double gradient = 0, low = 0, high = 0;  // with its 95 % interval [rad s2/m]
  std::size_t blocks = 0;                  // stretches of 10 s that it is of
  struct Corner {
    double vx = 0, omega = 0;  // [m/s], [rad/s], means over a window
  };
  std::vector<Corner> corners;
  /// "understeers by 0.52 deg/g (0.43 to 0.61)", "oversteers by ..." or, where the interval holds 0, "neither
  /// understeers nor oversteers significantly (-0.1 to 0.2 deg/g)".
  std::string text() const;
  /// The gradient that a car would show in the same corners whose road wheels turn by `angle` [rad] more than L / R, by
  /// corner. Where tyres are not quite linear, this is what `gradient` is to be compared with.
  double gradient_of(std::span<const double> angle) const;

  std::vector<double> of_ratio, of_slope;  // by corner: what its angle adds to `ratio` and `slope` (below)
};

/// How a car turns by its logs, or why they do not show it: a clause such as "speeds in their corners vary too little
/// to separate it ...".
struct TurningByLogs {
  std::optional<SteadyTurning> turning;
  std::string why_not;  // empty where there is one
};

/// How late a channel is on the clock of the steering [s], and how well that is known.
struct Lateness {
  double value = 0, low = 0, high = 0;
};
/// Lateness of the channels that turning is read from; yaw is used where there is no yaw rate.
struct TurningLateness {
  Lateness yaw_rate, yaw;
};

/// The understeer gradient of all logs together, by least squares over windows of five wheelbases at `v_ref`:
///   delta = ratio (L omega / vx) + slope (vx omega) + a constant of each log + a share of omega',
/// the last of which holds yaw inertia and a part of what is late; gradient = slope / ratio, so that a steering ratio
/// or offset that the log has wrong is not part of it. Windows that are far off (the car slides, the log jumps) do not
/// count.
///
/// The interval is Fieller's of the ratio, by the t distribution of as many blocks of 10 s as would be equal to those
/// there are; errors may be alike within a block (Liang and Zeger, Biometrika 73, 1986). It holds what a lateness that
/// is not well known makes, and standard deviations of 0.05 gradient and 0.025 L / v_ref^2, since corners are not quite
/// steady: simulated cars that weave and brake show their gradients to that. Where errors last for longer than some
/// seconds it is too narrow.
///
/// Windows count from half of `v_ref` on, below which the gradient hardly moves the steering, and up to 4 m/s2 across.
/// Nothing, and why, where steering, speed or turning are not there, where less than three such blocks show it, or
/// where the gradient is not separable from the ratio, as at one speed. `wheelbase` [m], `v_ref` [m/s].
///
/// A bank scales the gradient: down where it grows with the lateral acceleration; up, of a car that understeers, where
/// bends are alike. A steering map that bends passes for either sign.
TurningByLogs steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                             const TurningLateness& late = {});

}  // namespace gripline::measured
