#include "measured/replay/rollout.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_rollout {

using diagnose::ModelSpec;
using test::DiagnoseRig;

/// An effect, and a drive in which it shows without spinning the car or stopping it, where the tyres' equations are
/// stiffer than a step: with combined slip and the full weave the car turns at 25 rad/s, and 4 substeps are 0.02 sigma
/// from 16 where 8 are 0.002.
struct Shown {
  const char* id;
  std::vector<double> values;
  DiagnoseRig::Drive drive = {8, 11, 0};
};

/// The same log predicted with the car that drove it: nothing is left. With memory, delay and sensor errors too.
TEST(Rollout, TheTrueCarPredictsItsOwnLog) {
  DiagnoseRig rig;
  const std::vector<Shown> effects = {{"aero_drag", {0.4}},        {"steer_lag", {0.03}},
                                      {"motor_lag", {0.08}},       {"input_delay", {0.033}},
                                      {"vx_scale", {0.03}},        {"yawrate_bias", {0.1}},
                                      {"relaxation", {0.05}},      {"brake_fade", {2.0}, {8, 11, 0, 0.5, 0.4}},
                                      {"friction_drift", {-0.1}},  {"comb_slip", {0.6}, {8, 11, 0, 0.5}},
                                      {"plane_tilt", {0.02, 0.01}}};
  for (const auto& [id, values, drive] : effects) {
    const ModelSpec truth = rig.with(id, values);
    Trace trace;
    trace.log = rig.simulate(truth, drive);
    const StagedCar car = rig.catalogue().build(truth);
    trace.set_motion(trace.log.reading, rig.road());
    trace.set_motion(states_of_readings(car, trace.log.reading, trace.at), rig.road());
    RolloutOptions options;
    options.substeps = 4;
    Channels sigma{};
    for (std::size_t c = 0; c < channels; ++c) sigma[c] = rig.world().sensors.channels[c].sigma;
    const double with_effect = rms(roll_out(car, trace, rig.road(), options), sigma);
    EXPECT_LT(with_effect, 0.01) << id;
    Trace nominal = trace;
    nominal.set_motion(trace.log.reading, rig.road());
    const StagedCar bare = rig.catalogue().build(rig.catalogue().null_model());
    EXPECT_GT(rms(roll_out(bare, nominal, rig.road(), options), sigma), 0.1) << id;
  }
}

Rollouts of_errors(std::vector<double> error) {
  Rollouts r;
  r.predicted.assign(error.size(), 1.0);
  r.error = std::move(error);
  return r;
}

TEST(Rollout, ErrorsAreInStandardDeviationsAndClipped) {
  const Channels sigma = {1, 2, 1, 1, 1, 1};
  EXPECT_DOUBLE_EQ(rms(of_errors({0, 6, 0, 0, 0, 0}), sigma), 3.0 / std::sqrt(6.0));
  EXPECT_DOUBLE_EQ(rms(of_errors({1e9, 0, 0, 0, 0, 0}), sigma), most_deviation / std::sqrt(6.0));
  // A missing reading counts for nothing, a prediction without a number for the most.
  Rollouts missing = of_errors({not_a_number, 6, 0, 0, 0, 0});
  EXPECT_DOUBLE_EQ(rms(missing, sigma), 3.0 / std::sqrt(5.0));
  missing.predicted[0] = not_a_number;
  EXPECT_DOUBLE_EQ(rms(missing, sigma), std::sqrt((most_deviation * most_deviation + 9.0) / 6.0));
  EXPECT_EQ(rms(of_errors({}), sigma), 0.0);
  const SquaredErrors second = squared_errors(of_errors({9, 9, 9, 9, 9, 9, 1, 4, 0, 0, 0, 0}), 6, 12, sigma);
  EXPECT_EQ(second.sum, 5.0);
  EXPECT_EQ(second.readings, 6U);
}

TEST(Rollout, StartsAndSamplesAreAsAskedFor) {
  const DiagnoseRig rig;
  Trace trace;
  trace.log = rig.simulate(rig.catalogue().null_model(), {4, 12, 0});  // 201 samples
  trace.set_motion(trace.log.reading, rig.road());
  RolloutOptions options;
  options.horizon = 0.5;
  options.first = 20;
  options.every = 60;
  const Rollouts r = roll_out(rig.catalogue().build(rig.catalogue().null_model()), trace, rig.road(), options);
  EXPECT_EQ(r.samples, 25U);
  EXPECT_EQ(r.start, (std::vector<std::size_t>{20, 80, 140}));
  EXPECT_EQ(r.error.size(), 3 * 25 * channels);
}

/// What sensors with offsets and scales show is read back to the state.
TEST(Rollout, StatesAreReadThroughTheSensors) {
  const DiagnoseRig rig;
  const StagedCar car = rig.catalogue().build(rig.with(rig.with("vx_scale", {0.05}), "yawrate_bias", {0.1}));
  std::vector<double> readings = {1, 2, 0.3, 2.1, not_a_number, 0.6};
  const std::vector<double> states = states_of_readings(car, readings, std::vector<Place>(1));
  EXPECT_NEAR(states[3], 2.0, 1e-9);
  EXPECT_NEAR(states[5], 0.5, 1e-9);
  EXPECT_TRUE(std::isnan(states[4]));
}

TEST(Rollout, StatesAreReadThroughAxesTurnedByAnyAngle) {
  const DiagnoseRig rig;
  for (const double turned : {0.3, 1.2, -2.0, 3.1}) {
    const StagedCar car = rig.catalogue().build(rig.with("velocity_yaw", {turned}));
    const double c = std::cos(turned), s = std::sin(turned);
    const std::vector<double> readings = {1, 2, 0.3, 2.0 * c + 0.1 * s, 0.1 * c - 2.0 * s, 0.6};
    const std::vector<double> states = states_of_readings(car, readings, std::vector<Place>(1));
    EXPECT_NEAR(states[Channel::vx], 2.0, 1e-9) << turned;
    EXPECT_NEAR(states[Channel::vy], 0.1, 1e-9) << turned;
  }
}

}  // namespace test_rollout
}  // namespace gripline::measured
