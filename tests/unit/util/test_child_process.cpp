#include "util/child_process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace gripline {
namespace {

using testing::ElementsAre;

TEST(AskChild, WhatItTellsComesBack) {
  const ChildAnswer answer = ask_child(60, [](const TellParent& tell) {
    tell("one");
    tell("");
    tell(std::string(300'000, 'x'));
  });
  EXPECT_TRUE(answer.complete);
  EXPECT_EQ(answer.end, "");
  ASSERT_EQ(answer.told.size(), 3u);
  EXPECT_EQ(answer.told[0], "one");
  EXPECT_EQ(answer.told[2].size(), 300'000u);
}

TEST(AskChild, ABadEndIsDescribedAndWhatWasToldCounts) {
  const auto end_of = [](void (*work)()) {
    const ChildAnswer answer = ask_child(60, [&](const TellParent& tell) {
      tell("begun");
      work();
    });
    EXPECT_FALSE(answer.complete);
    EXPECT_THAT(answer.told, ElementsAre("begun"));
    return answer.end;
  };
  EXPECT_EQ(end_of([] { std::abort(); }), "was ended by signal 6 (Aborted)");
  EXPECT_EQ(end_of([] { _exit(0); }), "ended with exit code 0");
  EXPECT_EQ(end_of([] { _exit(3); }), "ended with exit code 3");
  EXPECT_EQ(end_of([] { throw std::runtime_error("no fuel"); }), "threw no fuel");
  EXPECT_EQ(end_of([] { throw 7; }), "threw something that is not a std::exception");
}

/// Silent, stopped, or with a child of its own that holds the line open: given up after the same time.
TEST(AskChild, OneThatNeverComesBackIsEndedWithAllItStarted) {
  const auto begin = std::chrono::steady_clock::now();
  for (void (*work)() : {+[] {
                           for (volatile bool on = true; on;) continue;
                         },
                         +[] { std::raise(SIGSTOP); },
                         +[] {
                           if (fork() == 0)
                             while (true) pause();
                           while (true) pause();
                         }}) {
    const ChildAnswer answer = ask_child(0.3, [&](const TellParent&) { work(); });
    EXPECT_EQ(answer.end, "did not come back within 0.3 s");
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

/// As `env --ignore-signal=CHLD` leaves it: the end of a child is still heard of, and the setting is as it was.
TEST(AskChild, WorksWhereTheEndOfChildrenIsIgnored) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(ask_child(60, [](const TellParent&) { std::abort(); }).end, "was ended by signal 6 (Aborted)");
  EXPECT_EQ(std::signal(SIGCHLD, before), SIG_IGN);
}

}  // namespace
}  // namespace gripline
