#include "experiment/offline_validation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "support/validation_rig.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_offline_validation {

using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace testing_support;

Node offline(std::string_view estimators) {
  Node tree = json(R"({"kind": "offline_validation", "model": {"plugin": "ekinematic"},
    "driver": {"planner": {"plugin": "fixed_speed", "params": {"mu": 0.6}},
               "controller": {"plugin": "pure_pursuit"}}})");
  for (const char* key : {"train", "test"}) {
    Node drive{Node::Object{}};
    drive.set("world", lap_world());
    tree.set(key, std::move(drive));
  }
  tree.set("estimators", json(estimators));
  return tree;
}

TEST(OfflineValidation, WhoLearnsNothingExplainsNothing) {
  const Folder out;
  const auto scores = by_channel(
      validate_offline(offline(R"({"none": {"plugin": "none"}, "elm": {"plugin": "elm"}})"), plugins(), out.path()),
      "none");
  ASSERT_EQ(scores.size(), 3u);
  for (const auto& [channel, score] : scores) {
    EXPECT_GT(score.n, 200u) << channel;
    EXPECT_GT(score.rmse, 0.0) << channel;
    EXPECT_LE(score.r2, 0.0) << channel;  // zero is no better than the mean
  }
  EXPECT_EQ(scores.at("e_vy").unit, "m/s2");
}

TEST(OfflineValidation, WhatWasLearnedOnOneLapHoldsOnTheNext) {
  const Folder out;
  const auto scores = by_channel(
      validate_offline(
          offline(R"({"elm": {"plugin": "elm", "params": {"solver": "pseudo_inverse", "window": 2000, "retain": 1}}})"),
          plugins(), out.path()),
      "elm");
  for (const char* channel : {"e_vx", "e_vy", "e_omega"}) EXPECT_GT(scores.at(channel).r2, 0.9) << channel;
}

TEST(OfflineValidation, WritesScoresAndTraces) {
  const Folder out;
  const auto all = validate_offline(offline(R"({"none": {"plugin": "none"}})"), plugins(), out.path());
  EXPECT_EQ(lines(out / "validation.csv").at(0), "estimator,channel,unit,n,r2,rmse");
  EXPECT_EQ(lines(out / "validation.csv").size(), 4u);
  const std::vector<std::string> traces = lines(out / "validation_traces.csv");
  EXPECT_EQ(traces.at(0), "estimator,channel,t_s,truth,predicted,slip_rad");
  EXPECT_EQ(traces.size(), 1 + all[0].n + all[1].n + all[2].n);
  EXPECT_TRUE(std::filesystem::exists(out / "train/steps.csv"));
  EXPECT_TRUE(std::filesystem::exists(out / "test/steps.csv"));
}

/// Throttle and steering angle that act in the middle of each judged step of the test, as spy.acting shows them, by the
/// number of the step. The test begins at rest: its first steps are too slow to be judged.
struct Acting {
  std::map<std::size_t, double> d, delta;
};
Acting acting_in(const Node& tree, const Folder& out) {
  validate_offline(tree, plugins(), out.path());
  Acting acting;
  for (const std::string& line : lines(out / "validation_traces.csv")) {
    std::vector<std::string> cells;
    std::stringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (cells.at(1) != "e_omega" && cells.at(1) != "e_vy") continue;
    const auto step = static_cast<std::size_t>(std::lround(std::stod(cells.at(2)) / 0.02));
    (cells[1] == "e_omega" ? acting.d : acting.delta)[step] = std::stod(cells.at(4));
  }
  EXPECT_GT(acting.d.size(), 200u);
  EXPECT_GT(acting.d.begin()->first, 1u);
  return acting;
}
Node from_rest(std::string_view patch) {
  Node tree = offline(R"({"spy": {"plugin": "spy.acting"}})");
  for (const char* key : {"train", "test"})
    tree.find(key)->set("world", merge(lap_world(R"({"start": {"speed": 0}})"), json(patch)));
  return tree;
}

/// Throttle and steering move in lines from one sample to the next, from the first step that is judged on.
TEST(OfflineValidation, CommandsMoveAsInTheWorld) {
  const Folder out;
  const Acting acting = acting_in(from_rest(R"({"input_hold": "foh"})"), out);
  const CsvTable steps = read_csv(out / "test/steps.csv");
  const std::vector<double> d = steps.column("d"), delta = steps.column("delta_rad");
  EXPECT_GT(d.at(acting.d.begin()->first), 0.1);
  for (const auto& [k, shown] : acting.d) ASSERT_NEAR(shown, 0.5 * (d.at(k) + d.at(k + 1)), 1e-5) << k;
  for (const auto& [k, shown] : acting.delta) ASSERT_NEAR(shown, 0.5 * (delta.at(k) + delta.at(k + 1)), 1e-5) << k;
}

/// What models remember goes on through steps that are not judged.
TEST(OfflineValidation, ALagIsThatOfTheWholeDrive) {
  const Folder out;
  const double tau = 0.5;
  Node tree = from_rest("{}");
  tree.find("model")->set("effects", json(R"([{"plugin": "motor_lag", "params": {"tau": 0.5}}])"));
  const Acting acting = acting_in(tree, out);
  const std::vector<double> d = read_csv(out / "test/steps.csv").column("d");
  double motor = 0.0;
  for (std::size_t k = 0; k < d.size(); ++k) {
    const double kept = std::exp(-0.02 / tau), mean = d[k] + (motor - d[k]) * (1.0 - kept) * tau / 0.02;
    motor = d[k] + (motor - d[k]) * kept;
    if (!acting.d.contains(k)) continue;
    ASSERT_NEAR(acting.d.at(k), mean, 1e-4) << k;
  }
}

/// As in a race: a learner that would be wrong there says so here too.
TEST(OfflineValidation, ALearnerOfHeldCommandsIsRefusedUnderOthers) {
  const Folder out;
  Node tree = from_rest(R"({"input_hold": "foh"})");
  tree.set("estimators", json(R"({"elm": {"plugin": "elm"}})"));
  EXPECT_THAT(refusal([&] { validate_offline(tree, plugins(), out.path()); }),
              HasSubstr("learns from held commands only: input_hold \"zoh\""));
}

TEST(OfflineValidation, ADriverThatDoesNotFinishIsAnError) {
  const Folder out;
  Node tree = offline(R"({"none": {"plugin": "none"}})");
  tree.find("test")->set("world", lap_world(R"({"timeout": "1 s"})"));
  EXPECT_THAT([&] { validate_offline(tree, plugins(), out.path()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("test: the driver did not finish: still driving after 1 s")));
}

TEST(OfflineValidation, AFilterOfTheDriversStateRefusesLateSensors) {
  for (const char* key : {"train", "test"}) {
    Node tree = offline(R"({"none": {"plugin": "none"}})");
    tree.find("driver")->set("state_filter", json(R"({"sigma": {}})"));
    EXPECT_EQ(refusal([&] { check_offline(tree, plugins()); }), "nothing");
    tree.find(key)->set("world", lap_world(R"({"sensors": {"delay": {"yaw": "20 ms"}}})"));
    EXPECT_THAT(refusal([&] { check_offline(tree, plugins()); }), HasSubstr("have a delay (yaw)")) << key;
  }
}

/// An estimator is asked about steps as those that it learned from, of the car that drove them.
TEST(OfflineValidation, WorldsOfOtherStepsOrCarsAreRefused) {
  const auto refused = [&](Node world) {
    Node tree = offline(R"({"none": {"plugin": "none"}})");
    tree.find("test")->set("world", std::move(world));
    return refusal([&] { check_offline(tree, plugins()); });
  };
  EXPECT_THAT(refused(lap_world(R"({"dt": "10 ms"})")),
              HasSubstr("/dt: the worlds of \"train\" and \"test\" differ in \"dt\""));
  EXPECT_THAT(refused(lap_world(R"({"input_hold": "foh"})")), HasSubstr("/input_hold: the worlds of"));
  Node heavier = lap_world();
  heavier.set("car", load_json(source_dir() / "worlds/cars/orca_1_43.json")).set("m", Node(0.05));
  EXPECT_THAT(refused(heavier), HasSubstr("differ in \"car\""));
  EXPECT_EQ(refused(lap_world(R"({"dt": 0.02, "friction": [{"t": 0, "factor": 0.9}]})")), "nothing");
}

TEST(OfflineValidation, ADriveWithoutAStepIsAnError) {
  const Folder out;
  for (const char* part : {"train", "test"}) {
    Node tree = offline(R"({"none": {"plugin": "none"}})");
    tree.find(part)->set("world", lap_world(R"({"duration": "1 ms"})"));
    EXPECT_THAT([&] { validate_offline(tree, plugins(), out.path()); },
                ThrowsMessage<std::runtime_error>(HasSubstr(std::string(part) + ": the drive has no step")));
  }
}

}  // namespace test_offline_validation
}  // namespace gripline
