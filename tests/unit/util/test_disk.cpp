#include "util/disk.hpp"

#include <gtest/gtest.h>

#include <cerrno>

namespace gripline {
namespace test_disk {

/// What plugins can do to their process is not the disk's fault.
TEST(FailWithErrno, TellsTheDisksReasonsFromOthers) {
  const auto is_of_disk = [](int reason) {
    errno = reason;
    try {
      fail_with_errno("cannot write x");
    } catch (const DiskError& error) {
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  };
  for (const int reason : {ENOSPC, EDQUOT, EIO, EROFS}) EXPECT_TRUE(is_of_disk(reason)) << reason;
  for (const int reason : {EBADF, ENOENT, EFBIG, EMFILE}) EXPECT_FALSE(is_of_disk(reason)) << reason;
}

TEST(FailWithErrno, SaysWhatAndWhy) {
  errno = ENOSPC;
  try {
    fail_with_errno("cannot write x");
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "cannot write x: No space left on device");
  }
}

}  // namespace test_disk
}  // namespace gripline
