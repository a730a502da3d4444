#include "util/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "support/host_support.hpp"

namespace gripline {
namespace test_temporary_folder {

namespace fs = std::filesystem;

TEST(TemporaryFolder, IsGoneWithItsFiles) {
  fs::path made;
  {
    const TemporaryFolder folder("test"), other("test");
    made = folder.path();
    EXPECT_NE(made, other.path());
    EXPECT_EQ(made.parent_path(), fs::temp_directory_path());
    EXPECT_TRUE(made.filename().string().starts_with("gripline_test_")) << made;
    EXPECT_TRUE(fs::is_empty(made));
    fs::create_directories(made / "a/b");
    std::ofstream(made / "a/b/file") << "x";
  }
  EXPECT_FALSE(fs::exists(made));
}

TEST(TemporaryFolder, SaysWhyThereIsNone) {
  const testing_support::Folder place;
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  setenv("TMPDIR", place.path().c_str(), 1);
  // The purpose is part of a name: a folder that is not there cannot hold the new one.
  std::string why;
  try {
    const TemporaryFolder folder("no/such");
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  before != nullptr ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  EXPECT_EQ(why.substr(0, why.find("_no/such")), "cannot make " + (place / "gripline").string());
  EXPECT_TRUE(why.ends_with(": No such file or directory")) << why;
  EXPECT_TRUE(fs::is_empty(place.path()));
}

}  // namespace test_temporary_folder
}  // namespace gripline
