#include "geometry/height_drift.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "geometry/curve_types.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "support/road_files.hpp"

namespace gripline {
namespace test_height_drift {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing_support::RoadFiles;

constexpr double pi = std::numbers::pi;
constexpr int lap = 200;

/// A circle of this radius whose row 200 repeats row 0, with hills of 5 m and heights that drift in a lap.
struct Row {
  double x, y, z;
};
Row row(int i, double radius, double drift) {
  const double a = 2 * pi * (i % lap) / lap;
  return {radius * std::cos(a), radius * std::sin(a), 5 * std::sin(a) + drift * i / lap};
}

struct Circle {
  std::vector<PlanePoint> points;
  std::vector<double> heights;
  explicit Circle(double drift) {
    for (int i = 0; i <= lap; ++i) {
      const Row r = row(i, 100.0, drift);
      points.push_back({r.x, r.y});
      heights.push_back(r.z);
    }
  }
};

TEST(HeightDrift, IsSpreadOverTheLapWhereAPointRepeatsTheFirst) {
  for (const double drift : {0.2, -0.2, 2.0}) {  // a step of the hills is 0.16 m
    Circle circle(drift);
    const Circle level(0.0);
    EXPECT_THAT(even_out_lap(circle.points, circle.heights, lap), HasSubstr(drift > 0 ? "m higher" : "m lower"));
    for (int i = 0; i < lap; ++i) EXPECT_NEAR(circle.heights[i], level.heights[i], 1e-12) << drift << ' ' << i;
  }
}

TEST(HeightDrift, NothingIsDoneWithoutDriftOrReturn) {
  Circle level(0.0);
  const std::vector<double> before = level.heights;
  EXPECT_EQ(even_out_lap(level.points, level.heights, lap), "");
  EXPECT_EQ(level.heights, before);
  Circle drifts(1.0);
  EXPECT_EQ(even_out_lap(drifts.points, drifts.heights, lap - 1), "");  // that point is a step before the first
  EXPECT_EQ(even_out_lap(drifts.points, {}, lap), "");
}

/// A last point a tenth of a step beyond the first is higher by a tenth of what a step rises: no drift.
TEST(HeightDrift, TheSlopeExplainsWhatARepeatedPointIsHigher) {
  Circle circle(0.0);
  const double beyond = 2 * pi * 0.1 / lap;
  circle.points.back() = {100 * std::cos(beyond), 100 * std::sin(beyond)};
  circle.heights.back() = 5 * std::sin(beyond);
  EXPECT_EQ(even_out_lap(circle.points, circle.heights, lap), "");
  circle.heights.back() += 0.1;
  EXPECT_THAT(even_out_lap(circle.points, circle.heights, lap), HasSubstr("evened out"));
}

TEST(HeightDrift, OfMoreThanAShareOfTheLengthIsRefused) {
  Circle circle(4.0);  // of 628 m, 0.5 % of which is 3.14 m
  EXPECT_THROW(even_out_lap(circle.points, circle.heights, lap), GeometryError);
}

/// By what `gripline track` says and reads: a drift as small as a step of the hills, in a trace and in an edge.
TEST_F(RoadFiles, HeightsOfARowThatRepeatsTheFirstAreEvenedOut) {
  const auto trace = [&](double drift) {
    return write("closed.csv", "x_m,y_m,z_m", lap + 1, [=](int i) {
      const Row r = row(i, 100.0, drift);
      return std::vector{r.x, r.y, r.z};
    });
  };
  const Track level = to_track(read({trace(0.0)}, {.width = 8.0}));
  EXPECT_THAT(remarks_, IsEmpty());
  const Track even = to_track(read({trace(0.3)}, {.width = 8.0}));
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("0.3 m higher than where it began: evened out")));
  for (int i = 0; i < 1000; ++i) EXPECT_NEAR(even.grade(0.628 * i), level.grade(0.628 * i), 1e-6) << i;
}

TEST_F(RoadFiles, AnEdgeOfARoadInJsonIsEvenedOutAndSaysSo) {
  const auto road = [&](double drift) {
    for (const auto& [name, radius] : {std::pair("inner.csv", 96.0), std::pair("outer.csv", 104.0)})
      write(name, "x_m,y_m,z_m", lap + 1, [=, radius = radius](int i) {
        const Row r = row(i, radius, drift);
        return std::vector{r.x, r.y, r.z};
      });
    const std::filesystem::path file = scratch_ / "road.json";
    std::ofstream(file) << R"({"edges": {"inner": "inner.csv", "outer": "outer.csv"}})";
    return file;
  };
  const Track level = load_track(road(0.0));
  EXPECT_THAT(level.remarks(), IsEmpty());
  const Track even = load_track(road(2.0));
  EXPECT_THAT(even.remarks(), ElementsAre(HasSubstr("inner edge: after a lap it is 2 m higher"),
                                          HasSubstr("outer edge: after a lap it is 2 m higher")));
  for (int i = 0; i < 1000; ++i) EXPECT_NEAR(even.grade(0.628 * i), level.grade(0.628 * i), 1e-6) << i;
  read({road(2.0)});
  EXPECT_THAT(remarks_, ::testing::Contains(HasSubstr("outer edge: after a lap")));
  EXPECT_THAT(refusal([&] { load_track(road(5.0)); }), HasSubstr("inner.csv: the heights do not close"));
}

}  // namespace test_height_drift
}  // namespace gripline
