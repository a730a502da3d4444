#include "calibrate/forecast/forecaster.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/forecast/forecast_run.hpp"
#include "car/instant.hpp"

namespace gripline::calibrate {
namespace {

using measured::Channel;
using measured::CommandGrid;
using measured::Road;

forecast::Stiffness stiffness_of(const StagedCar& car, const double* params, const ForecastOptions& options) {
  constexpr std::size_t speeds = forecast::Stiffness::speeds;
  const double v_ref = options.v_ref;
  const auto m = static_cast<std::size_t>(car.memory());
  // Straight on at v_ref, the same with either lateral motion, then at every speed as it is and with either memory
  // moved.
  const std::size_t n = 3 + speeds * (1 + m);
  constexpr double e = 1e-4;
  forecast::Stiffness found;
  found.speed = {std::min(options.v_min, 0.5 * v_ref), v_ref, 2.0 * v_ref};
  std::vector<double> x(n * channels), rate(n * channels), memory(n * m), memory_rate(n * m);
  for (std::size_t i = 0; i < n; ++i) x[i * channels + Channel::vx] = i < 3 ? v_ref : found.speed[(i - 3) / (1 + m)];
  x[1 * channels + Channel::vy] = e * v_ref;
  x[2 * channels + Channel::yaw_rate] = e * v_ref;
  for (std::size_t k = 0; k < speeds; ++k)
    for (std::size_t j = 0; j < m; ++j) memory[(3 + k * (1 + m) + 1 + j) * m + j] = e;
  const std::vector<ActingCommand<double>> command(n);
  const std::vector<Place> at(n);
  const CommandSample<double> idle{};
  const std::vector<History<double>> history(n, always(idle));
  CarBatch<double> batch;
  batch.n = n;
  batch.motion = x.data();
  batch.command = command.data();
  batch.memory = memory.data();
  batch.at = at.data();
  batch.params = params;
  batch.history = history.data();
  batch.motion_rate = rate.data();
  batch.memory_rate = memory_rate.data();
  car.rates(batch);
  const double a11 = (rate[channels + Channel::vy] - rate[Channel::vy]) / (e * v_ref);
  const double a22 = (rate[2 * channels + Channel::yaw_rate] - rate[Channel::yaw_rate]) / (e * v_ref);
  found.lateral = 1.2 * std::max(std::abs(a11), std::abs(a22)) * v_ref;
  for (std::size_t k = 0; k < speeds; ++k)
    for (std::size_t j = 0; j < m; ++j) {
      const std::size_t still = 3 + k * (1 + m), moved = still + 1 + j;
      found.lag[k] = std::max(found.lag[k], std::abs(memory_rate[moved * m + j] - memory_rate[still * m + j]) / e);
    }
  return found;
}

/// Scales of Cauchy's weight, much more than a model errs by between readings: 50 ms of travel, 0.1 rad, a tenth of
/// speed and of a tight turn's rate.
forecast::Row<double> cauchy_scales(const ForecastOptions& options) {
  const double v = options.v_ref;
  return {0.05 * v, 0.05 * v, 0.1, 0.1 * v, 0.1 * v, 0.1 * v / options.wheelbase};
}

/// By row: whether a reading of it, or of one in the 0.2 s before, is off the reading before by more than a car moves.
std::vector<char> rows_near_jumps(const Session& session, const forecast::Row<double>& cauchy_scale) {
  constexpr double lasting = 0.2, usual_gap = 0.1;  // [s]
  std::vector<char> near(session.rows());
  std::array<std::size_t, channels> last{};
  double until = session.t.front() - 1.0;
  for (std::size_t i = 1; i < session.rows(); ++i) {
    for (std::size_t c = Channel::yaw; c < channels; ++c) {  // places are of one measurement with the heading
      if (std::isnan(session.at(i, c))) continue;
      const double gap = session.t[i] - session.t[last[c]];
      if (std::abs(session.at(i, c) - session.at(last[c], c)) > 2.0 * cauchy_scale[c] * (1.0 + gap / usual_gap))
        until = session.t[i] + lasting;
      last[c] = i;
    }
    near[i] = session.t[i] <= until;
  }
  return near;
}

constexpr std::array<ForecastParameterInfo, forecast_parameter_count> infos = {{
    {"steer_tau", "s", 0.05, 60, 2, 1.0, true},
    {"force_tau", "s", 0.05, 60, 2, 1.0, true},
    {"gain_position", "1", 0, 1, 0.7, 0.3, false},
    {"gain_yaw", "1", 0, 1, 0.7, 0.3, false},
    {"gain_speed", "1", 0, 1, 0.7, 0.3, false},
    {"gain_lateral", "1", 0, 1, 0.3, 0.3, false},
    {"gain_yaw_rate", "1", 0, 1, 0.5, 0.3, false},
    {"gain_turn", "1/s", 0, 20, 0.5, 2.0, false},
    {"gain_force", "1/s", 0, 20, 0.5, 1.0, false},
    {"gain_steer", "1", 0, 1, 0.05, 0.2, false},
    {"delay_position", "s", -0.5, 1, 0, 0.1, false},
    {"delay_yaw", "s", -0.5, 1, 0, 0.1, false},
    {"delay_velocity", "s", -0.5, 1, 0, 0.1, false},
    {"delay_yaw_rate", "s", -0.5, 1, 0, 0.3, false},
}};

}  // namespace

std::span<const ForecastParameterInfo> forecast_parameter_infos() { return infos; }

Forecaster::Forecaster(const StagedCar& car, ForecastOptions options)
    : car_params_(car.params().size()),
      car_(car),
      steer_memory_(static_cast<std::size_t>(car.memory())),
      force_memory_(steer_memory_ + static_cast<std::size_t>(steer_.memory())),
      options_(options) {
  // Their parameters and memories follow the car's, in this order: the parameters are the forecast's first two.
  car_.add(steer_, {infos[0].start}, "steering disturbance");
  car_.add(force_, {infos[1].start}, "force disturbance");
}

StagedCar Forecaster::car_seen_by(const Session& session) const {
  StagedCar car = car_;
  const measured::Frame &pose = session.pose, &velocity = session.velocity;
  if (pose.given() || velocity.given())
    car.add(frames_, {pose.x, pose.y, pose.yaw, velocity.x, velocity.y, velocity.yaw}, "frames of the map");
  return car;
}

std::vector<double> Forecaster::defaults() const {
  std::vector<double> all(car_.params().begin(), car_.params().begin() + static_cast<std::ptrdiff_t>(car_params_));
  for (const ForecastParameterInfo& info : infos) all.push_back(info.start);
  return all;
}

template <class T>
void Forecaster::run(const Session& session, const CommandGrid& commands, const Road* road, std::span<const T> params,
                     const Starts& starts, std::vector<T>& predicted, ObserverSteps* steps) const {
  const StagedCar car = car_seen_by(session);
  std::vector<double> values(car.params().size());
  // The car's own, its disturbances', and those of the frames, which are fixed.
  std::vector<T> of_car(params.begin(), params.begin() + static_cast<std::ptrdiff_t>(car_params_ + 2));
  for (std::size_t i = of_car.size(); i < car.params().size(); ++i) of_car.push_back(T(car.params()[i]));
  for (std::size_t i = 0; i < of_car.size(); ++i) values[i] = value(of_car[i]);
  const forecast::Row<double> cauchy_scale = cauchy_scales(options_);
  const std::vector<char> jumped = rows_near_jumps(session, cauchy_scale);
  StagedCar moved = car;
  std::copy(values.begin(), values.end(), moved.params().begin());
  const forecast::Setting<T> setting{car,
                                     options_,
                                     session,
                                     commands,
                                     road,
                                     of_car.data(),
                                     params.data() + car_params_,
                                     values.data(),
                                     steer_memory_,
                                     force_memory_,
                                     stiffness_of(car, values.data(), options_),
                                     moved.look_back(),
                                     cauchy_scale,
                                     jumped,
                                     measured::VelocityAxes<T>::of(car, of_car.data())};
  forecast::ForecastRun<T> run(setting);
  run.observe(starts, steps);
  run.predict(starts, predicted);
}

template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const double>, const Starts&,
                              std::vector<double>&, ObserverSteps*) const;
template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const Dual8>, const Starts&,
                              std::vector<Dual8>&, ObserverSteps*) const;

}  // namespace gripline::calibrate
