#include "experiment/force_validation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/validation_rig.hpp"

namespace gripline {
namespace test_force_validation {

using namespace testing_support;

RaceSpec race_of(std::string_view stacks, std::string_view world = R"({"laps": 3})") {
  Node tree = json(R"({"kind": "force_validation", "base": {"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": 0.6}}, "controller": {"plugin": "pure_pursuit"}}})");
  tree.set("world", lap_world(world));
  tree.set("stacks", json(stacks));
  inline_world_files(*tree.find("world"));
  return read_race("forces.json", std::move(tree), plugins());
}

/// The oracle knows the true car: its predictions of every channel are the truth, over one lap and for asked rows only.
TEST(ForceValidation, TheTrueCarIsPredictedExactly) {
  const Folder out;
  const RaceSpec race = race_of(R"({"plain": {}, "told": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"},
                                    "unasked": {"estimator": {"plugin": "none"}}})");
  const auto all = validate_forces(race, {"plain", "told"}, out.path()).scores;
  const Scores scores = by_channel(all, "told");
  EXPECT_EQ(all.size(), 5u);
  ASSERT_EQ(scores.size(), 5u);
  for (const auto& [channel, score] : scores) EXPECT_GT(score.r2, 1.0 - 1e-4) << channel;
  EXPECT_EQ(scores.at("force_rear").unit, "N");
  EXPECT_FALSE(std::filesystem::exists(out / "unasked"));
}

/// What came out of other rows is judged all the same.
TEST(ForceValidation, ARowWithoutALapToJudgeIsSaid) {
  const Folder out;
  const RaceSpec race = race_of(R"({"told": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"},
                                    "late": {"estimator": {"plugin": "oracle"}, "adapt_after": "1000 s"}})");
  const ForceScores found = validate_forces(race, {"told", "late"}, out.path());
  EXPECT_EQ(found.unjudged, "late (3 laps driven)");
  EXPECT_EQ(by_channel(found.scores, "told").size(), 5u);
  EXPECT_TRUE(by_channel(found.scores, "late").empty());
  EXPECT_TRUE(std::filesystem::exists(out / "validation.csv"));
}

/// The first lap takes 4.3 s: the race ends within the second, which is the first after the stack trusts.
TEST(ForceValidation, ALapThatWasNotDrivenToItsEndIsNotJudged) {
  const Folder out;
  const RaceSpec race = race_of(R"({"told": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"}})",
                                R"({"laps": 3, "duration": "6 s"})");
  EXPECT_THAT([&] { validate_forces(race, {"told"}, out.path()); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("adapt_after): told (1 laps driven)")));
}

/// More laps would not help a car that does not drive them.
TEST(ForceValidation, ARaceThatDidNotFinishSaysWhy) {
  const Folder out;
  const RaceSpec race = race_of(R"({"told": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"}})",
                                R"({"laps": 3, "timeout": "6 s"})");
  try {
    validate_forces(race, {"told"}, out.path());
    ADD_FAILURE() << "no number at all passed";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::EndsWith("adapt_after): told (1 laps driven: still driving after 6 s)"));
  }
}

TEST(ForceValidation, NoRowWithALapToJudgeIsAnError) {
  const Folder out;
  const RaceSpec race = race_of(R"({"late": {"estimator": {"plugin": "oracle"}, "adapt_after": "1000 s"}})");
  try {
    validate_forces(race, {"late"}, out.path());
    ADD_FAILURE() << "no number at all passed";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("adapt_after): late (3 laps driven); a world of more laps"));
  }
}

/// What an earlier call wrote is read until the new files are whole.
TEST(ForceValidation, EarlierFilesStayUntilTheNewOnesAreWhole) {
  const Folder out;
  const RaceSpec race = race_of(R"({"told": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"}})");
  const std::vector<const char*> names = {"validation.csv", "validation_traces.csv"};
  for (const char* name : names) write_text(out / name, "earlier");
  int seen = 0;
  const auto look = [&](double, std::size_t, const std::string&) {
    ++seen;
    for (const char* name : names) EXPECT_EQ(contents(out / name), "earlier");
  };
  validate_forces(race, {"told"}, out.path(), look);
  EXPECT_GT(seen, 0);
  EXPECT_EQ(lines(out / "validation.csv").size(), 6u);
  EXPECT_GT(lines(out / "validation_traces.csv").size(), 5u * 100);
}

}  // namespace test_force_validation
}  // namespace gripline
