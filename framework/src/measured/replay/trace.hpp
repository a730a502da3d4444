// A log with a smooth reference trajectory beside it, along which models are evaluated and linearised.
#pragma once

#include "measured/log/log.hpp"
#include "measured/log/road.hpp"

namespace gripline::measured {

/// A log prepared for evaluation. `motion` is the reference trajectory, size() rows of motion_size;
/// `at` are the places along it.
struct Trace {
  Log log;
  std::vector<double> motion;
  std::vector<Place> at;
  std::vector<CommandSample<Dual8>> command_dual;  // of log.fine, or of log.command

  std::size_t size() const { return log.size(); }
  /// Replaces the reference; finds its places on the road.
  void set_motion(std::vector<double> rows, const Road& road);
  /// Curved commands between samples, as measured::bend_commands has it.
  void bend_commands(const Commands& bend);
  /// Expected values of rounded commands, as measured::unround_commands has it. Before any bend.
  void unround_commands(const Commands& steps);
  /// Only the first so many samples; a shorter one is left as it is.
  void cut(std::size_t samples);
  /// Commands up to sample k, as measured::history_at_sample has them. Holds pointers into this.
  History<Dual8> history(std::size_t k) const;
  /// Acting command `share` of a step after sample k.
  ActingCommand<double> command(std::size_t k, double share) const;
  /// Acting command at sample k, as measured::command_at_sample has it.
  ActingCommand<double> command(std::size_t k) const;
  /// Place `share` of a step after sample k.
  Place place(std::size_t k, double share) const;
  /// Reference `share` of a step after sample k, by a cubic through four samples.
  std::array<double, 6> reference(std::size_t k, double share) const;

 private:
  void copy_commands();
};

/// A first reference: local quadratic fits to each channel over 2 * half + 1 samples, wider where readings are missing.
std::vector<double> smooth_readings(const Log& log, int half);

/// Place `share` of a step of dt after `from`, on the way to `to`.
Place between(const Place& from, const Place& to, double share, double dt);

}  // namespace gripline::measured
