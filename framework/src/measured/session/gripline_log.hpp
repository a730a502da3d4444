// A session as a log in gripline's own columns: SI units, centre of gravity, one clock.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "measured/session/session_file.hpp"

namespace gripline::measured {

inline constexpr double shortest_delay = 1e-3;  // [s] shorter ones are none

/// Writes t_s and those of x_m, y_m, yaw_rad, vx_mps, vy_mps, yaw_rate_radps, d, delta_rad that the session has, a row
/// for each of its rows. Delays are removed (a channel is read at the row's time plus its delay), and so are the map's
/// frames: the columns are those of the centre of gravity. `delays`: of each group [s], as the map states them or as
/// they were found (estimates/session_delays.hpp, delays_to_take_off); NaN, of which none is taken off, where none could
/// be, and none where it is shorter than shortest_delay. Returns what was done, one sentence each.
std::vector<std::string> write_gripline_log(const std::filesystem::path& file, const SessionFile& session,
                                            std::array<double, delay_groups> delays);

}  // namespace gripline::measured
