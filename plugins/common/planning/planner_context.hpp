// What planners ask of their context, a car's own limits that their lines respect, and frictions that are planned for.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <gripline/interfaces.hpp>

namespace gripline::planning {

/// The road. Throws std::invalid_argument when there is none.
inline const Course& course_of(const PluginContext& context) {
  if (context.course == nullptr) throw std::invalid_argument("a planner needs a course");
  return *context.course;
}

/// The stack's nominal model. Throws std::invalid_argument when there is none.
inline Prediction& nominal_of(const PluginContext& context) {
  if (context.nominal == nullptr) throw std::invalid_argument("a speed planner needs the stack's nominal model");
  return *context.nominal;
}

/// The soft bound of a line's curvature: 0.8 of what the car can steer without slip [1/m].
inline double drivable_curvature(const Car& car) { return 0.8 * std::tan(car.delta_max) / (car.lf + car.lr); }

/// The number of a line's samples. Throws std::invalid_argument for too few, and for so many as a car has that is far
/// too small for the road: they would take hours and all memory.
inline std::size_t sample_count(double wanted) {
  constexpr double fewest = 8, most = 200000;
  if (!(wanted >= fewest && wanted <= most)) {
    std::ostringstream text;
    text << "the line along the course would have " << wanted << " samples; expected " << fewest << " to " << most
         << ": the car (or the line's \"spacing\") does not suit the length of the course";
    throw std::invalid_argument(text.str());
  }
  return static_cast<std::size_t>(wanted);
}

/// Friction coefficients from `lo` to `hi`, equally spaced by at most `step`. Throws std::invalid_argument for hi < lo.
inline std::vector<double> friction_grid(double lo, double hi, double step) {
  if (hi < lo) throw std::invalid_argument("mu_hi is below mu_lo");
  std::vector<double> mus{lo};
  const int intervals = static_cast<int>(std::ceil((hi - lo) / step - 1e-9));
  for (int i = 1; i <= intervals; ++i) mus.push_back(std::lerp(lo, hi, static_cast<double>(i) / intervals));
  return mus;
}

/// Less than any road has. A belief in less must not stop the car, which then would learn nothing more.
inline constexpr double least_friction = 0.01;

/// The share of speeds planned for the friction `planned` that is driven at friction `mu`: 1, and where mu is less the
/// root of their ratio, which tyres allow.
inline double speed_share(double mu, double planned) {
  return mu < planned ? std::sqrt(std::max(mu, least_friction) / planned) : 1.0;
}

}  // namespace gripline::planning
