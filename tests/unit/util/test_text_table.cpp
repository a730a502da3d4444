#include "util/text_table.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "support/comma_locale.hpp"

namespace gripline {
namespace test_text_table {

using namespace testing_support;

TEST(TextTable, ColumnsAreRightAlignedTheFirstOneLeft) {
  std::ostringstream out;
  print_aligned(out, {{"row", "lap [s]"}, {"best_body", "7.4"}, {"elm"}});
  EXPECT_EQ(out.str(), "row        lap [s]\nbest_body      7.4\nelm      \n");
}

TEST(TextTable, HugeNumbersAreShort) {
  EXPECT_EQ(cell_text(1.23456e55, "%.4f m"), "1.235e+55 m");
  EXPECT_EQ(cell_text(-2e7, "%+.3f"), "-2e+07");
  EXPECT_EQ(cell_text(999999.4, "%.2f s"), "999999.40 s");
  EXPECT_EQ(cell_text(1.5e7, "%.4g"), "1.5e+07");
}

using TextTableInCommaLocale = InCommaLocale;

TEST_F(TextTableInCommaLocale, CellsHavePoints) {
  EXPECT_EQ(cell_text(1.5, "%.2f s"), "1.50 s");
  EXPECT_EQ(cell_text(std::nullopt, "%.2f s"), "-");
}

}  // namespace test_text_table
}  // namespace gripline
