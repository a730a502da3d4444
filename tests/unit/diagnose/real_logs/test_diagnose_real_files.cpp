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

}  // namespace test_diagnose_real_files
}  // namespace gripline::diagnose
