#include "common/vehicle/axle_loads.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_axle_loads {

TEST(AxleLoads, BalanceTheWeightOfACarThatStands) {
  Car car;
  car.m = 1265.0;
  car.lf = 1.34;
  car.lr = 1.10;
  const vehicle::AxleLoads loads = vehicle::static_axle_loads(car);
  EXPECT_NEAR(loads.front + loads.rear, 1265.0 * gravity, 1e-9);
  EXPECT_NEAR(loads.front * car.lf, loads.rear * car.lr, 1e-9);
  EXPECT_EQ(loads.of(Axle::front), loads.front);
  EXPECT_EQ(loads.of(Axle::rear), loads.rear);
}

}  // namespace test_axle_loads
}  // namespace gripline
