#include "geometry/road_size.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gripline {
namespace test_road_size {

using testing::HasSubstr;
using testing::IsEmpty;

/// A circle of this length and width [m].
RoadTable circle(double length, double width) {
  constexpr int count = 100;
  RoadTable road;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * i / count, r = length / (2 * std::numbers::pi);
    road.points.push_back({r * std::cos(a), r * std::sin(a)});
  }
  road.right = road.left = std::vector<double>(count, 0.5 * width);
  return road;
}

TEST(RoadSize, RoadsOfRacesAndModelsAreNoReasonToWarn) {
  EXPECT_THAT(warning_of_size(circle(5000, 12)), IsEmpty());
  EXPECT_THAT(warning_of_size(circle(25000, 8)), IsEmpty());
  EXPECT_THAT(warning_of_size(circle(12, 0.3)), IsEmpty());
}

TEST(RoadSize, TheUnitThatNumbersMayHaveIsNamed) {
  EXPECT_THAT(warning_of_size(circle(0.58, 0.008)),
              testing::AllOf(HasSubstr("the road is 0.58 m long and usually 0.008 m wide"), HasSubstr("kilometres?")));
  EXPECT_THAT(warning_of_size(circle(500, 0.008)), HasSubstr("widths in another unit than its points"));
  EXPECT_THAT(warning_of_size(circle(5000, 90)), HasSubstr("feet or centimetres?"));
}

TEST(RoadSize, CircuitsOf3To25KilometresInOneUnitAreToldFromWidthsInAnother) {
  for (const double length : {3.0, 5.0, 7.0, 15.0, 20.8, 25.0})
    for (const double width : {8.0, 12.0, 15.0}) {
      SCOPED_TRACE(testing::Message() << length << " km, " << width << " m");
      EXPECT_THAT(warning_of_size(circle(1000 * length, width)), IsEmpty());
      EXPECT_THAT(warning_of_size(circle(length, 1e-3 * width)), HasSubstr("are its numbers kilometres?"));
      EXPECT_THAT(warning_of_size(circle(1000 * length, 1e-3 * width)), HasSubstr("widths in another unit"));
      EXPECT_THAT(warning_of_size(circle(1e5 * length, 100 * width)), HasSubstr("are its numbers, or its widths"));
      EXPECT_THAT(warning_of_size(circle(1000 * length, 100 * width)), HasSubstr("widths in another unit"));
    }
}

}  // namespace test_road_size
}  // namespace gripline
