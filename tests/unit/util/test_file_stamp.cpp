#include "util/file_stamp.hpp"

#include <gtest/gtest.h>

#include "support/host_support.hpp"

namespace gripline {
namespace test_file_stamp {

using namespace testing_support;
namespace fs = std::filesystem;

TEST(FileStamp, ChangesWithSizeTimeAndPlace) {
  const Folder folder;
  const fs::path file = folder / "t.csv", other = folder / "other.csv";
  EXPECT_FALSE(stamp_of(file));
  write_text(file, "1,2\n");
  const auto before = stamp_of(file);
  const auto time = fs::last_write_time(file);
  ASSERT_TRUE(before);
  EXPECT_EQ(stamp_of(file), before);
  write_text(file, "1,2,3\n");
  fs::last_write_time(file, time);
  EXPECT_NE(stamp_of(file), before) << "another size";
  write_text(file, "1,3\n");
  fs::last_write_time(file, time + std::chrono::milliseconds(1));
  EXPECT_NE(stamp_of(file), before) << "another time";
  write_text(other, "1,2\n");
  fs::last_write_time(other, time);
  fs::rename(other, file);
  EXPECT_NE(stamp_of(file), before) << "another file";
}

}  // namespace test_file_stamp
}  // namespace gripline
