#include "car/staged_car.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gripline/plugin.hpp>

#include <cmath>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_staged_car {

using testing::ElementsAre;
using testing::HasSubstr;

/// A model whose stages each add their number to a running decimal: ax spells the order in which things were called.
template <bool with_tyres>
class Spelling final : public AutoDiffVehicle<Spelling<with_tyres>> {
 public:
  template <class T>
  struct Params {
    T unused = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("unused", &Params<double>::unused, "1", {0, 1}, "nothing")};
  }
  template <class T>
  void drive(Point<T>& p, const Params<T>&) const {
    p.q.ax = T(1);
  }
  template <class T>
  void load(Point<T>& p, const Params<T>&) const {
    p.q.ax = p.q.ax * 10.0 + 2.0;
  }
  template <class T>
  void tyre(Point<T>& p, const Params<T>&) const requires with_tyres {
    p.q.ax = p.q.ax * 10.0 + 3.0;
  }
  template <class T>
  void body(Point<T>& p, const Params<T>&) const {
    p.q.ax = p.q.ax * 10.0 + 5.0;
  }
};

/// No forces at all, on the slope of the place.
class Sloped final : public AutoDiffVehicle<Sloped> {
 public:
  template <class T>
  struct Params {
    T unused = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("unused", &Params<double>::unused, "1", {0, 1}, "nothing")};
  }
  template <class T>
  void body(Point<T>& p, const Params<T>&) const {
    p.q.ax = p.q.ay = p.q.aw = T(0);
    p.q.grade = T(p.at.grade);
    p.q.bank = T(p.at.bank);
  }
};

/// Spells its digit in its stage; its memory grows with what it reads.
class Letter : public Effect {
 public:
  Letter(Stage stage, double digit, int memory = 0) : stage_(stage), digit_(digit), memory_(memory) {}
  Stage stage() const noexcept override { return stage_; }
  int memory() const noexcept override { return memory_; }
  double look_back(std::span<const double> params) const noexcept override { return params.empty() ? 0.0 : params[0]; }
  void start_memory(const Points<double>&, double* memory) const override {
    for (int j = 0; j < memory_; ++j) memory[j] = digit_ + 100 * j;
  }
  void apply(const Points<double>& points) const override { spell(points); }
  void apply(const Points<Dual8>& points) const override { spell(points); }

 private:
  template <class T>
  void spell(const Points<T>& points) const {
    for (std::size_t i = 0; i < points.n; ++i) {
      if (stage_ == Stage::reading) {
        points.reading[i].vx = points.reading[i].vx * 10.0 + digit_;
        continue;
      }
      points.q[i].ax = points.q[i].ax * 10.0 + digit_;
      for (int j = 0; j < memory_; ++j)
        points.memory_rate[i * points.memory_stride + static_cast<std::size_t>(j)] =
            points.memory[i * points.memory_stride + static_cast<std::size_t>(j)] * 2.0 + digit_;
    }
  }
  Stage stage_;
  double digit_;
  int memory_;
};

/// Rates of one car at rest.
std::vector<double> rates(const StagedCar& car, std::vector<double> memory = {}) {
  const double motion[motion_size] = {};
  const ActingCommand<double> command{};
  const Place at;
  std::vector<double> out(motion_size + memory.size());
  CarBatch<double> batch;
  batch.n = 1;
  batch.motion = motion;
  batch.command = &command;
  batch.memory = memory.data();
  batch.at = &at;
  batch.motion_rate = out.data();
  batch.memory_rate = out.data() + motion_size;
  car.rates(batch);
  return out;
}

TEST(StagedCar, EffectsActAfterTheirStageInTheOrderTheyWereAdded) {
  const Spelling<true> model;
  const Letter body(Stage::body, 9), tyre(Stage::tyre, 8), drive(Stage::drive, 7), second_tyre(Stage::tyre, 6);
  StagedCar car(model, {0});
  EXPECT_EQ(rates(car)[3], 1235);
  car.add(body, {}, "body");
  car.add(tyre, {}, "tyre");
  car.add(drive, {}, "drive");
  car.add(second_tyre, {}, "second tyre");
  EXPECT_EQ(rates(car)[3], 17238659);
}

/// What no stage fills is not what happened to lie in the caller's memory.
TEST(StagedCar, QuantitiesThatTheModelDoesNotFillAreZero) {
  const Sloped model;
  const StagedCar car(model, {0});
  const double motion[motion_size] = {0, 0, 0, 12, 0, 0};
  const ActingCommand<double> command{0.5, 0.1, 0.0};
  const Place at;
  CarBatch<double> batch;
  batch.n = 1;
  batch.motion = motion;
  batch.command = &command;
  batch.at = &at;
  Quantities<double> q{};
  q.slip_front = q.peak_rear = q.force_front = q.load_front = q.motor = 1e3;
  car.quantities(batch, &q);
  EXPECT_EQ(q.vx, 12);
  EXPECT_EQ(q.d, 0.5);
  EXPECT_EQ(q.slip_front, 0);
  EXPECT_EQ(q.peak_rear, 0);
  EXPECT_EQ(q.force_front, 0);
  EXPECT_EQ(q.load_front, 0);
  EXPECT_EQ(q.motor, 0);
}

TEST(StagedCar, RefusesAStageTheModelDoesNotHave) {
  const Spelling<false> model;
  const Letter tyre(Stage::tyre, 1), body(Stage::body, 2);
  StagedCar car(model, {0});
  car.add(body, {}, "drag");
  try {
    car.add(tyre, {}, "friction_scale");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "effect \"friction_scale\" acts on the tyre stage, which this model does not have");
  }
  EXPECT_EQ(car.effects(), 1u);
}

TEST(StagedCar, ParametersAndMemoryStandInTheOrderOfTheEffects) {
  const Spelling<true> model;
  const Letter one(Stage::body, 4, 1), two(Stage::drive, 6, 2);
  StagedCar car(model, {0});
  car.add(one, {0.25, 11}, "one");
  car.add(two, {0.75}, "two");
  EXPECT_THAT(car.params(), ElementsAre(0, 0.25, 11, 0.75));
  EXPECT_EQ(car.param_offset(-1), 0u);
  EXPECT_EQ(car.param_offset(0), 1u);
  EXPECT_EQ(car.param_offset(1), 3u);
  EXPECT_EQ(car.look_back(), 0.75);
  EXPECT_EQ(car.memory(), 3);
  const std::vector<double> out = rates(car, {10, 20, 30});
  EXPECT_THAT(std::vector<double>(out.begin() + motion_size, out.end()), ElementsAre(24, 46, 66));
}

TEST(StagedCar, StartMemoryIsWhatEachEffectSaysInTurn) {
  const Spelling<true> model;
  const Letter one(Stage::body, 4, 1), none(Stage::body, 5), two(Stage::drive, 6, 2);
  StagedCar car(model, {0});
  car.add(one, {}, "one");
  car.add(none, {}, "none");
  car.add(two, {}, "two");
  const double motion[2 * motion_size] = {};
  const ActingCommand<double> command[2] = {};
  const Place at[2];
  CarBatch<double> batch;
  batch.n = 2;
  batch.motion = motion;
  batch.command = command;
  batch.at = at;
  double memory[6] = {-1, -1, -1, -1, -1, -1};
  car.start_memory(batch, memory);
  EXPECT_THAT(memory, ElementsAre(4, 6, 106, 4, 6, 106));
}

TEST(StagedCar, ReadingsPassThroughTheReadingEffectsOnly) {
  const Spelling<true> model;
  const Letter body(Stage::body, 9), scale(Stage::reading, 3), bias(Stage::reading, 4);
  StagedCar car(model, {0});
  car.add(body, {}, "body");
  car.add(scale, {}, "scale");
  car.add(bias, {}, "bias");
  Reading<double> reading{};
  reading.vx = 1;
  const Place at;
  car.read(&reading, 1, &at, static_cast<const double*>(nullptr));
  EXPECT_EQ(reading.vx, 134);
  EXPECT_EQ(rates(car)[3], 12359);
}

TEST(StagedCar, RefusesAReadingThatRemembers) {
  const Spelling<true> model;
  const Letter lagged(Stage::reading, 3, 1);
  StagedCar car(model, {0});
  try {
    car.add(lagged, {}, "gyro");
    FAIL() << "was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "effect \"gyro\" has memory, which an effect of the reading stage cannot have");
  }
}

TEST(StagedCar, MotionIsInTheWorldAndSlopesPull) {
  const Sloped model;
  const StagedCar car(model, {0});
  const double motion[] = {5, 6, 0.4, 2, -0.3, 1.5};
  const ActingCommand<double> command{};
  Place at;
  at.grade = 0.1;
  at.bank = -0.05;
  double rate[motion_size];
  CarBatch<double> batch;
  batch.n = 1;
  batch.motion = motion;
  batch.command = &command;
  batch.at = &at;
  batch.motion_rate = rate;
  car.rates(batch);
  EXPECT_NEAR(rate[0], 2 * std::cos(0.4) + 0.3 * std::sin(0.4), 1e-15);
  EXPECT_NEAR(rate[1], 2 * std::sin(0.4) - 0.3 * std::cos(0.4), 1e-15);
  EXPECT_EQ(rate[2], 1.5);
  EXPECT_NEAR(rate[3], -gravity * std::sin(0.1), 1e-15);   // uphill: slower
  EXPECT_NEAR(rate[4], gravity * std::sin(-0.05), 1e-15);  // left side higher: pulled to the right
}

/// Batches are cut into chunks: the result must not show where.
TEST(StagedCar, ManyPointsAtOnceAreEachAlone) {
  const PluginContext context = [] {
    PluginContext s;
    s.car.v_ref = 2;
    return s;
  }();
  Errors errors;
  const CarFile file = read_car(load_json(testing_support::source_dir() / "worlds/cars/orca_1_43.json"), errors);
  const Node node = testing_support::json(R"({"plugin": "dynamic", "effects": [
    {"plugin": "relaxation", "params": {"sigma": 0.05}}, {"plugin": "aero_drag", "params": {"a": 0.5}},
    {"plugin": "steer_lag", "params": {"tau": 0.03}}]})");
  const Vehicle vehicle(read_vehicle(node, testing_support::plugins(), file, "rk4", errors), context);
  ASSERT_TRUE(errors.empty());
  const StagedCar& car = vehicle.car();
  constexpr std::size_t n = 21;
  std::vector<double> motion, memory;
  std::vector<ActingCommand<double>> command;
  const std::vector<Place> at(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = static_cast<double>(i);
    motion.insert(motion.end(), {x, -x, 0.1 * x, 1 + 0.05 * x, 0.1 * std::sin(x), std::cos(x)});
    memory.insert(memory.end(), {0.01 * x, -0.02 * x, 0.1 * std::cos(2 * x)});
    command.push_back({0.5 * std::sin(x), 0.2 * std::cos(x), 0.3});
  }
  const auto evaluate = [&](std::size_t begin, std::size_t count, std::vector<double>& rate) {
    rate.assign(count * 9, 0);
    CarBatch<double> batch;
    batch.n = count;
    batch.motion = motion.data() + begin * motion_size;
    batch.command = command.data() + begin;
    batch.memory = memory.data() + begin * 3;
    batch.at = at.data() + begin;
    batch.motion_rate = rate.data();
    batch.memory_rate = rate.data() + count * motion_size;
    car.rates(batch);
  };
  std::vector<double> all, one;
  evaluate(0, n, all);
  for (std::size_t i = 0; i < n; ++i) {
    evaluate(i, 1, one);
    for (std::size_t j = 0; j < motion_size; ++j) EXPECT_EQ(all[i * motion_size + j], one[j]);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(all[n * motion_size + i * 3 + j], one[motion_size + j]);
  }
}

}  // namespace test_staged_car
}  // namespace gripline
