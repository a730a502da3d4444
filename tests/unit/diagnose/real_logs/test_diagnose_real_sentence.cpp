#include "diagnose/real_logs/real_sentence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_real_sentence {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

MissingEffects found_with(std::initializer_list<const char*> names) {
  MissingEffects found;
  found.given = 3.0;
  found.calibrated = 2.0;
  found.found = 1.0;
  found.noise = 0.5;
  found.calibration = {-1.0 / 3.0, -0.4, -0.3, 0.999};
  found.change = {-0.5, -0.6, -0.4, 0.999};
  for (const char* name : names)
    found.named.push_back({calibrate::added_effect(name), false, {{"k", "1", 0.3, 0.2, 0.4, 0.0, 1.0}}, {}});
  return found;
}

std::string text_of(const MissingEffects& found, const Diagnosis& d = {}) { return real_sentence(d, found, {}); }

TEST(RealSentence, SaysWhatCalibrationTakesOffAndWhatIsLeft) {
  EXPECT_EQ(
      text_of(found_with({})),
      "Calibrating the world takes 33 % (30 % to 40 %) off the error of predictions 1 s ahead of time that was not "
      "fitted. The normalised error that remains, 1 where sensor noise alone would leave 0.5, is unexplained: no "
      "effect that was tried reduces it by enough, or with enough certainty, to be named.");
}

TEST(RealSentence, ListsEffectsWithTheirValues) {
  EXPECT_THAT(text_of(found_with({"drag"})),
              HasSubstr("not fitted; drag (k = 0.3) takes 50 % (40 % to 60 %) off what is left then. "));
  EXPECT_THAT(text_of(found_with({"drag", "bank", "lag"})),
              HasSubstr("; drag (k = 0.3), bank (k = 0.3) and lag (k = 0.3) take 50 % "));
  EXPECT_THAT(text_of(found_with({"drag"})), HasSubstr("is unexplained: no other effect that was tried"));
}

TEST(RealSentence, SaysThatCalibrationTookNothingOff) {
  MissingEffects found = found_with({});
  found.calibrated = 3.1;
  EXPECT_THAT(text_of(found), StartsWith("Calibrating the world does not reduce the error of predictions 1 s ahead"));
}

TEST(RealSentence, EndsWhereNothingIsLeftBesideNoise) {
  MissingEffects found = found_with({});
  found.noise = 1.0;
  EXPECT_THAT(text_of(found),
              EndsWith(". The normalised error that remains, 1, is as large as the sensors' own noise (1): "
                       "these logs show nothing more."));
}

TEST(RealSentence, SaysNothingOfSensorsWhoseNoiseIsNotKnown) {
  MissingEffects found = found_with({});
  found.noise = 0.0;
  EXPECT_THAT(text_of(found), HasSubstr("The normalised error that remains, 1, is unexplained: no effect"));
}

/// One channel that is wrong drowns in the sum of all.
TEST(RealSentence, DoesNotEndWhereOneChannelIsFarAboveItsNoise) {
  MissingEffects found = found_with({});
  found.noise = 1.0;
  found.largest_over_noise = {"vy", 9.2};
  EXPECT_THAT(text_of(found),
              EndsWith("that remains, 1, is in sum as large as the sensors' own noise (1), but the error of vy is 9.2 "
                       "times its sensor's noise and unexplained: no effect that was tried reduces it by enough, or "
                       "with enough certainty, to be named."));
  found.largest_over_noise = {"vy", 2.0};
  EXPECT_TRUE(found.at_noise());
}

/// Predictions cannot be better than their readings' noise: it is the noise that is wrong, and nothing is unexplained.
TEST(RealSentence, SaysThatANoiseAboveTheErrorIsMeasuredTooLarge) {
  MissingEffects found = found_with({});
  found.noise = 1.4;
  EXPECT_THAT(
      text_of(found),
      EndsWith("The normalised error that remains, 1, is less than sensor noise alone would leave by these logs "
               "(1.4): their noise is measured too large (motion passes for it), and whether more is missing is "
               "not told by it; no effect that was tried reduces it by enough, or with enough certainty, to be "
               "named."));
}

TEST(RealSentence, SaysWhatTheWorstStartsHaveInCommon) {
  MissingEffects found = found_with({});
  const auto with = [&](const Remainder& rest) {
    found.remainder = rest;
    return text_of(found);
  };
  EXPECT_THAT(with({"speed", true, 2.0, 0.61}),
              EndsWith("; 61 % of it lies in the third of the time with the largest speed (from 2 m/s)."));
  EXPECT_THAT(with({"steering", false, -0.2, 0.61}),
              EndsWith("; 61 % of it lies in the third with the smallest steering to the left (up to -0.2 rad)."));
  EXPECT_THAT(with({"throttle", true, 0.5, 0.61}), EndsWith(" the largest throttle (from 0.5)."));
  EXPECT_THAT(with({"time", true, 9.0, 0.61}), EndsWith("; 61 % of it lies in the third of the time at the end."));
  EXPECT_THAT(with({"time", false, 9.0, 0.61}), EndsWith("; 61 % of it lies in the third at the beginning."));
}

TEST(RealSentence, DelaysComeFirst) {
  Diagnosis d;
  d.delays.resize(2);
  d.delays[0].effect = "yaw_rate_delay";
  d.delays[0].params = {{"T", "s", 0.12, 0.1, 0.14}};
  d.delays[1].effect = "position_delay";
  d.delays[1].params = {{"T", "s", 0.08, 0.07, 0.09}};
  EXPECT_THAT(
      text_of(found_with({}), d),
      StartsWith("The yaw-rate channel is 0.12 s late (0.1 to 0.14). The position channels are 0.08 s late (0.07 "
                 "to 0.09). Calibrating"));
}

TEST(RealSentence, CornersAreToldWhereTheLogsTell) {
  const MissingEffects found = found_with({});
  Cornering corners;
  EXPECT_THAT(real_sentence({}, found, corners), Not(HasSubstr("corners")));
  corners.by_log.emplace();
  corners.by_log->gradient = 0.001;
  corners.by_log->low = 0.0008;
  corners.by_log->high = 0.0012;
  EXPECT_THAT(real_sentence({}, found, corners), HasSubstr("In gentle corners the car understeers by "));
}

}  // namespace test_diagnose_real_sentence
}  // namespace gripline::diagnose
