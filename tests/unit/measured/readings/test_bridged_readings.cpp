#include "measured/readings/bridged_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "measured/log/log.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_bridged_readings {

TEST(BridgedReadings, LieOnTheLineBetweenTwoThatAreNotTooFarApart) {
  const std::vector<double> t = {0.0, 0.1, 0.3, 0.4, 0.5, 1.0, 1.1};
  std::vector<double> reading(t.size() * channels, not_a_number);
  const auto at = [](std::vector<double>& of, std::size_t row) -> double& { return of[row * channels + Channel::vx]; };
  at(reading, 1) = 1.0, at(reading, 4) = 5.0, at(reading, 6) = 7.0;
  std::vector<double> bridged = bridged_readings(t, reading, 0.4);
  EXPECT_TRUE(std::isnan(at(bridged, 0))) << "nothing before";
  EXPECT_EQ(at(bridged, 1), 1.0);
  EXPECT_NEAR(at(bridged, 2), 3.0, 1e-12);
  EXPECT_NEAR(at(bridged, 3), 4.0, 1e-12);
  EXPECT_TRUE(std::isnan(at(bridged, 5))) << "0.6 s apart";
  for (std::size_t i = 0; i < t.size(); ++i) EXPECT_TRUE(std::isnan(bridged[i * channels + Channel::yaw]));
}

}  // namespace test_bridged_readings
}  // namespace gripline::measured
