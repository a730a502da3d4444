#include "world/world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "support/allocation_counter.hpp"
#include "support/host_support.hpp"
#include "world/friction_file.hpp"

namespace gripline {
namespace test_world {

using namespace testing_support;

/// Keeps to the centre line at a speed.
Input follow(const World& world, double speed) {
  const State& x = world.state();
  const Place& at = world.place();
  const double heading = std::remainder(x.yaw - at.yaw_line, 2 * std::numbers::pi);
  const double wanted = std::atan(0.062 * (at.kappa - 10 * at.n - 6 * heading));
  return {0.25 + 2 * (speed - x.vx), (wanted - x.delta) / world.spec().dt};
}

double total_truth(const World& world) {
  return total_mu({world.truth().mu(Axle::front), world.truth().mu(Axle::rear), 0, 0, true}, world.spec().car.car);
}

TEST(World, BeginsAtItsStart) {
  const WorldSpec spec = world_of(R"({"start": {"x": 0.5, "y": -0.1, "yaw": "5 deg", "speed": 1.5}})");
  const World world(spec, 1);
  EXPECT_EQ(world.time(), 0);
  EXPECT_EQ(world.step(), 0);
  EXPECT_EQ(world.state().x, 0.5);
  EXPECT_EQ(world.state().vx, 1.5);
  EXPECT_EQ(world.state().delta, 0);
  EXPECT_NEAR(world.place().s, 0.5, 1e-12);
  EXPECT_NEAR(world.place().n, -0.1, 1e-12);
  EXPECT_EQ(world.observe().x.yaw, world.state().yaw);
  EXPECT_EQ(world.observe().step, 0);
  EXPECT_EQ(world.observe().d, 0);
  EXPECT_EQ(world.laps(), 0);
  EXPECT_FALSE(world.outside());
}

TEST(World, CommandsBeyondTheCarsLimitsAreClamped) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1}})");
  World world(spec, 1);
  Input applied = world.advance({3.0, 50.0});
  EXPECT_EQ(applied.d, 1.0);
  EXPECT_DOUBLE_EQ(applied.ddelta, 5.0);
  EXPECT_DOUBLE_EQ(world.state().delta, 0.1);
  EXPECT_EQ(world.observe().d, 1.0);
  world.advance({-3.0, 5.0});
  EXPECT_EQ(world.observe().d, -0.1);
  world.advance({0, 5.0});
  applied = world.advance({0, 5.0});
  EXPECT_NEAR(applied.ddelta, 2.5, 1e-9);  // what is left up to full lock
  EXPECT_DOUBLE_EQ(world.state().delta, 0.35);
  EXPECT_NEAR(world.advance({0, 5.0}).ddelta, 0.0, 1e-9);
  const Input limited = world.clamp_to_limits({0.5, -7.0});
  EXPECT_EQ(limited.d, 0.5);
  EXPECT_DOUBLE_EQ(limited.ddelta, -5.0);
  EXPECT_DOUBLE_EQ(world.state().delta, 0.35);  // asking changes nothing
}

/// The world's own integrator and plant, rebuilt from parts: one car, one step after the other.
TEST(World, MovesAsItsPlantUnderTheFrictionOfEachStep) {
  const WorldSpec spec =
      world_of(R"({"start": {"speed": 1.8}, "friction": {"per_step": {"start_step": 5, "divide": 10}},
    "plant": {"plugin": "dynamic", "integrator": "rk6"}})");
  World world(spec, 1);
  PluginContext context;
  context.car = spec.car.car;
  const Vehicle plain(spec.vehicle, context);
  CorrectedModel model(plain.car(), {0.02, Hold::zoh, {find_tableau("rk6"), 1}});
  std::size_t front = 0, rear = 0;
  for (std::size_t i = 0; i < spec.vehicle.model.values.size(); ++i) {
    const std::string name = spec.vehicle.model.entry->params()[i].name;
    if (name == "Df") front = i;
    if (name == "Dr") rear = i;
  }
  State x = world.state();
  model.reset(x, 0, {});
  double factor = 1;
  for (int k = 0; k < 20; ++k) {
    if (k >= 5) factor -= factor / 10;
    EXPECT_NEAR(world.truth().factor(), factor, 1e-14) << "told before step " << k;
    model.set_parameter(front, 0.192 * factor);
    model.set_parameter(rear, 0.1737 * factor);
    const Input u = world.advance({0.4, k < 3 ? 3.0 : 0.0});
    x = model.advance(x, u, {});
    EXPECT_NEAR(world.state().x, x.x, 1e-13);
    EXPECT_NEAR(world.state().vy, x.vy, 1e-13);
    EXPECT_NEAR(world.state().omega, x.omega, 1e-11);
  }
  EXPECT_LT(factor, 0.25);
}

/// The factor is that of the step's beginning: places and times within the step do not count.
TEST(World, FrictionIsHeldOverAStep) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 2}, "duration": "2 s",
    "friction": {"points": [{"t": 0, "factor": 1}, {"t": 1, "factor": 0.5}],
                 "patches": [{"from_s": 0.5, "to_s": 1, "factor": 0.3, "from_t": 0}]}})");
  const FrictionSchedule schedule(spec.friction, 0.02, 1);
  World world(spec, 1);
  bool patched = false;
  for (int k = 0; k < 60; ++k) {
    const double expected = schedule.factor(k, 0.02 * k, world.place().s);
    EXPECT_DOUBLE_EQ(world.truth().factor(), expected);
    patched = patched || expected < 0.4;
    world.advance({0.3, 0});
    ASSERT_TRUE(world.finite());
  }
  EXPECT_TRUE(patched);
}

TEST(World, TrueFrictionOfTheSmallCarIs0909TimesTheFactor) {
  const WorldSpec spec = world_of(R"({"friction": [{"t": 0, "factor": 0.7}]})");
  const World world(spec, 1);
  EXPECT_NEAR(total_truth(world), 0.7 * (0.192 + 0.1737) / (0.041 * 9.81), 1e-9);
  EXPECT_NEAR(total_truth(world) / 0.7, 0.909, 5e-4);
  EXPECT_NEAR(world.truth().mu(Axle::front), 0.7 * 0.192 / (0.041 * 9.81 * 0.033 / 0.062), 1e-9);
  EXPECT_NEAR(world.truth().mu(Axle::rear), 0.7 * 0.1737 / (0.041 * 9.81 * 0.029 / 0.062), 1e-9);
  for (const double slip : {-0.4, -0.05, 0.0, 0.1, 0.6, 1.2}) {
    EXPECT_NEAR(world.truth().tyre_force(Axle::front, slip), 0.7 * 0.192 * std::sin(1.2 * std::atan(2.579 * slip)),
                1e-12);
    EXPECT_NEAR(world.truth().tyre_force(Axle::rear, slip), 0.7 * 0.1737 * std::sin(1.2691 * std::atan(3.3852 * slip)),
                1e-12);
  }
}

TEST(World, EffectsOfThePlantAreTrueToo) {
  const WorldSpec spec = world_of(R"({"friction": [{"t": 0, "factor": 0.5}], "plant": {"plugin": "dynamic",
    "effects": [{"plugin": "friction_scale", "params": {"k": -0.2}}, {"plugin": "relaxation", "params": {"sigma": 0.1}}]}})");
  const World world(spec, 1);
  EXPECT_NEAR(total_truth(world), 0.5 * 0.8 * 0.909227, 1e-6);
  // Relaxation is a matter of time, not of the curve; the factor counts once.
  EXPECT_NEAR(world.truth().tyre_force(Axle::rear, 0.2),
              0.5 * 0.8 * 0.1737 * std::sin(1.2691 * std::atan(3.3852 * 0.2)), 1e-12);
}

/// What the oracle is told: the plant's own accelerations, without those effects that have memory.
template <class T>
Quantities<T> told(const World& world, double vx, double vy, double omega, double d, double delta) {
  Quantities<T> q{};
  q.vx = T(vx);
  q.vy = T(vy);
  q.omega = T(omega);
  q.d = T(d);
  q.delta = T(delta);
  const Place at;
  Points<T> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  EXPECT_TRUE(world.truth().accelerations(points));
  return q;
}

/// The axis of the curve is the wheels' own slip, whatever the steering makes of a command.
TEST(World, TrueTyresDoNotDependOnTheSteering) {
  const WorldSpec plain = world_of();
  const WorldSpec geared = world_of(R"({"plant": {"effects": [{"plugin": "steer_gain", "params": {"k": 0.3}},
    {"plugin": "steer_offset", "params": {"d0": 0.02}}, {"plugin": "steer_lag", "params": {"tau": 0.1}}]}})");
  const World one(plain, 1), other(geared, 1);
  EXPECT_EQ(other.truth().tyre_force(Axle::front, 0.0), 0.0);
  for (const Axle axle : {Axle::front, Axle::rear}) {
    EXPECT_EQ(other.truth().tyre_force(axle, 0.2), one.truth().tyre_force(axle, 0.2));
    EXPECT_EQ(other.truth().mu(axle), one.truth().mu(axle));
  }
}

/// At static load: air that presses, a heavier car and one that is heavier behind have the friction of their tyres.
TEST(World, LoadsAreNoFriction) {
  const WorldSpec plain = world_of();
  const World one(plain, 1);
  for (const char* effect :
       {R"({"plugin": "downforce", "params": {"k": 0.3}})", R"({"plugin": "mass", "params": {"k": 0.2}})",
        R"({"plugin": "cog_shift", "params": {"k": 0.05}})"}) {
    const WorldSpec loaded = world_of(R"({"plant": {"effects": [)" + std::string(effect) + "]}}");
    const World other(loaded, 1);
    for (const Axle axle : {Axle::front, Axle::rear}) {
      EXPECT_NEAR(other.truth().mu(axle), one.truth().mu(axle), 1e-12) << effect;
      EXPECT_NEAR(other.truth().tyre_force(axle, -0.3), one.truth().tyre_force(axle, -0.3), 1e-12) << effect;
    }
  }
}

/// const calls of the SDK may come from several threads at once.
TEST(World, TruthMayBeAskedByManyAtOnce) {
  const WorldSpec spec = world_of(R"({"plant": {"effects": [{"plugin": "friction_drift", "params": {"k": -0.6}}]}})");
  World world(spec, 1);
  for (int k = 0; k < 50; ++k) world.advance({0.2, 0});
  std::vector<double> told(4);
  std::vector<std::thread> askers;
  for (double& mu : told) askers.emplace_back([&] { mu = world.truth().mu(Axle::rear); });
  for (std::thread& one : askers) one.join();
  for (const double mu : told) EXPECT_NEAR(mu, (1 - 0.6 / 60) * 0.1737 / (0.041 * 9.81 * 0.029 / 0.062), 1e-9);
}

TEST(World, FrictionThatThePlantChangesWithTimeIsTrueToo) {
  const WorldSpec spec = world_of(R"({"plant": {"effects": [{"plugin": "friction_drift", "params": {"k": -0.6}}]}})");
  World world(spec, 1);
  EXPECT_NEAR(total_truth(world), 0.909227, 1e-6);
  for (int k = 0; k < 50; ++k) world.advance({0.2, 0});
  EXPECT_NEAR(total_truth(world), (1 - 0.6 / 60) * 0.909227, 1e-6);
}

/// Peaks are searched anew only where the curves changed: into a patch, within it and out of it.
TEST(World, TrueFrictionIsThePeakOfTheCurveOfThisPlace) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 2}, "duration": "3 s", "plant": {"effects": [
    {"plugin": "friction_patch", "params": {"k": -0.4, "s0": 0.06, "w": 0.08}},
    {"plugin": "rear_stiff", "params": {"k": 0.2}}]}})");
  World world(spec, 1);
  double lowest = 1, last = 0;
  for (int k = 0; k < 100; ++k) {
    double top = 0;
    for (int i = 0; i <= 150; ++i) top = std::max(top, world.truth().tyre_force(Axle::rear, 0.01 * i));
    last = world.truth().mu(Axle::rear);
    ASSERT_NEAR(last, top / (0.041 * 9.81 * 0.029 / 0.062), 1e-4) << "step " << k;
    lowest = std::min(lowest, last);
    world.advance(follow(world, 2.0));
  }
  EXPECT_NEAR(lowest, 0.6 * 0.1737 / (0.041 * 9.81 * 0.029 / 0.062), 0.02);
  EXPECT_NEAR(last, 0.1737 / (0.041 * 9.81 * 0.029 / 0.062), 1e-9) << "behind the patch";
}

/// comb_slip takes from the peak that is there: Dr sqrt(1 - k (Fd / Dr)^2) with Dr after the schedule's factor.
TEST(World, EffectsOfThePlantMeetTheFrictionOfTheSchedule) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1}, "friction": [{"t": 0, "factor": 0.6}],
    "plant": {"effects": [{"plugin": "comb_slip", "params": {"k": 0.5}}]}})");
  const World world(spec, 1);
  const double vx = 1, vy = -0.4, slip = std::atan2(0.4, 1.0), d = 0.4;
  const double drive = (0.287 - 0.0545 * vx) * d, peak = 0.6 * 0.1737;
  const double rear =
      peak * std::sqrt(1 - 0.5 * (drive / peak) * (drive / peak)) * std::sin(1.2691 * std::atan(3.3852 * slip));
  const double front = 0.6 * 0.192 * std::sin(1.2 * std::atan(2.579 * slip));
  EXPECT_NEAR(told<double>(world, vx, vy, 0, d, 0).ay, (rear + front) / 0.041, 1e-9);
}

TEST(World, TheFullSizeCarHasItsFriction) {
  const Node tree = json(R"({"car": "cars/full_size.json", "track": "tracks/hill.json", "duration": 1,
    "plant": {"plugin": "double_track"}, "friction": [{"t": 0, "factor": 0.8}]})");
  Node inlined = tree;
  inline_world_files(inlined);
  Errors errors;
  const WorldSpec spec = read_world(inlined, plugins(), errors);
  ASSERT_TRUE(errors.empty());
  const World world(spec, 1);
  EXPECT_NEAR(total_truth(world), 0.8 * 1.05, 0.8 * 0.005);
}

TEST(World, TruthTellsTheTrueAccelerations) {
  const WorldSpec spec =
      world_of(R"({"friction": {"per_step": {"start_step": 0, "divide": 4}}, "plant": {"plugin": "dynamic", "effects": [
    {"plugin": "steer_lag", "params": {"tau": 0.1}}, {"plugin": "relaxation", "params": {"sigma": 0.1}},
    {"plugin": "aero_drag", "params": {"a": 0.5}}, {"plugin": "input_delay", "params": {"T": 0.04}}]}})");
  World world(spec, 1);
  world.advance({0.5, 1});       // memories are not steady
  const double f = 0.75 * 0.75;  // of the step that begins now
  const Quantities<double> q = told<double>(world, 2, 0.1, 3, 0.5, 0.1);
  const double front = f * 0.192 * std::sin(1.2 * std::atan(2.579 * (0.1 - std::atan2(3 * 0.029 + 0.1, 2))));
  const double rear = f * 0.1737 * std::sin(1.2691 * std::atan(3.3852 * std::atan2(3 * 0.033 - 0.1, 2)));
  const double drive = (0.287 - 0.0545 * 2) * 0.5 - 0.0518 - 0.00035 * 4;
  EXPECT_NEAR(q.ax, (drive - front * std::sin(0.1)) / 0.041 + 0.1 * 3 - 0.5, 1e-12);
  EXPECT_NEAR(q.ay, (rear + front * std::cos(0.1)) / 0.041 - 2 * 3, 1e-12);
  EXPECT_NEAR(q.aw, (front * 0.029 * std::cos(0.1) - rear * 0.033) / 27.8e-6, 1e-8);
  const Quantities<Dual8> dual = told<Dual8>(world, 2, 0.1, 3, 0.5, 0.1);
  EXPECT_NEAR(dual.aw.v, q.aw, 1e-9);
}

TEST(World, TruthTellsTheSlopesThatThePlantHas) {
  const WorldSpec spec =
      world_of(R"({"plant": {"effects": [{"plugin": "plane_tilt", "params": {"tx": 0.02, "ty": 0.01}},
    {"plugin": "bank", "params": {"c0": 0.03, "c1": 0.03, "c2": 0.03, "c3": 0.03, "c4": 0.03, "c5": 0.03, "c6": 0.03,
                                  "c7": 0.03, "c8": 0.03, "c9": 0.03}}]}})");
  const World world(spec, 1);
  const Quantities<double> q = told<double>(world, 2, 0, 0, 0, 0);
  EXPECT_NEAR(q.grade, 0.02, 1e-15);
  EXPECT_NEAR(q.bank, 0.03 - 0.01, 1e-15);
  EXPECT_NEAR(told<Dual8>(world, 2, 0, 0, 0, 0).bank.v, q.bank, 1e-15);
}

/// The commands told are those that act: what actuators make of them is not done to them again.
TEST(World, TruthTakesCommandsAsTheyAct) {
  const WorldSpec plain = world_of();
  const WorldSpec geared = world_of(R"({"plant": {"effects": [{"plugin": "steer_gain", "params": {"k": 0.1}},
    {"plugin": "steer_offset", "params": {"d0": 0.02}}, {"plugin": "throttle_dead_zone", "params": {"z": 0.2}}]}})");
  const World one(plain, 1), other(geared, 1);
  const Quantities<double> a = told<double>(one, 2, 0.1, 3, 0.5, 0.1), b = told<double>(other, 2, 0.1, 3, 0.5, 0.1);
  EXPECT_EQ(a.ax, b.ax);
  EXPECT_EQ(a.ay, b.ay);
  EXPECT_EQ(a.aw, b.aw);
}

TEST(World, TellingTheTruthAllocatesNothing) {
  if (!rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  const WorldSpec spec = world_of(R"({"plant": {"effects": [{"plugin": "aero_drag", "params": {"a": 0.5}}]}})");
  const World world(spec, 1);
  told<double>(world, 2, 0.1, 3, 0.5, 0.1);
  const long before = rig::allocations.load();
  told<double>(world, 2, 0.1, 3, 0.5, 0.1);
  told<Dual8>(world, 2, 0.1, 3, 0.5, 0.1);
  EXPECT_EQ(rig::allocations.load() - before, 0);
}

/// The lap ends where the centre of gravity crosses the normal at the start, interpolated within the step.
TEST(World, LapsEndOnTheNormalAtTheStart) {
  const WorldSpec spec = world_of(R"({"start": {"x": 0.505, "speed": 1}, "duration": "30 s"})");
  World world(spec, 1);
  std::vector<double> ended, crossed;
  while (world.time() < 29.99) {
    const double before_x = world.state().x, before_t = world.time(), y = world.state().y;
    world.advance(follow(world, 1.3));
    if (std::abs(y) < 0.3 && before_x < 0.505 && world.state().x >= 0.505)
      crossed.push_back(before_t + 0.02 * (0.505 - before_x) / (world.state().x - before_x));
    if (world.lap_ended()) ended.push_back(*world.lap_ended());
    EXPECT_EQ(world.laps(), static_cast<int>(ended.size()));
    ASSERT_FALSE(world.outside());
  }
  ASSERT_EQ(ended.size(), crossed.size());
  ASSERT_GE(ended.size(), 3u);
  for (std::size_t i = 0; i < ended.size(); ++i) EXPECT_NEAR(ended[i], crossed[i], 1e-9);
}

/// 0.3 m to either edge; the body reaches 15 mm to either side of the centre of gravity.
TEST(World, EdgesAndWallsMeetTheRightPartOfTheCar) {
  struct Seen {
    bool outside, body, crashed;
  };
  const auto at = [](const std::string& y) {
    const WorldSpec spec =
        world_of(R"({"track": {"walls": {"left": 0.02}}, "start": {"x": 0.5, "y": )" + y + R"(, "speed": 0}})");
    World world(spec, 1);
    world.advance({0, 0});
    return Seen{world.outside(), world.body_outside(), world.crashed()};
  };
  const Seen inside = at("0.28"), edge = at("0.29"), still = at("0.2999"), right = at("-0.2999");
  EXPECT_FALSE(inside.outside || inside.body || inside.crashed);
  EXPECT_TRUE(!edge.outside && edge.body && !edge.crashed);
  EXPECT_TRUE(!still.outside && still.body && !still.crashed);
  EXPECT_TRUE(!right.outside && right.body && !right.crashed);
  const WorldSpec spec =
      world_of(R"({"track": {"walls": {"left": 0.02}}, "start": {"x": 0.5, "y": 0.28, "yaw": "20 deg",
                                      "speed": 1}})");
  World world(spec, 1);
  bool was_outside = false;
  for (int k = 0; k < 20 && !world.crashed(); ++k) {
    world.advance({0.2, 0});
    was_outside = was_outside || world.outside();
  }
  EXPECT_TRUE(world.crashed());
  EXPECT_TRUE(world.body_outside());
  EXPECT_LT(world.state().y, 0.325);  // a corner meets the wall before the centre does
}

TEST(World, ReadingEffectsShowInObservationsAndNowhereElse) {
  const WorldSpec plain_spec = world_of(R"({"start": {"speed": 1}})");
  const WorldSpec biased_spec = world_of(R"({"start": {"speed": 1}, "plant": {"plugin": "dynamic", "effects": [
    {"plugin": "vx_scale", "params": {"k": 0.1}}, {"plugin": "vx_bias", "params": {"b": 0.05}}]}})");
  World plain(plain_spec, 1), biased(biased_spec, 1);
  EXPECT_DOUBLE_EQ(biased.observe().x.vx, 1.15);
  for (int k = 0; k < 10; ++k) {
    plain.advance({0.5, 1});
    biased.advance({0.5, 1});
    EXPECT_EQ(plain.state().vx, biased.state().vx);
    EXPECT_DOUBLE_EQ(biased.observe().x.vx, 1.1 * biased.state().vx + 0.05);
    EXPECT_EQ(biased.observe().x.omega, biased.state().omega);
  }
}

TEST(World, AnObservationIsPlacedWhereTheSensorsSeeIt) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1}, "sensors": {"bias": {"x": 0.2, "y": -0.1}}})");
  World world(spec, 1);
  world.advance({0.3, 0});
  EXPECT_NEAR(world.observe().at.s, world.state().x + 0.2, 1e-12);
  EXPECT_NEAR(world.observe().at.n, world.state().y - 0.1, 1e-12);
  EXPECT_NEAR(world.place().n, world.state().y, 1e-12);
  EXPECT_DOUBLE_EQ(world.observe().t, 0.02);
  EXPECT_DOUBLE_EQ(world.observe().at.t, 0.02);
}

TEST(World, WhatActsIsWhatTheActuatorsMakeOfTheCommand) {
  const WorldSpec plain = world_of(R"({"start": {"speed": 1.5}})");
  World world(plain, 1);
  for (int k = 0; k < 5; ++k) {
    const Input u = {0.1 * k, 1.0};
    EXPECT_EQ(world.acting_under(u).d, u.d);
    EXPECT_DOUBLE_EQ(world.acting_under(u).delta, world.state().delta + 0.02);
    const World::Acting promised = world.acting_under(u);
    world.advance(u);
    EXPECT_EQ(world.acting().force_front, promised.force_front);
    EXPECT_EQ(world.acting().d, promised.d);
  }
  const WorldSpec late = world_of(
      R"({"start": {"speed": 1.5}, "plant": {"plugin": "dynamic", "effects": [{"plugin": "input_delay", "params": {"T": 0.04}}]}})");
  World delayed(late, 1);
  for (int k = 0; k < 6; ++k) {
    const Input u = {0.1 * (k + 1), 1.0};
    EXPECT_NEAR(delayed.acting_under(u).d, k < 2 ? 0.0 : 0.1 * (k - 1), 1e-12) << k;
    delayed.advance(u);
  }
  const WorldSpec ramped = world_of(R"({"start": {"speed": 1.5}, "input_hold": "foh"})");
  World ramp(ramped, 1);
  ramp.advance({0.5, 1.0});
  EXPECT_DOUBLE_EQ(ramp.acting_under({0.9, 5}).d, 0.5);  // the command reached now, whatever comes next
  EXPECT_DOUBLE_EQ(ramp.acting_under({0.9, 5}).delta, 0.02);
}

/// A plant's force and the slip beside it are of one instant.
TEST(World, ForcesOfAPlantAreThoseOfNow) {
  const WorldSpec spec =
      world_of(R"({"start": {"speed": 1.5}, "plant": {"plugin": "spy.known_forces", "params": null}})");
  World world(spec, 1);
  const auto known = [&](const State& x) { return spec.car.car.m * x.vx * x.omega; };
  for (int k = 0; k < 8; ++k) {
    const Input u = {0.2, k < 4 ? 3.0 : -4.0};
    const State now = world.state();
    const World::Acting acting = world.acting_under(u);
    EXPECT_DOUBLE_EQ(acting.force_front, known(now)) << k;
    EXPECT_DOUBLE_EQ(acting.force_rear, 2 * known(now)) << k;
    EXPECT_DOUBLE_EQ(acting.slip_rear, std::atan2(0.033 * now.omega - now.vy, now.vx)) << k;
    world.advance(u);
    EXPECT_EQ(world.acting().force_front, acting.force_front) << k;
    EXPECT_NEAR(world.acting().slip_front, acting.slip_front, 1e-14) << k;
    EXPECT_NE(known(world.state()), known(now)) << k;  // else a step too early would not show
  }
}

TEST(World, ItsPluginsAreToldHowCommandsAreHeld) {
  const auto ax = [](const std::string& hold) {
    const WorldSpec spec =
        world_of(R"({"input_hold": ")" + hold + R"(", "plant": {"effects": [{"plugin": "spy.hold"}]}})");
    return told<double>(World(spec, 1), 1.5, 0, 0, 0.2, 0).ax;
  };
  EXPECT_NEAR(ax("foh"), ax("zoh") + 1.0, 1e-12);
  EXPECT_NEAR(ax("rate"), ax("zoh") + 2.0, 1e-12);
}

TEST(World, SlipsAreThoseOfTheCarsGeometry) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1.5}})");
  World world(spec, 1);
  for (int k = 0; k < 10; ++k) world.advance({0.5, 2});
  const State& x = world.state();
  EXPECT_DOUBLE_EQ(world.slip(Axle::front), x.delta - std::atan2(0.029 * x.omega + x.vy, x.vx));
  EXPECT_DOUBLE_EQ(world.slip(Axle::rear), std::atan2(0.033 * x.omega - x.vy, x.vx));
  EXPECT_GT(std::abs(world.slip(Axle::rear)), 0.01);
}

/// What slips is the wheel as it stands, on the axle where it is.
TEST(World, SlipsAreUnderTheWheelAngleThatActs) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1.5}, "plant": {"effects": [
    {"plugin": "steer_offset", "params": {"d0": 0.03}}, {"plugin": "cog_shift", "params": {"k": 0.05}}]}})");
  World world(spec, 1);
  for (int k = 0; k < 10; ++k) world.advance({0.5, 2});
  const State& x = world.state();
  const double lf = 0.029 + 0.05 * 0.062, lr = 0.033 - 0.05 * 0.062;
  EXPECT_NEAR(world.slip(Axle::front), x.delta + 0.03 - std::atan2(lf * x.omega + x.vy, x.vx), 1e-14);
  EXPECT_NEAR(world.slip(Axle::rear), std::atan2(lr * x.omega - x.vy, x.vx), 1e-14);

  const WorldSpec slow =
      world_of(R"({"start": {"speed": 1.5}, "plant": {"effects": [{"plugin": "steer_lag", "params": {"tau": 1}}]}})");
  World lagging(slow, 1);
  lagging.advance({0.5, 5});
  const State& y = lagging.state();
  const double wheel = lagging.slip(Axle::front) + std::atan2(0.029 * y.omega + y.vy, y.vx);
  EXPECT_NEAR(wheel, 0.1 * (1 - std::exp(-0.02)), 1e-6);  // of the 0.1 rad that were commanded
}

TEST(World, SlipsAndForcesUnderACommandAreOfOneTyre) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1.5}})");
  World world(spec, 1);
  for (int k = 0; k < 5; ++k) {
    const World::Acting acting = world.acting_under({0.4, 2});
    EXPECT_NEAR(acting.force_front, 0.192 * std::sin(1.2 * std::atan(2.579 * acting.slip_front)), 1e-14);
    EXPECT_NEAR(acting.force_rear, 0.1737 * std::sin(1.2691 * std::atan(3.3852 * acting.slip_rear)), 1e-14);
    world.advance({0.4, 2});
  }
}

/// Uphill without drive, steered to the left.
TEST(World, SlipsOfACarThatRollsBackwardsAreThoseOfItsTyres) {
  const double yaw = World(world_of(R"({"start": {"speed": 0}})"), 1).state().yaw;
  const std::string tilt =
      R"({"tx": )" + std::to_string(0.3 * std::cos(yaw)) + R"(, "ty": )" + std::to_string(0.3 * std::sin(yaw)) + "}";
  const WorldSpec spec = world_of(R"({"start": {"speed": 0}, "plant": {"substeps": 10, "effects": [
    {"plugin": "plane_tilt", "params": )" +
                                  tilt + "}]}}");
  World world(spec, 1);
  for (int k = 0; k < 15; ++k) world.advance({0.0, k < 2 ? 5.0 : 0.0});
  EXPECT_LT(world.state().vx, -0.3);
  const World::Acting acting = world.acting_under({0.0, 0.0});
  EXPECT_GT(std::abs(acting.force_front), 0.01);
  EXPECT_NEAR(acting.force_front, 0.192 * std::sin(1.2 * std::atan(2.579 * acting.slip_front)), 1e-14);
  EXPECT_NEAR(acting.force_rear, 0.1737 * std::sin(1.2691 * std::atan(3.3852 * acting.slip_rear)), 1e-14);
}

TEST(World, AForceThatIsNoNumberStopsTheWorldInsteadOfLosingTheCar) {
  const WorldSpec spec = world_of(
      R"({"plant": {"plugin": "dynamic", "effects": [{"plugin": "fault.nan_force", "params": {"t": 0.09}}]}})");
  World world(spec, 1);
  for (int k = 0; k < 4; ++k) world.advance({0.5, 0});
  EXPECT_TRUE(world.finite());
  world.advance({0.5, 0});
  EXPECT_FALSE(world.finite());
  EXPECT_NO_THROW(world.advance({0.5, 0}));
  EXPECT_EQ(world.plant_id(), "dynamic");
}

/// The masses and lengths of an F1TENTH car, leaving a start at 0.1 m/s while it is steered: true yaw rates.
std::vector<double> yaw_rates_leaving(const std::string& integrator, bool by_error, int substeps = 1) {
  const double grip = 0.8 * 3.74 * gravity / 0.33;
  std::string patch = R"({"car": {"m": 3.74, "Iz": 0.047, "lf": 0.159, "lr": 0.171, "length": 0.06, "width": 0.03,
    "d_min": -0.1, "d_max": 1, "delta_max": 0.35, "ddelta_max": 5, "v_ref": 3, "v_min": 0.3, "substeps_by_error": )";
  patch.append(by_error ? "true" : "false");
  patch.append(R"(}, "start": {"speed": 0.1}, "plant": {"plugin": "dynamic", "integrator": ")");
  patch.append(integrator).append("\", \"substeps\": ").append(std::to_string(substeps));
  patch.append(
      R"(, "params": {"Bf": 4, "Cf": 1.4, "Br": 4, "Cr": 1.4, "Cm1": 12, "Cm2": 1, "Cr0": 0, "Cd": 0, "Df": )");
  patch.append(number_text(grip * 0.171)).append(", \"Dr\": ").append(number_text(grip * 0.159)).append("}}}");
  const WorldSpec spec = world_of(patch);
  World world(spec, 1);
  std::vector<double> rates;
  for (int k = 0; k < 12; ++k) {
    world.advance({0.3, k < 2 ? 1.0 : 0.0});
    rates.push_back(world.state().omega);
  }
  return rates;
}

double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(World, AStiffStartTakesAsManySubstepsAsItsErrorAsksWhateverTheIntegrator) {
  const std::vector<double> exact = yaw_rates_leaving("rk4", false, 400);
  for (const char* integrator : {"euler", "heun", "rk4", "rkf5", "rk6"})
    EXPECT_LT(farthest(yaw_rates_leaving(integrator, true), exact), 0.01) << integrator;
  EXPECT_LT(farthest(yaw_rates_leaving("rk4", true, 3), exact), 0.01);
  // What it is for: as stated, one step goes wrong, and each integrator in its own way.
  EXPECT_GT(farthest(yaw_rates_leaving("rk6", false), exact), 0.5);
  EXPECT_GT(farthest(yaw_rates_leaving("rk4", false), yaw_rates_leaving("rk6", false)), 0.5);
}

/// Where one step is good enough it is taken as it is.
TEST(World, SubstepsByErrorLeaveAFastCarAsItIs) {
  const char* const fast = R"({"start": {"speed": 1.8}})";
  WorldSpec stated = world_of(fast), by_error = world_of(fast);
  ASSERT_FALSE(stated.car.substeps_by_error);  // the 1:43 car, as published
  by_error.car.substeps_by_error = true;
  World one(stated, 1), other(by_error, 1);
  for (int k = 0; k < 30; ++k) {
    one.advance({0.4, k < 5 ? 1.0 : 0.0});
    other.advance({0.4, k < 5 ? 1.0 : 0.0});
    EXPECT_EQ(one.state().omega, other.state().omega);
    EXPECT_EQ(one.state().vx, other.state().vx);
  }
}

TEST(World, TheSameSeedIsTheSameWorld) {
  const WorldSpec spec = world_of(R"({"start": {"speed": 1}, "sensors": {"sigma": {"x": 0.01, "yaw_rate": 0.05}}})");
  World one(spec, 3), same(spec, 3), other(spec, 4);
  bool differs = false;
  for (int k = 0; k < 30; ++k) {
    for (World* world : {&one, &same, &other}) world->advance({0.3, 0.5});
    EXPECT_EQ(one.observe().x.x, same.observe().x.x);
    EXPECT_EQ(one.state().x, other.state().x);
    differs = differs || one.observe().x.x != other.observe().x.x;
  }
  EXPECT_TRUE(differs);
}

}  // namespace test_world
}  // namespace gripline
