#include "geometry/trace_repair.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/road_files.hpp"

namespace gripline {
namespace test_trace_repair {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing_support::RoadFiles;
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;

/// Points on an ellipse of 400 m by 240 m, at these angles [rad].
RoadTrace ellipse_trace(int count, const std::function<double(int)>& angle) {
  RoadTrace trace;
  for (int i = 0; i < count; ++i) trace.points.push_back({200 * std::cos(angle(i)), 120 * std::sin(angle(i))});
  return trace;
}

constexpr TraceRepair survey{.width = 12.0, .surveyed = true}, drive{.width = 12.0};

std::vector<std::string> remarks_of(RoadTrace& trace, const TraceRepair& how) {
  std::vector<std::string> remarks;
  repair(trace, how, remarks);
  return remarks;
}

TEST(TraceRepair, APointThatTwoLapsShareIsKeptOnce) {
  RoadTrace road = ellipse_trace(163, [](int i) { return 2 * pi * i / 160; });
  EXPECT_THAT(remarks_of(road, survey), ElementsAre(HasSubstr("3 points after a lap: left out")));
  EXPECT_EQ(road.points.size(), 160u);
}

TEST(TraceRepair, ARoadDrivenTwiceIsCut) {
  RoadTrace road = ellipse_trace(320, [](int i) { return 2 * pi * i / 160; });
  remarks_of(road, survey);
  EXPECT_EQ(road.points.size(), 160u);
}

TEST(TraceRepair, ADriveThatTurnsRoundAfterItsLapIsCut) {
  RoadTrace trace = ellipse_trace(399, [](int i) { return 2 * pi * (i < 200 ? i : 398 - i) / 200; });
  remarks_of(trace, drive);
  EXPECT_NEAR(static_cast<double>(trace.points.size()), 200.0, 1.0);
}

/// Points 10 m apart on a road 12 m wide: the last is near the first, and a step before it.
TEST(TraceRepair, TheLastPointOfAClosedTraceIsKept) {
  for (const int turned : {0, 1, 17, 50}) {
    RoadTrace trace = ellipse_trace(100, [&](int i) { return 2 * pi * (i + turned) / 100; });
    EXPECT_TRUE(remarks_of(trace, drive).empty());
    EXPECT_EQ(trace.points.size(), 100u) << turned;
  }
}

TEST(TraceRepair, ALoggerThatStandsBeforeItsLapsIsNoCourse) {
  for (const double jitter : {0.05, 0.3}) {
    std::mt19937 random(3);
    std::normal_distribution<double> error(0.0, jitter);
    // 340 points a lap, 3 m apart.
    RoadTrace trace = ellipse_trace(100 + 800, [](int i) { return 2 * pi * std::max(0, i - 100) / 340.0; });
    for (int i = 0; i < 100; ++i) trace.points[i].x += error(random), trace.points[i].y += error(random);
    EXPECT_THAT(remarks_of(trace, drive), ElementsAre(HasSubstr("where the trace stands"), HasSubstr("after a lap")));
    EXPECT_NEAR(static_cast<double>(trace.points.size()), 340.0, 4.0) << jitter;
    EXPECT_NEAR(ClosedPolyline(trace.points).length(), 1022.0, 3.0);
  }
}

TEST_F(RoadFiles, AnOpenLineIsClosedOnlyWhenAsked) {
  const fs::path open = ellipse(0.0, 0.93);
  EXPECT_THAT(refusal([&] { read({open}); }), HasSubstr("--close METRES closes it"));
  EXPECT_THAT(refusal([&] { read({open}, {.largest_gap = 10.0}); }),
              ::testing::AllOf(HasSubstr("the line is open"), HasSubstr("; --close 10 is less than that gap of "),
                               ::testing::Not(HasSubstr("closes it"))));
  const RoadTable road = read({open}, {.largest_gap = 60.0});
  ASSERT_EQ(remarks_.size(), 1u);
  EXPECT_THAT(remarks_[0], HasSubstr("a gap of"));
  EXPECT_NEAR(to_track(road).length(), to_track(read({ellipse()})).length(), 1.0);
}

TEST_F(RoadFiles, ARoadWithWidthsIsCutAfterALapAsWell) {
  const RoadTable lap = read({ellipse()});
  EXPECT_TRUE(remarks_.empty());
  EXPECT_EQ(lap.size(), 160u);
  const RoadTable road = read({ellipse(0.0, 1.05)});  // 160 points on 1.05 laps
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("points after a lap: left out")));
  EXPECT_LT(road.size(), 154u);
  EXPECT_EQ(road.right.size(), road.size());
  const Track track = to_track(road);
  EXPECT_NEAR(track.length(), lap.length(), 1.0);
  for (int i = 0; i < 400; ++i)  // the ellipse's sharpest bend has a radius of 36 m
    EXPECT_LT(std::abs(track.at(track.length() * i / 400).kappa), 1 / 30.0);
}

TEST_F(RoadFiles, EdgesAreCutAfterALapAsWell) {
  const auto edge = [&](const char* name, double grow, int rows) {
    return write(name, "x_m,y_m", rows, [=](int i) {
      const double a = 2 * pi * i / 200;
      return std::vector{(100 + grow) * std::cos(a), (100 + grow) * std::sin(a)};
    });
  };
  const Track track = to_track(read({edge("left.csv", -4, 215), edge("right.csv", 4, 200)}));
  EXPECT_THAT(remarks_, ::testing::Contains(HasSubstr("15 points after a lap")));
  EXPECT_NEAR(track.length(), 2 * pi * 100, 0.5);
}

TEST_F(RoadFiles, AClosingPointNearTheFirstIsDropped) {
  for (const double gap : {0.0, 1e-6, 0.01, 0.25}) {
    const fs::path file = write("near.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 161, [=](int i) {
      const double a = 2 * pi * i / 160;
      return std::vector{100 * std::cos(a), 60 * std::sin(a) - (i == 160 ? gap : 0.0), 4.0, 8.0};
    });
    EXPECT_EQ(read({file}).size(), 160u) << gap;
    EXPECT_EQ(remarks_.size(), gap > 0.0 ? 1u : 0u) << gap;
    EXPECT_NEAR(load_track(file).length(), to_track(read({file})).length(), 1e-9);
  }
}

TEST_F(RoadFiles, HeightsThatDriftAreEvenedOutOrRefused) {
  const auto trace = [&](double drift) {
    return write("drift.csv", "x_m,y_m,z_m", 200, [=](int i) {
      const double a = 2 * pi * i / 200;
      return std::vector{100 * std::cos(a), 100 * std::sin(a), 5 * std::sin(a) + drift * i / 200};
    });
  };
  const Track clean = to_track(read({trace(0.0)}, {.width = 8.0}));
  EXPECT_TRUE(remarks_.empty());
  const Track even = to_track(read({trace(2.0)}, {.width = 8.0}));
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("m higher than where it began: evened out")));
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(even.grade(6.28 * i), clean.grade(6.28 * i), 1e-3) << i;
  EXPECT_THAT(refusal([&] { read({trace(-20.0)}, {.width = 8.0}); }), HasSubstr("20 m lower than where it began"));
}

}  // namespace test_trace_repair
}  // namespace gripline
