#include "geometry/polyline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "support/sample_curves.hpp"

namespace gripline {
namespace test_polyline {

/// A rectangle of 40 m by 1 m: its long sides run beside each other.
ClosedPolyline strip() { return ClosedPolyline({{0, 0}, {20, 0}, {40, 0}, {40, 1}, {20, 1}, {0, 1}}); }

TEST(ClosedPolyline, MeasuresAlongItsChords) {
  const ClosedPolyline line = strip();
  EXPECT_EQ(line.length(), 82.0);
  EXPECT_EQ(line.station(3), 41.0);
  EXPECT_EQ(line.nearest_station(7.0, -3.0), 7.0);
  EXPECT_EQ(line.nearest_station(-2.0, 0.25), 81.75);
  EXPECT_EQ(line.fraction(0.0, 0.0), 0.0);  // and not 1
  EXPECT_EQ(line.fraction(20.0, 2.0), 61.0 / 82.0);
  for (double s = -90.0; s < 200.0; s += 3.7) {
    const PlanePoint p = line.at(s);
    EXPECT_NEAR(wrap_difference(line.nearest_station(p.x, p.y) - s, 82.0), 0.0, 1e-12);
  }
}

TEST(ClosedPolyline, DropsALastPointThatRepeatsTheFirst) {
  EXPECT_EQ(ClosedPolyline({{0, 0}, {3, 0}, {3, 4}, {0, 0}}).points().size(), 3u);
  EXPECT_EQ(ClosedPolyline({{0, 0}, {3, 0}, {3, 4}, {0, 0}}).length(), 12.0);
  EXPECT_THROW(ClosedPolyline({{0, 0}, {3, 0}, {0, 0}}), GeometryError);
}

TEST(ClosedPolyline, WithinAReachOnlyThatStretchCounts) {
  const ClosedPolyline line = strip();
  // Nearer to the upper side, which is 61 m along; around 20 m only the lower side is.
  EXPECT_EQ(line.nearest_station(20.0, 0.9), 61.0);
  EXPECT_EQ(line.nearest_station(20.0, 0.9, 19.0, 8.0), 20.0);
  EXPECT_EQ(line.nearest_station(20.0, 0.9, 60.0, 8.0), 61.0);
  EXPECT_EQ(line.nearest_station(1.0, 0.1, 81.9, 4.0), 1.0);     // over the first point
  EXPECT_EQ(line.nearest_station(20.0, 0.9, 19.0, 41.0), 61.0);  // a reach of the whole line
}

TEST(ClosedPolyline, ALargeReachFindsWhatTheWholeSearchFinds) {
  const ClosedPolyline line(test::ellipse_points(30.0, 20.0, 90));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0.0, 1.0), off(-3.0, 3.0);
  for (int i = 0; i < 500; ++i) {
    const double s = line.length() * share(random);
    const PlanePoint p = line.at(s);
    const double x = p.x + off(random), y = p.y + off(random);
    EXPECT_EQ(line.nearest_station(x, y, s, 20.0), line.nearest_station(x, y));
  }
}

}  // namespace test_polyline
}  // namespace gripline
