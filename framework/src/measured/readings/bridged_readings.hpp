// Readings of channels that are read less often than a log has rows.
#pragma once

#include <span>
#include <vector>

namespace gripline::measured {

inline constexpr double even_motion = 0.25;  // [s] over which a car moves evenly: between its readings

/// Whether a gap is longer than it may be [s]; what rounding makes of stamps does not count: 0.55 - 0.3 is above 0.25.
inline bool is_longer(double gap, double longest_gap) { return gap > longest_gap + 1e-9; }

/// Readings of a log (rows x channels, NaN where missing) at times `t` [s], with what is missing between two of a
/// channel that are at most `longest_gap` [s] apart on the straight line between them.
std::vector<double> bridged_readings(std::span<const double> t, std::vector<double> reading, double longest_gap);

}  // namespace gripline::measured
