#include "util/csv_writer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>
#include <locale>

#include "support/host_support.hpp"
#include "util/csv.hpp"
#include "util/disk.hpp"

namespace gripline {
namespace test_csv_writer {

using testing::HasSubstr;
using namespace testing_support;

TEST(CsvWriter, WritesNumbersWordsAndEmptyCells) {
  const Folder folder;
  {
    CsvWriter csv(folder / "t.csv", "a,b,c,d");
    csv << 0.1 << 3 << "elm" << NAN;
    csv.end_row();
    csv << -1e-300 << std::int64_t{1234567890123456789} << std::string_view() << 1e22;
    csv.end_row();
  }
  EXPECT_EQ(contents(folder / "t.csv"), "a,b,c,d\n0.1,3,elm,\n-1e-300,1234567890123456789,,1e+22\n");
}

TEST(CsvWriter, EveryBitOfANumberComesBack) {
  const Folder folder;
  const std::vector<double> numbers = {
      0.1, 1.0 / 3.0, -5e-324, std::numeric_limits<double>::max(), 123456789.12345678, 0.30000000000000004, -0.0};
  {
    CsvWriter csv(folder / "t.csv", "x");
    for (const double number : numbers) {
      csv << number;
      csv.end_row();
    }
  }
  EXPECT_EQ(read_csv(folder / "t.csv").values, numbers);
}

/// A process that dies between two rows has every complete row in its file, and no half one.
TEST(CsvWriter, ARowReachesTheFileWhenItEnds) {
  const Folder folder;
  CsvWriter csv(folder / "t.csv", "x,y");
  EXPECT_EQ(contents(folder / "t.csv"), "x,y\n");
  csv << 1.0 << 2.0;
  csv.end_row();
  csv << 3.0;
  EXPECT_EQ(contents(folder / "t.csv"), "x,y\n1,2\n");
}

TEST(CsvWriter, AFullDiskIsToldWithItsReason) {
  const std::filesystem::path full = "/dev/full";
  if (!std::filesystem::exists(full)) GTEST_SKIP() << "no such device here";
  try {
    CsvWriter csv(full, "x");
    FAIL() << "written";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "cannot write /dev/full: No space left on device");
  }
}

TEST(CsvWriter, AFileThatCannotBeMadeIsToldWithItsReason) {
  const Folder folder;
  try {
    CsvWriter csv(folder / "no_folder/t.csv", "x");
    FAIL() << "written";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no_folder/t.csv: No such file or directory"));
  }
}

TEST(WriteFile, IsWholeOrAbsent) {
  const Folder folder;
  write_file(folder / "t.json", "first");
  write_file(folder / "t.json", "second");
  EXPECT_EQ(contents(folder / "t.json"), "second");
  EXPECT_FALSE(std::filesystem::exists(folder / "t.json.partial"));
  EXPECT_THROW(write_file(folder / "no_folder/t.json", "x"), std::runtime_error);
}

/// A disk that has no room for more than so many bytes, and may not know how to sync.
class SmallDisk final : public Disk {
 public:
  explicit SmallDisk(std::size_t room) : room_(room) {}
  bool write(int handle, std::string_view bytes) override {
    const std::size_t fits = std::min(bytes.size(), room_);
    room_ -= fits;
    if (Disk::write(handle, bytes.substr(0, fits)) && fits == bytes.size()) return true;
    errno = ENOSPC;
    return false;
  }
  bool sync(int) override {
    errno = EIO;
    return room_ > 0;
  }

 private:
  std::size_t room_;
};

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

TEST(CsvWriter, FinishesOnTheDiskOrSaysWhyNot) {
  const Folder folder;
  CsvWriter good(folder / "good.csv", "x");
  good << 1;
  good.end_row();
  good.finish();
  EXPECT_EQ(contents(folder / "good.csv"), "x\n1\n");
  SmallDisk small(2);
  const ScopedDisk use(small);
  CsvWriter full(folder / "full.csv", "x");
  EXPECT_THROW(full.finish(), std::runtime_error);
}

TEST(CsvWriter, WritesToATextAsToAFile) {
  std::string text = "before\n";
  CsvWriter csv(text, "x,y");
  csv << 1.5 << "a";
  csv.end_row();
  EXPECT_EQ(text, "before\nx,y\n1.5,a\n");
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

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  std::string do_grouping() const override { return "\3"; }
  char do_thousands_sep() const override { return '.'; }
};

TEST(CsvWriter, DoesNotDependOnTheLocale) {
  const Folder folder;
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  {
    CsvWriter csv(folder / "t.csv", "x,y");
    csv << 1234.5 << 1234567;
    csv.end_row();
  }
  std::locale::global(before);
  EXPECT_EQ(contents(folder / "t.csv"), "x,y\n1234.5,1234567\n");
}

}  // namespace test_csv_writer
}  // namespace gripline
