#include "report/columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gripline::report {
namespace test_report_columns {

TEST(ReportColumns, ReadsNumbersTextsAndQuotes) {
  const Columns table = Columns::parse("stack,v,w\n\"a,\"\"b\"\"\",1.5,\nplain,-2e3,x\n", true);
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.text("stack", 0), "a,\"b\"");
  EXPECT_EQ(table.text("stack", 1), "plain");
  EXPECT_EQ(table.number("v", 1), -2000);
  EXPECT_TRUE(std::isnan(table.number("w", 0)));
  EXPECT_TRUE(std::isnan(table.number("w", 1)));
  EXPECT_TRUE(std::isnan(table.number("absent", 0)));
  EXPECT_TRUE(table.numbers("absent").empty());
}

TEST(ReportColumns, ALineCutOffWhileWritingIsDropped) {
  EXPECT_EQ(Columns::parse("t,x\n0,1\n0.1,2\n0.2,3.14").rows(), 2u);
  EXPECT_EQ(Columns::parse("t,x\r\n0,1\r\n").number("x", 0), 1);
  EXPECT_EQ(Columns::parse("").rows(), 0u);
}

}  // namespace test_report_columns
}  // namespace gripline::report
