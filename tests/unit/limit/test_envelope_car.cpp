#include "limit/envelope_car.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "limit/lap_limit.hpp"
#include "limit/true_plant.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_envelope_car {

using namespace testing_support;

constexpr double radius = 60, straight = 200, half_width = 6;

/// The full-size black box on an oval.
WorldSpec oval(const std::string& friction = "null", const std::string& slopes = "") {
  return world_of(R"({"car": "cars/full_size.json", "plant": {"plugin": "double_track", "params": null},
    "track": {"half_width": 6, "segments": [{"line": 200}, {"arc": {"radius": 60, "turn": "180 deg"}}, {"line": 200},
    {"arc": {"radius": 60, "turn": "180 deg"}}])" +
                  slopes + R"(}, "friction": )" + friction + "}");
}

PlantEnvelope simple() {
  PlantEnvelope e;
  e.throttle = {5, 35, {4, 4, 4}};
  e.rolling = {5, 35, {-1, -1, -1}};
  e.brakes = {5, 35, {8, 8, 8}};
  e.side = {9, 0.001};
  e.drive = {12, 0};
  e.brake = {10, 0};
  e.top = 75;
  return e;
}

TEST(EnvelopeCar, UsesWhatItsTyresHold) {
  const WorldSpec world = oval();
  const EnvelopeCar car(world, simple(), false);
  Place at;
  at.s = 10;
  const auto used = [&](double v, double omega, double throttle, double brake) {
    return car.used(Dual8(v), Dual8(omega), Dual8(throttle), Dual8(brake), at).v;
  };
  EXPECT_NEAR(used(20, (9 + 0.4) / 20, 0, 0), 1.0, 1e-3);
  EXPECT_NEAR(used(20, -(9 + 0.4) / 20, 0, 0), 1.0, 1e-3);
  EXPECT_NEAR(used(20, 0, 0, -1), 0.64, 1e-3);
  EXPECT_NEAR(used(20, 0.6 * 9.4 / 20, 0, -1), 1.0, 1e-3);
  EXPECT_NEAR(used(20, 0, 1, 0), 1.0 / 9.0, 1e-3);
  at.bank = std::asin(0.1);  // the right side is higher: left turns ask for less
  EXPECT_LT(used(20, 0.4, 0, 0), used(20, -0.4, 0, 0));
  EXPECT_NEAR(car.acceleration(30, 1), 3.0, 1e-9);
  EXPECT_NEAR(car.acceleration(30, -0.5), -5.0, 1e-9);
}

TEST(EnvelopeCar, PatchesAndCrestsTakeFromWhatTyresHold) {
  const WorldSpec world = oval(
      R"({"points": [{"t": 0, "factor": 1}], "patches": [{"from_s": 210, "to_s": 380, "factor": 0.7, "from_t": 9}]})",
      R"(, "grade": [{"s": 0, "grade": 0}, {"s": 80, "grade": 0.08}, {"s": 160, "grade": -0.08},
          {"s": 240, "grade": 0}])");
  const EnvelopeCar without(world, simple(), false), with(world, simple(), true);
  Place at;
  const auto across = [&](const EnvelopeCar& car, double s) {
    at.s = s;
    return std::sqrt(car.used(Dual8(20.0), Dual8(0.3), Dual8(0.0), Dual8(0.0), at).v);
  };
  EXPECT_NEAR(across(with, 300) / across(without, 300), 1.0 / 0.7, 1e-3);
  EXPECT_NEAR(across(with, 500) / across(without, 500), 1.0, 1e-9);
  EXPECT_NEAR(with.mu(), 0.7 * without.mu(), 1e-12);
  EXPECT_GT(across(without, 120), 1.02 * across(without, 500));  // over the crest
}

/// From some 30 m/s on the crest leaves the tyres nothing.
TEST(EnvelopeCar, FasterOverACrestIsNeverLessUse) {
  const WorldSpec world = oval("null", R"(, "grade": [{"s": 0, "grade": 0}, {"s": 60, "grade": 0.1},
      {"s": 80, "grade": -0.1}, {"s": 140, "grade": 0}])");
  const EnvelopeCar car(world, simple(), false);
  Place at;
  at.s = 70;
  const auto used = [&](double v, double brake, const Dual8& speed) {
    return car.used(speed, Dual8(4.0 / v), Dual8(0.0), Dual8(brake), at);
  };
  for (const double brake : {0.0, -0.5}) {
    double before = 0;
    for (double v = 5; v < 80; v += 0.13) {
      const Dual8 here = used(v, brake, Dual8::variable(v, 2));  // v omega rises with v, omega constant
      const double ahead = used(v, brake, Dual8(v + 1e-5)).v, behind = used(v, brake, Dual8(v - 1e-5)).v;
      EXPECT_GE(here.v, before * (1 - 1e-9)) << v;
      EXPECT_NEAR(here.d[2], (ahead - behind) / 2e-5, 1e-4 * (1.0 + here.d[2])) << v;
      EXPECT_GT(here.d[2], 0.0) << v;
      before = here.v;
    }
    EXPECT_GT(before, 100.0);
  }
  EXPECT_LT(car.used(Dual8(70.0), Dual8(0.0), Dual8(0.0), Dual8(0.0), at).v, 0.01);  // straight on, in the air
}

TEST(EnvelopeCar, TurnsAsItIsSteered) {
  const WorldSpec world = oval();
  PlantEnvelope e = simple();
  e.bend = 0.01;
  const EnvelopeCar car(world, e, false);
  const double wheelbase = car.car().lf + car.car().lr, v = 20, delta = 0.05, omega = v * delta / wheelbase;
  const std::vector<Dual8> motion = {0.0, 0.0, 0.0, v, 0.0, omega};
  const std::vector<ActingCommand<Dual8>> command = {{1.0, delta, 0.1}};
  std::vector<Dual8> rate(motion_size);
  Place at;
  at.grade = 0.05;
  car.lap_rates(motion, command, {&at, 1}, rate);
  const double along = 3.0 - 0.01 * v * v * omega * omega - gravity * std::sin(0.05);
  EXPECT_NEAR(rate[3].v, along, 1e-9);
  EXPECT_NEAR(rate[4].v, 0.0, 1e-12);
  EXPECT_NEAR(rate[5].v, (along * delta + v * 0.1) / wheelbase, 1e-9);
}

/// The lap of an oval lies between two that are easily computed: the widest turns at the limit with straights at top
/// speed, and the centre line's turns with nothing gained on straights.
TEST(EnvelopeCar, TimeOptimalLapOfABlackBox) {
  const WorldSpec world = oval();
  const auto [fresh, lap, mesh] = find_fastest_lap(world, {1.0, false, false});
  EXPECT_LE(fresh.error_s, lap_limit_tolerance * fresh.lap_s);
  const EnvelopeCar car(world, 1.0, false);
  const double side = car.envelope().side.at(25.0, 1.0);
  EXPECT_GT(fresh.lap_s, 2 * straight / car.envelope().top +
                             2 * std::numbers::pi * radius / std::sqrt(1.05 * side * (radius + half_width)));
  EXPECT_LT(fresh.lap_s, (2 * straight + 2 * std::numbers::pi * radius) / std::sqrt(side * radius));
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    const auto &a = lap.z[k], &b = lap.z[(k + 1) % mesh.size()];
    const double d = a[lap_d];
    const Dual8 used = car.used(Dual8(0.5 * (a[lap_vx] + b[lap_vx])), Dual8(0.5 * (a[lap_omega] + b[lap_omega])),
                                Dual8(std::max(d, 0.0)), Dual8(std::min(d, 0.0)), mesh.places[k]);
    EXPECT_LT(used.v, 1.01) << k;
    EXPECT_LT(std::abs(a[lap_n]), half_width + 1e-6) << k;
  }
}

/// The 1:43 car, of whose equations nothing is seen.
class Covered final : public Plant {
 public:
  explicit Covered(const WorldSpec& spec) : spec_(spec) {}
  void reset(const State& x, const Ground& ground) override {
    x_ = {x.x, x.y, x.yaw, x.vx, x.vy, x.omega};
    model_.emplace(spec_, ground.at(x.x, x.y, x.yaw).factor);
  }
  State advance(double d, double delta, double dt, const Ground&) override {
    constexpr int steps = 20;
    const ActingCommand<double> command = {d, delta, 0.0};
    const Place at;
    const auto rates = [&](const Motion& x) {
      Motion rate;
      model_->rates<double>(x, {&command, 1}, {&at, 1}, rate);
      return rate;
    };
    const auto moved = [](const Motion& x, double h, const Motion& rate) {
      Motion y;
      for (std::size_t i = 0; i < y.size(); ++i) y[i] = x[i] + h * rate[i];
      return y;
    };
    for (int i = 0; i < steps; ++i)  // midpoint rule
      x_ = moved(x_, dt / steps, rates(moved(x_, 0.5 * dt / steps, rates(x_))));
    State x;
    x.x = x_[0], x.y = x_[1], x.yaw = x_[2], x.vx = x_[3], x.vy = x_[4], x.omega = x_[5], x.delta = delta;
    return x;
  }
  double mu(Axle) const override { return 1; }
  double tyre_force(Axle, double) const override { return 0; }
  double axle_force(Axle) const override { return 0; }

 private:
  using Motion = std::array<double, motion_size>;
  const WorldSpec& spec_;
  std::optional<TruePlant> model_;
  Motion x_{};
};

/// Steered as far as it goes, this car does not reach its tyres' peak, which the model's lap does by drifting: laps of
/// what driving shows are a little longer.
TEST(EnvelopeCar, LapOfACoveredModelIsNearTheModels) {
  const WorldSpec world = world_of();
  Covered covered(world);
  const LapCase fresh{1.0, false, false};
  const EnvelopeCar car(world, measure_envelope(covered, world.car.car, world.dt, fresh.factor), false);
  const double open = find_lap_limit(world, fresh).lap_s;
  const double shown = find_fastest_lap(world, car, fresh).limit.lap_s;
  EXPECT_GT(shown, 0.99 * open);
  EXPECT_LT(shown, 1.08 * open);
}

}  // namespace test_envelope_car
}  // namespace gripline
