// A measured log on an even grid, with a smooth trajectory beside it along which models are evaluated.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "../geometry/track.hpp"
#include "../staged_car.hpp"

namespace gripline::diagnose {

inline constexpr std::size_t channels = 6;  // x, y, yaw, vx, vy, yaw rate
using Channels = std::array<double, channels>;

/// What was measured: rows of six readings (NaN where missing) and the commands, linear between samples.
struct Measured {
  double dt = 0.02;
  double t0 = 0.0;              // time of the first row since the start of the log, for effects that depend on time
  std::vector<double> reading;  // n x 6
  std::vector<CommandSample<double>> command;
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

/// Advances every sample of the reference by one step of dt with the classical Runge-Kutta method: next has size() - 1
/// rows of motion_size + memory. `memory` holds size() rows. Steps are split where delayed commands have their kinks.
void step_all(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int substeps,
              std::vector<double>& next);

/// Memory of a car's effects along the reference, from its steady value at the start: size() rows.
std::vector<double> run_memory(const StagedCar& car, const Trace& trace);

/// Rates at every sample of the reference: size() rows of motion_size (memory rates left out).
std::vector<double> rates_at_samples(const StagedCar& car, const Trace& trace, const std::vector<double>& memory);

}  // namespace gripline::diagnose
