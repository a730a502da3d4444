// Plausibility checks of a car or a world: values that are allowed but outside the range of real cars, mostly by a slip
// of units, as a mass in tonnes beside forces in N.
#pragma once

#include <vector>

#include "config/errors.hpp"
#include "config/node.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// Warnings, each at its place in `node`, which the car was read from: lengths that no car has, a yaw inertia that its
/// mass and axles cannot have.
std::vector<Diagnostic> plausibility_warnings(const Car& car, const Node& node);

/// Warnings, each at its place in `node`: a factor that no road has. Points and patches are taken as if they met.
std::vector<Diagnostic> plausibility_warnings(const FrictionSpec& friction, const Node& node);

/// The warnings on its car and its friction, on a grip of its axles that no tyre has at any factor of the schedule, on a
/// road of another scale than the car, and on noise and bias of sensors: of the place beyond the road's width, of
/// velocities beyond the car's v_ref, of the yaw beyond 0.5 rad, of the yaw rate beyond that of a turn at v_ref and 1 g
/// (g / v_ref). Each has its place in `node`, which the world was read from. Constructs the plant in a process of its
/// own; what that refuses gives no warning.
std::vector<Diagnostic> plausibility_warnings(const WorldSpec& world, const Node& node);

}  // namespace gripline
