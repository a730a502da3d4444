#include "report/tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "report/inputs.hpp"
#include "report/series.hpp"
#include "support/report_files.hpp"
#include "util/resampling.hpp"

namespace gripline::report {
namespace test_report_tables {

TEST(ReportTables, MedianOfNumbers) {
  EXPECT_EQ(median_of_numbers(std::vector<double>{10, 1, 9, 2, 8, 3, 7, 4, 6, 5}), 5.5);
  EXPECT_EQ(median_of_numbers(std::vector<double>{3, gap, 1, 2}), 2);
  EXPECT_TRUE(std::isnan(median_of_numbers(std::vector<double>{})));
}

/// Of a race that was cut short, or of a table of an older program.
TEST(ReportTables, IntervalsThatNoTableStatesAreThoseOfTheTables) {
  const Folder folder;
  std::ofstream(folder.path() / "runs.csv") << "stack,seed,status,needs_truth,lap0_s,mu_rmse\n"
                                               "elm,1,finished,0,66,0.1\n"
                                               "elm,2,finished,0,60.5,\n"
                                               "elm,3,finished,0,63.5,0.3\n"
                                               "elm,4,finished,0,61,\n"
                                               "elm,5,finished,0,70,\n"
                                               "elm,6,finished,0,62,\n"
                                               "slow,1,finished,0,80,\n";
  const nlohmann::json table = table_json(read_inputs(folder.path()));
  ASSERT_EQ(table["columns"], nlohmann::json::array({"lap0_s", "mu_rmse"}));
  const nlohmann::json& elm = table["rows"][0];
  EXPECT_EQ(elm["values"], nlohmann::json::array({62.75, 0.2}));
  const MedianInterval laps = bootstrap_median_interval({60.5, 61, 62, 63.5, 66, 70});
  // Order statistics would give the range of six, 60.5 to 70.
  EXPECT_GT(laps.lo, 60.5);
  EXPECT_LT(laps.hi, 70);
  EXPECT_EQ(elm["low"], nlohmann::json::array({laps.lo, 0.1}));
  EXPECT_EQ(elm["high"], nlohmann::json::array({laps.hi, 0.3}));
  EXPECT_EQ(elm["n"], nlohmann::json::array({6, 2}));
  EXPECT_TRUE(table["rows"][1]["low"][0].is_null()) << "one run tells no interval";
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

/// As in table.csv: of ten values 95 % are the ten smallest, 50 % the five smallest.
TEST(ReportTables, SharesOfTimesAreByNearestRank) {
  TimeHistogram histogram;
  for (int i = 10; i >= 1; --i) histogram.add(i);
  const nlohmann::json json = histogram.json();
  EXPECT_EQ(json["median"], 5);
  EXPECT_EQ(json["p95"], 10);
  EXPECT_EQ(json["p99"], 10);
  EXPECT_EQ(json["max"], 10);
  EXPECT_TRUE(TimeHistogram().json()["p95"].is_null());
}

}  // namespace test_report_tables
}  // namespace gripline::report
