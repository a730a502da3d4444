// Every prediction as a row of a CSV, in the log's own clock and frames.
#pragma once

#include <span>
#include <string>

#include "calibrate/forecast/forecaster.hpp"

namespace gripline::calibrate {

/// A header and a row for each start and horizon whose speed was predicted; cells are empty where the log has no such
/// channel. Yaw is wrapped as the log's column wraps it. `predicted`: starts x horizons x 6 readings.
std::string samples_table(const Session& session, const Starts& starts, std::span<const double> predicted);

}  // namespace gripline::calibrate
