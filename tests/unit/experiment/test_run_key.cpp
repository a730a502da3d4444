#include "experiment/run_key.hpp"

#include <gtest/gtest.h>

#include "config/hash.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_run_key {

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

}  // namespace test_run_key
}  // namespace gripline
