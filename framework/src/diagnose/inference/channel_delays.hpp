// Channels that show later than others what the car did: errors of measurement that no car explains, because the
// channels compared (yaw rate and yaw, speed and place) show one and the same motion.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnose/inference/fit.hpp"
#include "measured/log/log_file.hpp"

namespace gripline::diagnose {

using measured::LogFile;

/// What speeds are set against the place by: how well accelerations correlate, or also what displacements say, where
/// these tell more.
enum class SpeedsBy { accelerations, displacements_too };

/// How late the channels of a group are (measured::delay_groups: those that one clock stamps).
struct ChannelDelay {
  std::size_t group = 0;                  // measured::delay_names
  double seconds = 0, low = 0, high = 0;  // 95 % by blocks of at most ten seconds
  double left = 0;                        // of `seconds`, what is not taken off a log but left to the model
  std::string name() const;               // "yaw_rate", as in pointers
  std::string words() const;              // "yaw rate"
  std::string against() const;            // words of the group that shows the same motion
};

/// Groups that are significantly late: of the delays between speeds and place, and between yaw rate and yaw
/// (measured::pairwise_delays), those that are longer than a sample, and significantly (thresholds::false_delay) longer
/// than half of one. As no sensor shows what has not happened yet, that of the two which comes after the other is the
/// late one. The logs are taken as from one recorder.
std::vector<ChannelDelay> significant_delays(std::span<const LogFile> logs, SpeedsBy speeds);

/// What delays of place and yaw may still be wrong by is open in every model from now on: a pose is so precise that a
/// tenth of a sample shows. Of them whole samples are to be taken off, where all logs have the same: what lies between
/// two samples is interpolated with less noise than there is, and coloured.
void keep_open(std::span<ChannelDelay> delays, std::span<const LogFile> logs, Catalogue& catalogue);
/// Where a fit stands at the limit of what was left open: moves the delays by what it found to be left of them.
bool move_limited(std::span<ChannelDelay> delays, const Catalogue& catalogue, const Fit& fit);
/// Takes out delays that a fit found to be shorter than thresholds::least_delay samples: what made them seem longer is
/// something else. Whether there were any.
bool drop_refuted(std::vector<ChannelDelay>& delays, std::span<const LogFile> logs, const Catalogue& catalogue,
                  const Fit& fit);
/// A delay with what a fit found to be left of it.
ChannelDelay refined(ChannelDelay delay, const Catalogue& catalogue, const Fit& fit);

/// The log as its channels would show it without these delays; what would have come after its end is missing.
LogFile without_delays(const LogFile& log, std::span<const ChannelDelay> delays);
std::vector<LogFile> without_delays(std::span<const LogFile> logs, std::span<const ChannelDelay> delays);

}  // namespace gripline::diagnose
