// Angles that a log wraps at whole turns, made continuous.
#pragma once

#include <cstddef>
#include <span>

namespace gripline::measured {

/// Adds whole turns [rad] to every `stride`th value from `first` on, so that each is within half a turn of the last one
/// that is not NaN. Returns how often the number of turns changes.
std::size_t unwrap_angles(std::span<double> values, std::size_t first = 0, std::size_t stride = 1);

}  // namespace gripline::measured
