// Noise of sensors from the fourth differences of their readings, which a smooth motion hardly touches.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "measured/log.hpp"
#include "measured/session.hpp"

namespace gripline::measured {

/// Standard deviation of white noise on a channel of logs on an even grid, from divided differences of this order of
/// its own consecutive readings, which may lie some samples apart: a motion that is a polynomial of a lower order is
/// not seen. NaN where there are never so many readings at their usual distance from each other.
double white_noise(std::span<const Log> stretches, std::size_t channel, std::size_t order);
/// That of each channel, by fourth differences (of readings in every sample their variance is 70 sigma^2).
Channels estimate_noise(std::span<const Log> stretches);

/// White noise seen through a first-order filter: n_k = colour n_{k-1} + ..., from the variance and the lag-one
/// correlation of the fourth differences.
struct Noise {
  double sigma = 0;   // standard deviation of the noise, in the channel's unit
  double colour = 0;  // lag-one correlation: 0 white, near 1 filtered
  std::size_t samples = 0;
};
/// Noise of one channel of a session, whose sensors may filter, from readings in consecutive rows, or of a channel that
/// is read in few of them from consecutive readings. Nothing below 100 usable differences, nor where a car moves too
/// much between such readings for their noise to show.
std::optional<Noise> noise_of(const Session& session, std::size_t channel, double row_step);

}  // namespace gripline::measured
