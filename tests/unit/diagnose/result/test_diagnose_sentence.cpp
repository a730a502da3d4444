#include "diagnose/result/sentence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace {

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

TEST(DiagnoseSentence, ALateChannelLeadsWithWhatItCloses) {
  Diagnosis d = unknown_with(0.5);
  NamedEffect& late = d.delays.emplace_back();
  late.effect = "yaw_rate_delay";
  late.params = {{"T", "s", 0.12, 0.11, 0.13}};
  EXPECT_THAT(sentence(d),
              StartsWith("The yaw-rate channel is 0.12 s late (0.11 to 0.13). With this delay taken off the log, "
                         "on data"));
}

/// A name whose gap does not close more than chance is not said to close it.
TEST(DiagnoseSentence, SaysWhereOnlyFittedDataSpeakForAName) {
  Diagnosis d;
  d.verdict = Verdict::named;
  NamedEffect& drag = d.named.emplace_back();
  drag.effect = "aero_drag";
  drag.confidence = 0.9;
  d.gap = {1.0, 1.144, 1.141, 0.0, 0.0, 0.0};
  EXPECT_THAT(sentence(d), HasSubstr("the data fitted say so, 1 s predictions of those not fitted cannot tell (1.14 "
                                     "sensor standard deviations without, 1.14 with); confidence 0.9."));
  d.gap.closure = 0.5;
  EXPECT_THAT(sentence(d), HasSubstr("on data not fitted the 1 s prediction error goes from"));
}

}  // namespace
}  // namespace gripline::diagnose
