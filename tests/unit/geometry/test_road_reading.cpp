#include "geometry/road_reading.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/racing_line.hpp"
#include "geometry/track_file.hpp"
#include "support/road_files.hpp"

namespace gripline {
namespace test_road_reading {

using ::testing::HasSubstr;
using testing_support::gpx_circle;
using testing_support::RoadFiles;
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;

TEST_F(RoadFiles, AFileWithoutRowsIsRefused) {
  const fs::path metres = scratch_ / "metres.csv", degrees = scratch_ / "degrees.csv", wide = scratch_ / "wide.csv";
  write_file(metres, "x_m,y_m\n");
  write_file(degrees, "lat,lon\n");
  write_file(wide, "x_m,y_m,w_tr_right_m,w_tr_left_m\n");
  const auto few = HasSubstr("no row of numbers; expected a header line and rows of numbers");
  for (const fs::path& file : {metres, degrees, wide}) {
    EXPECT_THAT(refusal([&] { read({file}, {.width = 12}); }), few);
    EXPECT_THAT(refusal([&] { read({ellipse(), file}); }), few);
    EXPECT_THAT(refusal([&] { read({file, ellipse()}); }), few);
  }
}

TEST_F(RoadFiles, WidthsAreCheckedLineByLineAndStatedOnce) {
  const fs::path none = write("none.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", 100, [](int i) {
    return std::vector{50 * std::cos(2 * pi * i / 100), 50 * std::sin(2 * pi * i / 100), 4.0, i == 30 ? 0.0 : 4.0};
  });
  EXPECT_THAT(refusal([&] { read({none}); }), HasSubstr("none.csv:32:1: half widths of 4 m (right) and 0 m (left)"));
  EXPECT_THAT(refusal([&] { load_track(none); }), HasSubstr("none.csv:32:1: the left half width is 0 m"));
  EXPECT_THAT(refusal([&] { read({ellipse()}, {.width = 5}); }), HasSubstr("has widths of its own"));
  EXPECT_THAT(refusal([&] { read({none, none}, {.width = 5}); }), HasSubstr("two edges have their width between them"));
  write_file(scratch_ / "road.xodr", "<OpenDRIVE/>");
  EXPECT_THAT(refusal([&] { read({scratch_ / "road.xodr"}); }), HasSubstr("is OpenDRIVE, which is not read"));
}

TEST_F(RoadFiles, ACentreLineBetweenItsEdgesIsRead) {
  const fs::path file =
      write("three.csv", "x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m", 200, [](int i) {
        const double c = std::cos(2 * pi * i / 200), s = std::sin(2 * pi * i / 200);
        return std::vector{100 * c, 100 * s, 97 * c, 97 * s, 105 * c, 105 * s};
      });
  const Track track = to_track(read({file}));
  EXPECT_NEAR(track.half_width_left(10), 3.0, 1e-6);
  EXPECT_NEAR(track.half_width_right(10), 5.0, 1e-6);
}

TEST_F(RoadFiles, EdgesMakeARoadWhosePointsNeedNotCorrespond) {
  const auto edge = [&](const char* name, double grow, int count) {
    return write(name, "x_m,y_m", count, [=](int i) {
      const double a = 2 * pi * i / count;
      return std::vector{(100 + grow) * std::cos(a), (100 + grow) * std::sin(a)};
    });
  };
  const Track track = to_track(read({edge("left.csv", -4, 150), edge("right.csv", 4, 210)}));
  EXPECT_NEAR(track.length(), 2 * pi * 100, 0.5);
  EXPECT_NEAR(track.half_width_left(50), 4.0, 0.05);
  EXPECT_NEAR(track.half_width_right(50), 4.0, 0.05);
}

/// How near an edge must come to its start again for a whole lap follows from the usual width of the road, not from the
/// one at the first point: a pit exit is wide.
TEST_F(RoadFiles, EdgesOfARoadThatIsWideAtItsStartAreKeptWhole) {
  const auto edge = [&](const char* name, double side) {
    return write(name, "x_m,y_m", 200, [=](int i) {
      const double a = 2 * pi * i / 200, r = 100 + side * (std::cos(a) > 0.98 ? 32.0 : 5.0);
      return std::vector{r * std::cos(a), r * std::sin(a)};
    });
  };
  const RoadTable road = read({edge("left.csv", -1), edge("right.csv", 1)});
  EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("the centre line is where both edges are equally far")));
  EXPECT_NEAR(road.length(), 2 * pi * 100, 2.0);
}

TEST_F(RoadFiles, WhatIsWrongWithTwoEdgesNamesTheirFiles) {
  const auto edge = [&](const char* name, const char* header, double r, double direction) {
    return write(name, header, 100, [=](int i) {
      return std::vector{r * std::cos(2 * pi * i / 100), direction * r * std::sin(2 * pi * i / 100)};
    });
  };
  const fs::path left = edge("left.csv", "x_m,y_m", 46, 1);
  EXPECT_THAT(refusal([&] {
                read({left, edge("right.csv", "x_m,y_m", 54, -1)});
              }),
              ::testing::AllOf(HasSubstr("left.csv and "), HasSubstr("right.csv: the two edges run opposite ways")));
  EXPECT_THAT(refusal([&] {
                read({left, edge("right.csv", "lat,lon", 54, 1)});
              }),
              HasSubstr("right.csv: is in degrees, the other edge in metres"));
}

TEST_F(RoadFiles, EdgesThatAreExchangedAreTold) {
  const auto edge = [&](const char* name, double r, double y) {
    return write(name, "x_m,y_m", 100, [=](int i) {
      return std::vector{r * std::cos(2 * pi * i / 100), y * r * std::sin(2 * pi * i / 100)};
    });
  };
  const auto told = ::testing::Contains(HasSubstr("named as the left edge, lies to the right of the direction"));
  const fs::path left = edge("left.csv", 46, 1), right = edge("right.csv", 54, 1);
  read({left, right});
  EXPECT_THAT(remarks_, ::testing::Not(told));
  read({right, left});
  EXPECT_THAT(remarks_, told);
  read({edge("left.csv", 46, -1), edge("right.csv", 54, -1)});  // y points to the right
  EXPECT_THAT(remarks_, told);
}

TEST_F(RoadFiles, RadiansAreTold) {
  const auto places = [&](double unit) {
    return write("places.csv", "lat,lon", 200, [=](int i) {
      return std::vector{unit * (48 + 0.1 * std::sin(2 * pi * i / 200)),
                         unit * (11 + 0.1 * std::cos(2 * pi * i / 200))};
    });
  };
  const auto told = ::testing::ElementsAre(HasSubstr("radians? Expected degrees"));
  read({places(pi / 180)}, {.width = 8.0});
  EXPECT_THAT(remarks_, told);
  read({places(1.0)}, {.width = 8.0});
  EXPECT_TRUE(remarks_.empty());
}

TEST_F(RoadFiles, ColumnsThatMayBeWidthsAreToldWhereWidthsAreMissing) {
  const fs::path file = write("names.csv", "x_m,y_m,w_tr_rigth_m,speed", 100, [](int i) {
    return std::vector{50 * std::cos(2 * pi * i / 100), 50 * std::sin(2 * pi * i / 100), 4.0, 4.0};
  });
  EXPECT_THAT(refusal([&] { read({file}); }),
              ::testing::AllOf(HasSubstr("has no widths (w_tr_right_m,w_tr_left_m)"),
                               HasSubstr("did you mean \"w_tr_right_m\" by \"w_tr_rigth_m\"?"),
                               HasSubstr("columns that are left out: w_tr_rigth_m,speed")));
}

TEST_F(RoadFiles, EdgesThatCrossAreRefusedWithThePlace) {
  const auto edge = [&](const char* name, double grow, double bump) {
    return write(name, "x_m,y_m", 300, [=](int i) {
      const double a = 2 * pi * i / 300, r = 100 + grow + (i >= 100 && i < 120 ? bump : 0.0);
      return std::vector{r * std::cos(a), r * std::sin(a)};
    });
  };
  const fs::path left = edge("left.csv", -4, 0);
  EXPECT_THAT(refusal([&] { read({left, edge("right.csv", 4, -12)}); }), HasSubstr("cross each other: near (-"));
  EXPECT_THAT(refusal([&] { read({left, left}); }), HasSubstr("are the same line"));
  EXPECT_EQ(refusal([&] { read({left, edge("right.csv", 4, -3)}); }), "not refused");
}

TEST_F(RoadFiles, HeightsOfOneEdgeAreToldToBeLeftOut) {
  const auto edge = [&](const char* name, double r, bool heights) {
    return write(name, heights ? "x_m,y_m,z_m" : "x_m,y_m", 200, [=](int i) {
      std::vector<double> row{r * std::cos(2 * pi * i / 200), r * std::sin(2 * pi * i / 200)};
      if (heights) row.push_back(1.0);
      return row;
    });
  };
  read({edge("left.csv", 96, true), edge("right.csv", 104, false)});
  EXPECT_THAT(remarks_,
              ::testing::Contains(::testing::AllOf(HasSubstr("heights are left out"), HasSubstr("left.csv"))));
}

TEST_F(RoadFiles, AGpxTraceIsCutAfterALap) {
  const fs::path file = scratch_ / "lap.gpx";
  write_file(file, gpx_circle());
  EXPECT_THAT(refusal([&] { read({file}); }), HasSubstr("--width METRES"));
  const RoadTable road = read({file}, {.width = 10.0});
  EXPECT_EQ(road.size(), 200u);
  const Track track = to_track(road);
  EXPECT_NEAR(track.length(), 2 * pi * 300, 6.0);
  EXPECT_NEAR(track.half_width_left(3), 5.0, 1e-12);
  // dz/ds is largest at the start: 5 m of height over a radius of 300 m.
  EXPECT_NEAR(track.grade(0.0), std::atan(5.0 / 300.0), 5e-4);
}

TEST_F(RoadFiles, WallsAndStartOfAJsonRoadAreKnown) {
  write_file(scratch_ / "walls.json",
             R"({"segments": [{"arc": {"radius": 40, "turn": "360 deg"}}], "half_width": 3,
                 "walls": {"left": 2}, "start": {"x": 5, "y": 1, "yaw": 0}})");
  const RoadTable walled = read({scratch_ / "walls.json"});
  EXPECT_TRUE(walled.walls);
  ASSERT_TRUE(walled.start);
  EXPECT_EQ(walled.start->x, 5.0);
  write_file(scratch_ / "plain.json", R"({"segments": [{"arc": {"radius": 40, "turn": "360 deg"}}], "half_width": 3})");
  const RoadTable plain = read({scratch_ / "plain.json"});
  EXPECT_FALSE(plain.walls || plain.start);
  EXPECT_TRUE(remarks_.empty());
}

TEST_F(RoadFiles, TwentyKilometresAreARoad) {
  const fs::path file = write("long.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", 4000, [](int i) {
    const double a = 2 * pi * i / 4000.0, r = 2600 + 500 * std::cos(5 * a) + 60 * std::sin(31 * a);
    return std::vector{r * std::cos(a), r * std::sin(a), 4.0, 4.0};
  });
  const Track track = to_track(read({file}));
  EXPECT_GT(track.length(), 19000);
  EXPECT_EQ(check_car_turns(track, 1.8, 6.0), "");
}

}  // namespace test_road_reading
}  // namespace gripline
