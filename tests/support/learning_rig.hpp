// What the tests of estimators share: plugins and effects by id, the 1:43 car's nominal model, the conformance kit's
// drives of its true equations (written out again, apart from the product's), and the shared logs as samples.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "car/corrected_model.hpp"
#include "conformance/recorded_drive.hpp"
#include "plugin/registry.hpp"
#include "support/paths.hpp"
#include "support/published_car.hpp"
#include "support/reference_data.hpp"

namespace gripline::rig {

using conformance::BendDriver;
using conformance::Drive;
using conformance::drive_bends;
using conformance::dt;
using conformance::make_sample;
using conformance::small_car;
using conformance::TrueCar;

inline Registry& registry() {
  static Registry one({testing_support::plugin_dir()});
  return one;
}

using Settings = std::map<std::string, double>;

inline std::vector<gripline::abi::ParamValue> values_of(const PluginEntry& entry, const Settings& settings) {
  std::vector<gripline::abi::ParamValue> values;
  for (const gripline::abi::ParamDecl& one : entry.params()) {
    const auto set = settings.find(one.name);
    values.push_back({set == settings.end() ? testing_support::published(entry, one) : set->second, {}});
  }
  return values;
}

/// A nominal model alone, as a Prediction.
class Nominal {
 public:
  explicit Nominal(const std::string& id, const Settings& settings = {}, const char* tableau = "rk4")
      : entry_(registry().find(gripline::abi::Kind::vehicle, id)),
        values_(values_of(entry_, settings)),
        model_(create<VehicleModel>(entry_, PluginContext{}, values_)),
        prediction_(car(), options(tableau)) {}

  CorrectedModel& prediction() { return prediction_; }
  StagedCar car() const {
    std::vector<double> params;
    for (const auto& value : values_) params.push_back(value.number);
    return StagedCar(*model_, params);
  }
  static StepOptions options(const char* tableau, int substeps = 1) {
    StepOptions options;
    options.dt = dt;
    options.hold = Hold::zoh;
    options.integration.tableau = find_tableau(tableau);
    options.integration.substeps = substeps;
    return options;
  }

 private:
  const PluginEntry& entry_;
  std::vector<gripline::abi::ParamValue> values_;
  Instance<VehicleModel> model_;
  CorrectedModel prediction_;
};

/// An effect with the parameters that are set, and the others as declared.
class OneEffect {
 public:
  OneEffect(const std::string& id, const Settings& settings)
      : entry_(registry().find(abi::Kind::effect, id)),
        values_(values_of(entry_, settings)),
        effect_(create<Effect>(entry_, PluginContext{}, values_)) {}
  void add_to(StagedCar& car) const {
    std::vector<double> params;
    for (const auto& value : values_) params.push_back(value.number);
    car.add(*effect_, params, entry_.decl->id);
  }

 private:
  const PluginEntry& entry_;
  std::vector<abi::ParamValue> values_;
  Instance<Effect> effect_;
};

/// Gaussian noise as the sensors of the 1:43 car have it (framework/doc/worlds.md), seeded.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}
  State read(State x) {
    x.vx += 0.02 * normal_(random_);
    x.vy += 0.02 * normal_(random_);
    x.omega += 0.05 * normal_(random_);
    return x;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// Largest slips of a drive so far, as framework/doc/metrics.md counts them for the visited mu.
struct Visited {
  double front = 0, rear = 0;
  void see(const TrueCar& truth, const State& x) {
    if (x.vx < truth.car.v_min) return;
    front = std::max(front, std::abs(truth.front_slip(x)));
    rear = std::max(rear, std::abs(truth.rear_slip(x)));
  }
  /// Friction by the true curves' maxima up to these slips.
  double mu(const TrueCar& truth) const {
    const auto peak = [&](Axle axle, double reach) {
      double best = 0;
      for (double slip = 0; slip <= reach; slip += 0.001) best = std::max(best, truth.force(axle, slip));
      return best;
    };
    return (peak(Axle::front, front) + peak(Axle::rear, rear)) / (truth.car.m * gravity);
  }
};

/// An estimator of the 1:43 car behind a nominal model.
inline Instance<Estimator> make_estimator(const std::string& id, Nominal& nominal, const Settings& settings = {},
                                          std::uint64_t seed = 1, const Truth* truth = nullptr) {
  const PluginEntry& entry = registry().find(gripline::abi::Kind::estimator, id);
  PluginContext context;
  context.car = small_car();
  context.dt = dt;
  context.seed = seed;
  context.mu_init = 1.0;
  context.nominal = &nominal.prediction();
  context.truth = truth;
  return create<Estimator>(entry, context, values_of(entry, settings));
}

/// The nominal model corrected by an estimator.
inline CorrectedModel corrected(const Nominal& nominal, const Estimator& estimator) {
  StagedCar car = nominal.car();
  car.add(estimator, {}, "estimator");
  return CorrectedModel(std::move(car), Nominal::options("rk4"));
}

/// Shares of the variance of e_vx, e_vy, e_omega that the correction explains, and the rms of what is left.
struct Validation {
  std::array<double, 3> r2{}, rmse{};
};
inline Validation validate(Nominal& nominal, const Estimator& estimator, const Drive& drive) {
  CorrectedModel model = corrected(nominal, estimator);
  std::array<double, 3> sum{}, squares{}, left{};
  double n = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    if (drive.x[i].vx < small_car().v_min) continue;
    const State& next = drive.x[i + 1];
    const State plain = nominal.prediction().advance(drive.x[i], drive.u[i], {});
    const State better = model.advance(drive.x[i], drive.u[i], {});
    const double e[] = {next.vx - plain.vx, next.vy - plain.vy, next.omega - plain.omega};
    const double rest[] = {next.vx - better.vx, next.vy - better.vy, next.omega - better.omega};
    for (int c = 0; c < 3; ++c) {
      sum[c] += e[c] / dt;
      squares[c] += e[c] * e[c] / (dt * dt);
      left[c] += rest[c] * rest[c] / (dt * dt);
    }
    n += 1;
  }
  Validation out;
  for (int c = 0; c < 3; ++c) {
    out.r2[c] = 1.0 - left[c] / (squares[c] - sum[c] * sum[c] / n);
    out.rmse[c] = std::sqrt(left[c] / n);
  }
  return out;
}

/// Feeds a whole drive, noise-free.
inline void learn(Estimator& estimator, Nominal& nominal, const Drive& drive) {
  for (std::size_t i = 0; i < drive.steps(); ++i)
    estimator.update(
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]));
}

/// Relative error of the resistance force that a corrected model has on a straight, worst over the speeds driven.
inline double resistance_error(Nominal& nominal, const Estimator& estimator) {
  CorrectedModel model = corrected(nominal, estimator);
  const TrueCar truth;
  double worst = 0;
  for (double v = 1.0; v <= 2.6; v += 0.2) {
    State x;
    x.vx = v;
    const double found = nominal.prediction().rates(x, {0.3, 0}, {}).vx - model.rates(x, {0.3, 0}, {}).vx;
    worst = std::max(worst, std::abs(found * truth.car.m / (truth.Cr0 + truth.Cd * v * v) - 1.0));
  }
  return worst;
}

/// Discrete Jacobians of a model at a state under an input against central differences, relative to their size.
inline double jacobian_error(CorrectedModel& model, const State& state, const Input& input, double difference = 1e-6) {
  const auto n = static_cast<std::size_t>(model.states());
  const Place at;
  std::vector<double> x(n), next(n), A(n * n), B(2 * n), u = {input.d, input.ddelta};
  model.start(state, x);
  model.step(1, x, u, {&at, 1}, next, A, B);
  double worst = 0;
  std::vector<double> lo(n), hi(n);
  for (std::size_t j = 0; j < n + 2; ++j) {
    double& variable = j < n ? x[j] : u[j - n];
    const double kept = variable, h = difference * std::max(1.0, std::abs(kept));
    variable = kept + h;
    model.step(1, x, u, {&at, 1}, hi, {}, {});
    variable = kept - h;
    model.step(1, x, u, {&at, 1}, lo, {}, {});
    variable = kept;
    for (std::size_t i = 0; i < n; ++i) {
      const double expected = (hi[i] - lo[i]) / (2 * h);
      const double found = j < n ? A[i * n + j] : B[i * 2 + (j - n)];
      worst = std::max(worst, std::abs(found - expected) / std::max(1.0, std::abs(expected)));
    }
  }
  return worst;
}

/// Columns by name from a CSV file with one header line.
inline std::map<std::string, std::vector<double>> read_columns(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, cell;
  std::getline(in, line);
  std::vector<std::string> names;
  for (std::stringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  std::map<std::string, std::vector<double>> columns;
  while (std::getline(in, line)) {
    std::stringstream row(line);
    for (const std::string& name : names) {
      std::getline(row, cell, ',');
      columns[name].push_back(std::stod(cell));
    }
  }
  return columns;
}

/// One of the shared logs, rows with t <= until: the inputs of a row act from it on.
inline Drive read_log(const std::string& name, double until = 1e9) {
  auto columns = read_columns(testing_support::reference_root() / "reference" / name);
  Drive log;
  double delta = 0;
  for (std::size_t i = 0; i < columns["t_s"].size() && columns["t_s"][i] <= until; ++i) {
    const double steer = columns["steer_cmd_rad"][i];
    State x;
    x.x = columns["x_m"][i];
    x.y = columns["y_m"][i];
    x.yaw = columns["psi_rad"][i];
    x.vx = columns["vx_mps"][i];
    x.vy = columns["vy_mps"][i];
    x.omega = columns["omega_radps"][i];
    x.delta = delta;
    log.x.push_back(x);
    log.u.push_back({columns["pwm_cmd"][i], (steer - delta) / dt});
    delta = steer;
  }
  return log;
}

}  // namespace gripline::rig
