#include "measured/log/road.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "support/sample_roads.hpp"

namespace gripline::measured {
namespace test_road {

/// Two metres beside its own pass, the car is nearer to the other one.
TEST(Road, ALogThatBeginsAtACrossingIsOnThePassThatItFollows) {
  const auto track = std::make_shared<const Track>(to_track(test::figure_of_eight(5.0, 4.0)));
  const Crossing c = track->crossings().front();
  const Road road(track);
  for (const double s : {c.first, c.second}) {
    const CurvePoint at = track->at(s);
    double hint = std::numeric_limits<double>::quiet_NaN();
    road.at(0.0, at.x - 2.0 * std::sin(at.yaw), at.y + 2.0 * std::cos(at.yaw), at.yaw, hint);
    EXPECT_NEAR(wrap_difference(hint - at.s, track->length()), 0.0, 0.1);
  }
}

}  // namespace test_road
}  // namespace gripline::measured
