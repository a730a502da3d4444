#include "util/clock.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace gripline {
namespace {

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

}  // namespace
}  // namespace gripline
