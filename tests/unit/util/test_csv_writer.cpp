#include "util/csv_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <locale>

#include "support/host_support.hpp"
#include "support/small_disk.hpp"
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

TEST(CsvWriter, WritesATableThatAppearsWhenItsFileIsFinished) {
  const Folder folder;
  WholeFile file(folder / "t.csv");
  CsvWriter csv(file, "x");
  csv << 1;
  csv.end_row();
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
  file.finish();
  EXPECT_EQ(contents(folder / "t.csv"), "x\n1\n");
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
