#include "geometry/road_stations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/sample_curves.hpp"

namespace gripline {
namespace test_road_stations {

TrackShape road(double left) { return {.centre = test::stadium(), .half_width_right = 0.3, .half_width_left = left}; }

TEST(RoadStations, AreAtEqualStepsWithTheWidthsThere) {
  const TrackShape shape = road(0.5);
  const std::vector<RoadStation> stations = road_stations(shape, 0.1);
  const double length = shape.centre.length();
  ASSERT_EQ(stations.size(), static_cast<std::size_t>(std::ceil(length / 0.1)));
  const double step = length / static_cast<double>(stations.size());
  EXPECT_LE(step, 0.1);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    EXPECT_NEAR(stations[i].centre.s, step * static_cast<double>(i), 1e-9);
    EXPECT_EQ(stations[i].left, 0.5);
    EXPECT_EQ(stations[i].right, 0.3);
  }
}

TEST(RoadStations, AreNeitherFewerThanSixtyFourNorMoreThanCanBeCompared) {
  EXPECT_EQ(road_stations(road(0.5), 5.0).size(), 64u);
  // 10 million pairs of stations within the widest half width: of 14.3 m and 0.5 m, about 16900 stations.
  const std::size_t most = road_stations(road(0.5), 1e-5).size();
  EXPECT_GT(most, 16000u);
  EXPECT_LT(most, 17500u);
}

/// As a search over all stations finds them, wherever squares begin and end.
TEST(StationSquares, AllStationsNearAPlaceAreVisitedOnce) {
  const std::vector<RoadStation> stations = road_stations(road(0.5), 0.1);
  const StationSquares squares(stations, 0.5);
  for (const double reach : {0.05, 0.3, 0.5})
    for (double x = -1.2; x < 5.5; x += 0.37)
      for (double y = -0.4; y < 2.5; y += 0.29) {
        std::vector<int> visits(stations.size(), 0);
        squares.visit_near(x, y, reach, [&](std::size_t i) { ++visits[i]; });
        for (std::size_t i = 0; i < stations.size(); ++i) {
          const double dx = x - stations[i].centre.x, dy = y - stations[i].centre.y;
          EXPECT_EQ(visits[i], dx * dx + dy * dy < reach * reach ? 1 : 0) << x << " " << y << " " << i;
        }
      }
}

}  // namespace test_road_stations
}  // namespace gripline
