// The line of least curvature between the edges of a road: eq. (1) of the paper.
#pragma once

#include <cmath>
#include <gripline/types.hpp>
#include <span>
#include <string>
#include <vector>

#include "geometry/track.hpp"

namespace gripline {

/// One place of a racing line. left and right are the distances [m] from the line to the road's edges.
struct RacingLineSample {
  double s = 0.0;         ///< [m] along the racing line
  double x = 0.0;         ///< [m]
  double y = 0.0;         ///< [m]
  double yaw = 0.0;       ///< [rad] in (-pi, pi]
  double kappa = 0.0;     ///< [1/m] left positive
  double centre_s = 0.0;  ///< [m] station of the centre line
  double n = 0.0;         ///< [m] offset from the centre line, left positive
  double left = 0.0;
  double right = 0.0;
};

struct RacingLine {
  ClosedCurve curve;                      ///< exact line through the optimised points
  std::vector<RacingLineSample> samples;  ///< equally spaced along it
  double squared_curvature = 0.0;         ///< integral of kappa^2 ds [1/m]
  double largest_curvature = 0.0;         ///< max |kappa| over the samples [1/m]
  int iterations = 0;                     ///< quadratic programs solved; 0 if the line was given, not computed

  double length() const { return curve.length(); }
};

struct RacingLineOptions {
  double car_width = 0.0;                        ///< [m] half of it stays inside the edges
  double margin = 0.0;                           ///< [m] further distance to both edges
  double margin_left = 0.0, margin_right = 0.0;  ///< [m] beside that to one of them
  /// [m] of the stations and of the samples; 0 means a sixteenth of the narrowest width, 23 mm on ETHZ
  double spacing = 0.0;
  double max_curvature = 0.0;  ///< [1/m] soft bound; 0 means none
  /// Weight of the line's length beside its squared curvature, relative to the centre line's mean squared curvature. 0
  /// is eq. (1). 0.2 costs 0.3 % of squared curvature on the ETHZ tracks and saves 2 % of length, which is faster.
  double length_weight = 0.0;
  int max_iterations = 60;  ///< quadratic programs
};

/// Minimises the integral of kappa^2 (eq. (1): the sum over equal steps) over offsets n in [-right + car_width/2 +
/// margin, left - car_width/2 - margin], from which margins to one edge are taken. Throws GeometryError if the road is
/// too narrow for that.
RacingLine minimum_curvature_line(const Track& track, const RacingLineOptions& options);

/// Radius of the centre of gravity's path at full lock without slip [m].
inline double least_turning_radius(const Car& car) {
  return std::hypot((car.lf + car.lr) / std::tan(car.delta_max), car.lr);
}

/// One line saying where a car of this width and least turning radius [m] cannot get round the road, and which radius
/// it would need; empty if it can. Judged by its line of least curvature within the edges, which is computed only where
/// the centre line bends more sharply than the car can; up to 5 % more is accepted, because cars slide.
std::string check_car_turns(const Track& track, double car_width, double least_radius);

/// Samples any closed line every `spacing` metres and measures it against the road.
RacingLine describe_line(const Track& track, ClosedCurve curve, double spacing);

}  // namespace gripline
