// Noise of sensors from differences of their readings on an even grid, which a smooth motion hardly touches. Of
// readings in a logger's own rows, with its colour: estimates/session_noise.
#pragma once

#include <cstddef>
#include <span>

#include "measured/log/log.hpp"

namespace gripline::measured {

/// Standard deviation of white noise on a channel of logs on an even grid, from divided differences of this order of
/// its own consecutive readings, which may lie some samples apart: a motion that is a polynomial of a lower order is
/// not seen. NaN where there are never so many readings at their typical distance from each other.
double white_noise(std::span<const Log> stretches, std::size_t channel, std::size_t order);
/// That of each channel, by fourth differences (of readings in every sample their variance is 70 sigma^2).
Channels estimate_noise(std::span<const Log> stretches);

}  // namespace gripline::measured
