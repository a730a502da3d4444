// A car linearised along a reference trajectory: the deviation z of the true state (and of the effects' memory, and of
// slowly changing unknown accelerations) from the reference obeys
//
//   z[k+1] = F[k] z[k] + f[k] + C[k] (theta - theta0) + process noise,
//   y[k]   = h[k] + H[k] z[k] + D[k] (theta - theta0) + sensor noise.
//
// f is exact: one step of the nonlinear model from the reference minus the reference one step on; F and C come from
// exact rates differentiated at the samples. The reference is close to the truth whatever the model, so nothing is ever
// simulated over a long time with a wrong model and nothing can spin.
#pragma once

#include <span>
#include <vector>

#include "diagnose/model/candidates.hpp"
#include "diagnose/model/states.hpp"

namespace gripline::diagnose {

/// Derivatives by one parameter, or a function of its own, at every sample: of the rates vx', vy', omega' and of the
/// readings. Column of the regression of innovations on parameters.
struct Regressor {
  std::vector<double> rate;     // n x 3
  std::vector<double> reading;  // n x 6, or empty
};

/// What depends on the model and its parameter values, for one trace. States are ordered: 6 of motion, the memory, the
/// errors of both commands where they were rounded, 3 unknown accelerations.
struct LinearModel {
  std::size_t n = 0;       // samples
  std::size_t states = 0;  // 6 + memory + errors of commands + 3
  double dt = 0;
  int substeps = 0;                        // of each step of integration
  double noise_time = default_noise_time;  // correlation time of the unknown accelerations [s]
  std::vector<double> F;                   // (n-1) x states x states
  std::vector<double> input0;      // (n-1) x states x 3: what a rate at sample k, fading to k + 1, adds to z[k+1]
  std::vector<double> input1;      // the same for a rate at sample k + 1
  std::vector<double> by_command;  // (n-1) x 2 x states: of a unit of each command half-way; or empty
  std::vector<Commands> command_variation;              // n - 1: how far commands may leave a line in a step; or empty
  std::vector<measured::RoundingError> rounding_error;  // n: of the commands; or empty
  std::vector<double> offset;                           // (n-1) x (states - 3): f
  std::vector<double> innovation;                       // n x 6: reading minus h; NaN where there is no reading
  std::vector<double> H;                                // n x 6 x 6, or empty for the identity
  std::vector<bool> interpolated;                       // n - 1: a command of the step was not recorded; or empty
  std::vector<double> memory;                           // n x memory, along the reference
  std::vector<double> memory_variance;                  // memory: of the first sample's, which are taken to be steady
  std::size_t command_errors() const { return rounding_error.empty() ? 0 : Commands{}.size(); }
  std::size_t memories() const { return states - channels - command_errors() - noise_states; }
};

/// `along` lists parameters of the car, at most lanes_beside_state of them, whose regressors come with the state's
/// derivatives at no cost and are written to `regressors` (same size). Throws std::invalid_argument beyond max_memory.
LinearModel linearise(const StagedCar& car, const Trace& trace, const Stepping& stepping,
                      std::span<const std::size_t> along = {}, std::span<Regressor> regressors = {});
std::size_t lanes_beside_state(const StagedCar& car);

/// Steps of integration per sample that a car's motion needs along these traces: its slip settles within a few times
/// 10 ms at the small scale, and logs are read at 20 to 100 Hz.
int substeps_of_motion(const StagedCar& car, std::span<const Trace> traces);

}  // namespace gripline::diagnose
