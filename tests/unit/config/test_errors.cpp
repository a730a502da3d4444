#include "config/errors.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gripline {
namespace test_errors {

TEST(Errors, AreCollectedToAThousandAndThenCounted) {
  Errors errors;
  for (int i = 0; i < 200'000; ++i) errors.add(Diagnostic{.file = "f", .line = i + 1, .message = "wrong"});
  errors.add(Diagnostic{.file = "f", .line = 1, .message = "wrong"});
  EXPECT_EQ(errors.size(), 200'000u);
  EXPECT_EQ(errors.added(), 200'001u);
  const std::vector<Diagnostic> sorted = errors.sorted();
  ASSERT_EQ(sorted.size(), 1001u);
  EXPECT_EQ(sorted.back().text(), "f: and 199000 more errors");
}

TEST(Errors, WordsOfOthersDoNoHarm) {
  EXPECT_EQ(escape_control("plain, größer"), "plain, größer");
  EXPECT_EQ(escape_control("\x1b[2J\n\x7f"), "\\x1b[2J\\x0a\\x7f");
  EXPECT_EQ(escape_control("\xc2\x9b"
                           "2J \xc3\x9f"),
            "\\x9b2J \xc3\x9f");  // a control of one byte beyond ASCII; ß
  EXPECT_LT(escape_control(std::string(1'000'000, 'x')).size(), 5000u);
}

}  // namespace test_errors
}  // namespace gripline
