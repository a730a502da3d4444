#include "experiment/race_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/race_sample.hpp"

namespace gripline {
namespace test_race_warnings {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using namespace testing_support;

/// The race of race_sample.hpp, changed by a JSON merge patch.
RaceSpec changed(const char* patch) { return read_race("table.json", merge(race_of().tree, json(patch)), plugins()); }

std::vector<std::string> late(const RaceSpec& race, const std::vector<std::string>& stacks = {"none", "elm"}) {
  std::vector<std::string> texts;
  for (const Diagnostic& one : late_sensor_warnings(race, stacks, "sensor_latency")) texts.push_back(one.text());
  return texts;
}

constexpr const char* all_late = R"({"sensors": {"delay": {"x": "20 ms", "y": "20 ms", "yaw": "20 ms", "vx": "20 ms",
                                                           "vy": "20 ms", "yaw_rate": "20 ms"}}})";

std::string with(const std::string& world, const std::string& stacks = "{}") {
  return R"({"world": )" + world + R"(, "stacks": )" + stacks + "}";
}

TEST(RaceWarnings, LateSensorsThatNoModelStatesAreWarnedOfOnce) {
  EXPECT_THAT(
      late(changed(with(all_late).c_str())),
      ElementsAre(AllOf(HasSubstr("/world/sensors/delay: the sensors show the car 20 ms late, and the models of stacks "
                                  "none, elm do not know: add {\"plugin\": \"sensor_latency\", \"params\": {\"T\": "
                                  "\"20 ms\"}} to the model's \"effects\""),
                        Not(HasSubstr("one time for all")))));
  EXPECT_THAT(late(race_of()), IsEmpty()) << "no delay";
}

TEST(RaceWarnings, ChannelsThatAreLateAloneAreNamed) {
  EXPECT_THAT(late(changed(with(R"({"sensors": {"delay": {"x": "20 ms", "vx": "40 ms"}}})").c_str()), {"elm"}),
              ElementsAre(AllOf(HasSubstr("the sensors are late (x 20 ms, vx 40 ms), and the model of stack elm does "
                                          "not know; the effect \"sensor_latency\" takes one time for all channels"),
                                Not(HasSubstr("\"T\"")))));
}

/// The effect would shift the channels that are on time too.
TEST(RaceWarnings, OneLateChannelGetsNoTimeForAll) {
  EXPECT_THAT(late(changed(with(R"({"sensors": {"delay": {"x": "100 ms"}}})").c_str()), {"elm"}),
              ElementsAre(AllOf(HasSubstr("late (x 100 ms)"), HasSubstr("one time for all channels"),
                                Not(HasSubstr("add {")))));
}

TEST(RaceWarnings, AModelWithADelayKnows) {
  for (const char* id : {"sensor_latency", "input_delay"}) {
    const std::string effect =
        R"({"model": {"effects": [{"plugin": ")" + std::string(id) + R"(", "params": {"T": "20 ms"}}]}})";
    EXPECT_THAT(late(changed(with(all_late, R"({"elm": )" + effect + "}").c_str())),
                ElementsAre(HasSubstr("the model of stack none does not know")));
    EXPECT_THAT(late(changed(with(all_late, R"({"elm": )" + effect + "}").c_str()), {"elm"}), IsEmpty()) << "not raced";
  }
  EXPECT_THAT(
      late(changed(with(all_late, R"({"elm": {"model": {"effects": [{"plugin": "steer_lag"}]}}})").c_str()), {"elm"}),
      SizeIs(1))
      << "a lag is no delay";
}

TEST(RaceWarnings, ALapThatIsNeverDriven) {
  const RaceSpec race = race_of(R"(["elm.lap1_s <= none.lap1_s", "elm.lap0_s <= 1.02 * none.lap2_s",
                                    "elm.pace_ratio7 < 2", "elm.lap2_s_hi < 9", "elm.violation_s <= 0"])");
  const std::vector<Diagnostic> warnings = claim_warnings(race);
  ASSERT_THAT(warnings, SizeIs(3));
  EXPECT_EQ(warnings[0].message,
            "\"lap2_s\" is of a lap that is never driven (the world ends after 2 laps, 0 to 1): the claim will fail");
  EXPECT_EQ(warnings[0].pointer, "/1");
  EXPECT_THAT(warnings[1].message, HasSubstr("\"pace_ratio7\""));
  EXPECT_THAT(warnings[2].message, HasSubstr("\"lap2_s_hi\""));
  Node timed = merge(race.tree, json(R"({"world": {"laps": null, "duration": "5 s"}})"));
  EXPECT_THAT(claim_warnings(read_race("table.json", timed, plugins())), IsEmpty()) << "nobody knows beforehand";
}

}  // namespace test_race_warnings
}  // namespace gripline
