#include "util/file_hashes.hpp"

#include <gtest/gtest.h>

#include "config/hash.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_file_hashes {

using namespace testing_support;
namespace fs = std::filesystem;

TEST(FileHashes, AreKeptAndAnEditIsNoticed) {
  const Folder folder;
  const fs::path file = folder / "road.csv";
  write_text(file, "1,2\n");
  FileHashes hashes;
  EXPECT_FALSE(hashes.unchanged(file)) << "it was never asked for";
  const std::string before = hashes.of(file);
  EXPECT_EQ(before, sha256_of_file(file));
  EXPECT_TRUE(hashes.unchanged(file));
  write_text(file, "1,3,4\n");
  EXPECT_EQ(hashes.of(file), before);
  EXPECT_FALSE(hashes.unchanged(file));
  fs::remove(file);
  EXPECT_FALSE(hashes.unchanged(file));
}

TEST(FileHashes, AreOfTheFileAsItIsWhereThatIsAsked) {
  const Folder folder;
  const fs::path file = folder / "steps.csv";
  FileHashes hashes;
  EXPECT_EQ(hashes.now(file), "") << "no such file";
  write_text(file, "1,2\n");
  const std::string before = hashes.now(file);
  EXPECT_EQ(before, sha256_of_file(file));
  EXPECT_EQ(hashes.now(file), before);
  write_text(file, "1,3,4\n");
  EXPECT_EQ(hashes.now(file), sha256_of_file(file));
  EXPECT_NE(hashes.now(file), before);
  EXPECT_EQ(hashes.of(file), hashes.now(file)) << "from then on that is what is known";
  EXPECT_TRUE(hashes.unchanged(file));
  fs::remove(file);
  EXPECT_EQ(hashes.now(file), "");
}

}  // namespace test_file_hashes
}  // namespace gripline
