// Measured logs as users bring them: read, judged, and put on an even grid.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "measured/trace.hpp"

namespace gripline::diagnose {

/// A row of the data-health table.
struct Health {
  std::string check, found, done;
  enum class Level { good, note, bad } level = Level::good;
};

/// A log in stretches without long gaps.
struct LogFile {
  std::string name;
  std::vector<Measured> stretches;
  std::vector<Health> health;
  double seconds = 0;  // of all stretches
};

/// What makes a log plausible.
struct LogExpectations {
  double v_ref = 1;            // [m/s]
  const Road* road = nullptr;  // null: any place will do
};

/// Reads t_s, x_m, y_m, yaw_rad, vx_mps, vy_mps (may be absent), yaw_rate_radps, d, delta_rad; other columns are left
/// alone. Yaw is unwrapped, uneven time stamps are brought to an even grid, outliers of any size and missing readings are
/// left out, long gaps cut the log. Throws InputError with one clear line when nothing sensible can be done: columns
/// missing, time running backward, wrong units, a parked car, too short, another track.
LogFile read_log_file(const std::filesystem::path& file, const LogExpectations& expected);

/// The same readings and commands, whatever the files are called.
bool same_content(const LogFile& a, const LogFile& b);
/// Logs without those that repeat an earlier one; its health says so. Counted twice, noise would look like evidence.
std::vector<LogFile> each_once(std::span<const LogFile> logs);
/// Throws InputError when a log to measure on is one of those that are fitted.
void check_held_out(std::span<const LogFile> logs, std::span<const LogFile> held_out);

/// Standard deviation of white noise on each channel, from fourth differences (their variance is 70 sigma^2); NaN
/// where a channel was never read.
Channels estimate_noise(std::span<const Measured> stretches);

}  // namespace gripline::diagnose
