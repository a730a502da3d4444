#include "diagnose/result/verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_verdict {

using testing::SizeIs;

/// What is left unexplained outweighs every name; a manoeuvre that is to decide, a name of what fits best.
TEST(Verdict, FollowsFromWhatIsLeftAndWhatIsNamed) {
  Explanation e;
  const std::vector<NamedEffect> none, late(1);
  EXPECT_EQ(verdict_of(e, none), Verdict::nothing_missing);
  EXPECT_EQ(verdict_of(e, late), Verdict::named) << "a delay is something that was missing";
  e.named.resize(1);
  EXPECT_EQ(verdict_of(e, none), Verdict::named);
  e.equivalent = {{"drive_gain"}, {"motor_lag"}};
  EXPECT_EQ(verdict_of(e, none), Verdict::named) << "two names of one thing: no manoeuvre tells them apart";
  e.manoeuvre = "drive straight on";
  EXPECT_EQ(verdict_of(e, none), Verdict::indistinguishable);
  EXPECT_EQ(verdict_of(e, late), Verdict::indistinguishable);
  e.unknown.emplace();
  EXPECT_EQ(verdict_of(e, none), Verdict::unknown);
  EXPECT_EQ(verdict_of(e, late), Verdict::unknown);
  e.named.clear();
  EXPECT_EQ(verdict_of(e, none), Verdict::unknown);
}

TEST(Verdict, HeadsWhatWasFound) {
  Findings found;
  found.named.resize(2);
  found.gap.before = 3.0;
  found.health.resize(1);
  const Diagnosis d = assemble(found, std::vector<NamedEffect>(1));
  EXPECT_EQ(d.verdict, Verdict::named);
  EXPECT_THAT(d.named, SizeIs(2));
  EXPECT_THAT(d.delays, SizeIs(1));
  EXPECT_EQ(d.gap.before, 3.0);
  EXPECT_THAT(d.health, SizeIs(1));
  EXPECT_TRUE(d.sentence.empty());
}

}  // namespace test_diagnose_verdict
}  // namespace gripline::diagnose
