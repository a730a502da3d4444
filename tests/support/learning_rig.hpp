// What the tests of estimators share: plugins by id, the 1:43 car's nominal model, a plain simulation of its true
// equations (written out again, apart from the product's), and the shared logs as samples.
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
#include "plugin/registry.hpp"
#include "support/paths.hpp"
#include "support/published_car.hpp"
#include "support/reference_data.hpp"

namespace gripline::rig {

inline constexpr double dt = 0.02;

inline Car small_car() {
  Car car;
  car.m = 0.041;
  car.Iz = 27.8e-6;
  car.lf = 0.029;
  car.lr = 0.033;
  car.length = 0.06;
  car.width = 0.03;
  car.d_min = -0.1;
  car.d_max = 1.0;
  car.delta_max = 0.35;
  car.ddelta_max = 5.0;
  car.v_ref = 2.0;
  car.v_min = 0.3;
  return car;
}

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
  static StepOptions options(const char* tableau) {
    StepOptions options;
    options.dt = dt;
    options.hold = Hold::zoh;
    options.integration.tableau = find_tableau(tableau);
    return options;
  }

 private:
  const PluginEntry& entry_;
  std::vector<gripline::abi::ParamValue> values_;
  Instance<VehicleModel> model_;
  CorrectedModel prediction_;
};

/// The published 1:43 car, by the equations of the paper; friction multiplies both axles' peaks.
struct TrueCar {
  Car car = small_car();
  double Bf = 2.579, Cf = 1.2, Df = 0.192, Br = 3.3852, Cr = 1.2691, Dr = 0.1737;
  double Cm1 = 0.287, Cm2 = 0.0545, Cr0 = 0.0518, Cd = 0.00035;
  double factor = 1.0;

  double force(Axle axle, double slip) const {
    return axle == Axle::front ? factor * Df * std::sin(Cf * std::atan(Bf * slip))
                               : factor * Dr * std::sin(Cr * std::atan(Br * slip));
  }
  double peak(Axle axle, double reach) const {
    double best = 0;
    for (double slip = 0; slip <= reach; slip += 0.001) best = std::max(best, force(axle, slip));
    return best;
  }
  double mu_visited(double reach_front, double reach_rear) const {
    return (peak(Axle::front, reach_front) + peak(Axle::rear, reach_rear)) / (car.m * gravity);
  }
  double mu() const { return factor * (Df + Dr) / (car.m * gravity); }

  double front_slip(const State& x) const { return x.delta - std::atan2(x.omega * car.lf + x.vy, std::abs(x.vx)); }
  double rear_slip(const State& x) const { return std::atan2(x.omega * car.lr - x.vy, std::abs(x.vx)); }

  /// x.delta is the angle that acts.
  State rates(const State& x, double d, double grade = 0, double bank = 0) const {
    const double ff = force(Axle::front, front_slip(x)), fr = force(Axle::rear, rear_slip(x));
    State r;
    r.x = x.vx * std::cos(x.yaw) - x.vy * std::sin(x.yaw);
    r.y = x.vx * std::sin(x.yaw) + x.vy * std::cos(x.yaw);
    r.yaw = x.omega;
    r.vx = ((Cm1 - Cm2 * x.vx) * d - Cr0 - Cd * x.vx * x.vx - ff * std::sin(x.delta)) / car.m + x.vy * x.omega -
           gravity * std::sin(grade);
    r.vy = (fr + ff * std::cos(x.delta)) / car.m - x.vx * x.omega + gravity * std::sin(bank);
    r.omega = (ff * car.lf * std::cos(x.delta) - fr * car.lr) / car.Iz;
    return r;
  }

  /// One control step, steering held: twenty classical Runge-Kutta steps.
  State step(State x, const Input& u, double grade = 0, double bank = 0) const {
    x.delta += u.ddelta * dt;
    const double h = dt / 20;
    const auto moved = [](State a, const State& r, double by) {
      a.x += by * r.x;
      a.y += by * r.y;
      a.yaw += by * r.yaw;
      a.vx += by * r.vx;
      a.vy += by * r.vy;
      a.omega += by * r.omega;
      return a;
    };
    for (int i = 0; i < 20; ++i) {
      const State k1 = rates(x, u.d, grade, bank);
      const State k2 = rates(moved(x, k1, h / 2), u.d, grade, bank);
      const State k3 = rates(moved(x, k2, h / 2), u.d, grade, bank);
      const State k4 = rates(moved(x, k3, h), u.d, grade, bank);
      x = moved(moved(moved(moved(x, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
    }
    return x;
  }
};

/// Algorithm 1, line 4: one step as the stack sees it.
inline Sample make_sample(CorrectedModel& nominal, std::int64_t step, const State& x, const Input& u,
                          const State& x_next, const Place& at = {}) {
  Sample k;
  k.t = static_cast<double>(step) * dt;
  k.dt = dt;
  k.step = step;
  k.x = x;
  k.u = u;
  k.at = k.at_next = at;
  k.x_next = x_next;
  const State predicted = nominal.advance(x, u, at);
  k.e_vx = (x_next.vx - predicted.vx) / dt;
  k.e_vy = (x_next.vy - predicted.vy) / dt;
  k.e_omega = (x_next.omega - predicted.omega) / dt;
  return k;
}

/// A driver of bends: every 0.3 to 0.8 s another curvature, the speed it allows at 85 % of the friction; seeded.
class BendDriver {
 public:
  explicit BendDriver(unsigned seed) : state_(seed * 2654435761u + 1u) {}
  Input drive(const State& x, const TrueCar& truth) {
    if (left_-- <= 0) {
      left_ = 15 + static_cast<int>(25 * random());
      const double sharpest = 4.5;
      curvature_ = (random() < 0.2 ? 0.1 : 1.0) * sharpest * (2 * random() - 1);
      if (std::abs(curvature_) < 0.3) curvature_ = 0;
    }
    const Car& car = truth.car;
    const double speed = std::min(2.8, std::sqrt(0.95 * truth.mu() * gravity / std::max(0.05, std::abs(curvature_))));
    const double wanted = std::atan((car.lf + car.lr) * curvature_) + 0.12 * (curvature_ * x.vx - x.omega) +
                          (curvature_ > 0 ? 1 : -1) * (curvature_ == 0 ? 0 : 0.15);
    const double delta = std::clamp(wanted, -car.delta_max, car.delta_max);
    Input u;
    u.ddelta = std::clamp((delta - x.delta) / dt, -car.ddelta_max, car.ddelta_max);
    u.d = std::clamp(0.25 + 1.0 * (speed - x.vx), car.d_min, car.d_max);
    return u;
  }

 private:
  double random() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  std::uint64_t state_;
  int left_ = 0;
  double curvature_ = 0;
};

/// A sequence of steps of the true car: states (steering as it acted before each), inputs, friction factors.
struct Drive {
  std::vector<State> x;
  std::vector<Input> u;
  std::vector<double> factor;
  std::size_t steps() const { return x.size() - 1; }
};

/// The bend driver for `seconds`, friction by time.
template <class Factor>
Drive drive_bends(double seconds, unsigned seed, const Factor& factor_at) {
  BendDriver driver(seed);
  TrueCar truth;
  Drive drive;
  State x;
  x.vx = 0.5;
  drive.x.push_back(x);
  for (int i = 0; i * dt < seconds; ++i) {
    truth.factor = factor_at(i * dt);
    drive.factor.push_back(truth.factor);
    drive.u.push_back(driver.drive(drive.x.back(), truth));
    drive.x.push_back(truth.step(drive.x.back(), drive.u.back()));
  }
  return drive;
}

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
