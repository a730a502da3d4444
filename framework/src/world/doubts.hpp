// What a car or a world says that is allowed and hardly meant: slips of units, as a mass in tonnes beside forces in N.
#pragma once

#include <string>
#include <vector>

#include "world/world_spec.hpp"

namespace gripline {

/// One line each, no place: lengths that no car has, a yaw inertia that its mass and axles cannot have.
std::vector<std::string> doubts_about(const Car& car);

/// The doubts about its car, a grip of its axles that no tyre has at any factor of the schedule, and position noise
/// wider than the road. Constructs the plant in a process of its own; what that refuses is no doubt.
std::vector<std::string> doubts_about(const WorldSpec& world);

}  // namespace gripline
