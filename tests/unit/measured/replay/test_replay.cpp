#include "measured/replay/replay.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::measured {
namespace test_replay {

using test::DiagnoseRig;

/// The car after the step from sample k, which lasts from `t` [s] on.
std::vector<double> stepped(const StagedCar& car, const Log& log, std::size_t k, double t, std::vector<double> x) {
  Place from, to;
  from.t = t;
  to.t = t + log.dt;
  LogStepper(car, log, 8).advance({&k, 1}, {&from, 1}, {&to, 1}, x.data(), nullptr);
  return x;
}

const std::vector<CommandSample<double>> jumping = {{0.3, 0.0}, {0.6, 0.1}, {0.2, -0.05}, {0.5, 0.2}, {0.4, 0.0}};
const std::vector<double> start = {0.0, 0.0, 0.1, 1.6, 0.02, 0.3};

/// A log whose command never changes.
Log constant(const CommandSample<double>& command, double dt) {
  Log log;
  log.dt = dt;
  log.command.assign(2, command);
  return log;
}

TEST(Replay, AHeldCommandActsUntilTheNext) {
  const DiagnoseRig rig;
  const StagedCar car = rig.catalogue().build(rig.catalogue().null_model());
  Log log;
  log.command = jumping;
  log.hold.until_next = true;
  const auto held = stepped(car, log, 2, 0.04, start),
             alone = stepped(car, constant(jumping[2], log.dt), 0, 0.0, start);
  for (std::size_t c = 0; c < channels; ++c) EXPECT_NEAR(held[c], alone[c], 1e-12) << c;
  log.hold.until_next = false;
  EXPECT_GT(std::abs(stepped(car, log, 2, 0.04, start)[5] - alone[5]), 0.1);
}

/// A delay of one and a half samples: the step after sample 3 begins with command 1 and ends with command 2.
TEST(Replay, AHeldCommandActsLateUntilTheNextIsAsLate) {
  const DiagnoseRig rig;
  const StagedCar late = rig.catalogue().build(rig.with("input_delay", {0.03}));
  const StagedCar bare = rig.catalogue().build(rig.catalogue().null_model());
  Log log;
  log.command = jumping;
  log.hold.until_next = true;
  const auto held = stepped(late, log, 3, 0.06, start);
  const auto half = stepped(bare, constant(jumping[1], 0.5 * log.dt), 0, 0.0, start);
  const auto whole = stepped(bare, constant(jumping[2], 0.5 * log.dt), 0, 0.0, half);
  for (std::size_t c = 0; c < channels; ++c) EXPECT_NEAR(held[c], whole[c], 1e-7) << c;
}

/// Every second of commands that change evenly, each held for half a sample.
TEST(Replay, HeldCommandsThatWereLeftOutAreTakenToBeBetweenTheirNeighbours) {
  const DiagnoseRig rig;
  const StagedCar car = rig.catalogue().build(rig.catalogue().null_model());
  Log whole, half;
  whole.dt = 0.02;
  half.dt = 0.04;
  for (std::size_t k = 0; k < 5; ++k) {
    const double turn = 0.002 * static_cast<double>(k);
    whole.command.push_back({0.3, turn});
    if (k % 2 == 0) half.command.push_back({0.3, turn});
  }
  whole.hold.until_next = true;
  hold_commands(half, held_for(0.02, half.dt));
  EXPECT_NEAR(command_at(half, 1, 0.2).delta, 0.004, 1e-15);
  EXPECT_NEAR(command_at(half, 1, 0.7).delta, 0.006, 1e-15);
  EXPECT_NEAR(command_at_sample(half, 1).delta, 0.003, 1e-15);
  EXPECT_NEAR(history_at(half, 0.07).at(0.0).delta, 0.006, 1e-15);
  EXPECT_NEAR(history_at_sample(half, 0.06).at(0.0).delta, 0.005, 1e-15);
  const auto first = stepped(car, whole, 2, 0.04, start), second = stepped(car, whole, 3, 0.06, first);
  const auto both = stepped(car, half, 1, 0.04, start);
  hold_commands(half, {});
  const auto straight = stepped(car, half, 1, 0.04, start);
  for (std::size_t c = 0; c < channels; ++c) EXPECT_NEAR(both[c], second[c], 2e-6) << c;
  EXPECT_GT(std::abs(straight[5] - second[5]), 1e-3);
}

TEST(Replay, ACommandHeldForAboutASampleIsHeldUntilTheNext) {
  EXPECT_EQ(held_for(0.02, 0.02), (CommandHold{.until_next = true}));
  EXPECT_EQ(held_for(0.02, 0.01), (CommandHold{.until_next = true}));
  EXPECT_EQ(held_for(0.02, 0.04), (CommandHold{.halves = true}));
  EXPECT_NEAR(held_for(0.02, 0.06).lag, 1.0 / 6.0, 1e-15);
  for (const double dt : {0.02, 0.04, 0.06}) EXPECT_NEAR(held_for(0.02, dt).seconds(dt), 0.02, 1e-15);
  EXPECT_EQ(CommandHold{}.seconds(0.04), 0.0);
}

/// Where more of them were left out, what acts is the straight line between those logged, late by half a hold.
TEST(Replay, ManyHeldCommandsThatWereLeftOutActLate) {
  Log log;
  log.dt = 0.06;
  for (std::size_t k = 0; k < 4; ++k) log.command.push_back({0.3, 0.006 * static_cast<double>(k)});
  hold_commands(log, held_for(0.02, log.dt));
  EXPECT_NEAR(command_at(log, 1, 0.0).delta, 0.005, 1e-15);
  EXPECT_NEAR(command_at(log, 1, 0.5).delta, 0.008, 1e-15);
  EXPECT_NEAR(command_at(log, 0, 0.1).delta, 0.0, 1e-15);
  EXPECT_NEAR(command_at_sample(log, 2).delta, 0.011, 1e-15);
  EXPECT_NEAR(history_at(log, 0.12).at(0.03).delta, 0.008, 1e-12);
}

/// What is taken as linear between samples has each held command's mean over its step, with a delay as without.
TEST(Replay, HeldCommandsCountAtSamplesByTheMeanOfBothSides) {
  Log log;
  for (std::size_t k = 0; k < 8; ++k) log.command.push_back({0.1 * static_cast<double>(k), 0.0});
  log.hold.until_next = true;
  EXPECT_NEAR(command_at_sample(log, 4).d, 0.35, 1e-12);
  EXPECT_NEAR(history_at_sample(log, 0.08).at(0.0).d, 0.35, 1e-12);
  EXPECT_NEAR(history_at_sample(log, 0.08).at(0.03).d, 0.2, 1e-12);
  log.hold.until_next = false;
  EXPECT_NEAR(command_at_sample(log, 4).d, 0.4, 1e-12);
  EXPECT_NEAR(history_at_sample(log, 0.08).at(0.03).d, 0.25, 1e-12);
}

}  // namespace test_replay
}  // namespace gripline::measured
