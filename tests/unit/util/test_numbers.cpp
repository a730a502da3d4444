#include "util/numbers.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "support/comma_locale.hpp"

namespace gripline {
namespace test_numbers {

TEST(Numbers, AsPrintfWritesThem) {
  EXPECT_EQ(format("plain"), "plain");
  EXPECT_EQ(format("%s: %.1f m of %d, %zu %%", "road", 2.5, 3, std::size_t{4}), "road: 2.5 m of 3, 4 %");
  EXPECT_EQ(significant(1234.5678), "1.23e+03");
  EXPECT_EQ(significant(1234.5678, 6), "1234.57");
}

TEST(Numbers, LongTextsStayWhole) {
  for (const std::size_t length : {0, 299, 300, 301, 5000}) {
    const std::string name(length, 'x');
    EXPECT_EQ(format("%s is %g m long", name.c_str(), 0.5), name + " is 0.5 m long");
  }
}

using NumbersInCommaLocale = testing_support::InCommaLocale;

TEST_F(NumbersInCommaLocale, HavePoints) {
  EXPECT_EQ(format("%.2f", 1.5), "1.50");
  EXPECT_EQ(significant(0.125), "0.125");
  // Only what it writes: the process keeps its locale.
  char text[8];
  std::snprintf(text, sizeof text, "%.1f", 1.5);
  EXPECT_STREQ(text, "1,5");
}

}  // namespace test_numbers
}  // namespace gripline
