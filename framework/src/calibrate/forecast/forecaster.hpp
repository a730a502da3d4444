// Predictions of what a log's own columns will show, from what they showed before: an observer carries the model's
// states along the log, and every start rolls on from there with the recorded commands.
//
// Between rows the car moves by its model. A row shows channel c as the car was delay_c earlier; what it shows beyond
// the model's own reading (the innovation) moves the states by a gain per channel,
//   x += K (z - x),   z the state that the row's readings stand for,
// and two slow disturbances, a force and a steering angle, that take up what the model leaves unexplained and decay.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "calibrate/forecast/disturbance.hpp"
#include "car/staged_car.hpp"
#include "measured/replay/trace.hpp"
#include "measured/session/log_map.hpp"
#include "measured/session/session.hpp"

namespace gripline::calibrate {

using measured::channels;
using measured::Session;

/// What a forecast has besides the car's own parameters, behind which it stands in the vector of all parameters.
enum class ForecastParameter : std::size_t {
  steer_tau,       // [s] decay of the steering disturbance
  force_tau,       // [s] decay of the force disturbance
  gain_position,   // [-] share of an innovation that moves the state, per row
  gain_yaw,        // [-]
  gain_speed,      // [-] vx
  gain_lateral,    // [-] vy
  gain_yaw_rate,   // [-] the yaw rate by its own channel
  gain_turn,       // [1/s] the yaw rate by the yaw's innovation
  gain_force,      // [1/s] the force by the speed's innovation
  gain_steer,      // [-] the steering by the yaw rate's innovation, as the angle that would turn a rolling car so
  delay_position,  // [s] how late a channel shows what the car did, on the clock of the commands
  delay_yaw,       // [s]
  delay_velocity,  // [s] vx and vy
  delay_yaw_rate,  // [s]
};
inline constexpr std::size_t forecast_parameter_count = 14;
struct ForecastParameterInfo {
  const char* name;
  const char* unit;
  double lo, hi, start;
  double sigma;  // how well it is known before any log is read
  bool log;      // sigma is relative
};
std::span<const ForecastParameterInfo> forecast_parameter_infos();

struct ForecastOptions {
  double step = 0.04;        // [s] of the integration
  double block = 8.0;        // [s] of a log that one lane of the observer covers
  double pre_roll = 2.5;     // [s] that it runs before
  double longest_gap = 0.5;  // [s] without any row: the observer begins anew
  double v_min = 1.0;        // [m/s] below it the measured state is taken as it is
  double v_ref = 10.0;       // [m/s]
  double wheelbase = 1.0;    // [m]
  double delta_max = 0.5;    // [rad]
  /// Blocks or starts that are integrated together, with the steps that the slowest of them needs.
  std::size_t lanes = 32;
  /// Every horizon knows the commands up to its own time. Otherwise all of a start know them up to the longest, for
  /// fits: one integration serves all.
  bool own_commands = true;
};

/// Starts on a log and how far ahead. Predictions are for start + horizon, by the log's clock.
struct Starts {
  std::vector<double> time;      // [s]
  std::vector<double> horizons;  // [s], rising

  /// Where the six readings of a start at a horizon begin in what is predicted for them.
  std::size_t reading_index(std::size_t start, std::size_t horizon) const {
    return (start * horizons.size() + horizon) * channels;
  }
};

/// Substeps that an observer took, by group of lanes and by step. The slowest lane of a group decides on them for all,
/// so it moves on when none of its own states is asked for any more; a run of the same values that is given them leaves
/// such lanes out, and predicts the same.
using ObserverSteps = std::vector<std::vector<int>>;

/// The car with its disturbances, and how it is observed. Holds a reference to the plugins of the car it was made from.
class Forecaster {
 public:
  Forecaster(const StagedCar& car, ForecastOptions options);

  std::size_t car_params() const { return car_params_; }
  std::size_t params() const { return car_params_ + forecast_parameter_count; }
  std::size_t index(ForecastParameter one) const { return car_params_ + static_cast<std::size_t>(one); }
  /// The car's stored parameters, then the starts of the forecast's own.
  std::vector<double> defaults() const;
  Forecaster(const Forecaster&) = delete;
  Forecaster& operator=(const Forecaster&) = delete;
  const ForecastOptions& options() const { return options_; }
  ForecastOptions& options() { return options_; }

  /// predicted: starts x horizons x 6 readings, NaN where the log has no rows to start from, and from where the state
  /// is not finite on. `params`: params() numbers. `steps`, where given, are those of an earlier run of the same values;
  /// empty ones are filled.
  template <class T>
  void run(const Session& session, const measured::CommandGrid& commands, const measured::Road* road,
           std::span<const T> params, const Starts& starts, std::vector<T>& predicted,
           ObserverSteps* steps = nullptr) const;

 private:
  /// With the frames of the units whose readings the session has.
  StagedCar car_seen_by(const Session& session) const;

  ForceDisturbance force_;
  SteerDisturbance steer_;
  StatedFrames frames_;
  std::size_t car_params_;
  StagedCar car_;
  std::size_t steer_memory_, force_memory_;  // where its memory holds the disturbances
  ForecastOptions options_;
};

}  // namespace gripline::calibrate
