#include "util/child_process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <vector>

namespace gripline {
namespace test_child_process {

using testing::ElementsAre;

TEST(RunInChild, MessagesComeBack) {
  const ChildResult result = run_in_child(60, [](const SendMessage& send) {
    send("one");
    send("");
    send(std::string(300'000, 'x'));
  });
  EXPECT_TRUE(result.completed);
  EXPECT_EQ(result.failure, "");
  ASSERT_EQ(result.messages.size(), 3u);
  EXPECT_EQ(result.messages[0], "one");
  EXPECT_EQ(result.messages[2].size(), 300'000u);
}

TEST(RunInChild, AFailureIsDescribedAndEarlierMessagesCount) {
  const auto end_of = [](void (*work)()) {
    const ChildResult result = run_in_child(60, [&](const SendMessage& send) {
      send("begun");
      work();
    });
    EXPECT_FALSE(result.completed);
    EXPECT_THAT(result.messages, ElementsAre("begun"));
    return result.failure;
  };
  EXPECT_EQ(end_of([] { std::abort(); }), "was ended by signal 6 (Aborted)");
  EXPECT_EQ(end_of([] { _exit(0); }), "ended with exit code 0");
  EXPECT_EQ(end_of([] { _exit(3); }), "ended with exit code 3");
  EXPECT_EQ(end_of([] { throw std::runtime_error("no fuel"); }), "threw no fuel");
  EXPECT_EQ(end_of([] { throw 7; }), "threw something that is not a std::exception");
}

/// The signal that ended it is told apart from words that speak of one, and from the end that is made at a time limit.
TEST(RunInChild, TellsTheSignalThatEndedIt) {
  const auto signal_of = [](void (*work)(), double timeout_s = 60) {
    return run_in_child(timeout_s, [&](const SendMessage&) { work(); }).signal;
  };
  EXPECT_EQ(signal_of([] { std::raise(SIGKILL); }), SIGKILL);
  EXPECT_EQ(signal_of([] { throw std::runtime_error("was ended by signal 9 (Killed)"); }), 0);
  EXPECT_EQ(signal_of([] { _exit(3); }), 0);
  EXPECT_EQ(signal_of([] { pause(); }, 0.2), 0);
  EXPECT_TRUE(ends_from_outside(SIGKILL) && ends_from_outside(SIGTERM));
  EXPECT_FALSE(ends_from_outside(SIGSEGV) || ends_from_outside(0));
}

/// What libraries do at exit may wait for threads that the child does not have.
TEST(RunInChild, ExitEndsItAtOnce) {
  static const pid_t parent = getpid();
  std::atexit([] {
    while (getpid() != parent) pause();
  });
  const ChildResult result = run_in_child(20, [](const SendMessage&) { std::exit(3); });
  EXPECT_FALSE(result.completed);
  EXPECT_EQ(result.failure, "ended with exit code 3");
}

/// Busy, stopped, or with a child of its own that keeps the pipe open: given up after the same time.
TEST(RunInChild, OneThatNeverReturnsIsEndedWithAllItStarted) {
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
    const ChildResult result = run_in_child(0.3, [&](const SendMessage&) { work(); });
    EXPECT_EQ(result.failure, "did not come back within 0.3 s");
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

/// As `env --ignore-signal=CHLD` leaves it: the status of a child is still collected, and the setting is kept.
TEST(RunInChild, WorksWhereTheEndOfChildrenIsIgnored) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(run_in_child(60, [](const SendMessage&) { std::abort(); }).failure, "was ended by signal 6 (Aborted)");
  EXPECT_EQ(std::signal(SIGCHLD, before), SIG_IGN);
}

TEST(CollectIfEnded, GivesTheStatusOnceAndNothingBefore) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t pid = fork();
  if (pid == 0) {
    char byte = 0;
    close(ends[1]);
    _exit(read(ends[0], &byte, 1) == 0 ? 5 : 1);
  }
  EXPECT_FALSE(collect_if_ended(pid).has_value());
  close(ends[1]);
  std::optional<int> status;
  for (int i = 0; i < 10'000 && !status; ++i) {
    status = collect_if_ended(pid);
    if (!status) usleep(1000);
  }
  close(ends[0]);
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(describe_end(*status), "ended with exit code 5");
  EXPECT_EQ(collect_if_ended(pid), 0) << "collected already";
}

/// Where nothing is kept of children that end, waiting ends all the same.
TEST(WaitForEnd, HasAStatusUnlessTheEndOfChildrenIsIgnored) {
  const auto end = [] {
    const pid_t pid = fork_process();
    if (pid == 0) _exit(6);
    return wait_for_end(pid);
  };
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(end(), std::nullopt);
  {
    const UsualChildSignal kept;
    const std::optional<int> status = end();
    ASSERT_TRUE(status.has_value());
    EXPECT_EQ(describe_end(*status), "ended with exit code 6");
  }
  EXPECT_EQ(std::signal(SIGCHLD, before), SIG_IGN);
}

TEST(LimitData, AllocationsBeyondItFail) {
  const ChildResult result = run_in_child(60, [](const SendMessage& send) {
    limit_data(64);
    const std::vector<char> big(std::size_t{256} << 20U, 'x');
    send({big.data(), 1});
  });
  EXPECT_FALSE(result.completed);
  EXPECT_TRUE(result.messages.empty());
}

}  // namespace test_child_process
}  // namespace gripline
