#include "calibrate/predict/prediction_samples.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace test_prediction_samples {

constexpr double turn = 2.0 * std::numbers::pi;
const std::string header = "start_s,t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps\n";

/// Rows at 0 and 0.1 s of a clock that showed 100 s at the first; yaw passes half a turn between them.
Session turning() {
  Session s;
  s.begin = 100.0;
  s.t = {0.0, 0.1};
  s.has.fill(true);
  for (const double yaw : {3.1, 3.2})
    for (const double value : {0.0, 0.0, yaw, 5.0, 0.0, 1.0}) s.reading.push_back(value);
  s.written_yaw = {3.1, 3.2 - turn};
  return s;
}

/// A prediction for half a second after each start.
const Starts starts{{0.0, 0.1}, {0.5}};
const std::vector<double> predicted{1.0, 2.0, 3.3, 5.0, 0.1, 0.2, 1.5, 2.5, 3.4, 5.0, 0.1, 0.2};

TEST(PredictionSamples, AreInTheLogsClockAndItsTurns) {
  EXPECT_EQ(samples_table(turning(), starts, predicted),
            header +
                "100.000000,100.500000,1.00000,2.00000,-2.9831853,5.0000000,0.1000000,0.2000000\n"
                "100.100000,100.600000,1.50000,2.50000,-2.8831853,5.0000000,0.1000000,0.2000000\n");
}

/// A column that was seen beyond half a turn counts turns.
TEST(PredictionSamples, YawGoesOnWhereTheColumnDoes) {
  Session session = turning();
  session.written_yaw = {3.1 + turn, 3.2 + turn};
  EXPECT_EQ(samples_table(session, starts, predicted),
            header +
                "100.000000,100.500000,1.00000,2.00000,9.5831853,5.0000000,0.1000000,0.2000000\n"
                "100.100000,100.600000,1.50000,2.50000,9.6831853,5.0000000,0.1000000,0.2000000\n");
}

TEST(PredictionSamples, WhatTheLogDoesNotHaveIsEmptyAndWhatWasNotPredictedIsLeftOut) {
  Session session = turning();
  session.has[measured::Channel::x] = session.has[measured::Channel::y] = session.has[measured::Channel::yaw] = false;
  std::vector<double> one = predicted;
  one[measured::channels + measured::Channel::vx] = not_a_number;
  EXPECT_EQ(samples_table(session, starts, one), header + "100.000000,100.500000,,,,5.0000000,0.1000000,0.2000000\n");
}

}  // namespace test_prediction_samples
}  // namespace gripline::calibrate
