#include "calibrate/forecast/forecast_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace test_forecast_run {

using test::CalibrateRig;
using test::drive;
using test::some_starts;

TEST(ForecastRun, StepsAreWholeAndNoneWhereTheirNumberIsNone) {
  EXPECT_EQ(forecast::whole_steps(2.1), 3u);
  EXPECT_EQ(forecast::whole_steps(2.0), 2u);
  for (const double none : {0.0, -1.5, not_a_number, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(forecast::whole_steps(none), 0u) << none;
}

/// Else a fit that tries such a value would never end.
TEST(ForecastRun, ParametersThatAreNoNumbersPredictNothing) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 10});
  const Starts starts = some_starts(s);
  constexpr std::size_t of_car = 0;
  for (const std::size_t wrong : {of_car, rig.forecaster.index(ForecastParameter::delay_position),
                                  rig.forecaster.index(ForecastParameter::delay_yaw_rate)}) {
    std::vector<double> params = rig.forecaster.defaults();
    params[wrong] = not_a_number;
    const std::vector<double> predicted = rig.predict(s, params, starts);
    ASSERT_FALSE(predicted.empty());
    EXPECT_TRUE(std::ranges::all_of(predicted, [](double x) { return std::isnan(x); })) << wrong;
  }
}

}  // namespace test_forecast_run
}  // namespace gripline::calibrate
