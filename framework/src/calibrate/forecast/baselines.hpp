// Predictions by models without knowledge of the car, to compare with.
#pragma once

#include <array>
#include <vector>

#include "calibrate/forecast/forecaster.hpp"

namespace gripline::calibrate {

/// persistence: velocities and yaw rate stay as the log shows them at the start, the pose moves along.
/// constant_speed: the speed stays, straight ahead.
/// kinematic: the speed stays, the wheels roll where the recorded commands point them.
enum class Baseline { persistence, constant_speed, kinematic };
inline constexpr std::array<const char*, 3> baseline_names = {"persistence", "constant speed", "kinematic"};

/// starts x horizons x 6 readings in the log's own frames; NaN where the log does not show what is needed.
/// What the start's row lacks is taken from the rows of the quarter second before it. `wheelbase` [m].
std::vector<double> baseline(Baseline which, const Session& session, const Starts& starts, double wheelbase);

}  // namespace gripline::calibrate
