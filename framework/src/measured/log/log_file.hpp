// CSV logs in gripline's columns: read, checked, and resampled to an even grid.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "measured/finding.hpp"
#include "measured/log/log.hpp"
#include "measured/log/log_expectations.hpp"
#include "measured/session/session.hpp"

namespace gripline::measured {

/// A log in stretches without long gaps.
struct LogFile {
  std::string name;
  std::vector<Log> stretches;
  std::vector<Finding> health;
  double seconds = 0;  // of all stretches
};

/// Reads t_s, x_m, y_m, yaw_rad, vx_mps, vy_mps (may be absent), yaw_rate_radps, d, delta_rad; other columns are left
/// alone. Yaw is unwrapped, uneven time stamps are brought to an even grid, outliers of any size and missing readings
/// are left out, long gaps cut the log. Throws InputError with one clear line when nothing sensible can be done:
/// columns missing, time running backward, wrong units, a parked car, too short, another track.
LogFile read_log_file(const std::filesystem::path& file, const LogExpectations& expected);

/// A session's rows, in gripline's channels, cleaned and brought to an even grid as `read_log_file` does it. Nothing is
/// refused: a log that shows too little has no stretches. `v_ref`: typical speed of the car [m/s].
LogFile on_even_grid(const Session& session, double v_ref);

/// Whether two logs hold the same readings and commands, whatever their names.
bool same_content(const LogFile& a, const LogFile& b);
/// Logs without those that repeat an earlier one; its health says so. The same noise counted twice would look like
/// evidence.
std::vector<LogFile> each_once(std::span<const LogFile> logs);
/// Throws InputError when a held-out log is one of those that are fitted.
void check_held_out(std::span<const LogFile> logs, std::span<const LogFile> held_out);

}  // namespace gripline::measured
