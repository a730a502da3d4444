#include "config/utf8.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_utf8 {

TEST(Utf8, TheFirstBytesThatAreNoneAreFound) {
  EXPECT_FALSE(find_malformed_utf8(""));
  EXPECT_FALSE(find_malformed_utf8("plain, 25 \xc2\xb0, \xe2\x82\xac, \xf0\x9f\x98\x80"));
  EXPECT_EQ(find_malformed_utf8("25 \xb0"), 3U);
  EXPECT_EQ(find_malformed_utf8("cut off \xe2\x82"), 8U);
  EXPECT_EQ(find_malformed_utf8("overlong \xc0\xaf"), 9U);
  EXPECT_EQ(find_malformed_utf8("a surrogate \xed\xa0\x80"), 12U);
}

}  // namespace test_utf8
}  // namespace gripline
