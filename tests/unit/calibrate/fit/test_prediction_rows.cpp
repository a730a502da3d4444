#include "calibrate/fit/prediction_rows.hpp"

#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_prediction_rows {

constexpr std::size_t vx = 3, vx_quantity = 2;  // among channels, among quantities

/// What a log shows, vx off by one value at the first horizon and by another at the last.
std::vector<double> off_by(const FitLog& log, double at_first, double at_last) {
  std::vector<double> predicted = log.truth;
  for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
    predicted[2 * i * channels + vx] += at_first;
    predicted[(2 * i + 1) * channels + vx] += at_last;
  }
  return predicted;
}

TEST(PredictionRows, AreOfTheLastHorizonAndNoBlockIsOfTwoLogs) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 6});
  const std::vector<FitLog> logs(2, FitLog(session, 0.02, {0.5, 1.0}, 0.5, 0.5));
  ASSERT_GE(logs.front().starts.time.size(), 3u);
  const HorizonRow row = row_of_predictions("off", logs, {off_by(logs[0], 5.0, 0.1), off_by(logs[1], 5.0, -0.3)});
  EXPECT_EQ(row.name, "off");
  const HorizonError& error = row.error[vx_quantity];
  EXPECT_EQ(error.count, 2 * logs.front().starts.time.size());
  EXPECT_NEAR(error.rms, std::sqrt(0.05), 1e-9);
  EXPECT_NEAR(error.low, 0.1, 1e-9);
  EXPECT_NEAR(error.high, 0.3, 1e-9);
}

TEST(PredictionRows, OfAModelAreItsErrors) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 20});
  std::vector<FitLog> logs(1, FitLog(session, 0.02, {1.0}, 0.5, 0.5));
  const PredictionErrors errors(rig.forecaster, logs);
  const std::vector<double> params = rig.forecaster.defaults();
  const std::vector<double> off = errors.errors(params).front();
  double sum = 0.0;
  for (std::size_t i = 0; i < logs.front().starts.time.size(); ++i)
    sum += off[i * channels + vx] * off[i * channels + vx];
  EXPECT_GT(sum, 0.0);
  EXPECT_NEAR(row_of_model("model", errors, params).error[vx_quantity].rms,
              std::sqrt(sum / static_cast<double>(logs.front().starts.time.size())), 1e-9);
}

}  // namespace test_prediction_rows
}  // namespace gripline::calibrate
