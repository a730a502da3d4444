#include "experiment/offline_validation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/validation_rig.hpp"

namespace gripline {
namespace {

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

TEST(OfflineValidation, ADriverThatDoesNotFinishIsAnError) {
  const Folder out;
  Node tree = offline(R"({"none": {"plugin": "none"}})");
  tree.find("test")->set("world", lap_world(R"({"timeout": "1 s"})"));
  EXPECT_THAT([&] { validate_offline(tree, plugins(), out.path()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("test: the driver did not finish: still driving after 1 s")));
}

}  // namespace
}  // namespace gripline
