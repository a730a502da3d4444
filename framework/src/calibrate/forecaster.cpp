#include "calibrate/forecaster.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/forecast_run.hpp"

namespace gripline::calibrate {
namespace {

using measured::CommandGrid;
using measured::Road;

/// Largest eigenvalue of the lateral motion times speed, from the rates at v_ref.
double lateral_stiffness(const StagedCar& car, const double* params, double v_ref) {
  const auto m = static_cast<std::size_t>(car.memory());
  constexpr double e = 1e-4;
  std::array<double, 3 * channels> x{}, rate{};
  for (std::size_t i = 0; i < 3; ++i) x[i * channels + 3] = v_ref;
  x[1 * channels + 4] = e * v_ref;
  x[2 * channels + 5] = e * v_ref;
  std::vector<double> memory(3 * m), memory_rate(3 * m);
  const std::array<ActingCommand<double>, 3> command{};
  const std::array<Place, 3> at{};
  const CommandSample<double> idle{};
  History<double> past;
  past.samples = &idle;
  past.count = 1;
  past.dt = 0.01;
  const std::array<History<double>, 3> history{past, past, past};
  CarBatch<double> batch;
  batch.n = 3;
  batch.motion = x.data();
  batch.command = command.data();
  batch.memory = memory.data();
  batch.at = at.data();
  batch.params = params;
  batch.history = history.data();
  batch.motion_rate = rate.data();
  batch.memory_rate = memory_rate.data();
  car.rates(batch);
  const double a11 = (rate[channels + 4] - rate[4]) / (e * v_ref);
  const double a22 = (rate[2 * channels + 5] - rate[5]) / (e * v_ref);
  return 1.2 * std::max(std::abs(a11), std::abs(a22)) * v_ref;
}

constexpr std::array<ExtraInfo, extra_count> infos = {{
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

std::span<const ExtraInfo> extra_infos() { return infos; }

Forecaster::Forecaster(const StagedCar& car, ForecastOptions options)
    : car_params_(car.params().size()), car_(car), options_(options) {
  // Their parameters follow the car's: the first two extras.
  car_.add(steer_, {infos[0].start}, "steering disturbance");
  car_.add(force_, {infos[1].start}, "force disturbance");
  const measured::Frame &pose = options.pose, &velocity = options.velocity;
  if (pose.point_given || pose.yaw_given || velocity.point_given || velocity.yaw_given)
    car_.add(frames_, {pose.x, pose.y, pose.yaw, velocity.x, velocity.y, velocity.yaw}, "frames of the map");
}

std::vector<double> Forecaster::defaults() const {
  std::vector<double> all(car_.params().begin(), car_.params().begin() + static_cast<std::ptrdiff_t>(car_params_));
  for (const ExtraInfo& info : infos) all.push_back(info.start);
  return all;
}

template <class T>
void Forecaster::run(const Session& session, const CommandGrid& commands, const Road* road, std::span<const T> params,
                     const Starts& starts, std::vector<T>& predicted) const {
  std::vector<double> values(car_.params().size());
  // The car's own, its disturbances', and those of the frames, which nobody moves.
  std::vector<T> of_car(params.begin(), params.begin() + static_cast<std::ptrdiff_t>(car_params_ + 2));
  for (std::size_t i = of_car.size(); i < car_.params().size(); ++i) of_car.push_back(T(car_.params()[i]));
  for (std::size_t i = 0; i < of_car.size(); ++i) values[i] = value(of_car[i]);
  const forecast::Setting<T> setting{car_,
                                     options_,
                                     session,
                                     commands,
                                     road,
                                     of_car.data(),
                                     params.data() + car_params_,
                                     values.data(),
                                     lateral_stiffness(car_, values.data(), options_.v_ref)};
  forecast::Run<T> run(setting);
  run.observe(starts);
  run.predict(starts, predicted);
}

template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const double>, const Starts&,
                              std::vector<double>&) const;
template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const Dual8>, const Starts&,
                              std::vector<Dual8>&) const;

}  // namespace gripline::calibrate
