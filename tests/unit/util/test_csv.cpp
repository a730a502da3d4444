#include "util/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <locale>

#include "support/host_support.hpp"

namespace gripline {
namespace test_csv {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using namespace testing_support;

class Csv : public testing::Test {
 protected:
  CsvTable read(std::string_view text, bool allow_missing = false) {
    write_text(folder_ / "t.csv", text);
    return read_csv(folder_ / "t.csv", allow_missing);
  }
  /// The message behind the file's name.
  std::string why(std::string_view text, bool allow_missing = false) {
    const std::string message = refusal([&] { (void)read(text, allow_missing); });
    const auto at = message.find("t.csv");
    return at == std::string::npos ? message : message.substr(at);
  }
  Folder folder_;
};

TEST_F(Csv, ReadsNumbersUnderNames) {
  const CsvTable table = read("x_m, y_m,z\n1,2,-3.5e-2\n4,5,6\n");
  EXPECT_THAT(table.header, ElementsAre("x_m", "y_m", "z"));
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.at(0, 2), -0.035);
  EXPECT_THAT(table.column("y_m"), ElementsAre(2, 5));
  EXPECT_EQ(table.find("z"), 2);
  EXPECT_EQ(table.find("w"), -1);
  EXPECT_THAT(table.line, ElementsAre(2, 3));
}

TEST_F(Csv, AcceptsWindowsLinesCommentsBlanksAndNoLastNewline) {
  const CsvTable table = read("# x,y\r\n1,2\r\n\r\n# a remark\r\n 3 ,\t4");
  EXPECT_THAT(table.header, ElementsAre("x", "y"));
  EXPECT_THAT(table.values, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(table.line, ElementsAre(2, 5));
}

TEST_F(Csv, AByteOrderMarkIsNoLetterOfTheFirstColumn) {
  const CsvTable table = read("\xef\xbb\xbf# x,y\n1,2\n");
  EXPECT_THAT(table.header, ElementsAre("x", "y"));
  EXPECT_THAT(table.values, ElementsAre(1, 2));
  EXPECT_EQ(why("\xef\xbb\xbfx;y\n"), "t.csv:1:2: columns are separated by ';' here; expected ','");
}

TEST_F(Csv, OtherEncodingsAndLineEndsAreNamed) {
  const std::string utf16("\xff\xfex\0,\0y\0\n\0", 10);
  EXPECT_EQ(why(utf16), "t.csv:1:1: is UTF-16; expected UTF-8 (iconv -f UTF-16 -t UTF-8)");
  EXPECT_EQ(why("x,y\r1,2\r"), "t.csv:1:1: lines end with carriage returns alone; expected newlines (tr '\\r' '\\n')");
  EXPECT_EQ(read("x,y\r").rows(), 0u);  // one line is one line
}

TEST_F(Csv, RemarksMayStandBeforeTheHeader) {
  for (const char* text : {"# made by me\n# x,y\n1,2\n", "# made by me\nx,y\n1,2\n", "# x,y\n# made by me\n1,2\n"}) {
    const CsvTable table = read(text);
    EXPECT_THAT(table.header, ElementsAre("x", "y")) << text;
    EXPECT_THAT(table.values, ElementsAre(1, 2)) << text;
  }
  EXPECT_EQ(read("# x,y\nnan,nan\n", true).rows(), 1u);
  EXPECT_THAT(why("# x,y\n# of me\n1,2,3\n"), HasSubstr("t.csv:3:5: expected 2 columns as in the header, found 3"));
}

TEST_F(Csv, APlusIsASign) {
  EXPECT_THAT(read("x,y\n+1.5,-2\n").values, ElementsAre(1.5, -2));
  EXPECT_EQ(why("x\n+-1\n"), "t.csv:2:1: expected a finite number, found \"+-1\"");
  EXPECT_EQ(why("x\n+\n"), "t.csv:2:1: expected a finite number, found \"+\"");
}

TEST_F(Csv, TabsAreNoCommas) {
  EXPECT_EQ(why("# x\ty\n1\t2\n"), "t.csv:1:4: columns are separated by tabs here; expected ','");
  EXPECT_EQ(read("x,\ty\n1,\t2\n").rows(), 1u);
}

TEST_F(Csv, MissingCellsOnlyWhereTheyAreAllowed) {
  EXPECT_EQ(why("a,b\n1,\n"), "t.csv:2:3: expected a finite number, found \"\"");
  EXPECT_EQ(why("a,b\nnan,1\n"), "t.csv:2:1: expected a finite number, found \"nan\"");
  const CsvTable table = read("a,b\n1,\nnan,2\n", true);
  EXPECT_TRUE(std::isnan(table.at(0, 1)));
  EXPECT_TRUE(std::isnan(table.at(1, 0)));
  EXPECT_EQ(table.at(1, 1), 2);
}

TEST_F(Csv, ALastRowThatIsCutIsLeftOutWhereThatIsAllowed) {
  const auto cut = [&](std::string_view text) {
    write_text(folder_ / "t.csv", text);
    return read_csv(folder_ / "t.csv", true, true);
  };
  for (const char* text : {"a,b\n1,2\n3", "a,b\n1,2\n3,-", "a,b\n1,2\n3\n\n"}) {
    EXPECT_THAT(cut(text).values, ElementsAre(1, 2)) << text;
    EXPECT_EQ(cut(text).cut_line, 3) << text;
  }
  EXPECT_EQ(cut("a,b\n1,2\n3,4").cut_line, 0);
  EXPECT_EQ(cut("a,b\n1,2\n3,").rows(), 2u);
  EXPECT_THAT(refusal([&] { (void)cut("a,b\n1\n3,4\n"); }), HasSubstr("expected 2 columns"));
}

TEST_F(Csv, RefusalsSayLineAndColumn) {
  EXPECT_EQ(why("a,b\n1,2\n3,x\n"), "t.csv:3:3: expected a finite number, found \"x\"");
  EXPECT_EQ(why("a,b\n1,inf\n"), "t.csv:2:3: expected a finite number, found \"inf\"");
  EXPECT_EQ(why("a,b\n1,2 m\n"), "t.csv:2:3: expected a finite number, found \"2 m\"");
  EXPECT_EQ(why("a,b\n1,0x10\n"), "t.csv:2:3: expected a finite number, found \"0x10\"");
  EXPECT_EQ(why("a,b\n1\n"), "t.csv:2:2: expected 2 columns as in the header, found 1");
  EXPECT_EQ(why("a,b\n1,5,2,5\n"),
            "t.csv:2:5: expected 2 columns as in the header, found 4 (is the decimal sign a comma? expected '.')");
  EXPECT_EQ(why("a;b\n1;2\n"), "t.csv:1:2: columns are separated by ';' here; expected ','");
  EXPECT_EQ(why("# a;b\n1;2\n"), "t.csv:1:4: columns are separated by ';' here; expected ','");
  EXPECT_EQ(why("a,b\n  1, \xc3\xa4\n"), "t.csv:2:6: expected a finite number, found \"\xc3\xa4\"");
  EXPECT_EQ(why("a,b\n \xc3\xa4,2;3\n", true).substr(0, 9), "t.csv:2:2");
  EXPECT_EQ(why("a,b\n1, 2;4\n").substr(0, 9), "t.csv:2:5");
  EXPECT_EQ(why("a\n1;2\n"),
            "t.csv:2:2: columns are separated by ';' here; expected ',' between columns and '.' as the decimal sign");
  EXPECT_EQ(why(""), "t.csv:1:1: the file is empty; expected a header line and rows of numbers");
  EXPECT_EQ(why("\n\n"), "t.csv:1:1: the file is empty; expected a header line and rows of numbers");
  EXPECT_THAT(refusal([&] { (void)read_csv(folder_ / "absent.csv"); }), EndsWith("absent.csv: no such file"));
  EXPECT_THAT(refusal([&] { (void)read_csv(folder_.path()); }), HasSubstr("is a folder, expected a file"));
}

TEST_F(Csv, AMissingColumnNamesTheNearest) {
  const CsvTable table = read("x_m,yaw_rad\n1,2\n");
  EXPECT_THAT(refusal([&] { (void)table.column("yaw"); }), HasSubstr("no column \"yaw\""));
  EXPECT_THAT(refusal([&] { (void)table.column("x_n"); }), HasSubstr("did you mean \"x_m\"?"));
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST_F(Csv, DoesNotDependOnTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const CsvTable table = read("a\n1.5\n");
  std::locale::global(before);
  EXPECT_EQ(table.at(0, 0), 1.5);
}

}  // namespace test_csv
}  // namespace gripline
