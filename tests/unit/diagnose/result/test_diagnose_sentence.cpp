#include "diagnose/result/sentence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_sentence {

using testing::HasSubstr;
using testing::StartsWith;

Diagnosis unknown_with(double closure) {
  Diagnosis d;
  d.verdict = Verdict::unknown;
  d.unknown.emplace();
  d.unknown->where = Where::state;
  d.gap = {1.0, 4.0, 2.5, closure, 0.8 * closure, 1.1 * closure};
  return d;
}

/// What was found leads, with how much it closes; that something is missing comes after it.
TEST(DiagnoseSentence, RefittedParametersLeadWhereNothingIsNamed) {
  Diagnosis d = unknown_with(0.5);
  d.nominal_fit = {{"Df", 0.19}, {"Br", 3.2}};
  const std::string text = sentence(d);
  EXPECT_THAT(text,
              StartsWith("Refitted are Df = 0.19, Br = 3.2: on data not fitted the 1 s prediction error goes from "
                         "4 to 2.5 sensor standard deviations (50 % of the gap, 40 to 55)"));
  EXPECT_THAT(text, HasSubstr(". Beside that something is missing that no effect of the catalogue explains"));
}

TEST(DiagnoseSentence, NothingLeadsWhereNothingCloses) {
  Diagnosis d = unknown_with(0.0);
  d.nominal_fit = {{"Df", 0.19}};
  EXPECT_THAT(sentence(d), StartsWith("Something is missing that no effect of the catalogue explains; it shows "));
}

TEST(DiagnoseSentence, AWrongChannelIsNamedWithHowWrongItIs) {
  Diagnosis d = unknown_with(0.0);
  d.unknown->where = Where::reading;
  d.unknown->quantity = "vy";
  d.wrong_channel = ChannelError{measured::Channel::vy, 0.174, 0.03};
  EXPECT_EQ(
      sentence(d),
      "Something is missing that no effect of the catalogue explains; it shows in the readings: those of vy disagree "
      "with the others by 0.174 m/s, slowly, 5.8 times the noise that is stated.");
}

/// Words begin with a capital where a sentence does, and nowhere else; ids of effects never do.
TEST(DiagnoseSentence, HasCapitalsWhereSentencesBegin) {
  Diagnosis d;
  d.verdict = Verdict::indistinguishable;
  NamedEffect& offset = d.named.emplace_back();
  offset.effect = "yawrate_bias";
  offset.measurement = true;
  offset.params = {{"b", "rad/s", 0.05, 0.04, 0.06}};
  d.equivalent = {{"yawrate_bias"}, {"steer_offset"}};
  d.manoeuvre = "drive straight on";
  EXPECT_THAT(sentence(d), HasSubstr("2 explanations; in the measurement yawrate_bias (b = 0.05 rad/s) fits best: "));
  d.verdict = Verdict::named;
  EXPECT_THAT(sentence(d), StartsWith("In the measurement yawrate_bias (b = 0.05 rad/s) is missing: "));
  NamedEffect drag;
  drag.effect = "aero_drag";
  drag.params = {{"a", "1", 0.4, 0.3, 0.5}};
  d.named.insert(d.named.begin(), drag);
  EXPECT_THAT(sentence(d),
              StartsWith("aero_drag (a = 0.4) and in the measurement yawrate_bias (b = 0.05 rad/s) are missing"));
}

TEST(DiagnoseSentence, ALateChannelLeadsWithWhatItCloses) {
  Diagnosis d = unknown_with(0.5);
  NamedEffect& late = d.delays.emplace_back();
  late.effect = "yaw_rate_delay";
  late.params = {{"T", "s", 0.12, 0.11, 0.13}};
  EXPECT_THAT(sentence(d),
              StartsWith("The yaw-rate channel is 0.12 s late (0.11 to 0.13). With this delay taken off the log, "
                         "on data"));
}

Diagnosis named(double before, double after, double closure, ErrorChange change) {
  Diagnosis d;
  d.verdict = Verdict::named;
  NamedEffect& drag = d.named.emplace_back();
  drag.effect = "aero_drag";
  drag.params = {{"a", "m/s2", 0.72, 0.7, 0.74}};
  drag.confidence = 0.9;
  d.gap = d.named_gap = {1.0, before, after, closure, closure, closure, change};
  return d;
}

TEST(DiagnoseSentence, ANameSaysWhatItCloses) {
  EXPECT_EQ(
      sentence(named(8.0, 1.0, 0.99, {-0.9, -0.95, -0.8})),
      "aero_drag (a = 0.72 m/s2) is missing: with it on data not fitted the 1 s prediction error goes from 8 to 1 "
      "sensor standard deviations (99 % of the gap, 99 to 99); confidence 0.9.");
}

/// A name whose gap does not close more than chance is not said to close it.
TEST(DiagnoseSentence, SaysWhereOnlyFittedDataSpeakForAName) {
  EXPECT_EQ(sentence(named(1.144, 1.141, 0.0, {-0.003, -0.01, 0.01})),
            "aero_drag (a = 0.72 m/s2) is missing: the fitted data show it, 1 s predictions of data not fitted do not "
            "change significantly (1.14 sensor standard deviations, 1.14 with it); confidence 0.9.");
}

TEST(DiagnoseSentence, SaysWhereTooLittleIsHeldOutForAnInterval) {
  EXPECT_EQ(sentence(named(11.0, 1.04, 0.0, {-0.9})),
            "aero_drag (a = 0.72 m/s2) is missing: the 1 s prediction error on data not fitted is 11 sensor standard "
            "deviations, 1.04 with it, of too little data for an interval; confidence 0.9.");
}

/// What refitted parameters and delays close is not the name's.
TEST(DiagnoseSentence, ANameIsCreditedBesideRefittedParametersAndDelays) {
  Diagnosis d = named(1.3, 1.1, 0.7, {-0.15, -0.2, -0.1});
  d.gap.before = 8.9;
  d.nominal_fit = {{"Df", 0.19}};
  EXPECT_THAT(sentence(d), HasSubstr("goes from 1.3 to 1.1 sensor standard deviations (70 % of the gap, 70 to 70); 8.9 "
                                     "before parameters were refitted; confidence"));
  NamedEffect& late = d.delays.emplace_back();
  late.effect = "yaw_rate_delay";
  late.params = {{"T", "s", 0.12, 0.11, 0.13}};
  EXPECT_THAT(sentence(d), HasSubstr("; 8.9 before parameters were refitted and delays taken off; confidence"));
}

}  // namespace test_diagnose_sentence
}  // namespace gripline::diagnose
