#include "util/shared_array.hpp"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>

namespace gripline {
namespace test_shared_array {

struct Counter {
  std::atomic<int> value{7};
};

TEST(SharedArray, ValuesAreMadeOnceForAll) {
  SharedArray<Counter> counters(1000);
  ASSERT_EQ(counters.size(), 1000u);
  for (std::size_t i = 0; i < counters.size(); ++i) ASSERT_EQ(counters[i].value.load(), 7);
}

TEST(SharedArray, WhatAForkWritesIsReadAfterItsEnd) {
  SharedArray<Counter> counters(3);
  const pid_t pid = fork();
  if (pid == 0) {
    counters[2].value.store(42);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  EXPECT_EQ(counters[1].value.load(), 7);
  EXPECT_EQ(counters[2].value.load(), 42);
}

TEST(SharedArray, MayBeEmpty) { EXPECT_EQ(SharedArray<Counter>(0).size(), 0u); }

}  // namespace test_shared_array
}  // namespace gripline
