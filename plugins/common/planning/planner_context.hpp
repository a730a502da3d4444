// What planners ask of their context, and a car's own limits that their lines respect.
#pragma once

#include <cmath>
#include <cstddef>
#include <sstream>
#include <stdexcept>

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
         << ": the car, or the spacing of the line, does not suit the length of the course";
    throw std::invalid_argument(text.str());
  }
  return static_cast<std::size_t>(wanted);
}

}  // namespace gripline::planning
