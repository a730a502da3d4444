#include "calibrate/measured_kind/measured_experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_measured_experiment {

using namespace testing_support;

MeasuredSpec read(std::string_view patch = "{}") {
  Node tree = json(R"({"kind": "measured", "logs": ["log.csv"]})");
  tree.set("world", test::small_car_world(R"({"plant": {"effects": [
    {"plugin": "friction_patch"}, {"plugin": "steer_offset", "params": {"d0": 0}}]}})"));
  return read_measured(merge(tree, json(patch)), plugins());
}

TEST(ReadMeasured, AnEffectThatIsLeftOutHasNoRow) {
  const MeasuredSpec spec = read();
  EXPECT_THAT(spec.left_out, testing::ElementsAre("friction_patch"));
  EXPECT_THAT(spec.ablate, testing::ElementsAre("steer_offset"));
  EXPECT_THAT(refusal([] { read(R"({"ablate": ["friction_patch"]})"); }), testing::HasSubstr("steer_offset"));
}

TEST(ReadMeasured, AnEffectThatIsThereTwiceHasARowForEach) {
  const std::string twice = R"({"world": {"plant": {"effects": [{"plugin": "steer_offset"}, {"plugin": "aero_drag"},
                                                                {"plugin": "steer_offset"}]}})";
  EXPECT_THAT(read(twice + "}").ablate, testing::ElementsAre("steer_offset_0", "aero_drag", "steer_offset_2"));
  EXPECT_THAT(
      read(twice + R"(, "ablate": ["steer_offset"], "claims": ["without_steer_offset_2.position_m <= 1"]})").ablate,
      testing::ElementsAre("steer_offset_0", "steer_offset_2"));
  EXPECT_THAT(refusal([] { read(R"({"world": {"plant": {"effects": []}}, "ablate": ["aero_drag"]})"); }),
              testing::HasSubstr("the world has no effect to take out"));
}

/// Of an hour's log too: readers of the page tell its starts apart.
TEST(WriteMeasured, ThePagesTimesKeepTheirMilliseconds) {
  const Folder folder;
  MeasuredOutcome outcome;
  outcome.fitted = Node::empty_object();
  outcome.held_out.push_back({"log.csv", 0.0, {3599.876}, std::vector<double>(6, 0.5), std::vector<double>(6, 0.5)});
  MeasuredSpec spec;
  spec.horizon = 1.0;
  write_measured(folder.path(), spec, outcome);
  const Node page = load_json(folder / "measured.json");
  EXPECT_EQ(find_pointer(page, "/held_out/0/t_s/0")->number(), 3600.876);
}

}  // namespace test_measured_experiment
}  // namespace gripline::calibrate
