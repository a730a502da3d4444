#include "exports/foxglove.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "support/mcap_reading.hpp"

namespace gripline::exports {
namespace test_foxglove {

using testing::Pair;
using testing::UnorderedElementsAre;
using testing_support::McapFile;
using testing_support::McapMessage;
using testing_support::read_mcap;

Results two_runs() {
  Results results;
  results.scene = nlohmann::json::parse(R"({"car": {"length": 0.06, "width": 0.03}})");
  results.track =
      report::Columns::parse("s_m,x_m,y_m,left_x_m,left_y_m,right_x_m,right_y_m\n0,0,0,0,1,0,-1\n1,1,0,1,1,1,-1\n");
  results.runs.push_back(
      {"elm", report::Columns::parse("t_s,x_m,y_m,yaw_rad,vx_mps,x_true_m,y_true_m,yaw_true_rad\n"
                                     "0,9,9,9,0.1,1,2,0\n0.02,9,9,9,0.2,1.5,2.5,3.141592653589793\n")});
  results.runs.push_back({"own log", report::Columns::parse("t_s,x_m,y_m,yaw_rad,mu\n0.01,5,6,0,\n")});
  return results;
}

TEST(Foxglove, EveryStepHasItsPoseAndItsColumns) {
  const McapFile file = read_mcap(foxglove_mcap(two_runs()));
  std::map<std::string, int> counts;
  for (const McapMessage& message : file.messages) ++counts[message.topic];
  EXPECT_THAT(counts, UnorderedElementsAre(Pair("/track", 1), Pair("/cars", 1), Pair("/tf", 3), Pair("/elm/pose", 2),
                                           Pair("/elm/step", 2), Pair("/own log/pose", 1), Pair("/own log/step", 1)));
  std::map<std::string, McapMessage> last;
  for (const McapMessage& message : file.messages) last[message.topic] = message;
  // The true pose where there is one: half a turn about z.
  const nlohmann::json& pose = last["/elm/pose"].data;
  EXPECT_EQ(last["/elm/pose"].schema, "foxglove.PoseInFrame");
  EXPECT_EQ(pose["frame_id"], "world");
  EXPECT_EQ(pose["timestamp"], nlohmann::json({{"sec", 0}, {"nsec", 20'000'000}}));
  EXPECT_EQ(pose["pose"]["position"]["x"], 1.5);
  EXPECT_NEAR(pose["pose"]["orientation"]["z"].get<double>(), 1, 1e-12);
  EXPECT_NEAR(pose["pose"]["orientation"]["w"].get<double>(), 0, 1e-12);
  EXPECT_EQ(last["/elm/step"].data["vx_mps"], 0.2);
  EXPECT_EQ(last["/tf"].data["child_frame_id"], "elm");
  // A measured log has no truth, and what was not measured has no value.
  EXPECT_EQ(last["/own log/pose"].data["pose"]["position"]["y"], 6);
  EXPECT_FALSE(last["/own log/step"].data.contains("mu"));
}

TEST(Foxglove, MessagesAreInOrderOfTime) {
  const McapFile file = read_mcap(foxglove_mcap(two_runs()));
  ASSERT_GT(file.messages.size(), 1U);
  for (std::size_t i = 1; i < file.messages.size(); ++i)
    EXPECT_LE(file.messages[i - 1].log_time, file.messages[i].log_time);
}

TEST(Foxglove, RoadAndCarsAreDrawn) {
  const McapFile file = read_mcap(foxglove_mcap(two_runs()));
  const nlohmann::json& track = file.messages.at(0).data["entities"][0];
  EXPECT_EQ(track["frame_id"], "world");
  ASSERT_EQ(track["lines"].size(), 2U);
  EXPECT_EQ(track["lines"][0]["points"][1], nlohmann::json({{"x", 1.0}, {"y", 1.0}, {"z", 0.0}}));
  const nlohmann::json& cars = file.messages.at(1).data["entities"];
  ASSERT_EQ(cars.size(), 2U);
  EXPECT_EQ(cars[1]["frame_id"], "own log");
  EXPECT_EQ(cars[0]["cubes"][0]["size"]["x"], 0.06);
  EXPECT_NE(cars[0]["cubes"][0]["color"], cars[1]["cubes"][0]["color"]);
}

TEST(Foxglove, SchemasNameEveryColumn) {
  const McapFile file = read_mcap(foxglove_mcap(two_runs()));
  for (const char* name : {"foxglove.SceneUpdate", "foxglove.FrameTransform", "foxglove.PoseInFrame", "gripline.Step"})
    ASSERT_TRUE(file.schemas.contains(name)) << name;
  for (const McapMessage& message : file.messages)
    if (message.schema != "gripline.Step") {
      for (const auto& [key, value] : message.data.items())
        EXPECT_TRUE(file.schemas.at(message.schema)["properties"].contains(key)) << message.schema << ' ' << key;
    }
}

}  // namespace test_foxglove
}  // namespace gripline::exports
