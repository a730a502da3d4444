// Shares and gains of a step are stated for one of 20 ms, that of the published code. At another control step they are
// converted by its length, so that what is learned or driven in a second stays the same.
#pragma once

namespace gripline {

inline constexpr double reference_step = 0.02;  // [s]

}  // namespace gripline
