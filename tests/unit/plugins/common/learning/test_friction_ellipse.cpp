#include "common/learning/friction_ellipse.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::learning {
namespace test_friction_ellipse {

TEST(FrictionEllipse, TakesFromTheSideWhatDriveAndBrakesUse) {
  const FrictionEllipse none;
  EXPECT_EQ(none.side_share(Axle::front, 5000.0, 1.0, 6000.0), 1.0);
  const FrictionEllipse ellipse{1.1, 0.4, 0.6};
  // Drive: 0.4 in front, 0.6 behind; brakes the other way round. The load stretches the ellipse.
  EXPECT_NEAR(ellipse.side_share(Axle::front, 5000.0, 1.0, 6000.0), std::sqrt(1 - square(2000 / 6600.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, 5000.0, 1.0, 6000.0), std::sqrt(1 - square(3000 / 6600.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::front, -5000.0, 1.2, 6000.0), std::sqrt(1 - square(3000 / 7920.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, -5000.0, 0.8, 6000.0), std::sqrt(1 - square(2000 / 5280.0)), 1e-12);
  EXPECT_DOUBLE_EQ(ellipse.side_share(Axle::rear, 1e6, 1.0, 6000.0), 0.2);
  Dual8 force(5000.0);
  force.d[0] = 1.0;
  const double h = 1e-3;
  const double slope = (ellipse.side_share(Axle::rear, 5000.0 + h, 1.0, 6000.0) -
                        ellipse.side_share(Axle::rear, 5000.0 - h, 1.0, 6000.0)) /
                       (2 * h);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, force, Dual8(1.0), 6000.0).d[0], slope, 1e-9);
}

}  // namespace test_friction_ellipse
}  // namespace gripline::learning
