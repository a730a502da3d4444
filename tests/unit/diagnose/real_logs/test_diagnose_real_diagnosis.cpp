#include "diagnose/real_logs/real_diagnosis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {
namespace test_diagnose_real_diagnosis {

using testing::StartsWith;

/// A search that named one effect, which halves what calibration leaves.
MissingEffects found_one() {
  MissingEffects found;
  found.given = 3.0;
  found.calibrated = 2.0;
  found.found = 1.0;
  found.noise = 0.5;
  found.calibration = {-1.0 / 3.0, -0.4, -0.3, 0.999};
  found.change = {-0.5, -0.6, -0.4, 0.999};
  found.all = {-2.0 / 3.0, -0.75, -0.5, 0.999};
  found.named.push_back(
      {calibrate::added_effect("steer_offset"), false, {{"d0", "rad", 0.03, 0.02, 0.04, -0.2, 0.2}}, found.change});
  found.remainder = {"speed", true, 2.0, 0.6};
  return found;
}

TEST(RealGap, IsClosedByWhatIsTakenOffBeyondTheSensorsNoise) {
  const Gap gap = real_gap(found_one());
  EXPECT_EQ(gap.horizon, 1.0);
  EXPECT_EQ(gap.before, 3.0);
  EXPECT_EQ(gap.after, 1.0);
  EXPECT_NEAR(gap.closure, 2.0 / 2.5, 1e-12);
  EXPECT_NEAR(gap.closure_low, 1.5 / 2.5, 1e-12);
  EXPECT_NEAR(gap.closure_high, 2.25 / 2.5, 1e-12);
}

TEST(RealGap, NoErrorBelowTheNoiseClosesMoreThanAll) {
  MissingEffects found = found_one();
  found.found = 0.4;
  EXPECT_EQ(real_gap(found).closure, 1.0);
}

TEST(RealGap, IsNotClosedWhereTheErrorIsNoSmaller) {
  MissingEffects found = found_one();
  found.found = 3.1;
  found.all = {0.03, -0.2, 0.2, 0.4};
  const Gap gap = real_gap(found);
  EXPECT_EQ(gap.closure, 0.0);
  EXPECT_EQ(gap.closure_low, 0.0);
  EXPECT_GT(gap.closure_high, 0.0);
}

TEST(RealDiagnosis, NamesEffectsBesideAnUnknown) {
  MissingEffects found = found_one();
  found.named.front().params.front().value = 0.2;
  const Diagnosis d = real_diagnosis(found, {}, {});
  EXPECT_EQ(d.verdict, Verdict::unknown);
  ASSERT_EQ(d.named.size(), 1u);
  EXPECT_EQ(d.named.front().effect, "steer_offset");
  EXPECT_EQ(d.named.front().confidence, thresholds::most_beside_unknown);
  EXPECT_TRUE(d.named.front().rollout.helps());
  ASSERT_EQ(d.named.front().params.size(), 1u);
  EXPECT_EQ(d.named.front().params.front().at_end, "high");
  EXPECT_THAT(d.sentence, StartsWith("Calibrating the world takes "));
  found.named.front().change.certainty = 0.3;
  EXPECT_EQ(real_diagnosis(found, {}, {}).named.front().confidence, 0.3);
}

TEST(RealDiagnosis, SaysWhereTheRestShows) {
  MissingEffects found = found_one();
  for (const auto& [of, where] : {std::pair("time", Where::time),
                                  {"throttle", Where::input},
                                  {"steering", Where::input},
                                  {"speed", Where::state},
                                  {"yaw rate", Where::state}}) {
    found.remainder.of = of;
    const Diagnosis d = real_diagnosis(found, {}, {});
    ASSERT_TRUE(d.unknown) << of;
    EXPECT_EQ(d.unknown->where, where) << of;
    EXPECT_EQ(d.unknown->quantity, of);
  }
}

TEST(RealDiagnosis, RanksWhatWasNotTriedWithoutAnErrorOfItsOwn) {
  MissingEffects found = found_one();
  found.ranking = {{"steer_offset", 0.4, true, 1.2, {-0.4, -0.5, -0.3, 0.99}}, {"air_drag", 0.1, false, 0.0, {}}};
  const Diagnosis d = real_diagnosis(found, {}, {});
  ASSERT_EQ(d.ranking.size(), 2u);
  EXPECT_EQ(d.ranking[0].held_out, 1.2);
  EXPECT_EQ(d.ranking[0].selected_fraction, 0.99);
  EXPECT_TRUE(std::isnan(d.ranking[1].held_out));
  EXPECT_EQ(d.ranking[1].selected_fraction, 0.0);
  EXPECT_EQ(d.ranking[0].less_error, 0.4);
  EXPECT_FALSE(d.ranking[0].gain.has_value());
}

TEST(RealDiagnosis, ListsTheModelsOwnParametersAndNoOthers) {
  MissingEffects found = found_one();
  for (const char* pointer : {"/plant/params/Bf", "/plant/effects/steer_offset/params/d0", "/calibration/delays/yaw"}) {
    calibrate::FittedParameter& one = found.parameters.emplace_back();
    one.unknown.pointer = pointer;
    one.value = 4.0;
  }
  const Diagnosis d = real_diagnosis(found, {}, {});
  ASSERT_EQ(d.nominal_fit.size(), 1u);
  EXPECT_EQ(d.nominal_fit.front(), std::pair(std::string("Bf"), 4.0));
}

TEST(RealDiagnosis, DelaysOfChannelsAreErrorsOfMeasurement) {
  const std::vector<ChannelDelay> delays = {{3, 0.12, 0.1, 0.14}};
  const Diagnosis d = real_diagnosis(found_one(), delays, {});
  ASSERT_EQ(d.delays.size(), 1u);
  EXPECT_EQ(d.delays.front().effect, "yaw_rate_delay");
  EXPECT_TRUE(d.delays.front().measurement);
  EXPECT_EQ(d.delays.front().params.front().value, 0.12);
  EXPECT_THAT(d.sentence, StartsWith("The yaw-rate channel is 0.12 s late (0.1 to 0.14). "));
}

TEST(RealDiagnosis, IsAnAnswerWhereSomethingNamedHelpsOrNothingIsLeft) {
  MissingEffects found = found_one();
  const auto answered = [&] { return is_answer(real_diagnosis(found, {}, {}), found); };
  EXPECT_TRUE(answered());
  found.found = 3.1;
  EXPECT_FALSE(answered()) << "named, but the error is no smaller";
  found.found = 1.0;
  found.named.clear();
  EXPECT_FALSE(answered()) << "nothing is named";
  found.noise = 1.0;
  EXPECT_TRUE(answered()) << "nothing is left beside noise";
}

}  // namespace test_diagnose_real_diagnosis
}  // namespace gripline::diagnose
