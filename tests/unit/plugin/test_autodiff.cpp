#include <gripline/autodiff.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gripline {
namespace test_autodiff {

/// A lag of the throttle that asks for the commands a while ago.
class Lag final : public AutoDiffEffect<Lag> {
 public:
  template <class T>
  struct Params {
    T tau = T(0.1), age = T(0);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("tau", &P::tau, "s", {0.01, 1}, "lag"), param("age", &P::age, "s", {0, 1}, "delay")};
  }
  Stage stage() const noexcept override { return Stage::command; }
  int memory() const noexcept override { return 2; }
  void initial(const Point<double>& p, const Params<double>& k, std::span<double> memory) const {
    memory[0] = p.q.d;
    memory[1] = k.tau * static_cast<double>(memory.size());
  }
  double delay(const Params<double>& k) const noexcept { return k.age; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.memory_rate[0] = (p.q.d - p.memory[0]) / k.tau;
    p.memory_rate[1] = T(0);
    p.q.d = p.memory[0] + p.memory[1];
  }
};

/// No parameters; its memory starts without them.
class Counter final : public AutoDiffEffect<Counter> {
 public:
  Stage stage() const noexcept override { return Stage::body; }
  int memory() const noexcept override { return 1; }
  void initial(const Point<double>& p, std::span<double> memory) const { memory[0] = p.at.t; }
  template <class T>
  void act(Point<T>& p) const {
    p.memory_rate[0] = T(1);
  }
};

/// Says reading, but derives from the base of the other stages.
class Misplaced final : public AutoDiffEffect<Misplaced> {
 public:
  Stage stage() const noexcept override { return Stage::reading; }
  template <class T>
  void act(Point<T>&) const {}
};

class Scale final : public AutoDiffReading<Scale> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() { return std::tuple{param("k", &Params<double>::k, "1", {-1, 1}, "error")}; }
  template <class T>
  void sense(Reading<T>& r, const Place& at, const Params<T>& k) const {
    r.vx *= k.k + 1.0;
    r.omega += at.t;
  }
};

class Sliding final : public AutoDiffVehicle<Sliding> {
 public:
  template <class T>
  struct Params {
    T m = T(2);
  };
  static constexpr auto parameters() { return std::tuple{param("m", &Params<double>::m, "kg", {0, 9}, "mass")}; }
  template <class T>
  void load(Point<T>& p, const Params<T>& k) const {
    p.q.m = k.m;
  }
  template <class T>
  void body(Point<T>& p, const Params<T>&) const {
    p.q.ax = p.q.vx / p.q.m;
  }
};

TEST(AutoDiffEffect, EachPointHasItsOwnRowOfMemory) {
  const Lag lag;
  const std::vector<double> params = {0.5, 0.2};
  std::vector<Quantities<double>> q(2);
  const std::vector<Place> at(2);
  q[0].d = 0.3;
  q[1].d = -0.6;
  std::vector<double> memory(6, 9.0), rate(6, 9.0);
  Points<double> points;
  points.n = 2;
  points.q = q.data();
  points.at = at.data();
  points.params = params.data();
  points.memory_stride = 3;  // beside another effect's
  const Effect& effect = lag;
  effect.start_memory(points, memory.data());
  EXPECT_EQ(memory, (std::vector<double>{0.3, 1.0, 9, -0.6, 1.0, 9}));
  memory = {0.1, 0, 9, 0.2, 0, 9};
  points.memory = memory.data();
  points.memory_rate = rate.data();
  effect.apply(points);
  EXPECT_EQ(rate, (std::vector<double>{(0.3 - 0.1) / 0.5, 0, 9, (-0.6 - 0.2) / 0.5, 0, 9}));
  EXPECT_EQ(q[0].d, 0.1);
  EXPECT_EQ(q[1].d, 0.2);
  EXPECT_EQ(effect.look_back(params), 0.2);
}

TEST(AutoDiffEffect, WithoutParametersMemoryStartsAllTheSame) {
  const Counter counter;
  Quantities<double> q{};
  Place at;
  at.t = 4.5;
  double memory = 0;
  Points<double> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  points.memory_stride = 1;
  static_cast<const Effect&>(counter).start_memory(points, &memory);
  EXPECT_EQ(memory, 4.5);
  EXPECT_EQ(counter.look_back({}), 0.0);
}

TEST(AutoDiffEffect, OfTheReadingStageIsToldWhatToDeriveFrom) {
  const Misplaced misplaced;
  Reading<double> reading{};
  const Place at;
  Points<double> points;
  points.n = 1;
  points.reading = &reading;
  points.at = &at;
  try {
    misplaced.apply(points);
    FAIL() << "was called";
  } catch (const std::exception& error) {
    EXPECT_STREQ(error.what(), "an effect of Stage::reading derives from AutoDiffReading");
  }
}

TEST(AutoDiffReading, ChangesReadingsWithDerivatives) {
  const Scale scale;
  EXPECT_EQ(scale.stage(), Stage::reading);
  std::vector<Reading<Dual8>> readings(2);
  readings[1].vx = Dual8::variable(3.0, 0);
  std::vector<Place> at(2);
  at[1].t = 0.5;
  const Dual8 params[] = {Dual8::variable(0.25, 1)};
  Points<Dual8> points;
  points.n = 2;
  points.reading = readings.data();
  points.at = at.data();
  points.params = params;
  scale.apply(points);
  EXPECT_EQ(readings[1].vx.v, 3.75);
  EXPECT_EQ(readings[1].vx.d[0], 1.25);
  EXPECT_EQ(readings[1].vx.d[1], 3.0);
  EXPECT_EQ(readings[1].omega.v, 0.5);
  EXPECT_EQ(readings[0].vx.v, 0.0);
}

TEST(AutoDiffVehicle, HasTheStagesThatItWrites) {
  const Sliding model;
  EXPECT_EQ(model.stages(),
            stage_bit(Stage::command) | stage_bit(Stage::load) | stage_bit(Stage::body) | stage_bit(Stage::reading));
}

TEST(AutoDiffVehicle, FillsTheStagesAskedForAndNoOther) {
  const Sliding model;
  Quantities<double> q{};
  q.vx = 6;
  q.m = 1;
  const Place at;
  const double mass = 3;
  Points<double> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  points.params = &mass;
  model.evaluate(Stage::body, Stage::body, points);
  EXPECT_EQ(q.ax, 6);
  model.evaluate(Stage::drive, Stage::load, points);
  EXPECT_EQ(q.m, 3);
  EXPECT_EQ(q.ax, 6);
  model.evaluate(Stage::command, Stage::body, points);
  EXPECT_EQ(q.ax, 2);
}

}  // namespace test_autodiff
}  // namespace gripline
