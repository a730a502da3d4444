#include "util/machine.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

namespace gripline {
namespace test_machine {

TEST(ThisMachine, IsWhatTheKernelCallsIt) {
  std::ifstream in("/proc/sys/kernel/hostname");
  std::string name;
  std::getline(in, name);
  EXPECT_EQ(this_machine(), name);
}

/// A name with blanks and brackets changes nothing.
TEST(ProcessStart, StaysAndIsEarlierThanThatOfChildren) {
  const auto own = process_start(getpid());
  ASSERT_TRUE(own);
  char before[16] = "";
  prctl(PR_GET_NAME, before);
  prctl(PR_SET_NAME, "a) R 1 (b");
  EXPECT_EQ(process_start(getpid()), own);
  prctl(PR_SET_NAME, before);
  usleep(30'000);  // a few of the kernel's ticks, of 10 ms
  const pid_t child = fork();
  if (child == 0)
    while (true) pause();
  const auto later = process_start(child);
  ASSERT_TRUE(later);
  EXPECT_GT(*later, *own);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(process_start(child));
}

}  // namespace test_machine
}  // namespace gripline
