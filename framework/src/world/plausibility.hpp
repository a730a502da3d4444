// Plausibility checks of a car or a world: values that are allowed but outside the range of real cars, mostly by a slip
// of units, as a mass in tonnes beside forces in N.
#pragma once

#include <string>
#include <vector>

#include "world/world_spec.hpp"

namespace gripline {

/// Warnings, one line each, without a place in the file: lengths that no car has, a yaw inertia that its mass and axles
/// cannot have.
std::vector<std::string> plausibility_warnings(const Car& car);

/// The warnings on its car, on a grip of its axles that no tyre has at any factor of the schedule, and on position
/// noise wider than the road. Constructs the plant in a process of its own; what that refuses gives no warning.
std::vector<std::string> plausibility_warnings(const WorldSpec& world);

}  // namespace gripline
