// Whether a session's numbers fit its map: units, signs and frames that must be wrong are refused, each with its
// evidence.
#pragma once

#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// Checks that the numbers fit the map, by medians over driving, so that no outlier decides; its frames are taken off
/// first. Throws InputError with the evidence: units of speed, angles and time, a heading turned against the path, a
/// steering angle or yaw rate of the other sign, x and y or vx and vy by turns, a steering angle of the handwheel, a
/// parked car. `v_ref`: typical speed of the car [m/s]; `delta_max`: its largest steering angle [rad], 0 where no world
/// says it.
void check_session(const SessionFile& file, double v_ref, double delta_max = 0.0);

}  // namespace gripline::measured
