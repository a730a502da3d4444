#include "util/numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>
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

TEST(Numbers, AreRoundedToSignificantDigits) {
  EXPECT_NEAR(rounded(1234.5678, 6), 1234.57, 1e-9);
  EXPECT_NEAR(rounded(-0.00123456, 3), -0.00123, 1e-15);
  EXPECT_NEAR(rounded(9.9996, 4), 10.0, 1e-12);
  EXPECT_EQ(rounded(0.0, 6), 0.0);
  EXPECT_TRUE(std::isnan(rounded(not_a_number, 6)));
  EXPECT_TRUE(std::isinf(rounded(-INFINITY, 6)));
}

TEST(Numbers, AreReadFromWholeTexts) {
  EXPECT_EQ(parse_number("2.5"), 2.5);
  EXPECT_EQ(parse_number("-1e3"), -1000.0);
  EXPECT_EQ(parse_number("inf"), INFINITY);
  for (const char* text : {"", " 1", "1 ", "+1", "1x", "x", "1,5", "1e999"}) EXPECT_FALSE(parse_number(text)) << text;
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
