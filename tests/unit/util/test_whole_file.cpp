#include "util/whole_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"
#include "support/power_loss.hpp"
#include "support/small_disk.hpp"

namespace gripline {
namespace test_whole_file {

using testing::AnyOf;
using testing::HasSubstr;
using namespace testing_support;

TEST(WriteFile, IsWholeOrAbsent) {
  const Folder folder;
  write_file(folder / "t.json", "first");
  write_file(folder / "t.json", "second");
  EXPECT_EQ(contents(folder / "t.json"), "second");
  EXPECT_FALSE(std::filesystem::exists(folder / "t.json.partial"));
  EXPECT_THROW(write_file(folder / "no_folder/t.json", "x"), std::runtime_error);
}

TEST(WriteFile, WhereTheDiskIsFullWhatStoodThereStays) {
  const Folder folder;
  write_file(folder / "t.json", "first");
  for (const std::size_t room : {std::size_t{0}, std::size_t{3}, std::size_t{6}}) {  // 6: all of it, and no sync
    SmallDisk small(room);
    const ScopedDisk use(small);
    try {
      write_file(folder / "t.json", "second");
      FAIL() << "written";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(room < 6 ? "t.json: No space left on device" : "t.json: Input/output error"));
    }
    EXPECT_EQ(contents(folder / "t.json"), "first");
    EXPECT_FALSE(std::filesystem::exists(folder / "t.json.partial"));
  }
}

/// What somebody laid where the file aside is made is not written through.
TEST(WriteFile, FollowsNoLinkWhereTheFileAsideIsMade) {
  const Folder folder;
  write_text(folder / "precious", "mine");
  std::filesystem::create_symlink(folder / "precious", folder / "t.json.partial");
  write_file(folder / "t.json", "words");
  EXPECT_EQ(contents(folder / "precious"), "mine");
  EXPECT_EQ(contents(folder / "t.json"), "words");
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "t.json"));
}

/// Its folder is synced too: a file that was finished is there after a power failure.
TEST(WholeFile, InPiecesIsWholeOrAsBefore) {
  const Folder folder;
  std::filesystem::create_directories(folder / "out");
  RecordingDisk recording(folder / "out");
  {
    const ScopedDisk use(recording);
    write_file(folder / "out/t.txt", "before");
    WholeFile file(folder / "out/t.txt");
    file.write("one ");
    file.write("two");
    EXPECT_EQ(contents(folder / "out/t.txt"), "before");
    file.finish();
  }
  for (const Survives survives : {Survives::everything, Survives::names, Survives::synced}) {
    for (const RecordingDisk::Files& files : recording.all_left(0, survives)) {
      const auto file = files.find("t.txt");
      if (file == files.end()) continue;
      EXPECT_THAT(file->second, AnyOf("before", "one two"));
    }
    EXPECT_EQ(recording.left_after(recording.calls(), survives).at("t.txt"), "one two");
  }
}

TEST(WholeFile, OfOneThatIsNotFinishedNothingIsLeft) {
  const Folder folder;
  {
    WholeFile file(folder / "t.txt");
    file.write("half");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

/// A link stays a link, and what it names is written, there already or not.
TEST(WriteFile, FollowsLinksToWhatTheyName) {
  namespace fs = std::filesystem;
  const Folder folder;
  fs::create_directory(folder / "real");
  fs::create_symlink("real/t.json", folder / "inner.json");
  fs::create_symlink(folder / "inner.json", folder / "outer.json");
  for (const char* text : {"first", "second"}) {
    write_file(folder / "outer.json", text);
    EXPECT_EQ(contents(folder / "real/t.json"), text);
    EXPECT_TRUE(fs::is_symlink(folder / "outer.json") && fs::is_symlink(folder / "inner.json"));
    EXPECT_FALSE(fs::exists(folder / "real/t.json.partial"));
  }
}

/// A device is written to; a file renamed over it would take its place for everyone.
TEST(WriteFile, NeverTakesThePlaceOfADevice) {
  namespace fs = std::filesystem;
  const Folder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_file(pipe, "words");
  char words[16] = "";
  EXPECT_EQ(read(reader, words, sizeof words), 5);
  EXPECT_STREQ(words, "words");
  close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
  ASSERT_TRUE(fs::is_character_file("/dev/full")) << "no such device here";
  fs::create_symlink("/dev/full", folder / "full");
  EXPECT_THROW(write_file(folder / "full", "words"), std::runtime_error);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

}  // namespace test_whole_file
}  // namespace gripline
