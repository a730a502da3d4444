#include "diagnose/real_logs/real_files.hpp"

#include <gtest/gtest.h>

#include "diagnose/real_logs/real_diagnosis.hpp"

namespace gripline::diagnose {
namespace test_diagnose_real_files {

Node json_of(const Cornering& corners) {
  const MissingEffects found;
  return real_diagnosis_json(real_diagnosis(found, {}, corners), found, corners);
}

TEST(RealFiles, UndersteerStandsWithTheGradientsOfTheWorlds) {
  Cornering corners;
  corners.by_log.emplace();
  corners.by_log->gradient = 0.001;
  corners.by_log->low = 0.0008;
  corners.by_log->high = 0.0012;
  corners.given = 0.0009;
  const Node json = json_of(corners);
  EXPECT_EQ(find_pointer(json, "/understeer/gradient")->number(), 0.001);
  EXPECT_EQ(find_pointer(json, "/understeer/ci95/1")->number(), 0.0012);
  EXPECT_EQ(find_pointer(json, "/understeer/given")->number(), 0.0009);
  EXPECT_TRUE(find_pointer(json, "/understeer/found")->is_null());
  EXPECT_TRUE(json.find("understeer_reason")->is_null());
}

TEST(RealFiles, AnUndersteerThatIsNotToldHasItsReason) {
  Cornering corners;
  corners.why_not = "they are short";
  const Node json = json_of(corners);
  EXPECT_TRUE(json.find("understeer")->is_null());
  EXPECT_EQ(json.find("understeer_reason")->text(), "they are short");
}

TEST(RealFiles, TheReportHasTheCalibratedParameters) {
  MissingEffects found;
  for (const char* pointer : {"/plant/params/Dr", "/calibration/observer/yaw"}) {
    calibrate::FittedParameter& one = found.parameters.emplace_back();
    one.unknown.pointer = pointer;
    one.unknown.prior = 6500.0;
    one.unknown.observer = one.unknown.pointer.starts_with("/calibration");
    one.value = 5084.0;
    one.interval.low = 4901.0;
    one.interval.high = 5273.0;
  }
  const Node report =
      real_report(real_diagnosis(found, {}, {}), found, "w.json", Registry(std::vector<std::filesystem::path>()), {});
  ASSERT_EQ(report.find("calibrated")->array().size(), 1u);
  EXPECT_EQ(find_pointer(report, "/calibrated/0/param")->text(), "/plant/params/Dr");
  EXPECT_EQ(find_pointer(report, "/calibrated/0/given")->number(), 6500.0);
  EXPECT_EQ(find_pointer(report, "/calibrated/0/found")->number(), 5084.0);
  EXPECT_EQ(find_pointer(report, "/calibrated/0/ci95/1")->number(), 5273.0);
}

}  // namespace test_diagnose_real_files
}  // namespace gripline::diagnose
