#include "tables/text_encoding.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gripline {
namespace test_text_encoding {

TEST(TextEncoding, Utf8StaysAsItIs) {
  std::string text = "Gierwinkel [\xc2\xb0]\n1\n";
  EXPECT_FALSE(to_utf8(text));
  EXPECT_EQ(text, "Gierwinkel [\xc2\xb0]\n1\n");
}

TEST(TextEncoding, LinesThatAreNoUtf8AreWindows1252) {
  std::string text =
      "Gr\xf6\xdf"
      "e [\xb0]\r\n\x80;\x81\n";
  EXPECT_TRUE(to_utf8(text));
  EXPECT_EQ(text,
            "Gr\xc3\xb6\xc3\x9f"
            "e [\xc2\xb0]\r\n\xe2\x82\xac;\xef\xbf\xbd\n");
}

/// Of a file that was cut off within a letter, the header is still in UTF-8.
TEST(TextEncoding, OtherLinesOfTheFileStayAsTheyAre) {
  std::string text = "[\xc2\xb0]\n1\n\xc2";
  EXPECT_TRUE(to_utf8(text));
  EXPECT_EQ(text, "[\xc2\xb0]\n1\n\xc3\x82");
}

}  // namespace test_text_encoding
}  // namespace gripline
