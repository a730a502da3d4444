#include "config/ascii.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_ascii {

TEST(Trim, TakesBlanksOffBothEndsOnly) {
  EXPECT_EQ(trim(" \t a b\r"), "a b");
  EXPECT_EQ(trim("a"), "a");
  EXPECT_EQ(trim(" \t\r "), "");
  EXPECT_EQ(trim(""), "");
  EXPECT_EQ(trim("\na"), "\na") << "none of the usual ones";
}

TEST(Trim, TakesThoseItIsTold) {
  EXPECT_EQ(trim(" a\t ", " "), "a\t");
  EXPECT_EQ(trim("\n a\v", " \t\n\r\f\v"), "a");
}

TEST(LowerCase, LeavesAllButAsciiLetters) {
  EXPECT_EQ(lower_case('Z'), 'z');
  EXPECT_EQ(lower_case('@'), '@');
  EXPECT_EQ(lower_case('['), '[');
  EXPECT_EQ(lower_case(std::string("GPX-9 \xc3\x84 x")), "gpx-9 \xc3\x84 x");
}

}  // namespace test_ascii
}  // namespace gripline
