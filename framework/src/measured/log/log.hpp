// A measured log on an even grid of time: readings of the sensors and commands of the driver.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "car/staged_car.hpp"
#include "measured/channels.hpp"

namespace gripline::measured {

/// Throttle and steering, of what belongs to a command.
using Commands = std::array<double, 2>;

/// What is not known of commands that were rounded, at one sample: a first-order autoregressive process.
struct RoundingError {
  Commands variance{};        // of the error
  Commands autoregression{};  // share of it that is in the next sample's
};

/// What commands do between samples: move linearly where nothing else is said.
struct CommandHold {
  bool until_next = false;  // each is held until the next
  bool halves = false;      // so are those half-way, which the log left out: they are interpolated (bend_commands)
  double lag = 0.0;         // linear ones act so much of a sample late, less than 1
  /// Whether commands stay as they are between the instants at which they change.
  bool in_steps() const { return until_next || halves; }
  /// For how long each command is held in a log with samples dt apart; 0 for linear ones [s].
  double seconds(double dt) const;
  bool operator==(const CommandHold&) const = default;
};
/// Commands that are each held for so long [s], in a log with samples dt [s] apart. Of those held for a part of dt the
/// log has left some out. Where it is every second one it is taken to be between its neighbours; more act, in the mean,
/// as linear ones do, late by half the time for which each was held.
CommandHold held_for(double seconds, double dt);

/// Samples dt apart. Rows of `reading` hold the channels (SI; not_a_number where missing); what commands do between
/// samples, or between `fine` ones, is said by `hold`.
struct Log {
  double dt = 0.02;
  double t0 = 0.0;              // time of the first row since the start of the log, for effects that depend on time
  std::vector<double> reading;  // n x 6
  std::vector<CommandSample<double>> command;
  std::vector<CommandSample<double>> fine;  // 2 size() - 1 commands half a sample apart; empty: `command` says all
  CommandHold hold;                         // set by hold_commands(), which `fine` goes with
  std::vector<bool> interpolated;  // samples without a recorded command, filled in from their neighbours; empty: none
  std::vector<RoundingError> rounding_error;  // by sample, where commands are expected values of rounded ones; or empty
  /// Whether a command of the step after sample k was not recorded.
  bool interpolated_step(std::size_t k) const {
    return k + 1 < interpolated.size() && (interpolated[k] || interpolated[k + 1]);
  }
  std::size_t size() const { return command.size(); }
};

/// Sets `hold`. Of held halves, `fine` becomes the commands without a bend.
void hold_commands(Log& log, const CommandHold& hold);

/// Samples in which a channel was read.
std::vector<std::size_t> samples_with(const Log& log, std::size_t channel);
/// Whether two recordings hold the same readings, or commands; what is missing in both is the same.
bool same_readings(std::span<const double> a, std::span<const double> b);
bool same_commands(std::span<const CommandSample<double>> a, std::span<const CommandSample<double>> b);

/// Acting command `share` of a step after sample k; of held ones the step's own, at either end.
ActingCommand<double> command_at(const Log& log, std::size_t k, double share);
/// Commands up to `now` [s], for effects with a delay. Holds pointers into the log.
History<double> history_at(const Log& log, double now);
/// Acting command at a sample, and commands up to it, for what is evaluated at samples and taken as linear between
/// them: held commands jump there and count by the mean of both sides, so that the mean over a step is that of the
/// command up to 1/8 of its second difference.
ActingCommand<double> command_at_sample(const Log& log, std::size_t k);
History<double> history_at_sample(const Log& log, double now);

/// Makes the commands curved between samples (of held halves, moves what was left out): half-way they are off the
/// straight line by `bend` times the mean of the second differences at both ends. -1/8 is a parabola through the
/// samples, 0 the straight line.
void bend_commands(Log& log, const Commands& bend);
/// Root mean squares of the commands' second differences: how far they may have been off straight lines.
Commands command_curvature(std::span<const Log> stretches);
/// How far the commands of each step may have been off a straight line, size() - 1 of them: the root of the squared
/// difference of its ends and the mean of their squared second differences. Where a command rests nothing was left out;
/// where it jumps, when it did is unknown.
std::vector<Commands> command_variation(const Log& log);

}  // namespace gripline::measured
