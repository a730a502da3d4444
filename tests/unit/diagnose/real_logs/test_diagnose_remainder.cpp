#include "diagnose/real_logs/remainder.hpp"

#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_remainder {

using calibrate::FitLog;
using calibrate::ForecastErrors;

/// Errors that grow with one thing lie in its upper third, those that fall with it in its lower one.
TEST(Remainder, SaysWhatTheWorstStartsHaveInCommon) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 40});
  constexpr double horizon = 1.0;
  const std::vector<FitLog> logs(1, FitLog(session, 0.02, {horizon}, calibrate::judged_every, 0.5));
  const FitLog& log = logs.front();
  for (const double sign : {1.0, -1.0}) {
    ForecastErrors errors;
    for (const double t : log.starts.time)
      errors.square.push_back(std::exp(sign * 4.0 * session.interpolate(3, t + 0.5 * horizon)));
    const Remainder rest = remainder_of(logs, errors, horizon);
    EXPECT_EQ(rest.of, "speed");
    EXPECT_EQ(rest.most, sign > 0.0);
    EXPECT_GT(rest.share, 0.6);
    std::size_t beyond = 0;
    for (const double t : log.starts.time)
      beyond += sign * session.interpolate(3, t + 0.5 * horizon) >= sign * rest.from ? 1 : 0;
    EXPECT_EQ(beyond, log.starts.time.size() / 3);
  }
}

TEST(Remainder, IsEmptyWhereThereAreNoErrors) {
  EXPECT_EQ(remainder_of({}, {}, 1.0).share, 0.0);
  EXPECT_TRUE(remainder_of({}, {}, 1.0).of.empty());
}

}  // namespace test_diagnose_remainder
}  // namespace gripline::diagnose
