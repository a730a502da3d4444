// The state that planner and controller act on where a stack filters what its sensors show: an extended Kalman filter
// over the six channels, with the stack's present model.
//
//   predict   x- = f(x+, u),  P- = A P+ A' + Q        f, A: one step of the model with its exact derivative
//   update    per channel i: k = P e_i / (P_ii + sigma_i^2),  x += k (z_i - x_i),  P -= k e_i' P
//
// A channel that is read less often than the car is controlled is taken in once per reading: held, it is an old one.
// Sensors with delays are refused (check_sensors in stack.hpp): each would need the state of another moment.
//
// Q is what the model may be wrong in a step: drift_i dt in each velocity. A reading further than three standard
// deviations from its prediction says that the model is wrong by more (friction fell): its variance grows to what the
// reading shows first, so that the filter follows within a step.
// Source: Jazwinski (1970), Stochastic Processes and Filtering Theory, ch. 8; channels one by one as their noise is
// independent.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <gripline/interfaces.hpp>

#include "config/reader.hpp"
#include "world/sensors.hpp"

namespace gripline {

/// What a stack knows of its sensors and how wrong its model may be. Channels in the order x, y, yaw, vx, vy, yaw_rate.
struct StateFilterSpec {
  std::array<double, 6>
      sigma{};  // standard deviation of a reading [m, m, rad, m/s, m/s, rad/s]; 0: taken as it is read
  std::array<double, 3> drift{};  // of vx, vy and yaw rate: acceleration that the model lacks [m/s2, m/s2, rad/s2]
};
/// {"sigma": {"x": "2 mm", ...}, "drift": {"vx": "0.5 m/s2", ...}}. Drift is 0.1 g where it is not given, of the yaw
/// rate that over the distance of the axles.
StateFilterSpec read_state_filter(const Node& node, const Car& car, Errors& errors);

class StateFilter {
 public:
  explicit StateFilter(const StateFilterSpec& spec);
  /// Begins at a reading.
  void start(const State& reading);
  /// One step of `model` from the state that is held, under u at a place; to be called before the model's memory moves
  /// on. Allocates in the first call, and where another model has more states than those before.
  void predict(Prediction& model, const Input& u, const Place& at);
  /// Takes in the channels of a reading that are new, and its steering angle; the others stay as predicted.
  void update(const State& reading, const ChannelSet& read);
  const State& state() const { return x_; }

 private:
  StateFilterSpec spec_;
  State x_;
  std::array<double, 36> P_{};  // covariance of the six channels, symmetric
  std::vector<double> row_, next_, A_, B_;
};

}  // namespace gripline
