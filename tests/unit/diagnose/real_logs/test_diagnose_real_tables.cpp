#include "diagnose/real_logs/real_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_real_tables {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

MissingEffects found_one(const std::string& log) {
  MissingEffects found;
  found.named.push_back(
      {calibrate::added_effect("drag"), false, {{"k", "1", 0.3, 0.2, 0.4, 0.0, 1.0}}, {-0.5, -0.6, -0.4, 0.999}});
  found.sessions.push_back({log, 1.25, 0.5, {-0.6, -0.7, -0.5, 0.999}});
  return found;
}

TEST(RealTables, ALogsFiguresStandInTheirColumns) {
  EXPECT_EQ(sessions_table(found_one("/data/a.csv")),
            "\nlog                              calibrated  with effects   change, of time not fitted\n"
            "a.csv                                 1.250         0.500   -60.0 % (-70.0 to -50.0)\n");
}

TEST(RealTables, ALogWithALongNameKeepsItsFigures) {
  const std::string name(400, 'n');
  EXPECT_THAT(sessions_table(found_one("/data/" + name)),
              EndsWith("\n" + name + "      1.250         0.500   -60.0 % (-70.0 to -50.0)\n"));
}

TEST(RealTables, AnEffectStandsWithItsChangeAndItsValues) {
  EXPECT_EQ(named_table(found_one("a")),
            "\nmissing             predictions of time not fitted, beside the others\n"
            "drag                 -50.0 % (-60.0 to -40.0)   k = 0.3 (0.2 to 0.4)\n");
}

TEST(RealTables, NothingNamedHasNoTables) {
  MissingEffects found = found_one("a");
  found.named.clear();
  EXPECT_EQ(named_table(found), "");
  EXPECT_EQ(sessions_table(found), "");
  EXPECT_EQ(calibrated_table(found), "");
}

TEST(RealTables, WithoutAnEffectThatWasFittedAloneWordsSayWhy) {
  MissingEffects found;
  EXPECT_EQ(tried_table(found),
            "\nno effect was fitted alone: there is none that the world lacks and these logs could show\n");
  for (const auto& [effect, gain] : {std::pair("drag", 0.004), std::pair("steer_lag", 0.0071)})
    found.ranking.push_back({effect, gain, false, 0.0, {}});
  EXPECT_EQ(tried_table(found),
            "\nno effect was fitted alone: to first order none of 2 takes enough off the squared error, and the log's "
            "blocks of time agree on none (the most: steer_lag, 0.71 %)\n");
  found.ranking.front().tried = true;
  EXPECT_THAT(tried_table(found), StartsWith("\nalone  "));
}

TEST(RealTables, CalibratedAreNeitherTheObserversNorOfEffectsNamed) {
  MissingEffects found = found_one("a");
  for (const char* pointer : {"/plant/params/Bf", "/calibration/observer/yaw", "/plant/effects/drag/params/k"}) {
    calibrate::FittedParameter& one = found.parameters.emplace_back();
    one.unknown.pointer = pointer;
    one.unknown.prior = 5.0;
    one.unknown.observer = one.unknown.pointer.starts_with("/calibration");
    one.value = 4.0;
    one.interval.low = 3.0;
    one.interval.high = 4.5;
  }
  EXPECT_EQ(calibrated_table(found),
            "\ncalibrated                                         start      found   95 %\n"
            "/plant/params/Bf                                       5          4   3 to 4.5\n");
}

TEST(RealTables, SayWhyNothingIsSaidOfCorners) {
  Cornering corners;
  corners.why_not = "they are short";
  EXPECT_EQ(no_understeer(corners), "\nundersteer: not determined by these logs; they are short\n");
  corners.why_not.clear();
  EXPECT_EQ(no_understeer(corners), "");
}

TEST(RealTables, TriedStandByTheirGain) {
  MissingEffects found;
  found.ranking = {{"small", 0.1, true, 1.0, {0.02, 0.01, 0.03, 0.01}},
                   {"not_tried", 0.9, false, 0.0, {}},
                   {"large", 0.4, true, 1.0, {-0.3, -0.4, -0.2, 0.999}}};
  EXPECT_EQ(tried_table(found),
            "\nalone               squared error, fitted   predictions of the same logs' time not fitted\n"
            "large                           -40.0 %     -30.0 % (-40.0 to -20.0): helps\n"
            "small                           -10.0 %      +2.0 % (+1.0 to +3.0): harms\n");
}

}  // namespace test_diagnose_real_tables
}  // namespace gripline::diagnose
