// Blocks of a log whose errors are taken for independent of each other: by their spread estimates get intervals.
#pragma once

#include <algorithm>
#include <cstddef>

namespace gripline::measured {

inline constexpr double independent_time = 10.0;  // [s] behind which errors are hardly correlated
inline constexpr std::size_t least_blocks = 8;    // of fewer the spread says hardly anything

/// Samples of a block: ten seconds, less in a log too short for as many blocks as there should be at least. `dt`:
/// between samples [s].
inline std::size_t samples_of_block(double dt, std::size_t samples) {
  return std::max<std::size_t>(1, std::min(static_cast<std::size_t>(independent_time / dt), samples / least_blocks));
}

}  // namespace gripline::measured
