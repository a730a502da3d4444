#include "plugin/guard.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gripline {
namespace test_guard {

TEST(LastCall, SaysWhereAProcessWas) {
  LastCall last;
  EXPECT_EQ(describe_place(last), "");
  last.note("elm", LastCall::Phase::being_made);
  EXPECT_EQ(describe_place(last), " while elm was made");
  last.note("elm", LastCall::Phase::made);
  EXPECT_EQ(describe_place(last), "; the plugin made last was elm");
  last.note_call("mpc_sqp", 0.4);
  EXPECT_EQ(describe_place(last), " at t = 0.400000 s; the plugin called last was mpc_sqp");
  last.note("mpc_sqp", LastCall::Phase::being_destroyed);
  EXPECT_EQ(describe_place(last), " while mpc_sqp was destroyed");
}

/// A stack without an estimator calls a plugin of no name.
TEST(LastCall, WhatHasNoNameIsNotNoted) {
  LastCall last;
  last.note_call("elm", 0.4);
  last.note_call("", 0.6);
  last.note("", LastCall::Phase::being_destroyed);
  EXPECT_EQ(describe_place(last), " at t = 0.400000 s; the plugin called last was elm");
}

TEST(LastCall, GuardNotesEveryCall) {
  LastCall last;
  LastCall* const before = last_call();
  last_call() = &last;
  guard("elm", 1.5, [] {});
  last_call() = before;
  EXPECT_EQ(describe_place(last), " at t = 1.500000 s; the plugin called last was elm");
}

TEST(SharedText, CutsWhatIsLonger) {
  SharedText text;
  text.set("elm");
  EXPECT_EQ(text.get(), "elm");
  char copied[64] = "";
  text.copy(copied, sizeof copied);
  EXPECT_STREQ(copied, "elm");
  text.set(std::string(100, 'x'));
  EXPECT_EQ(text.get(), std::string(63, 'x'));
  char few[4] = "";
  text.copy(few, sizeof few);
  EXPECT_STREQ(few, "xxx");
}

}  // namespace test_guard
}  // namespace gripline
