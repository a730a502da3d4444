#include "tables/delimited_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "config/errors.hpp"
#include "support/scratch.hpp"

namespace gripline {
namespace test_delimited_table {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::scratch;

DelimitedTable read(const std::string& text) {
  const auto file = scratch("table.csv");
  std::ofstream(file, std::ios::binary) << text;
  return read_delimited(file);
}

std::string why(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "read";
}

std::string rows(const char* line, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += line;
  return out;
}

TEST(DelimitedTable, ReadsAPlainCsv) {
  const auto t = read("t_s,x_m\n0,1.5\n0.1,\n0.2,nan\n0.3,-2e-3\n");
  EXPECT_THAT(t.name, ElementsAre("t_s", "x_m"));
  ASSERT_EQ(t.rows(), 4u);
  EXPECT_EQ(t.column[1][0], 1.5);
  EXPECT_TRUE(std::isnan(t.column[1][1]));
  EXPECT_TRUE(std::isnan(t.column[1][2]));
  EXPECT_EQ(t.column[1][3], -2e-3);
  EXPECT_EQ(t.line[3], 5);
  EXPECT_TRUE(t.found.empty());
}

TEST(DelimitedTable, ReadsAPreambleQuotesAndARowOfUnits) {  // as MoTeC writes
  const auto t = read(
      "\"Format\",\"MoTeC CSV File\"\n\"Venue\",\"Somewhere, far\"\n\"Beacon\",\"1\"\n\n"
      "\"Time\",\"Ground Speed\",\"Steered Angle\"\n\"s\",\"km/h\",\"deg\"\n" +
      rows("\"0.00\",\"36.0\",\"-1.5\"\n", 6));
  EXPECT_THAT(t.name, ElementsAre("Time", "Ground Speed", "Steered Angle"));
  EXPECT_THAT(t.unit, ElementsAre("s", "km/h", "deg"));
  EXPECT_TRUE(t.unit_row);
  EXPECT_EQ(t.rows(), 6u);
  EXPECT_EQ(t.column[1][5], 36.0);
}

TEST(DelimitedTable, APreambleAsLongAsTheHeaderIsNone) {  // as RaceChrono writes: units and sources below the header
  const auto t =
      read("Format,3,,\nCreated,1/2/2024,12:21,\n\ntimestamp,lap,speed,angle\nunix time,,m/s,deg\n,,100: gps,calc\n" +
           rows("1.5,1,20,3\n", 6));
  EXPECT_THAT(t.name, ElementsAre("timestamp", "lap", "speed", "angle"));
  EXPECT_THAT(t.unit, ElementsAre("unix time", "", "m/s", "deg"));
  EXPECT_EQ(t.rows(), 6u);
}

TEST(DelimitedTable, ReadsSemicolonsWithDecimalCommas) {
  const auto t = read("Zeit;Weg\n" + rows("0,25;-1,5\n", 5));
  EXPECT_THAT(t.name, ElementsAre("Zeit", "Weg"));
  EXPECT_EQ(t.column[0][0], 0.25);
  EXPECT_EQ(t.column[1][4], -1.5);
  EXPECT_THAT(t.found, testing::Contains("decimal commas"));
}

TEST(DelimitedTable, ReadsTabsUnitsInNamesAndCommentLines) {
  const auto t = read("# made by hand\nTime (s)\tSpeed [km/h]\n0\t3\n# in between\n1\t4\n2\t5\n");
  EXPECT_THAT(t.name, ElementsAre("Time", "Speed"));
  EXPECT_THAT(t.unit, ElementsAre("s", "km/h"));
  EXPECT_EQ(t.rows(), 3u);
}

TEST(DelimitedTable, ReadsAHeaderBehindACommentSign) {  // the racetrack files of TU Munich
  const auto t = read("# x_m,y_m,w_tr_right_m\n" + rows("1.0,2.0,3.5\n", 5));
  EXPECT_THAT(t.name, ElementsAre("x_m", "y_m", "w_tr_right_m"));
}

TEST(DelimitedTable, RowsOfAnotherLengthAreLeftOutAndSaid) {
  const auto t = read("a,b\n1,2\n3\n4,5\n6,7,8\n9,10\n11,12\n");
  EXPECT_EQ(t.rows(), 4u);
  EXPECT_THAT(t.found, testing::Contains("2 rows of another length, left out"));
}

TEST(DelimitedTable, RowsMayLackEmptyCellsAtTheirEnd) {
  const auto t = read("a,b,c\n1,2\n1,2,3\n1,2,3\n4,5\n1,2,3\n1,2,3\n6,7");
  ASSERT_EQ(t.rows(), 6u);  // the last line may have been cut off
  EXPECT_THAT(t.name, ElementsAre("a", "b", "c"));
  EXPECT_EQ(t.column[1][3], 5.0);
  EXPECT_TRUE(std::isnan(t.column[2][0]));
  EXPECT_THAT(t.found,
              ElementsAre("2 rows lack cells at their end, taken for empty", "1 rows of another length, left out"));
  const auto mostly = read("a,b,c\n" + rows("1,2\n1,2\n1,2,3\n", 20));
  EXPECT_THAT(mostly.name, ElementsAre("a", "b", "c"));
  ASSERT_EQ(mostly.rows(), 60u);
  EXPECT_EQ(mostly.column[2][2], 3.0);
}

/// A row whose first cells are empty begins with the separator, which a tab is too.
TEST(DelimitedTable, FirstCellsMayBeEmpty) {
  for (const char separator : {',', '\t', ';'}) {
    std::string text = "a,b,c\n" + rows("1,2,3\n,5,6\n,,9\n", 10);
    std::replace(text.begin(), text.end(), ',', separator);
    const auto t = read(text);
    EXPECT_THAT(t.name, ElementsAre("a", "b", "c")) << separator;
    ASSERT_EQ(t.rows(), 30u) << separator;
    EXPECT_TRUE(std::isnan(t.column[0][1])) << separator;
    EXPECT_EQ(t.column[1][1], 5.0) << separator;
    EXPECT_TRUE(std::isnan(t.column[1][2])) << separator;
    EXPECT_EQ(t.column[2][2], 9.0) << separator;
  }
  const auto mostly = read("a\tb\tc\n" + rows("\t2\t3\n\t2\t3\n1\t2\t3\n", 20));
  EXPECT_THAT(mostly.name, ElementsAre("a", "b", "c"));
  EXPECT_EQ(mostly.column[0][2], 1.0);
}

TEST(DelimitedTable, ACommentBelowTheHeaderHoldsItsUnits) {
  const auto t = read("t,x\n# s,m\n" + rows("1.0,2.0\n", 6));
  EXPECT_THAT(t.name, ElementsAre("t", "x"));
  EXPECT_THAT(t.unit, ElementsAre("s", "m"));
}

TEST(DelimitedTable, ACommentBelowAPreambleIsTheHeader) {
  const auto t = read("Driver,me\n# time,vx\n" + rows("1.0,2.0\n", 6));
  EXPECT_THAT(t.name, ElementsAre("time", "vx"));
}

TEST(DelimitedTable, LettersThatEndWithTheByteOfABlankStayWhole) {
  const auto t = read("t,Vitesse \xc3\xa0,\xc2\xa0x\xc2\xa0\n" + rows("1.0,2.0,3.0\n", 6));
  EXPECT_THAT(t.name, ElementsAre("t", "Vitesse \xc3\xa0", "x"));
}

TEST(DelimitedTable, QuotedCellsMayHaveDecimalCommas) {
  const auto t = read("t,x\n" + rows("\"0,25\",\"-1,5\"\n", 6));
  EXPECT_EQ(t.column[0][0], 0.25);
  EXPECT_EQ(t.column[1][5], -1.5);
  const auto thousands = read("t,x,y\n" + rows("1,\"1,234\",2\n", 6));
  EXPECT_TRUE(std::isnan(thousands.column[1][0]));
}

TEST(DelimitedTable, CellsThatAreNoNumbersAreCounted) {
  const auto t = read("t,x,y\n1,2,3\n1,3 m,\n1,4 m,nan\n" + rows("1,2,3\n", 6));
  ASSERT_EQ(t.unread.size(), 3u);
  EXPECT_EQ(t.unread[1].cells, 2u);
  EXPECT_EQ(t.unread[1].first, "3 m");
  EXPECT_EQ(t.unread[1].line, 3);
  EXPECT_EQ(t.unread[2].cells, 0u);
}

TEST(DelimitedTable, TwoColumnsOfOneNameAreToldApart) {
  EXPECT_THAT(read("a,a,\n1,2,3\n1,2,3\n").name, ElementsAre("a", "a_2", "column_3"));
}

TEST(DelimitedTable, RefusesWhatIsNoTable) {
  EXPECT_THAT(why(""), HasSubstr("the file is empty"));
  EXPECT_THAT(why("\xff\xfe"
                  "1,2\n"),
              HasSubstr("UTF-16"));
  EXPECT_THAT(why(std::string("a,b\n1,2\0\n", 10)), HasSubstr("not a text"));
  EXPECT_THAT(why("one\ntwo\nthree\n"), HasSubstr("no separator"));
  EXPECT_THAT(why("a,b\nc,d\ne,f\n"), HasSubstr("no row of numbers"));
  EXPECT_THAT(why("1,2\n3,4\n5,6\n"), HasSubstr("no header line"));
}

TEST(DelimitedTable, LinesOfTheHeaderAndOfTheFirstRowOfAnotherLengthAreKept) {
  const auto t = read("a logger\n\nt,x,y\n1,2,3\n1,2,3,4\n1,2,3\n1,2,3,4\n" + rows("1,2,3\n", 6));
  EXPECT_EQ(t.header_line, 3);
  EXPECT_EQ(t.other_length, 5);
  EXPECT_EQ(read("t,x\n" + rows("1,2\n", 6)).other_length, 0);
}

/// What import writes of a bag has names of array elements.
TEST(DelimitedTable, ANumberInABracketIsAnElementAndNoUnit) {
  const auto t = read("time,/joints.position[3],/joints.speed[m/s]\n0,1,2\n1,2,3\n2,3,4\n");
  EXPECT_THAT(t.name, ElementsAre("time", "/joints.position[3]", "/joints.speed"));
  EXPECT_THAT(t.unit, ElementsAre("", "", "m/s"));
  const auto shares = read("time [s],Throttle [1],Brake (1)\n0,1,2\n1,2,3\n2,3,4\n");
  EXPECT_THAT(shares.name, ElementsAre("time", "Throttle", "Brake"));
  EXPECT_THAT(shares.unit, ElementsAre("s", "1", "1"));
}

TEST(DelimitedTable, ABagOfRosIsToldFromATable) {
  EXPECT_THAT(why("#ROSBAG V2.0\nE"), HasSubstr("the file is a bag of ROS"));
  EXPECT_THAT(why("SQLite format 3\n"), HasSubstr("gripline import BAG --map MAP --table FILE.csv"));
}

/// As Excel saves a CSV where decimals are written with commas.
TEST(DelimitedTable, ReadsWindows1252) {
  const auto t = read("Zeit [s];Gierrate [\xb0/s]\n" + rows("0,02;-3,9\n", 6));
  EXPECT_THAT(t.unit, ElementsAre("s", "\xc2\xb0/s"));
  EXPECT_THAT(t.found, testing::Contains(HasSubstr("Windows-1252")));
}

}  // namespace test_delimited_table
}  // namespace gripline
