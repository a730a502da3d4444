#include "experiment/perturb.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "experiment/experiment.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_perturb {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

RaceSpec race_of(std::string_view perturb, std::string_view patch = "{}") {
  Node world = small_world();
  inline_world_files(world);
  Node tree = json(R"({"base": {"model": {"plugin": "ekinematic"}, "controller": {"plugin": "pure_pursuit"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}}, "stacks": {"good": {}}})");
  tree.set("world", world);
  tree.set("perturb", json(perturb));
  return read_race("perturb.json", merge(tree, json(patch)), plugins());
}
std::string why(std::string_view perturb, std::string_view patch = "{}") {
  return refusal([&] { race_of(perturb, patch); });
}

TEST(Perturb, IsReadWithUnits) {
  const PerturbSpec spec = race_of(R"({"position": "20 mm", "heading": "3 deg", "speed": "0.1 m/s"})").perturb;
  EXPECT_DOUBLE_EQ(spec.position, 0.02);
  EXPECT_NEAR(spec.heading, 3 * 3.14159265358979 / 180, 1e-12);
  EXPECT_DOUBLE_EQ(spec.speed, 0.1);
  EXPECT_EQ(spec.pace, 0);
  EXPECT_TRUE(spec.any());
}

TEST(Perturb, SaysWhatCannotBe) {
  EXPECT_THAT(why("{}"), HasSubstr("perturbs nothing"));
  EXPECT_THAT(why(R"({"positon": 1})"), HasSubstr("did you mean \"position\"?"));
  EXPECT_THAT(why(R"({"position": "3 s"})"), HasSubstr("expected a length [m]"));
  EXPECT_THAT(why(R"({"speed": 0.2})"), HasSubstr("/speed: the start's speed is 0.1 m/s; expected at most that"));
  EXPECT_THAT(why(R"({"position": 0.4})"), HasSubstr("at its extremes"));  // the road is 0.3 m to either side
  EXPECT_THAT(why(R"({"pace": 0.5})",
                  R"({"base": {"planner": {"plugin": "time_optimal", "params": {"pace": 1.9, "mu": null}}}})"),
              HasSubstr("/pace: that of stack good would leave 0.05 to 2"));
}

/// A start that is off the road is one mistake, however it is moved.
TEST(Perturb, AStartOffTheRoadIsToldOnce) {
  for (const char* perturb : {R"({"position": 0.1})", R"({"position": 0.1, "within_road": true})",
                              R"({"heading": "3 deg"})", R"({"speed": 0.05})"}) {
    const std::string message = why(perturb, R"({"world": {"start": {"y": 0.5}}})");
    EXPECT_THAT(message, AllOf(HasSubstr("/start"), HasSubstr("is off the track"), Not(HasSubstr("\n")))) << perturb;
  }
}

TEST(Perturb, KeepsToANarrowRoadWhereAsked) {
  const PerturbSpec narrow = race_of(R"({"position": 0.4, "heading": "3 deg", "within_road": true})").perturb;
  const RaceSpec race = race_of(R"({"position": 0.1, "within_road": true})");
  EXPECT_EQ(race.perturb.position, 0.1);  // the road has room for that
  const double room = 0.3 - 0.5 * race.world.car.car.width;
  EXPECT_LE(narrow.position, room + 1e-6);
  EXPECT_GT(narrow.position, 0.8 * room);  // along a road that turns
  EXPECT_NEAR(narrow.heading, 3 * 3.14159265358979 / 180, 1e-12);
  EXPECT_THAT(why(R"({"position": 0.4})"), HasSubstr("\"within_road\": true"));
  EXPECT_THAT(why(R"({"position": 0.01, "heading": "90 deg"})", R"({"world": {"start": {"yaw": "5 deg"}}})"),
              AllOf(HasSubstr("faces backwards"), Not(HasSubstr("within_road"))));  // the heading is wrong
  EXPECT_THAT(why(R"({"position": 0.01, "within_road": true})", R"({"world": {"start": {"y": 0.29}}})"),
              HasSubstr("/position: the car's body is not on the road at the start itself"));
  EXPECT_THAT(why(R"({"position": 0.4, "within_road": 1})"), HasSubstr("/within_road"));
}

TEST(Perturb, ADrawIsOfItsSeedAloneAndWithinItsWidth) {
  const PerturbSpec spec{0.02, 0.05, 0.1, 0.03};
  std::set<double> places;
  double sum = 0, most = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Draw draw = draw_of(spec, seed);
    EXPECT_EQ(draw.across, draw_of(spec, seed).across);
    EXPECT_LE(std::abs(draw.along), 0.02);
    EXPECT_LE(std::abs(draw.heading), 0.05);
    EXPECT_LE(std::abs(draw.speed), 0.1);
    EXPECT_LE(std::abs(draw.pace - 1), 0.03);
    places.insert(draw.across);
    sum += draw.across;
    most = std::max(most, std::abs(draw.across));
  }
  EXPECT_EQ(places.size(), 200u);
  EXPECT_NEAR(sum / 200, 0, 0.003);
  EXPECT_GT(most, 0.019);
  // A quantity that is added leaves the draws of the others as they were.
  EXPECT_EQ(draw_of({0.02, 0, 0, 0.03}, 7).across, draw_of({0.02, 0.05, 0.1, 0}, 7).across);
  EXPECT_EQ(draw_of({0.02, 0, 0, 0}, 7).pace, 1);
}

TEST(Perturb, MovesTheStartInTheCarsAxesAndThePlannersPace) {
  const RaceSpec race = race_of(R"({"position": "20 mm", "speed": "0.05 m/s", "pace": 0.1})");
  WorldSpec world = race.world;
  StackSpec stack = race.stacks[0];
  const Draw draw = perturb(race.perturb, 3, world, stack).value();
  EXPECT_DOUBLE_EQ(world.start.x, draw.along);  // it starts at the origin towards +x
  EXPECT_DOUBLE_EQ(world.start.y, draw.across);
  EXPECT_DOUBLE_EQ(world.start_speed, 0.1 + draw.speed);
  int changed = 0;
  for (std::size_t i = 0; i < stack.planner.values.size(); ++i)
    if (const double before = race.stacks[0].planner.values[i].number; stack.planner.values[i].number != before) {
      EXPECT_DOUBLE_EQ(stack.planner.values[i].number, before * draw.pace);
      ++changed;
    }
  EXPECT_EQ(changed, 1);
  const Pose turned = moved_start({1, 2, 0.5 * 3.14159265358979}, {.along = 0.1, .across = 0.2, .heading = 0.3});
  EXPECT_NEAR(turned.x, 0.8, 1e-12);
  EXPECT_NEAR(turned.y, 2.1, 1e-12);
}

TEST(Perturb, SeedsComeFromATextAlone) {
  const std::vector<std::uint64_t> seeds = seeds_from("2b99b83", 20);
  EXPECT_EQ(seeds, seeds_from("2b99b83", 20));
  EXPECT_NE(seeds, seeds_from("2b99b84", 20));
  EXPECT_EQ(std::set<std::uint64_t>(seeds.begin(), seeds.end()).size(), 20u);
  for (const std::uint64_t seed : seeds) EXPECT_LE(seed, static_cast<std::uint64_t>(largest_seed));
  const std::vector<std::uint64_t> fewer = seeds_from("2b99b83", 5);
  EXPECT_TRUE(std::equal(fewer.begin(), fewer.end(), seeds.begin()));  // more draws go on from fewer
}

/// Seed k sees friction later by (k - 1) times the shift, and drawn seeds are up to a billion.
TEST(Perturb, SeedsAreNotDrawnWhereFrictionComesLaterWithThem) {
  const Folder folder;
  write_text(folder / "shifts.json", R"({"points": [{"t": 5, "factor": 0.7}], "shift_per_seed": "3 s"})");
  write_text(folder / "stays.json", R"({"points": [{"t": 5, "factor": 0.7}], "shift_per_seed": "0 s"})");
  const auto why_not = [&](const std::string& text) {
    return refusal([&] { require_drawn_seeds_fit(parse_text(text, "experiment", folder.path()), "2b99b83"); });
  };
  const std::string seed = std::to_string(seeds_from("2b99b83", 1).front());
  const std::string shifted = why_not(R"({"world": {"friction": "shifts.json"}})");
  EXPECT_THAT(shifted, HasSubstr("shifts.json:1:"));
  EXPECT_THAT(shifted, HasSubstr("/shift_per_seed: --seeds-from \"2b99b83\" draws seed " + seed + ","));
  EXPECT_THAT(shifted, HasSubstr("--set /seeds/first="));
  EXPECT_THAT(why_not(R"({"cases": {"a": {"hidden": {"friction": {"shift_per_seed": 1}}}}})"),
              HasSubstr("/cases/a/hidden/friction/shift_per_seed"));
  EXPECT_EQ(why_not(R"({"world": {"friction": "stays.json"}})"), "nothing");
  EXPECT_EQ(why_not(R"({"world": {"friction": [{"t": 0, "factor": 1}]}})"), "nothing");
}

}  // namespace test_perturb
}  // namespace gripline
