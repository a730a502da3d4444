#include "report/tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "report/inputs.hpp"
#include "report/series.hpp"
#include "support/report_files.hpp"

namespace gripline::report {
namespace {

TEST(ReportTables, IntervalOfTheMedianByOrderStatistics) {
  std::vector<double> ten{10, 1, 9, 2, 8, 3, 7, 4, 6, 5};
  EXPECT_EQ(median_of_numbers(ten), 5.5);
  // n = 10: second smallest to second largest, covering 97.9 %.
  EXPECT_EQ(median_interval(ten).low, 2);
  EXPECT_EQ(median_interval(ten).high, 9);
  const std::vector<double> three{3, gap, 1, 2};
  EXPECT_EQ(median_of_numbers(three), 2);
  EXPECT_EQ(median_interval(three).low, 1);
  EXPECT_TRUE(std::isnan(median_interval(std::vector<double>{1}).low));
  EXPECT_TRUE(std::isnan(median_of_numbers(std::vector<double>{})));
  // n = 20: the sixth, P(Binomial(20, 1/2) <= 5) = 0.0207.
  std::vector<double> twenty(20);
  for (std::size_t i = 0; i < twenty.size(); ++i) twenty[i] = static_cast<double>(i + 1);
  EXPECT_EQ(median_interval(twenty).low, 6);
}

TEST(ReportTables, ClaimsKeepWhatWasSkipped) {
  const nlohmann::json claims = claims_json(nlohmann::json::parse(R"({"claims": [{"text": "a.x <= b.x", "holds": false,
    "values": {"left": 2, "right": 1}}], "skipped": [{"text": "c", "why": "left out"}]})"));
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_EQ(claims[0]["holds"], false);
  EXPECT_EQ(claims[0]["values"]["left"], 2);
  EXPECT_TRUE(claims[1]["holds"].is_null());
  EXPECT_EQ(claims[1]["why"], "left out");
}

TEST(ReportTables, TimesPooledOnALogarithmicAxis) {
  TimeHistogram histogram;
  for (int i = 1; i <= 100; ++i) histogram.add(0.01 * i);
  histogram.add(gap);
  histogram.add(-1);
  const nlohmann::json json = histogram.json();
  EXPECT_EQ(json["n"], 100);
  EXPECT_NEAR(json["median"].get<double>(), 0.5, 0.011);
  EXPECT_NEAR(json["max"].get<double>(), 1.0, 1e-6);
  long counted = 0;
  for (const nlohmann::json& bin : json["bins"]) counted += bin[1].get<long>();
  EXPECT_EQ(counted, 100);
}

}  // namespace
}  // namespace gripline::report
