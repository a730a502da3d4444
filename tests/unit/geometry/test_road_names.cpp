#include "geometry/road_names.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tables/column_names.hpp"

namespace gripline {
namespace test_road_names {

TEST(RoadNames, NamesAreKnownByThemselves) {
  for (const char* name : {"x", "Northing", "lat", "z_m", "w_right_ft", "grade_deg", "width"})
    EXPECT_TRUE(is_road_column(name)) << name;
  for (const char* name : {"grade", "speed", "id", "x_center_m", "w_tr_rigth_m"})
    EXPECT_FALSE(is_road_column(name)) << name;
  EXPECT_TRUE(is_road_width("w_tr_left_m"));
  EXPECT_FALSE(is_road_width("x_m"));
}

TEST(RoadNames, TheUnitIsWhatStandsBehindTheWord) {
  const auto unit = [](RoadRole role, const char* name, const char* written = "") {
    const auto found = road_name(role, name, written);
    return found ? found->unit + found->foreign : "none";
  };
  EXPECT_EQ(unit(RoadRole::x, "x_mm"), "mm");
  EXPECT_EQ(unit(RoadRole::x, "odom.x_mm"), "mm");
  EXPECT_EQ(unit(RoadRole::x, "pose.position.x"), "m");
  EXPECT_EQ(unit(RoadRole::x, "odom.x"), "none") << "a letter";
  EXPECT_EQ(unit(RoadRole::left, "left"), "m") << "not feet";
  EXPECT_EQ(unit(RoadRole::latitude, "lat"), "deg");
  EXPECT_EQ(unit(RoadRole::grade, "grade"), "none");
  EXPECT_EQ(unit(RoadRole::grade, "grade", "%"), "%");
  EXPECT_EQ(unit(RoadRole::height, "z", "g"), "g") << "foreign";
}

/// Names of logs as well: a new one in tables/column_names.cpp needs its pair.
TEST(RoadNames, EveryNameOfAPlaceHasItsPair) {
  const auto frames = [](RoadRole role, const char* channel) {
    std::set<std::string> all;
    for (const char* name : names_of(channel)) all.insert(road_name(role, name, {}).value_or(RoadName{}).frame);
    return all;
  };
  EXPECT_EQ(frames(RoadRole::x, "x"), frames(RoadRole::y, "y"));
  EXPECT_EQ(frames(RoadRole::longitude, "longitude"), frames(RoadRole::latitude, "latitude"));
  const auto frame = [](RoadRole role, const char* name) { return road_name(role, name, {})->frame; };
  EXPECT_NE(frame(RoadRole::x, "px"), frame(RoadRole::y, "northing"));
  EXPECT_NE(frame(RoadRole::x, "posx"), frame(RoadRole::y, "ypos"));
  EXPECT_EQ(frame(RoadRole::x, "posx_mm"), frame(RoadRole::y, "posy"));
  EXPECT_EQ(frame(RoadRole::right, "w_right_ft"), frame(RoadRole::left, "w_left"));
  EXPECT_NE(frame(RoadRole::right, "w_right"), frame(RoadRole::left, "left"));
}

}  // namespace test_road_names
}  // namespace gripline
