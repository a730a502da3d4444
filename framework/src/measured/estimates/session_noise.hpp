// Noise of sensors, and its colour, from the fourth differences of a session's readings, which a smooth motion hardly
// touches. Of logs on an even grid: log/log_noise.
#pragma once

#include <cstddef>
#include <optional>

#include "measured/session/session.hpp"

namespace gripline::measured {

/// White noise seen through a first-order filter: n_k = colour n_{k-1} + ..., from the variance and the lag-one
/// correlation of the fourth differences.
struct Noise {
  double sigma = 0;   // standard deviation of the noise, in the channel's unit
  double colour = 0;  // lag-one correlation: 0 white, near 1 filtered
  std::size_t samples = 0;
};
/// Noise of one channel of a session, whose sensors may filter, from readings in consecutive rows, or of a channel that
/// is read in few of them from consecutive readings. Nothing below 100 usable differences, nor where a car moves too
/// much between such readings for their noise to show. Taken for white where differences do not follow each other, and
/// of uneven readings in few of the rows. Where rows are uneven and the channel was read at their times, as what it
/// moves between them shows, its noise fades with time or from row to row, `colour` being that of a median step; else
/// its readings are taken for even, and for stamped by a clock that jitters. `row_step`: median time between rows [s].
std::optional<Noise> noise_of(const Session& session, std::size_t channel, double row_step);

}  // namespace gripline::measured
