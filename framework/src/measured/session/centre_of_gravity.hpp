// What sensors at the car's centre of gravity would have shown in place of a log's own.
#pragma once

#include <array>

#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// The session as sensors at the centre of gravity would show it: without the map's frames, each channel read its
/// group's delay [s] after the row's time. Headings, yaw rates and velocities that frames are taken off with lie on the
/// line between rows up to `even_motion` apart where the row has none; a speed in turned axes that no lateral one goes
/// with is taken for that of a car that moves straight ahead.
Session at_centre_of_gravity(const SessionFile& file, const std::array<double, delay_groups>& delays = {});

}  // namespace gripline::measured
