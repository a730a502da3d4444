#include "geometry/corner_room.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_corner_room {

/// Driven counter-clockwise: its left edge is the inner one.
Track ring(double radius, double left, double right) {
  const std::vector<Segment> segments{Segment::arc(radius, 2.0 * std::numbers::pi)};
  return Track(TrackShape{
      .centre = ClosedCurve::from_segments({}, segments), .half_width_right = right, .half_width_left = left});
}
/// A car with its centre of gravity over the rear axle, which turns within 0.55 m.
Car car_of(double length, double width) { return {.lf = 0.2, .length = length, .width = width, .delta_max = 0.35}; }

TEST(CornerRoom, TheOuterCornersDecideInATurn) {
  const FarthestCorner fits = farthest_corner(ring(1.0, 0.1, 0.1), car_of(0.5, 0.1));
  EXPECT_NEAR(fits.beyond, std::hypot(1.05, 0.25) - 1.1, 1e-4);
  EXPECT_LT(fits.beyond, 0.0);
  // 0.1 m wide on a road of 0.2 m, and too long for its bend all the same.
  const FarthestCorner swings_out = farthest_corner(ring(1.0, 0.1, 0.1), car_of(0.9, 0.1));
  EXPECT_NEAR(swings_out.beyond, std::hypot(1.05, 0.45) - 1.1, 1e-4);
}

/// The centre line lies 0.02 m from the outer edge: half of a car 0.1 m wide has no room there.
TEST(CornerRoom, ALineFartherInsideIsFound) {
  EXPECT_LE(farthest_corner(ring(1.0, 0.3, 0.02), car_of(0.3, 0.1)).beyond, 0.0);
}

/// On the centre line and on the widest one its outer corners swing out. There is room farther inside, but not for the
/// same distance from the inner edge.
TEST(CornerRoom, WhereOneEdgeLacksRoomTheLineKeepsAwayFromThatOneAlone) {
  const Track road = ring(1.0, 0.1, 0.1);
  ASSERT_GT(std::hypot(1.05, 0.35) - 1.1, 0.0);
  EXPECT_LT(farthest_corner(road, car_of(0.7, 0.1)).beyond, -0.01);
}

TEST(CornerRoom, TheSmallCarHasRoomOnItsRoads) {
  const Car car{.lf = 0.029, .lr = 0.033, .length = 0.06, .width = 0.03, .delta_max = 0.35};
  for (const char* name : {"ethz.json", "ethz_mobil.json"})
    EXPECT_LT(farthest_corner(load_track(testing_support::source_dir() / "worlds/tracks" / name), car).beyond, 0.0);
}

}  // namespace test_corner_room
}  // namespace gripline
