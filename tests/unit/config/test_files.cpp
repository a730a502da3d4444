#include "config/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/scratch.hpp"

namespace gripline {
namespace test_files {

namespace fs = std::filesystem;

TEST(Files, OnlyThoseReadAsAWholeHaveALargestSize) {
  const fs::path file = testing_support::scratch("large.bin");
  std::ofstream(file) << "x";
  fs::resize_file(file, max_file_size);  // a hole: it takes no room
  EXPECT_EQ(why_unreadable(file), "");
  fs::resize_file(file, max_file_size + 1);
  EXPECT_EQ(why_unreadable(file), "is larger than 256 MB");
  EXPECT_EQ(why_unopenable(file), "");
  fs::remove(file);
  EXPECT_THAT(why_unopenable(file), testing::StartsWith("no such file"));
  EXPECT_EQ(why_unopenable(file.parent_path()), "is a folder, expected a file");
}

TEST(Files, ANameWithoutItsEndingIsThatOfTheFileWithIt) {
  const fs::path folder = testing_support::scratch("endings");
  fs::create_directories(folder);
  for (const char* name : {"exp.json", "exq", "road.csv"}) std::ofstream(folder / name) << "x";
  EXPECT_EQ(why_unopenable(folder / "exp"), "no such file; did you mean \"exp.json\"?");
  EXPECT_EQ(why_unopenable(folder / "road"), "no such file; did you mean \"road.csv\"?");
  EXPECT_EQ(why_unopenable(folder / "exx"), "no such file; did you mean \"exq\"?");
}

}  // namespace test_files
}  // namespace gripline
