// Small logs with known effects, for tests of the diagnosis: the 1:43 car under a smooth, seeded command signal.
#pragma once

#include <cmath>
#include <filesystem>
#include <random>

#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "diagnose/inference/fit.hpp"
#include "measured/replay/replay.hpp"
#include "support/paths.hpp"
#include "world/world_spec.hpp"

namespace gripline::test {

class DiagnoseRig {
 public:
  /// `more_plugins`: folders beside the shipped plugins. `patch`: a JSON merge patch of the world.
  explicit DiagnoseRig(std::vector<std::string> exclude = {}, std::vector<std::filesystem::path> more_plugins = {},
                       std::string_view patch = "{}")
      : registry_(with_shipped(std::move(more_plugins))),
        world_(load(patch)),
        catalogue_(world_.vehicle, world_.car.car, registry_, exclude),
        road_(world_.track) {}

  diagnose::Catalogue& catalogue() { return catalogue_; }
  const diagnose::Catalogue& catalogue() const { return catalogue_; }
  const measured::Road& road() const { return road_; }
  const WorldSpec& world() const { return world_; }
  const Registry& registry() const { return registry_; }

  /// Makes the diagnosis refit these nominal parameters, with a prior deviation of this share of their values.
  void trust(const std::vector<const char*>& names, double share) {
    std::vector<diagnose::Nuisance> nuisances;
    for (const char* name : names) {
      diagnose::Nuisance& n = nuisances.emplace_back();
      n.name = name;
      n.nominal = catalogue_.nominal(name, &n.index);
      n.sigma = share * n.nominal;
    }
    catalogue_.set_nuisances(nuisances);
  }

  /// A model with one effect whose fitted parameters have these values.
  diagnose::ModelSpec with(const std::string& id, const std::vector<double>& fitted) const {
    return with(catalogue_.null_model(), id, fitted);
  }
  diagnose::ModelSpec with(const diagnose::ModelSpec& model, const std::string& id,
                           const std::vector<double>& fitted) const {
    const std::size_t c = catalogue_.find(id);
    diagnose::ModelSpec more = catalogue_.with(model, c);
    for (std::size_t f = 0; f < fitted.size(); ++f)
      more.values[more.position(c)][catalogue_.candidates()[c].fitted[f]] = fitted[f];
    return more;
  }

  struct Drive {
    double seconds = 20;
    std::uint64_t seed = 1;
    double noise = 1;                                  // factor on the world's sensor noise
    double steer = 1;                                  // factor on the steering
    double braking = 0;                                // how far the pedal swings beyond the usual, into the brakes
    std::array<double, 3> rough{};                     // process noise of framework/doc/diagnose-cases.md, times these
    double noise_time = diagnose::default_noise_time;  // its correlation time [s]
    measured::Channels colour{};                       // lag-one correlation of the sensors' noise
    double unsteady = 0;    // of hands and feet: steps of 0.01 rad and 0.06, fading in 0.16 s
    double jumps = 0;       // of hands and feet: of 0.08 rad and 0.5, fading so too; share of samples that have one
    bool held = false;      // commands act until the next
    double steer_step = 0;  // [rad] the car is given rounded steering
  };
  /// What the sensors of a car with this model show while it weaves around; samples 20 ms apart.
  measured::Log simulate(const diagnose::ModelSpec& truth, const Drive& drive) const {
    const StagedCar car = catalogue_.build(truth);
    measured::Log log;
    log.hold.until_next = drive.held;
    const auto n = static_cast<std::size_t>(std::round(drive.seconds / log.dt)) + 1;
    std::mt19937_64 random(drive.seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double a = normal(random), b = normal(random);
    CommandSample<double> shaking{0.0, 0.0};
    for (std::size_t k = 0; k < n; ++k) {
      const double t = static_cast<double>(k) * log.dt;
      const double turn = std::sin(0.9 * t + a) > 0.0 ? 1.0 : -1.0;
      const double delta = drive.steer * (0.16 * std::sin(2.1 * t + a) + 0.05 * turn * std::sin(5.7 * t + b));
      if (drive.unsteady > 0.0)
        shaking = {0.88 * shaking.d + 0.06 * drive.unsteady * normal(random),
                   0.88 * shaking.delta + 0.01 * drive.unsteady * normal(random)};
      if (drive.jumps > 0.0) {
        const auto jump = [&] { return uniform(random) < drive.jumps ? normal(random) : 0.0; };
        shaking = {0.88 * shaking.d + 0.5 * jump(), 0.88 * shaking.delta + 0.08 * jump()};
      }
      const double d = 0.55 + (0.25 + drive.braking) * std::sin(1.3 * t + b) + 0.1 * std::sin(7.9 * t);
      log.command.push_back({d + shaking.d, delta + shaking.delta});
      if (drive.steer_step > 0.0) round_steering(log.command.back(), drive.steer_step);
    }
    std::vector<double> x = {1.0, 0.5, 0.3, 1.6, 0.0, 0.0}, memory(static_cast<std::size_t>(car.memory()));
    double hint = std::nan("");
    Place at = road_.at(0.0, x[0], x[1], x[2], hint);
    const ActingCommand<double> first = measured::command_at(log, 0, 0.0);
    const History<double> history{log.command.data(), n, 0.0, log.dt, 0.0, Hold::foh};
    CarBatch<double> batch;
    batch.n = 1;
    batch.motion = x.data();
    batch.command = &first;
    batch.at = &at;
    batch.history = &history;
    if (!memory.empty()) car.start_memory(batch, memory.data());
    measured::LogStepper stepping(car, log, 16);
    constexpr std::array<double, 3> typical = {0.1, 0.1, 0.8};  // [m/s2, m/s2, rad/s2]
    std::array<double, 3> road{};
    measured::Channels error{};  // of the sensors, in standard deviations
    const double keeps = std::exp(-log.dt / drive.noise_time);
    for (std::size_t k = 0; k < n; ++k) {
      Reading<double> r{x[0], x[1], x[2], x[3], x[4], x[5]};
      car.read(&r, 1, &at, nullptr);
      const std::array<double, 6> shown = {r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
      for (std::size_t c = 0; c < 6; ++c) {
        const double rho = k == 0 ? 0.0 : drive.colour[c];
        error[c] = rho * error[c] + std::sqrt(1.0 - rho * rho) * normal(random);
        log.reading.push_back(shown[c] + drive.noise * world_.sensors.channels[c].sigma * error[c]);
      }
      if (k + 1 == n) break;
      Place next = road_.at(static_cast<double>(k + 1) * log.dt, x[0] + log.dt * x[3] * std::cos(x[2]),
                            x[1] + log.dt * x[3] * std::sin(x[2]), x[2], hint);
      stepping.advance({&k, 1}, {&at, 1}, {&next, 1}, x.data(), memory.data());
      for (std::size_t c = 0; c < 3 && drive.rough != std::array<double, 3>{}; ++c) {
        road[c] = keeps * road[c] + std::sqrt(1.0 - keeps * keeps) * drive.rough[c] * typical[c] * normal(random);
        x[3 + c] += log.dt * road[c];
      }
      at = road_.at(static_cast<double>(k + 1) * log.dt, x[0], x[1], x[2], hint);
    }
    return log;
  }

  static void round_steering(CommandSample<double>& command, double step) {
    command.delta = step * std::round(command.delta / step);
  }
  /// A log whose recorder rounded the steering.
  static measured::Log rounded(measured::Log log, double step) {
    for (CommandSample<double>& one : log.command) round_steering(one, step);
    return log;
  }

  /// Every second sample of a log, or one of more.
  static measured::Log thinned(const measured::Log& log, std::size_t every = 2) {
    measured::Log less;
    less.dt = static_cast<double>(every) * log.dt;
    for (std::size_t k = 0; k < log.size(); k += every) {
      less.command.push_back(log.command[k]);
      const auto row = log.reading.begin() + static_cast<std::ptrdiff_t>(6 * k);
      less.reading.insert(less.reading.end(), row, row + 6);
    }
    return less;
  }

  /// A problem of these logs, the world's noise levels assumed.
  diagnose::Problem problem(std::vector<measured::Log> logs) const {
    diagnose::Problem p;
    p.catalogue = &catalogue_;
    for (std::size_t c = 0; c < 6; ++c) p.sensor[c] = world_.sensors.channels[c].sigma;
    p.process_unit = {0.1, 0.1, 1.6};
    for (measured::Log& log : logs) {
      measured::Trace trace;
      trace.log = std::move(log);
      trace.set_motion(measured::smooth_readings(trace.log, 3), road_);
      p.rows += 6 * trace.size();
      p.traces.push_back(std::move(trace));
    }
    return p;
  }

  diagnose::Noise noise(const diagnose::Problem& p, double process) const {
    diagnose::Noise n;
    n.sensor = p.sensor;
    for (std::size_t i = 0; i < diagnose::noise_states; ++i) n.process[i] = std::pow(process * p.process_unit[i], 2);
    return n;
  }

 private:
  static std::vector<std::filesystem::path> with_shipped(std::vector<std::filesystem::path> folders) {
    folders.push_back(testing_support::plugin_dir());
    return folders;
  }
  WorldSpec load(std::string_view patch) const {
    Errors errors;
    const Node world_file = load_json(testing_support::source_dir() / "worlds/diagnose_rc43.json");
    WorldSpec world = read_world(merge(world_file, parse_text(patch, "patch")), registry_, errors);
    errors.throw_if_any();
    return world;
  }

  Registry registry_;
  WorldSpec world_;
  diagnose::Catalogue catalogue_;
  measured::Road road_;
};

}  // namespace gripline::test
