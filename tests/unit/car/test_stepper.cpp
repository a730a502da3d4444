#include "car/stepper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gripline/plugin.hpp>

#include <cmath>
#include <span>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_stepper {

using namespace testing_support;

/// The 1:43 car with JSON effects.
class TestedCar {
 public:
  explicit TestedCar(const char* effects = "[]") {
    const Node file = load_json(source_dir() / "worlds/cars/orca_1_43.json");
    Errors errors;
    const CarFile car = read_car(file, errors);
    const std::string text =
        R"({"plugin": "dynamic", "params": )" + published_tyres_json + R"(, "effects": )" + effects + "}";
    const VehicleSpec spec = read_vehicle(json(text), plugins(), car, "rk4", errors);
    errors.throw_if_any();
    PluginContext context;
    context.car = car.car;
    vehicle_ = std::make_unique<Vehicle>(spec, context);
  }
  const StagedCar& car() const { return vehicle_->car(); }

 private:
  std::unique_ptr<Vehicle> vehicle_;
};

/// A car in a bend, on the throttle, steering ramping by 0.05 rad over a step of 80 ms: all motion changes.
std::vector<double> step(const TestedCar& tested, const char* method, int substeps) {
  const double dt = 0.08;
  Stepper<double> stepper;
  const Integration integration = {find_tableau(method), substeps};
  const int memory = tested.car().memory();
  stepper.resize(1, memory, integration.tableau->stages, 0);
  const double motion[] = {0.2, -0.1, 0.7, 1.8, 0.15, 3.0};
  std::copy_n(motion, motion_size, stepper.motion.begin());
  std::fill_n(stepper.memory.begin(), memory, 0.02);
  stepper.ramp[0] = {{0.4, 0.10, 0.625}, {0.8, 0.15, 0.625}};
  const Place at;
  stepper.step(tested.car(), integration, dt, 1, &at, nullptr);
  std::vector<double> out(stepper.motion.begin(), stepper.motion.begin() + motion_size);
  out.insert(out.end(), stepper.memory.begin(), stepper.memory.begin() + memory);
  return out;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

class Order : public testing::TestWithParam<std::string> {};

/// The convergence test of the integrators as the product uses them: the car itself, memory included, commands ramping.
TEST_P(Order, OfTheCarsMotionIsTheMethods) {
  const TestedCar tested(R"([{"plugin": "relaxation", "params": {"sigma": 0.1}}])");
  const std::vector<double> exact = step(tested, "rk6", 512);
  double order = 0;
  for (const int substeps : {8, 16}) {
    const double coarse = distance(step(tested, GetParam().c_str(), substeps), exact);
    const double fine = distance(step(tested, GetParam().c_str(), 2 * substeps), exact);
    order = std::log2(coarse / fine);
  }
  EXPECT_NEAR(order, find_tableau(GetParam())->order, 0.4);
}

INSTANTIATE_TEST_SUITE_P(Tableaux, Order, testing::Values("euler", "heun", "rk4", "rkf5", "rk6"),
                         [](const auto& one) { return one.param; });

TEST(Stepper, ManyCarsAtOnceAreEachAlone) {
  const TestedCar tested(R"([{"plugin": "steer_lag", "params": {"tau": 0.03}}])");
  const Integration integration = {find_tableau("rk4"), 2};
  constexpr std::size_t n = 11;
  const auto fill = [](Stepper<double>& stepper, std::size_t slot, std::size_t i) {
    const auto x = static_cast<double>(i);
    const double motion[] = {x, 0, 0.3 * x, 1 + 0.1 * x, 0.02 * x, std::sin(x)};
    std::copy_n(motion, motion_size, stepper.motion.begin() + static_cast<std::ptrdiff_t>(slot * motion_size));
    stepper.memory[slot] = 0.01 * x;
    stepper.ramp[slot] = {{0.1 * x, 0.02 * x, 0.1}, {0.1 * x, 0.03 * x, 0.1}};
  };
  Stepper<double> many, single;
  many.resize(n, 1, 4, 0);
  single.resize(1, 1, 4, 0);
  std::vector<Place> at(n);
  for (std::size_t i = 0; i < n; ++i) {
    fill(many, i, i);
    at[i].grade = 0.01 * static_cast<double>(i);
  }
  many.step(tested.car(), integration, 0.02, n, at.data(), nullptr);
  for (std::size_t i = 0; i < n; ++i) {
    fill(single, 0, i);
    single.step(tested.car(), integration, 0.02, 1, &at[i], nullptr);
    for (std::size_t j = 0; j < motion_size; ++j) EXPECT_EQ(many.motion[i * motion_size + j], single.motion[j]);
    EXPECT_EQ(many.memory[i], single.memory[0]);
  }
}

/// Motion after so long [s] under a held command; `past`, oldest first, are the commands before it.
std::vector<double> held(const TestedCar& tested, std::span<const double> motion, double seconds,
                         const CommandSample<double>& now, std::span<const CommandSample<double>> past = {}) {
  Stepper<double> stepper;
  const std::size_t count = past.empty() ? 0 : past.size() + 1;
  stepper.resize(1, 0, 4, static_cast<int>(count));
  std::ranges::copy(motion, stepper.motion.begin());
  const ActingCommand<double> command = {now.d, now.delta, 0.0};
  stepper.ramp[0] = {command, command};
  stepper.past_dt = seconds;
  stepper.past_offset = -seconds * static_cast<double>(past.size());
  std::ranges::copy(past, stepper.past.begin());
  if (count > 0) stepper.past[past.size()] = now;
  const Place at;
  stepper.step(tested.car(), Integration{}, seconds, 1, &at, nullptr);
  return {stepper.motion.begin(), stepper.motion.begin() + motion_size};
}

/// No method steps over the jump of a held command rightly: the step is cut in two where it jumps.
TEST(Stepper, AStepIsCutWhereALateCommandJumps) {
  const TestedCar late(R"([{"plugin": "input_delay", "params": {"T": 0.03}}])"), prompt;
  const std::vector<double> start = {0.2, -0.1, 0.7, 1.8, 0.15, 3.0};
  const std::vector<CommandSample<double>> past = {{0.1, 0.0}, {0.1, 0.0}, {0.4, 0.10}};
  const CommandSample<double> now = {0.8, 0.15};
  const auto once = held(late, start, 0.02, now, past);
  // 30 ms late in steps of 20 ms: the command before the last one acts for 10 ms, then the last one.
  const auto half = held(prompt, start, 0.01, past[1]), twice = held(prompt, half, 0.01, past[2]);
  for (std::size_t i = 0; i < motion_size; ++i) EXPECT_NEAR(once[i], twice[i], 1e-12) << i;
}

/// Throttle and steering that are late by different times jump at two places of a step: it is cut at both.
TEST(Stepper, AStepIsCutWhereEachLateCommandJumps) {
  const TestedCar late(R"([{"plugin": "throttle_delay", "params": {"T": 0.034}},
                          {"plugin": "steer_delay", "params": {"T": 0.025}}])"),
      prompt;
  const std::vector<double> start = {0.2, -0.1, 0.7, 1.8, 0.15, 3.0};
  const std::vector<CommandSample<double>> past = {{0.1, 0.0}, {0.2, 0.05}, {0.4, 0.10}};
  const auto once = held(late, start, 0.02, {0.8, 0.15}, past);
  auto pieces = held(prompt, start, 0.005, {past[1].d, past[1].delta});
  pieces = held(prompt, pieces, 0.009, {past[1].d, past[2].delta});
  pieces = held(prompt, pieces, 0.006, {past[2].d, past[2].delta});
  for (std::size_t i = 0; i < motion_size; ++i) EXPECT_NEAR(once[i], pieces[i], 1e-12) << i;
}

/// vx' = 3 t^2.
class Clock final : public AutoDiffEffect<Clock> {
 public:
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p) const {
    p.q.ax = T(3.0 * p.at.t * p.at.t);
  }
};

/// The place is held over a step, its time moves along.
TEST(Stepper, TimeRunsWithinAStep) {
  const TestedCar tested;
  const Clock clock;
  StagedCar car = tested.car();
  car.add(clock, {}, "clock");
  for (const int substeps : {1, 3}) {
    const Integration integration = {find_tableau("rk4"), substeps};
    Stepper<double> stepper;
    stepper.resize(1, 0, integration.tableau->stages, 0);
    const double motion[] = {0, 0, 0, 2, 0, 0};
    std::copy_n(motion, motion_size, stepper.motion.begin());
    Place at;
    at.t = 1.5;
    stepper.step(car, integration, 0.1, 1, &at, nullptr);
    EXPECT_NEAR(stepper.motion[3] - 2, std::pow(1.6, 3) - std::pow(1.5, 3), 1e-14);
    EXPECT_EQ(at.t, 1.5);
  }
}

TEST(Stepper, LookTellsTheStartOfTheStep) {
  const TestedCar tested;
  Stepper<double> stepper;
  stepper.resize(1, 0, 4, 0);
  const double motion[] = {0, 0, 0, 2, 0.1, 1};
  std::copy_n(motion, motion_size, stepper.motion.begin());
  stepper.ramp[0] = {{0.2, 0.05, 5}, {0.9, 0.15, 5}};
  const Place at;
  Quantities<double> q{};
  stepper.quantities(tested.car(), 0.02, 1, &at, nullptr, &q);
  EXPECT_EQ(q.d, 0.2);
  EXPECT_EQ(q.delta, 0.05);
  EXPECT_EQ(q.delta_rate, 5);
  EXPECT_NEAR(q.force_front, 0.192 * std::sin(1.2 * std::atan(2.579 * (0.05 - std::atan2(0.029 + 0.1, 2.0)))), 1e-15);
  EXPECT_EQ(stepper.motion[3], 2);  // nothing moved
}

}  // namespace test_stepper
}  // namespace gripline
