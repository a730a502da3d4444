#include "race/state_filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "race/assembly.hpp"
#include "support/allocation_counter.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_state_filter {

using testing::HasSubstr;
using namespace testing_support;

/// A car without forces on a straight: positions move with the velocities, the rest stays. One number of memory, which
/// a filter has to skip.
class Gliding final : public Prediction {
 public:
  int states() const noexcept override { return state_size + 1; }
  double dt() const noexcept override { return 0.02; }
  void start(const State& now, std::span<double> x) const override {
    const double row[] = {now.x, now.y, now.yaw, now.vx, now.vy, now.omega, now.delta, 7.0};
    std::copy(std::begin(row), std::end(row), x.begin());
  }
  void step(std::size_t, std::span<const double> x, std::span<const double>, std::span<const Place>,
            std::span<double> x_next, std::span<double> A, std::span<double>) override {
    std::copy(x.begin(), x.end(), x_next.begin());
    std::fill(A.begin(), A.end(), 0.0);
    for (std::size_t i = 0; i < x.size(); ++i) A[i * x.size() + i] = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
      x_next[i] += dt() * x[3 + i];
      A[i * x.size() + 3 + i] = dt();
    }
  }
  Rates rates(const State&, const Input&, const Place&) override { return {}; }
};

constexpr StateFilterSpec noisy = {{0.002, 0.002, 0.005, 0.02, 0.02, 0.05}, {0.5, 0.5, 5.0}};

const ChannelSet every = ChannelSet().set();

/// Readings that are exact are taken as they are, whatever the model says.
TEST(StateFilter, WithoutNoiseItShowsTheReading) {
  for (const double drift : {0.0, 0.5}) {
    StateFilter filter({{}, {drift, drift, 10 * drift}});
    Gliding model;
    filter.start({0, 0, 0, 1, 0, 0, 0});
    filter.predict(model, {}, {});
    const State reading{0.3, -0.2, 0.1, 2.0, 0.4, -1.0, 0.05};
    filter.update(reading, every);
    for (const auto member : {&State::x, &State::y, &State::yaw, &State::vx, &State::vy, &State::omega, &State::delta})
      EXPECT_NEAR(filter.state().*member, reading.*member, 1e-12);
  }
}

/// A velocity that is read alone is a random walk in white noise. The filter's gain goes to
/// K = M / (M + r), M = (q + sqrt(q^2 + 4 q r)) / 2 (the scalar Riccati equation), q and r variances of walk and
/// reading.
TEST(StateFilter, ItsGainIsThatOfTheRiccatiEquation) {
  StateFilterSpec spec = noisy;
  spec.sigma[0] = spec.sigma[1] = spec.sigma[2] = 1e6;  // no position says anything of the velocity
  StateFilter filter(spec);
  Gliding model;
  filter.start({0, 0, 0, 1, 0, 0, 0});
  for (int i = 0; i < 200; ++i) {
    filter.predict(model, {}, {});
    filter.update(filter.state(), every);
  }
  const double q = std::pow(0.5 * 0.02, 2), r = 0.02 * 0.02, M = 0.5 * (q + std::sqrt(q * q + 4 * q * r));
  filter.predict(model, {}, {});
  State reading = filter.state();
  reading.vx += 0.01;
  const double before = filter.state().vx;
  filter.update(reading, every);
  EXPECT_NEAR((filter.state().vx - before) / 0.01, M / (M + r), 1e-6);
}

/// On a car that does what the model says, noise shrinks: positions to less than half, as speeds say where the car
/// goes.
TEST(StateFilter, ShrinksTheNoiseOfACarThatTheModelKnows) {
  StateFilter filter({noisy.sigma, {0.05, 0.05, 0.5}});
  Gliding model;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  State truth{0, 0, 0, 1, 0.1, 0.2, 0};
  double read = 0, filtered = 0;
  filter.start(truth);
  for (int i = 0; i < 2000; ++i) {
    truth.x += 0.02 * truth.vx, truth.y += 0.02 * truth.vy, truth.yaw += 0.02 * truth.omega;
    State reading = truth;
    reading.x += 0.002 * normal(random), reading.y += 0.002 * normal(random), reading.yaw += 0.005 * normal(random);
    reading.vx += 0.02 * normal(random), reading.vy += 0.02 * normal(random), reading.omega += 0.05 * normal(random);
    filter.predict(model, {}, {});
    filter.update(reading, every);
    read += std::pow(reading.y - truth.y, 2);
    filtered += std::pow(filter.state().y - truth.y, 2);
  }
  EXPECT_LT(std::sqrt(filtered / read), 0.5);
  EXPECT_GT(filtered, 0.0);
}

/// Where friction falls the model is wrong by far more than its drift: the filter must not go on believing it.
TEST(StateFilter, FollowsAReadingThatTheModelCannotExplain) {
  StateFilter filter(noisy);
  Gliding model;
  filter.start({0, 0, 0, 1, 0, 0, 0});
  for (int i = 0; i < 50; ++i) {
    filter.predict(model, {}, {});
    filter.update(filter.state(), every);
  }
  filter.predict(model, {}, {});
  State reading = filter.state();
  reading.vy += 0.3;
  filter.update(reading, every);
  EXPECT_GT(filter.state().vy, 0.28);
}

/// A channel that is held shows the past: until its next reading the state goes where the model and the others take it,
/// and in doubt, so that the next reading counts for more than one of many.
TEST(StateFilter, AHeldReadingIsNotTakenAgain) {
  StateFilter filter(noisy), slow(noisy);
  Gliding model;
  const State start{0, 0, 0, 1, 0, 0, 0};
  filter.start(start);
  slow.start(start);
  ChannelSet without_x = every;
  without_x.reset(0);
  for (int i = 0; i < 50; ++i) {
    filter.predict(model, {}, {});
    slow.predict(model, {}, {});
    State held = slow.state();
    const double predicted = held.x;
    if (i % 10 != 9) held.x -= 1.0;
    held.delta = 0.01 * i;
    filter.update(filter.state(), every);
    slow.update(held, i % 10 == 9 ? every : without_x);
    EXPECT_DOUBLE_EQ(slow.state().x, predicted);
    EXPECT_EQ(slow.state().delta, held.delta);
  }
  const auto gain = [&](StateFilter& of) {
    of.predict(model, {}, {});
    State reading = of.state();
    const double before = reading.x;
    reading.x += 1e-3;
    of.update(reading, every);
    return (of.state().x - before) / 1e-3;
  };
  const double often = gain(filter);
  EXPECT_LT(often, 0.5);
  EXPECT_GT(gain(slow), 1.2 * often);
}

TEST(StateFilter, AllocatesOnlyInItsFirstStep) {
  if (!rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  StateFilter filter(noisy);
  Gliding model;
  filter.start({});
  filter.predict(model, {}, {});
  const long before = rig::allocations.load();
  for (int i = 0; i < 10; ++i) {
    filter.predict(model, {}, {});
    filter.update({}, every);
  }
  EXPECT_EQ(rig::allocations.load() - before, 0);
}

/// In a race: what planner and controller act on is nearer to the truth than the readings, place and all; without a
/// filter it is the readings.
TEST(StateFilter, PlannerAndControllerActOnIt) {
  const WorldSpec world = world_of(R"({"duration": "2 s", "start": {"speed": 1},
    "sensors": {"sigma": {"x": "5 mm", "y": "5 mm", "vx": 0.05, "vy": 0.05, "yaw_rate": 0.05}}})");
  const auto errors = [&](const std::string& stack) {
    const StackSpec spec = stack_of(world.car, stack);
    RaceAssembly race(world, spec, {.seed = 5});
    race.simulation().start();
    double read = 0, acted = 0;
    for (int i = 0; i < 100; ++i) {
      race.simulation().step();
      const State &truth = race.world().state(), &shown = race.simulation().now().x;
      const Observation& used = race.simulation().acted_on();
      read += std::pow(shown.y - truth.y, 2);
      acted += std::pow(used.x.y - truth.y, 2);
      EXPECT_NEAR(used.at.n, race.world().course().locate(used.x.x, used.x.y, used.at.s).n, 1e-9);
    }
    return acted / read;
  };
  EXPECT_DOUBLE_EQ(errors("{}"), 1.0);
  EXPECT_LT(errors(R"({"model": {"plugin": "dynamic", "params": )" + published_tyres_json + R"(},
    "state_filter": {"sigma": {"x": "5 mm", "y": "5 mm", "vx": 0.05, "vy": 0.05, "yaw_rate": 0.05}}})"),
            0.5);
}

/// With positions at 10 Hz beside speeds at 50 Hz: where the car is, and not where it was when it was last told.
TEST(StateFilter, FollowsTheCarBetweenTheReadingsOfASlowSensor) {
  const WorldSpec world = world_of(R"({"duration": "2 s", "start": {"speed": 1}, "sensors": {
    "sigma": {"x": "5 mm", "y": "5 mm", "vx": 0.05, "vy": 0.05, "yaw_rate": 0.05},
    "rate": {"x": "10 Hz", "y": "10 Hz"}}})");
  const StackSpec spec =
      stack_of(world.car, R"({"model": {"plugin": "dynamic", "params": )" + published_tyres_json + R"(},
    "state_filter": {"sigma": {"x": "5 mm", "y": "5 mm", "vx": 0.05, "vy": 0.05, "yaw_rate": 0.05}}})");
  RaceAssembly race(world, spec, {.seed = 5});
  race.simulation().start();
  double read = 0, acted = 0;
  for (int i = 0; i < 100; ++i) {
    race.simulation().step();
    const State &truth = race.world().state(), &shown = race.simulation().now().x;
    const State& used = race.simulation().acted_on().x;
    read += std::pow(shown.x - truth.x, 2) + std::pow(shown.y - truth.y, 2);
    acted += std::pow(used.x - truth.x, 2) + std::pow(used.y - truth.y, 2);
  }
  EXPECT_GT(std::sqrt(read / 100), 0.03);
  EXPECT_LT(std::sqrt(acted / 100), 0.015);
}

StateFilterSpec filter_of(const char* text) {
  const CarFile car = world_of().car;
  return *stack_of(car, std::string(R"({"state_filter": )") + text + "}").state_filter;
}

TEST(StateFilter, IsReadStrictly) {
  const StateFilterSpec spec = filter_of(R"({"sigma": {"x": "2 mm", "yaw_rate": 0.05}, "drift": {"vy": "2 m/s2"}})");
  EXPECT_DOUBLE_EQ(spec.sigma[0], 0.002);
  EXPECT_DOUBLE_EQ(spec.sigma[1], 0.0);
  EXPECT_DOUBLE_EQ(spec.sigma[5], 0.05);
  EXPECT_DOUBLE_EQ(spec.drift[0], 0.1 * gravity);
  EXPECT_DOUBLE_EQ(spec.drift[1], 2.0);
  const Car car = world_of().car.car;
  EXPECT_DOUBLE_EQ(spec.drift[2], 0.1 * gravity / (car.lf + car.lr));
  EXPECT_THAT(refusal([] { filter_of(R"({"sigma": {"yawrate": 0.05}})"); }), HasSubstr("yaw_rate"));
  EXPECT_THAT(refusal([] { filter_of(R"({"drift": {}})"); }), HasSubstr("sigma"));
  EXPECT_THAT(refusal([] { filter_of(R"({"sigma": {}, "drft": {}})"); }), HasSubstr("did you mean \"drift\"?"));
  EXPECT_THAT(refusal([] { filter_of(R"({"sigma": {"x": -1}})"); }), HasSubstr("/state_filter/sigma/x"));
}

}  // namespace test_state_filter
}  // namespace gripline
