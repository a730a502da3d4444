#include "tables/cell_value.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_cell_value {

TEST(CellValue, TimesAndTruthsAreNumbers) {
  EXPECT_EQ(read_cell("1:02.5", false), 62.5);
  EXPECT_EQ(read_cell("2:01:02", false), 7262.0);
  EXPECT_EQ(read_cell("true", false), 1.0);
  EXPECT_EQ(read_cell("+3", false), 3.0);
  EXPECT_TRUE(std::isnan(read_cell("3 m", false)));
  EXPECT_TRUE(std::isnan(read_cell("1:2:3:4", false)));
}

TEST(CellValue, DatesAreSecondsSince1970) {
  EXPECT_EQ(read_cell("1970-01-02 00:00:01.5", false), 86401.5);
  EXPECT_EQ(read_cell("2018-04-08T10:31:37Z", false), 1523183497.0);
  EXPECT_EQ(read_cell("2018/04/08 12:31:37+02:00", false), 1523183497.0);
  EXPECT_EQ(read_cell("2018-04-08 08:31:37-02:00", false), 1523183497.0);
  EXPECT_TRUE(std::isnan(read_cell("2018-02-30 10:31:37", false)));
  EXPECT_EQ(read_cell("2018-04-08 12:31:37 +0200", false), 1523183497.0);
  EXPECT_EQ(read_cell("2018-04-08 12:31:37+02", false), 1523183497.0);
  EXPECT_EQ(read_cell("2018-04-08 10:31:37 UTC", false), 1523183497.0);
  EXPECT_EQ(read_cell("2018-04-08 10:31:37,5", false), 1523183497.5);
  EXPECT_TRUE(std::isnan(read_cell("2018-04-08 10", false)));
  EXPECT_TRUE(std::isnan(read_cell("2018-04-08 10:31", false)));
  EXPECT_TRUE(std::isnan(read_cell("2018-04-08 10:31:37+2", false)));
  EXPECT_TRUE(std::isnan(read_cell("2018-04-08 10:31:37 h", false)));
}

}  // namespace test_cell_value
}  // namespace gripline
