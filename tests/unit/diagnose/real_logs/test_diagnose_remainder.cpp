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

/// A speed that is read in few of the rows is no speed of 0 in the others.
TEST(Remainder, SpeedsBetweenReadingsCount) {
  const test::CalibrateRig rig;
  const measured::Session full = test::drive(rig.vehicle.car(), {.seconds = 40});
  constexpr double horizon = 1.0;
  const auto rest_of = [&](std::size_t every) {
    measured::Session session = full;
    for (std::size_t i = 0; i < session.rows(); ++i)
      if (i % every != 0) session.reading[i * measured::channels + measured::Channel::vx] = NAN;
    const std::vector<FitLog> logs(1, FitLog(session, 0.02, {horizon}, calibrate::judged_every, 0.5));
    ForecastErrors errors;
    for (std::size_t i = 0; i < logs.front().starts.time.size(); ++i)
      if (calibrate::has_truth(logs.front(), i))
        errors.square.push_back(std::exp(-4.0 * full.interpolate(3, logs.front().starts.time[i] + 0.5 * horizon)));
    return remainder_of(logs, errors, horizon);
  };
  const Remainder rest = rest_of(5);
  EXPECT_EQ(rest.of, "speed");
  EXPECT_FALSE(rest.most);
  EXPECT_GT(rest.from, 0.5);
  EXPECT_NE(rest_of(100).of, "speed") << "nothing tells it between readings 2 s apart";
}

TEST(Remainder, IsEmptyWhereThereAreNoErrors) {
  EXPECT_EQ(remainder_of({}, {}, 1.0).share, 0.0);
  EXPECT_TRUE(remainder_of({}, {}, 1.0).of.empty());
}

}  // namespace test_diagnose_remainder
}  // namespace gripline::diagnose
