// x_{k+1} = f(x_k, u_k): a nominal model, its effects and what an estimator learned, with the exact derivative of the
// discrete step. It is the world's car, a stack's model and a candidate of diagnose.
#pragma once

#include <utility>
#include <vector>

#include "car/staged_car.hpp"
#include "car/stepper.hpp"

namespace gripline {

/// How commands act between two control steps: `zoh` the new command is held over the step (as published), `foh` linear
/// from the old to the new one, `rate` throttle held and steering moving with its rate.
struct StepOptions {
  double dt = 0.02;
  Hold hold = Hold::zoh;
  Integration integration;
};

/// The error that a step may have.
struct StepBound {
  double velocity = 0;   ///< of vx, of vy and of the yaw rate times the wheelbase [m/s]
  double wheelbase = 1;  ///< [m]
};

/// A row of x: State, the effects' memory, then the last commands (d, delta; oldest first) when an effect reads past
/// commands or the hold needs them. The memory and past commands of the instant observed last are kept and moved on by
/// advance().
class CorrectedModel final : public Prediction {
 public:
  CorrectedModel(StagedCar car, StepOptions options);

  const StagedCar& car() const { return car_; }
  /// Sets a parameter of the car by its number in StagedCar::params, for values and derivatives alike. Not for a delay
  /// that would change how many past commands a row of x holds: a car with another one is another model.
  void set_parameter(std::size_t number, double value);

  int states() const noexcept override { return state_size + car_.memory() + 2 * past_; }
  double dt() const noexcept override { return options_.dt; }
  void start(const State& now, std::span<double> x) const override;
  void step(std::size_t n, std::span<const double> x, std::span<const double> u, std::span<const Place> at,
            std::span<double> x_next, std::span<double> A, std::span<double> B) override;
  Rates rates(const State& x, const Input& u, const Place& at) override;

  /// Whether since the last call every derivative of the first step asked for was a number where the step itself was:
  /// the first one starts at the car, where a solver cannot go on without it.
  bool smooth_since_asked() { return std::exchange(smooth_, true); }

  /// Sets memory and past commands to their steady values for a car that starts in this state under this throttle.
  void reset(const State& x, double d, const Place& at);
  /// One step from an observed state: returns the state predicted after it, and advances memory and past commands.
  State advance(const State& x, const Input& u, const Place& at);
  /// advance() in at least the given number of substeps, doubled (up to 256 times) until the error of the step,
  /// estimated by comparison with twice as many, is within the bound. At low speed the tyres' equations are stiff: a
  /// Runge-Kutta step of 20 ms is then unstable although its result still looks plausible.
  State advance_within(const StepBound& bound, const State& x, const Input& u, const Place& at);
  /// The working quantities at the start of a step from x under u: forces, slips, acting commands. The memory stays.
  Quantities<double> quantities(const State& x, const Input& u, const Place& at);
  /// Those at the end of a step that came to x under u: the angle commanded is x.delta, and still moves at u.ddelta.
  Quantities<double> quantities_after(const State& x, const Input& u, const Place& at);

 private:
  template <class T>
  void load(Stepper<T>& stepper, std::size_t n, const T* rows, const T* inputs, std::size_t stride);
  template <class T>
  void unload(const Stepper<T>& stepper, std::size_t i, T* row) const;
  int past_commands() const;
  Quantities<double> loaded_quantities(const Place& at);
  void values(std::size_t n, const double* x, const double* u, const Place* at, double* x_next);
  void derivatives(std::size_t n, const double* x, const double* u, const Place* at, double* x_next, double* A,
                   double* B);
  void check_derivatives(const double* x_next, const double* A, const double* B);
  void seed_block(std::size_t n, const double* x, const double* u, int first);

  StagedCar car_;
  StepOptions options_;
  int past_ = 0;
  bool smooth_ = true;
  std::vector<double> current_;  // memory and past commands of the instant observed last
  std::vector<double> row_, row_next_, row_finer_;
  Stepper<double> stepper_;
  Stepper<Dual8> dual_stepper_;
  std::vector<Dual8> dual_params_, dual_rows_, dual_inputs_;
};

}  // namespace gripline
