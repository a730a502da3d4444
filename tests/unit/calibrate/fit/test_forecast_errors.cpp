#include "calibrate/fit/forecast_errors.hpp"

#include <gtest/gtest.h>

namespace gripline::calibrate {
namespace test_forecast_errors {

ForecastErrors errors_of(double size, double with_odd) {
  ForecastErrors out;
  for (std::size_t i = 0; i < 40; ++i) {
    const std::size_t stretch = i / 4;
    out.square.push_back(stretch % 2 == 0 ? size : size * with_odd);
    out.stretch.push_back(stretch);
  }
  return out;
}

TEST(ForecastChange, SaysWhatTheStretchesAgreeOn) {
  const ForecastErrors one = errors_of(1.0, 1.0);
  EXPECT_TRUE(change_of(errors_of(0.64, 1.1), one).helps());
  EXPECT_NEAR(change_of(errors_of(0.64, 1.0), one).change, -0.2, 1e-12);
  EXPECT_TRUE(change_of(errors_of(1.3, 1.1), one).harms());
  const ForecastChange split = change_of(errors_of(0.5, 3.0), one);
  EXPECT_FALSE(split.helps() || split.harms());
}

TEST(ForecastChange, TellsNothingOfTwoStretches) {
  ForecastErrors few;
  few.square = {1.0, 1.0};
  few.stretch = {1, 2};
  ForecastErrors less = few;
  less.square = {0.1, 0.1};
  const ForecastChange change = change_of(less, few);
  EXPECT_FALSE(change.helps());
  EXPECT_EQ(change.certainty, 0.5) << "neither for nor against";
}

TEST(ForecastErrors, OfOneLogAreItsOwn) {
  ForecastErrors two;
  two.square = {1.0, 4.0, 9.0, 16.0};
  two.stretch = {1, 1, 2, 3};
  two.log = {0, 0, 0, 1};
  EXPECT_EQ(two.stretches(), 3u);
  EXPECT_EQ(two.of_log(0).square, (std::vector{1.0, 4.0, 9.0}));
  EXPECT_EQ(two.of_log(0).stretches(), 2u);
  EXPECT_EQ(two.of_log(1).rms(), 4.0);
}

}  // namespace test_forecast_errors
}  // namespace gripline::calibrate
