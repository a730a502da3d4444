#include "report/measured_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace gripline::report {
namespace test_report_measured_page {

using testing::HasSubstr;
using testing::Not;

nlohmann::json measured() {
  return nlohmann::json::parse(R"({"horizon_s": 1,
    "rows": [{"name": "persistence", "position_m": [0.9, 0.7, 1.1]}, {"name": "kinematic", "position_m": [1.1, 0.9, 1.3]},
             {"name": "fitted", "position_m": [0.223, 0.2, 0.25], "yaw_rad": [0.15, 0.14, 0.16]}],
    "ablations": [{"name": "cornering_drag", "position_m": [0.01, -0.001, 0.02]}],
    "parameters": [{"pointer": "/plant/params/Iz", "group": "inertia", "value": 0.0045, "low": 0.003, "high": 0.008,
                    "prior": 0.008, "status": "determined"}],
    "held_out": [{"log": "a.csv", "t_s": [0, 1], "predicted_x_m": [0, 1], "predicted_y_m": [0, 0],
                  "measured_x_m": [0, 1.2], "measured_y_m": [0, 0]}],
    "health": [{"log": "a.csv", "check": "rate", "found": "100 Hz", "done": ""},
               {"log": "a.csv", "check": "time", "found": "even", "done": ""}]})");
}

TEST(ReportMeasuredPage, LeadsWithWhatTheFitIsWorth) {
  const std::string page = measured_page(measured(), {}, {});
  const std::size_t lead = page.find(
      "The fitted model predicts where the car is 1 s ahead to 0.223 m (95 %: 0.2 to 0.25 m), in data that it was not "
      "fitted to; the best of the others, persistence, to 0.9 m.");
  ASSERT_NE(lead, page.npos) << page;
  EXPECT_LT(lead, page.find("<h2>"));
  EXPECT_LT(lead, page.find("<table>"));
}

TEST(ReportMeasuredPage, LogsParametersAndHealthAreFolded) {
  const std::string page = measured_page(measured(), {}, {});
  for (const char* title : {"Predictions of a.csv", "Parameters", "Health of the logs"}) {
    std::string folded = "<details><summary>";
    folded.append(title).append("</summary>");
    EXPECT_THAT(page, HasSubstr(folded));
  }
  // One table a log, not one line after the other of all logs.
  EXPECT_THAT(page, HasSubstr("<h2>a.csv</h2>"));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme:dark"));
}

TEST(ReportMeasuredPage, WithoutAFitNothingIsClaimed) {
  nlohmann::json data = measured();
  data["rows"].erase(2);
  EXPECT_THAT(measured_page(data, {}, {}), Not(HasSubstr("The fitted model")));
  EXPECT_THAT(measured_page(nlohmann::json::object(), {}, {}), Not(HasSubstr("<details>")));
}

}  // namespace test_report_measured_page
}  // namespace gripline::report
