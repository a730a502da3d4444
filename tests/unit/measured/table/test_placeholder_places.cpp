#include "measured/table/placeholder_places.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::measured {
namespace test_placeholder_places {
namespace {

/// A car that drives at 10 m/s from x = 50 on, of whose 20 rows a second the first `without` show this place.
struct Drive {
  std::vector<double> t, x, y;
  Drive(std::size_t without, double place, double first_x = 50.0, std::size_t held = 1) {
    for (std::size_t i = 0; i < 400; ++i) {
      const double now = 0.05 * static_cast<double>(i - i % held);
      t.push_back(0.05 * static_cast<double>(i));
      x.push_back(i < without ? place : first_x + 10 * now);
      y.push_back(i < without ? place : 3.0);
    }
  }
};

TEST(PlaceholderPlaces, ThoseBeforeTheFirstFixAreLeftOut) {
  for (const double place : {0.0, -9999.0}) {
    Drive drive(100, place);
    const PlaceholderPlaces dropped = drop_placeholder_places(drive.t, drive.x, drive.y);
    EXPECT_EQ(dropped.rows, 100u);
    EXPECT_EQ(dropped.x, place);
    EXPECT_TRUE(std::isnan(drive.x[0]) && std::isnan(drive.y[99]));
    EXPECT_DOUBLE_EQ(drive.x[100], 100.0);
  }
}

TEST(PlaceholderPlaces, ACarThatStandsAtFirstStays) {
  Drive drive(0, 0.0);
  for (std::size_t i = 0; i < 100; ++i) drive.x[i] = drive.x[100] - 0.5;
  EXPECT_EQ(drop_placeholder_places(drive.t, drive.x, drive.y).rows, 0u);
  EXPECT_FALSE(std::isnan(drive.x[0]));
}

TEST(PlaceholderPlaces, APlaceThatIsHeldStays) {
  Drive drive(0, 0.0, 0.0, 20);
  EXPECT_EQ(drop_placeholder_places(drive.t, drive.x, drive.y).rows, 0u);
}

TEST(PlaceholderPlaces, AGapAfterAStandStays) {
  Drive drive(100, 0.0, 5000.0);
  for (std::size_t i = 100; i < drive.t.size(); ++i) drive.t[i] += 500;
  EXPECT_EQ(drop_placeholder_places(drive.t, drive.x, drive.y).rows, 0u);
}

TEST(PlaceholderPlaces, OnePlaceThroughoutStays) {
  Drive drive(400, 0.0);
  EXPECT_EQ(drop_placeholder_places(drive.t, drive.x, drive.y).rows, 0u);
}

}  // namespace
}  // namespace test_placeholder_places
}  // namespace gripline::measured
