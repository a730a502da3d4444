// The result of testing a fitted model for what it does not explain.
#pragma once

#include <array>
#include <string>

namespace gripline::diagnose {

/// What an unexplained acceleration is a function of; or that it is none, but an error of a channel's readings.
enum class Where { position, time, state, input, reading };
inline constexpr std::array<const char*, 5> where_names = {"position", "time", "state", "input", "reading"};

struct ResidualTest {
  Where where = Where::position;
  double gain = 0;  // rise of the log likelihood with all its functions in
  std::size_t dof = 0;
  /// Standardised: (2 gain - dof) / sqrt(2 dof) of the joint tests, which is about standard normal when nothing is
  /// left; scaled, beside uncertain commands (thresholds::misfit_uncertain_commands) and of the other tests, so that
  /// thresholds::misfit is the critical value of all.
  double statistic = 0;
  /// Interval where the remainder is largest: lap fractions, seconds or, of a spectral line, hertz.
  double from = 0, to = 0;
  std::string quantity;  // "noise", "frequency" or empty; the channel of Where::reading
  /// A test of few functions: it sees small remainders of simple shape, and says less about where they are.
  bool focused = false;
  /// The unexplained accelerations vx', vy', omega' where they are largest [m/s2, m/s2, rad/s2].
  std::array<double, 3> size{};
};

}  // namespace gripline::diagnose
