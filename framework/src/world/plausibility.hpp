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

/// Warnings, one line each: a factor that no road has. Points and patches are taken as if they met.
std::vector<std::string> plausibility_warnings(const FrictionSpec& friction);

/// The warnings on its car and its friction, on a grip of its axles that no tyre has at any factor of the schedule, on a
/// road of another scale than the car, and on position noise wider than the road. Constructs the plant in a process of
/// its own; what that refuses gives no warning.
std::vector<std::string> plausibility_warnings(const WorldSpec& world);

}  // namespace gripline
