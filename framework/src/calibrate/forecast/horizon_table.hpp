// Root mean square errors at a horizon, with intervals by block bootstrap.
#pragma once

#include <array>
#include <iosfwd>
#include <string>
#include <vector>

#include "calibrate/forecast/forecaster.hpp"

namespace gripline::calibrate {

/// Position, yaw, vx, vy, yaw rate.
inline constexpr std::size_t quantities = 5;
inline constexpr std::array<const char*, quantities> quantity_names = {"position_m", "yaw_rad", "vx_mps", "vy_mps",
                                                                       "yaw_rate_radps"};

/// One error and its 95 % interval, in the quantity's unit; NaN where nothing was measured.
struct HorizonError {
  double rms = 0, low = 0, high = 0;
  std::size_t count = 0;  // of starts
};
struct HorizonRow {
  std::string name;
  std::array<HorizonError, quantities> error;
};

/// Errors of predictions at the horizon: `predicted` and `truth` are starts x 6. Blocks of ten seconds are drawn, the
/// same ones each time.
HorizonRow horizon_row(std::string name, std::span<const double> start_time, std::span<const double> predicted,
                       std::span<const double> truth);

/// Root mean square of `other` less that of `predicted` over the starts that both have, of one quantity; the same
/// blocks are drawn for both.
HorizonError paired_change(std::span<const double> start_time, std::span<const double> predicted,
                           std::span<const double> other, std::span<const double> truth, std::size_t quantity);

/// A table for people: a row each, intervals in brackets, a dash where nothing was measured.
void print_horizon_table(std::ostream& out, std::span<const HorizonRow> rows);

}  // namespace gripline::calibrate
