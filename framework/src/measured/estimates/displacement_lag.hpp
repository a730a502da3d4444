// How much later the velocity of a car is read than its place, or earlier, by what the place moves while the velocity
// says so. A heavy car changes its speed little within the time of a lag, and differences of its place drown in noise;
// the direction of its velocity turns with every bend, and displacements of half a second are far above the noise.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace gripline::measured {

/// Channels on one even grid, NaN where nothing was read: place [m] and heading [rad], velocity in the car's axes
/// [m/s]. The heading is on time.
struct PlaneMotion {
  std::span<const double> x, y, yaw, vx, vy;
  double dt = 0;  // [s]
};

struct DisplacementLag {
  double seconds = 0;      // positive: the velocity is the later one
  double sigma = 0;        // standard deviation by blocks of at most ten seconds, not yet widened for few of them [s]
  std::size_t blocks = 0;  // there are
  double explained = 0;    // share of the squared displacements that the velocity explains
};

/// The lag with the least squares of
///   place(t + w) - place(t) = (1 + scale) R(turn) integral of velocity + lever (heading(t + w) - heading(t))
/// by the scale of the speeds, the turn of their axes, and where on the car the place is read. Empty where noise
/// says which lag is best, as of a car at nearly one speed, at which such a lever and a lag are the same; where fewer
/// than eight blocks have been read; and where the best lag is as far as they are tried, 1.2 s.
std::optional<DisplacementLag> displacement_lag(const PlaneMotion& motion);

}  // namespace gripline::measured
