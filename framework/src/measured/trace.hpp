// A measured log on an even grid, with a smooth trajectory beside it along which models are evaluated.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "car/staged_car.hpp"
#include "geometry/track.hpp"

namespace gripline::diagnose {

inline constexpr std::size_t channels = 6;  // x, y, yaw, vx, vy, yaw rate
using Channels = std::array<double, channels>;

/// What was measured: rows of six readings (NaN where missing) and the commands, linear between samples.
struct Measured {
  double dt = 0.02;
  double t0 = 0.0;              // time of the first row since the start of the log, for effects that depend on time
  std::vector<double> reading;  // n x 6
  std::vector<CommandSample<double>> command;
  std::vector<bool> guessed;  // samples whose command nobody recorded; empty: none
  /// Whether what was commanded during the step after sample k is a guess.
  bool guessed_step(std::size_t k) const { return k + 1 < guessed.size() && (guessed[k] || guessed[k + 1]); }
  std::size_t size() const { return command.size(); }
};

/// Places along a track: lap fraction by the file's points, slopes, direction.
class Road {
 public:
  explicit Road(std::shared_ptr<const Track> track) : track_(std::move(track)) {}
  /// `hint` is a station nearby or NaN; it is moved to the one found.
  Place at(double t, double x, double y, double yaw, double& hint) const;
  const Track& track() const { return *track_; }

 private:
  std::shared_ptr<const Track> track_;
};

/// A log prepared for evaluation. `motion` is the reference trajectory, n rows of motion_size.
struct Trace {
  Measured log;
  std::vector<double> motion;
  std::vector<Place> at;
  std::vector<CommandSample<Dual8>> command_dual;

  std::size_t size() const { return log.size(); }
  void set_motion(std::vector<double> rows, const Road& road);
  /// Acting command `share` of a step after sample k.
  ActingCommand<double> command(std::size_t k, double share) const;
  /// Place `share` of a step after sample k.
  Place place(std::size_t k, double share) const;
  /// Reference `share` of a step after sample k, by a cubic through four samples.
  std::array<double, 6> reference(std::size_t k, double share) const;
};

/// A first reference by a local quadratic fit to each channel over 2 * half + 1 samples; missing readings are bridged.
std::vector<double> smooth_readings(const Measured& log, int half);

/// Acting command `share` of a step after sample k; commands are linear between samples.
ActingCommand<double> command_at(const Measured& log, std::size_t k, double share);
/// Place `share` of a step of dt after `from`, on the way to `to`.
Place between(const Place& from, const Place& to, double share, double dt);

/// One step of dt of many cars, each at its own sample of a log, by the classical Runge-Kutta method. Steps are split
/// where delayed commands have their kinks. Holds references.
class Stepping {
 public:
  Stepping(const StagedCar& car, const Measured& log, int substeps);
  /// Car i starts at sample[i], at place from[i], and will be near to[i] afterwards; rows of x (motion_size) and of
  /// memory are overwritten with the state after the step.
  void advance(std::span<const std::size_t> sample, std::span<const Place> from, std::span<const Place> to, double* x,
               double* memory);

 private:
  const StagedCar& car_;
  const Measured& log_;
  std::size_t m_;
  bool looks_back_;
  std::vector<double> knots_;
  std::vector<double> xs_, ms_, kx_, km_, sum_x_, sum_m_;
  std::vector<ActingCommand<double>> command_;
  std::vector<Place> at_;
  std::vector<History<double>> history_;
};

/// Advances every sample of the reference by one step of dt: next has size() - 1 rows of motion_size + memory.
/// `memory` holds size() rows.
void step_all(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int substeps,
              std::vector<double>& next);

/// Memory of a car's effects along the reference, from its steady value at the start: size() rows.
std::vector<double> run_memory(const StagedCar& car, const Trace& trace);

/// Rates at every sample of the reference: size() rows of motion_size (memory rates left out).
std::vector<double> rates_at_samples(const StagedCar& car, const Trace& trace, const std::vector<double>& memory);
/// The same of the memory.
std::vector<double> memory_rates(const StagedCar& car, const Trace& trace, const std::vector<double>& memory);

}  // namespace gripline::diagnose
