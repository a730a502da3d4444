#include "util/made_folders.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "support/scratch.hpp"

namespace gripline {
namespace test_made_folders {

namespace fs = std::filesystem;
using testing_support::scratch;

TEST(MadeFolders, OnlyWhatWasMadeAndIsEmptyIsRemoved) {
  const fs::path root = scratch("made_folders");
  fs::remove_all(root);
  fs::create_directories(root / "there");
  std::error_code failed;
  make_folders(root / "there/a/b/", failed);
  make_folders(root / "full/c/d", failed);
  make_folders(root / "there", failed);
  EXPECT_FALSE(failed);
  EXPECT_TRUE(made_here(root / "there/a/b"));
  EXPECT_TRUE(made_here(root / "there/x/../a"));
  EXPECT_FALSE(made_here(root / "there"));
  std::ofstream(root / "full/result") << "x";
  remove_empty_made_folders();
  EXPECT_TRUE(fs::exists(root / "there"));
  EXPECT_FALSE(fs::exists(root / "there/a"));
  EXPECT_TRUE(fs::exists(root / "full/result"));
  EXPECT_FALSE(fs::exists(root / "full/c"));
  EXPECT_FALSE(made_here(root / "full")) << "forgotten once the command ended";
  fs::remove_all(root);
}

TEST(MadeFolders, WhatCannotBeMadeIsSaidAndItsParentsGo) {
  const fs::path root = scratch("made_folders_half");
  fs::remove_all(root);
  std::error_code failed;
  make_folders(root / "a" / std::string(300, 'x'), failed);
  EXPECT_TRUE(failed);
  remove_empty_made_folders();
  EXPECT_FALSE(fs::exists(root));
}

}  // namespace test_made_folders
}  // namespace gripline
