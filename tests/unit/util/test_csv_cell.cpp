#include "util/csv_cell.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_csv_cell {

TEST(CsvCell, PlainTextStaysAsItIs) {
  for (const char* text : {"", "elm", "a b", "0.5", "it's"}) EXPECT_EQ(csv_cell(text), text);
}

TEST(CsvCell, SeparatorsAndQuotesAreQuoted) {
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_cell("say \"go\""), "\"say \"\"go\"\"\"");
  EXPECT_EQ(csv_cell("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(csv_cell("cr\r"), "\"cr\r\"");
}

}  // namespace test_csv_cell
}  // namespace gripline
