#include "util/clock.hpp"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <thread>

namespace gripline {
namespace test_clock {

/// Work whose time the compiler cannot leave out.
void work_until(double thread_s) {
  volatile double x = 1;
  while (thread_cpu_s() < thread_s)
    for (int i = 0; i < 1000; ++i) x = x * 1.0000001;
}

TEST(Clock, AThreadPaysForItselfAndTheProcessForAll) {
  const double process = process_cpu_s(), mine = thread_cpu_s();
  double of_other = 0;
  std::thread other([&] {
    work_until(0.02);
    of_other = thread_cpu_s();
  });
  other.join();
  EXPECT_GE(of_other, 0.02);
  EXPECT_GE(process_cpu_s() - process, 0.02);
  EXPECT_LT(thread_cpu_s() - mine, 0.02);
}

TEST(Clock, ChildrenPayForThemselvesOnceCollected) {
  const double before = children_cpu_s(), mine = process_cpu_s();
  const pid_t pid = fork();
  if (pid == 0) {
    work_until(thread_cpu_s() + 0.05);
    _exit(0);
  }
  ASSERT_EQ(waitpid(pid, nullptr, 0), pid);
  EXPECT_GE(children_cpu_s() - before, 0.04);
  EXPECT_LT(process_cpu_s() - mine, 0.04);
}

}  // namespace test_clock
}  // namespace gripline
