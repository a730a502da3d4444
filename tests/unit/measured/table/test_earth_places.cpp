#include "measured/table/earth_places.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "config/errors.hpp"

namespace gripline::measured {
namespace test_earth_places {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
const std::vector<int> lines{2, 3, 4, 5, 6, 7, 8, 9};

const std::vector<double> times{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};

PlanePlaces plane(EarthPlaces places, std::vector<Finding>* findings = nullptr) {
  std::vector<Finding> unread;
  places.t = times;
  return on_plane(std::move(places), "drive.csv", lines, findings != nullptr ? *findings : unread);
}
std::vector<std::string> checks(const EarthPlaces& places) {
  std::vector<Finding> findings;
  plane(places, &findings);
  std::vector<std::string> out;
  for (const Finding& one : findings) out.push_back(one.check + ": " + one.done);
  return out;
}

// Lengths of a degree on WGS 84, from tables: 110.574 and 111.320 km at the equator, 111.132 and 78.847 km at 45
// degrees.
TEST(EarthPlaces, DegreesAreAsLongAsOnTheEllipsoid) {
  for (const auto& [latitude, north, east] :
       {std::array{0.0, 110574.0, 111320.0}, {45.0, 111132.0, 78847.0}, {-45.0, 111132.0, 78847.0}}) {
    const double step = 1e-3;
    const PlanePlaces out = plane({.latitude = {latitude * deg, (latitude + step) * deg, latitude * deg},
                                   .longitude = {8 * deg, 8 * deg, (8 + step) * deg},
                                   .latitude_unit_is_known = true,
                                   .longitude_unit_is_known = true});
    EXPECT_EQ(out.x[0], 0.0);
    EXPECT_EQ(out.y[0], 0.0);
    EXPECT_NEAR(out.y[1], north * step, 1e-3 * step * north) << latitude;
    EXPECT_NEAR(out.x[2], east * step, 1e-3 * step * east) << latitude;
    EXPECT_EQ(out.y[2], 0.0);
  }
}

TEST(EarthPlaces, BothSidesOfTheDateLineAreNear) {
  const PlanePlaces out = plane({.latitude = {0.0, 0.0}, .longitude = {179.9995 * deg, -179.9995 * deg}});
  EXPECT_NEAR(out.x[1], 111.32, 0.01);
}

TEST(EarthPlaces, TheFirstPlaceThatIsKnownIsTheOrigin) {
  const PlanePlaces out = plane({.latitude = {none, 0.0, 0.5, 0.5}, .longitude = {0.1, 0.0, 0.1, 0.1}});
  EXPECT_TRUE(std::isnan(out.x[0]) && std::isnan(out.y[0]));
  EXPECT_TRUE(std::isnan(out.x[1]) && std::isnan(out.y[1]));  // 0, 0: no fix
  EXPECT_EQ(out.x[2], 0.0);
  EXPECT_EQ(out.y[3], 0.0);
}

TEST(EarthPlaces, AnglesBeyondRadiansAreDegreesWhereNobodySaysTheUnit) {
  const EarthPlaces degrees{.latitude = {48.1, 48.2}, .longitude = {1.1, 1.1}};
  EXPECT_NEAR(plane(degrees).y[1], 11120, 20);
  EXPECT_EQ(checks(degrees).front(), "unit: taken for degrees; `unit` in the map says so");
  const EarthPlaces radians{.latitude = {0.84, 0.841}, .longitude = {1.1, 1.1}};
  EXPECT_NEAR(plane(radians).y[1], 6371, 30);
  EXPECT_EQ(checks(radians).size(), 1u);
}

TEST(EarthPlaces, ALatitudeBeyondAPoleIsRefusedAtItsLine) {
  try {
    plane({.latitude = {0.1, 1.7}, .longitude = {0.1, 0.1}, .latitude_unit_is_known = true});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics()[0].line, 3);
    EXPECT_NE(std::string(error.what()).find("97.4028 deg"), std::string::npos) << error.what();
  }
  EXPECT_THROW(plane({.latitude = {none, 0.0}, .longitude = {0.1, 0.0}}), InputError);
}

/// A receiver that shows yesterday's place until it has a fix does not say where the plane lies.
TEST(EarthPlaces, ThePlaceOfBeforeTheFirstFixIsNone) {
  const double step = 1e-5;
  EarthPlaces there{.latitude = {30 * deg, 30 * deg, 30 * deg},
                    .longitude = {8 * deg, 8 * deg, 8 * deg},
                    .latitude_unit_is_known = true,
                    .longitude_unit_is_known = true};
  for (int k = 0; k < 5; ++k) {
    there.latitude.push_back(60 * deg);
    there.longitude.push_back((9 + k * step) * deg);
  }
  std::vector<Finding> findings;
  const PlanePlaces out = plane(there, &findings);
  EXPECT_TRUE(std::isnan(out.x[0]));
  EXPECT_TRUE(std::isnan(out.y[2]));
  EXPECT_EQ(out.x[3], 0.0);
  EXPECT_NEAR(out.x[7], 4 * step * 55800.0, 0.01);  // a degree of longitude at 60 degrees
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().found,
            "3 rows at the beginning show the latitude and longitude 30, 8 deg, far from the rest");
}

}  // namespace
}  // namespace test_earth_places
}  // namespace gripline::measured
