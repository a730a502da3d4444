// A car driven by the commands of a log: single steps from measured states, and the hidden states of its effects along
// the reference trajectory.
#pragma once

#include "car/integrator.hpp"
#include "measured/replay/trace.hpp"

namespace gripline::measured {

/// Steps of dt of many copies of a car, each at its own sample of a log, by the classical Runge-Kutta method. Steps are
/// split where delayed commands have their breakpoints. Holds references.
class LogStepper {
 public:
  LogStepper(const StagedCar& car, const Log& log, int substeps);
  /// Car i starts at sample[i], at place from[i], and will be near to[i] afterwards; rows of x (motion_size) and of
  /// memory are overwritten with the state after the step.
  void advance(std::span<const std::size_t> sample, std::span<const Place> from, std::span<const Place> to, double* x,
               double* memory);

 private:
  const StagedCar& car_;
  const Log& log_;
  std::size_t m_;
  bool looks_back_;
  std::vector<double> knots_;
  const Tableau* rk4_;
  std::vector<double> xs_, ms_, kx_, km_, sum_x_, sum_m_;
  std::vector<ActingCommand<double>> command_;
  std::vector<Place> at_;
  std::vector<History<double>> history_;
};

/// One-step predictions from every sample of the reference: `next` becomes size() - 1 rows of motion_size + memory;
/// `memory` has size() rows.
void predict_one_step(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int substeps,
                      std::vector<double>& next);

/// Hidden states of a car's effects along the reference, from their steady values at the start: size() rows of memory.
std::vector<double> simulate_memory(const StagedCar& car, const Trace& trace);
/// Steady values of the hidden states at every sample, where they would settle under its commands: size() rows. 0 for
/// effects that give none (Effect::start_memory).
std::vector<double> steady_memory(const StagedCar& car, const Trace& trace);

/// Rates at every sample of the reference: size() rows of motion_size (memory rates left out).
std::vector<double> rates_at_samples(const StagedCar& car, const Trace& trace, const std::vector<double>& memory);
/// Rates of the hidden states at every sample of the reference: size() rows of memory.
std::vector<double> memory_rates(const StagedCar& car, const Trace& trace, const std::vector<double>& memory);

/// Derivatives of the rates at every sample by a command that is higher all the time.
struct CommandRates {
  std::vector<double> motion, memory;  // size() rows
};
/// By throttle and by steering; the memory is as given.
std::array<CommandRates, 2> rates_by_command(const StagedCar& car, const Trace& trace,
                                             const std::vector<double>& memory);

}  // namespace gripline::measured
