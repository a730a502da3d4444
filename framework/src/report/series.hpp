// The time series of one run as the page shows them: chosen, derived and, where there are too many, decimated so that
// nothing visible is lost.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "report/inputs.hpp"

namespace gripline::report {

/// How a channel may be thinned out.
enum class Thinning {
  sample,    ///< smooth (a pose): the value at the row
  extremes,  ///< two rows become their smallest and largest value in the order of occurrence
  any        ///< a flag: set if it was set anywhere in between
};

struct TimeSeries {
  std::string name;
  Thinning thinning = Thinning::extremes;
  std::vector<double> values;
};

/// Keeps about one value in `stride` of every channel. Rows fall into buckets of 2 stride; each gives two values, which
/// all channels share the places of: the first row of the bucket and the one in its middle. The extremes of every
/// bucket survive, so the curve's envelope is the one of the full data at any width of at most values / 2 pixels.
std::vector<double> thin(std::span<const double> values, Thinning thinning, std::size_t stride);

/// What the page knows of the car.
struct CarShape {
  double length = 0, width = 0, lf = 0, lr = 0, m = 0;
};

/// Share of the front axle in the friction of the whole car: its share of the static load.
double front_share(const CarShape& car);

/// Channels of steps.csv, poses and rates as they truly were where the log has them, with what follows from them:
///   mu_belief   of the whole car: both axles weighted by their static loads
///   ax, ay      accelerations of the centre of gravity along and across the car [m/s2]: vx' - vy w, vy' + vx w
///   solve_ms    from timing.csv, if it has a row per step
/// Columns that are absent or empty are left out. The first channel is t.
std::vector<TimeSeries> step_channels(const Run& run, const CarShape& car);

/// Standard deviation of mu_belief at every row of replay.csv, weighted alike: an error of both axles in one direction
/// is taken for granted, as total_sigma of the SDK has it. Empty if the log does not state it.
std::vector<double> mu_sigma(const Run& run, const CarShape& car);

}  // namespace gripline::report
