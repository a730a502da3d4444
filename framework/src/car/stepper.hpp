// One control step of n cars at once, by a Runge-Kutta method.
#pragma once

#include <vector>

#include "car/integrator.hpp"
#include "car/staged_car.hpp"

namespace gripline {

/// How a step is integrated: `substeps` equal steps of the method per control step of dt [s]; one in which delayed
/// commands change is cut at each of these instants.
struct Integration {
  const Tableau* tableau = find_tableau("rk4");
  int substeps = 1;
};

/// Works in buffers of its own that grow with n and are then reused.
template <class T>
class Stepper {
 public:
  /// Makes room for n cars with this much memory each and `past` samples of past commands.
  void resize(std::size_t n, int memory, int stages, int past);

  /// Filled by the caller before step(), overwritten with the state after it.
  std::vector<T> motion;  // n x motion_size
  std::vector<T> memory;  // n x memory

  /// The commands during the step: linear from begin to end, the rate constant.
  struct Ramp {
    ActingCommand<T> begin, end;
  };
  std::vector<Ramp> ramp;              // n
  std::vector<CommandSample<T>> past;  // n x past, oldest first, for effects that read past commands
  double past_offset = 0.0;            // time of the first past sample relative to the start of the step [s]
  double past_dt = 0.0;
  Hold hold = Hold::zoh;

  /// Advances all cars by dt. The place is held over the step, its time moves along. params: see CarBatch.
  void step(const StagedCar& car, const Integration& integration, double dt, std::size_t n, const Place* at,
            const T* params);
  /// Quantities of all cars at the start of the step, with their memory as loaded.
  void quantities(const StagedCar& car, double dt, std::size_t n, const Place* at, const T* params, Quantities<T>* q);

 private:
  /// All cars by h [s], the method's step, from so far into the control step on.
  void advance(const StagedCar& car, const Tableau& method, double from, double h, double dt, std::size_t n,
               const Place* at, const T* params);
  void stage_inputs(std::size_t n, const Place* at, double from, double c, double h, double dt);

  int memory_ = 0, past_ = 0;
  std::vector<T> stage_motion_, stage_memory_, motion_rate_, memory_rate_;
  std::vector<ActingCommand<T>> command_;
  std::vector<Place> place_;
  std::vector<History<T>> history_;
  StagedCar::Scratch<T> scratch_;
};

}  // namespace gripline
