#include "car/stated_drive.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "util/child_process.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

// 100 s to 5 m/s; what races has at least twenty times as much.
constexpr double least_acceleration = 0.05;  // [m/s2]

constexpr std::size_t directions = 8;  // of a Dual8

/// What every car states: acceleration depends on its mass, which says nothing of its drive.
bool is_constant_of_car(std::string_view name) {
  constexpr std::array<std::string_view, 4> constants = {"m", "Iz", "lf", "lr"};
  return std::ranges::find(constants, name) != constants.end();
}

/// vx' [m/s2] straight ahead on a level road at the speed vx [m/s] and the throttle d, and its derivatives by eight
/// parameters from `first` on.
Dual8 acceleration(const StagedCar& car, double vx, double d, std::size_t first) {
  std::vector<Dual8> params(car.params().begin(), car.params().end());
  for (std::size_t j = 0; j < directions && first + j < params.size(); ++j)
    params[first + j] = Dual8::variable(params[first + j].v, static_cast<int>(j));
  std::array<Dual8, motion_size> motion{}, rate{};
  motion[3] = vx;
  const ActingCommand<Dual8> command{d, 0.0, 0.0};
  const Place at{};
  CarBatch<Dual8> batch;
  batch.n = 1;
  batch.motion = motion.data();
  batch.command = &command;
  batch.at = &at;
  batch.params = params.data();
  batch.motion_rate = rate.data();
  car.rates(batch);
  return rate[3];
}

/// By parameter, whether what the throttle adds to the acceleration depends on it.
std::vector<bool> drive_parameters(const StagedCar& car, double vx, double d) {
  std::vector<bool> drives(car.params().size());
  for (std::size_t first = 0; first < drives.size(); first += directions) {
    const Dual8 added = acceleration(car, vx, d, first) - acceleration(car, vx, 0.0, first);
    for (std::size_t j = 0; j < directions && first + j < drives.size(); ++j) drives[first + j] = added.d[j] != 0.0;
  }
  return drives;
}

/// What is wrong with the drive of a car; empty if nothing is.
std::string problem_of(const PluginSpec& model, const StagedCar& staged, const Car& car) {
  const double a = acceleration(staged, car.v_min, car.d_max, 0).v;
  if (!(a < least_acceleration)) return {};
  const std::vector<bool> drives = drive_parameters(staged, car.v_min, car.d_max);
  std::string names;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const std::string name = model.entry->params()[i].name;
    if (!drives[i] || is_constant_of_car(name)) continue;
    if (!model.defaulted[i]) return {};
    names += (names.empty() ? "" : ", ") + name;
  }
  if (names.empty()) return {};
  return "at full throttle this car accelerates by " + significant(a, 2) + " m/s2 at " + number_text(car.v_min) +
         " m/s, expected at least " + number_text(least_acceleration) +
         ": its drive is not stated, and the vehicle model's defaults are another car's (" + names +
         "); state them here (example: worlds/cars/full_size.json)";
}

}  // namespace

void check_drive(const PluginSpec& model, const CarFile& car, Errors& errors) {
  if (!car.known_at || std::ranges::find(model.defaulted, true) == model.defaulted.end()) return;
  constexpr double timeout_s = 10.0;
  const ChildResult result = run_in_child(timeout_s, [&](const SendMessage& send) {
    PluginContext context;
    context.car = car.car;
    const auto made = create<VehicleModel>(*model.entry, context, model.values);
    if (const std::string problem = problem_of(model, StagedCar(*made, model.numbers()), car.car); !problem.empty())
      send(problem);
  });
  for (const std::string& problem : result.messages) errors.add(*car.known_at, problem);
}

}  // namespace gripline
