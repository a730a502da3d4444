#include "report/sweep_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace gripline::report {
namespace test_report_sweep_page {

using testing::HasSubstr;
using testing::Not;

nlohmann::json sweep(double seeds_share) {
  nlohmann::json data =
      nlohmann::json::parse(R"({"name": "learning", "runs": 12, "finished": 12, "broken": 0, "missing": 0,
    "factors": ["/stacks/elm/params/decay", "/stacks/elm/params/mu"],
    "responses": [{"name": "lap1_s", "higher_is_better": false,
      "effects": [{"factor": "/stacks/elm/params/decay", "main": 0.62, "total": 0.7, "levels": []},
                  {"factor": "/stacks/elm/params/mu", "main": 0.1, "total": 0.12, "levels": []}],
      "best": [{"levels": ["0.98", "0.7"], "median": 7.21, "lo": 7.2, "hi": 7.3, "runs": 3, "p": 1}]},
     {"name": "pace", "higher_is_better": true, "seeds_share": 0.05,
      "effects": [{"factor": "/stacks/elm/params/mu", "main": 0.4, "total": 0.5, "levels": []}],
      "best": [{"levels": ["0.9", "0.8"], "median": 2.5, "runs": 3}]}]})");
  data["responses"][0]["seeds_share"] = seeds_share;
  return data;
}

TEST(ReportSweepPage, LeadsWithWhatMattersAndTheBestSetting) {
  const std::string page = sweep_page(sweep(0.08));
  const std::size_t lead = page.find(
      "lap1_s depends most on decay: 62 % of the variance, seeds 8 %; smallest, 7.21, with decay 0.98, mu 0.7.");
  ASSERT_NE(lead, page.npos) << page;
  EXPECT_LT(lead, page.find("12 of 12 runs"));
  EXPECT_THAT(page, HasSubstr("pace depends most on mu: 40 % of the variance, seeds 5 %; largest, 2.5, with"));
}

TEST(ReportSweepPage, SaysWhereSeedsMatterMoreThanSettings) {
  const std::string page = sweep_page(sweep(0.9));
  EXPECT_THAT(page, HasSubstr("lap1_s differs more between seeds (90 % of the variance) than by any setting"));
}

TEST(ReportSweepPage, TheFirstResponsesBestSettingsAreOpenTheOthersFolded) {
  const std::string page = sweep_page(sweep(0.08));
  EXPECT_THAT(page, HasSubstr("<h2>Best settings by lap1_s, smallest first</h2>"));
  EXPECT_THAT(page, HasSubstr("<details><summary>Best settings by pace, largest first</summary>"));
}

TEST(ReportSweepPage, WithoutFactorsNothingIsSaidOfThem) {
  EXPECT_THAT(sweep_page(nlohmann::json::parse(R"({"name": "x", "runs": 2, "finished": 2})")),
              Not(HasSubstr("depends most")));
}

}  // namespace test_report_sweep_page
}  // namespace gripline::report
