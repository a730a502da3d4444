#include "geometry/long_steps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/road_files.hpp"

namespace gripline {
namespace test_long_steps {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing_support::RoadFiles;
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;

/// 300 points on an ellipse of 300 m by 200 m without those from `from` to `to`, the first row being `first`.
std::vector<PlanePoint> ellipse_without(int from, int to, int first) {
  std::vector<PlanePoint> points;
  for (int i = 0; i < 300; ++i) {
    const int k = (i + first) % 300;
    if (k < from || k >= to) points.push_back({150 * std::cos(2 * pi * k / 300), 100 * std::sin(2 * pi * k / 300)});
  }
  return points;
}

/// Two straights of 300 m and two half circles of 15 m radius: points every 2 m in bends, none on the straights.
std::vector<PlanePoint> stadium() {
  std::vector<PlanePoint> points;
  for (const double x : {300.0, 0.0})
    for (int i = 0; i <= 24; ++i) {
      const double a = pi * i / 24 + (x > 0.0 ? -0.5 : 0.5) * pi;
      points.push_back({x + 15 * std::cos(a), 15 + 15 * std::sin(a)});
    }
  return points;
}

TEST(LongSteps, APieceThatIsMissingIsToldByItsLines) {
  std::vector<int> lines;
  const std::vector<PlanePoint> points = ellipse_without(120, 180, 0);
  for (std::size_t i = 0; i < points.size(); ++i) lines.push_back(static_cast<int>(i) + 2);
  EXPECT_THAT(remark_of_long_steps(points, lines, 8.0),
              AllOf(HasSubstr("nothing between lines 121 and 122 for 119.3 m"), HasSubstr("as a smooth curve")));
  EXPECT_THAT(remark_of_long_steps(points, {}, 8.0), HasSubstr("between (-119.479, 60.4599) and (-121"));
  EXPECT_THAT(remark_of_long_steps(ellipse_without(0, 4, 0), {}, 8.0),
              HasSubstr("between the last point and the first for 10.4"));
  EXPECT_EQ(remark_of_long_steps(ellipse_without(0, 0, 0), {}, 8.0), "");
  EXPECT_EQ(remark_of_long_steps(ellipse_without(0, 4, 0), {}, 12.0), "");  // shorter than the road is wide
}

TEST(LongSteps, FewPointsOnStraightsAreNoGap) {
  std::vector<PlanePoint> road = stadium();
  EXPECT_THAT(remark_of_long_steps(road, {}, 8.0), HasSubstr("2 steps are so long"));
  // A point every 50 m, beside 2 m in the bends.
  for (int i = 1; i < 6; ++i) road.push_back({50.0 * i, 0.0});
  for (int i = 5; i > 0; --i) road.insert(road.begin() + 25, {50.0 * (6 - i), 30.0});
  EXPECT_EQ(remark_of_long_steps(road, {}, 8.0), "");
}

/// Points every metre on a ring of 200 m, but a straight of this length whose ends run straight on.
TEST(LongSteps, AStraightHasFewerPoints) {
  const auto road = [](double straight) {
    std::vector<PlanePoint> points;
    for (int i = 0; i < 1200; ++i) points.push_back({200 * std::sin(pi * i / 600), 200 - 200 * std::cos(pi * i / 600)});
    for (PlanePoint& p : points)
      if (p.x > 0.0) p.x += straight;
    return points;
  };
  EXPECT_EQ(remark_of_long_steps(road(8.0), {}, 4.0), "");
  EXPECT_THAT(remark_of_long_steps(road(12.0), {}, 4.0), HasSubstr("2 steps are so long"));
}

/// An edge beside which a pit lane begins and ends.
TEST(LongSteps, AStepAsideIsNoGap) {
  const auto road = [](double aside) {
    std::vector<PlanePoint> points;
    for (int i = 0; i < 200; ++i) {
      const double r = i < 20 ? 100.0 + aside : 100.0;
      points.push_back({r * std::cos(2 * pi * i / 200), r * std::sin(2 * pi * i / 200)});
    }
    return points;
  };
  EXPECT_EQ(remark_of_long_steps(road(25.0), {}, 10.0), "");
  EXPECT_THAT(remark_of_long_steps(road(60.0), {}, 10.0), HasSubstr("2 steps are so long"));
}

/// Wherever the file begins, the same piece is missing.
TEST_F(RoadFiles, AMissingPieceIsToldOrRefused) {
  const auto file = [&](int from, int to, int first, const char* header) {
    const std::vector<PlanePoint> points = ellipse_without(from, to, first);
    return write("road.csv", header, static_cast<int>(points.size()), [&](int i) {
      std::vector<double> row{points[static_cast<std::size_t>(i)].x, points[static_cast<std::size_t>(i)].y};
      if (std::string_view(header).ends_with("left_m")) row.insert(row.end(), {4.0, 4.0});
      return row;
    });
  };
  const char* const road = "x_m,y_m,w_tr_right_m,w_tr_left_m";
  const auto told = ElementsAre(HasSubstr("nothing between lines 121 and 122 for 119.3 m"));
  read({file(120, 180, 0, road)});
  EXPECT_THAT(remarks_, told);
  EXPECT_THAT(load_track(file(120, 180, 0, road)).remarks(), told);
  read({file(120, 180, 0, "x_m,y_m")}, {.width = 8.0});
  EXPECT_THAT(remarks_, told);
  EXPECT_THAT(refusal([&] { read({file(120, 180, 180, road)}); }), HasSubstr("the line is open"));
  read({file(0, 4, 0, road)});
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("between the last point and the first for 10.4")));
}

}  // namespace test_long_steps
}  // namespace gripline
