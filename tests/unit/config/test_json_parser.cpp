#include "config/json_parser.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "support/json_samples.hpp"

namespace gripline {
namespace test_json_parser {

using testing::HasSubstr;
using testing_support::every_construct;

std::string message_of(std::string_view text) {
  try {
    (void)parse_text(text, "t");
    return "accepted";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(ParseText, KnowsWhereEverythingIsWritten) {
  const Node node = parse_text("{\n  \"a\": [10,\t-2.5 , \"é\", {\"b\":true}],\r\n  \"c/d\":\n null }", "t");
  const auto where = [&](const char* pointer) {
    const Origin& at = find_pointer(node, pointer)->origin;
    EXPECT_EQ(at.pointer, pointer);
    return std::to_string(at.line) + ':' + std::to_string(at.column);
  };
  EXPECT_EQ(where(""), "1:1");
  EXPECT_EQ(where("/a"), "2:8");
  EXPECT_EQ(where("/a/0"), "2:9");
  EXPECT_EQ(where("/a/1"), "2:13");
  EXPECT_EQ(where("/a/2"), "2:20");
  EXPECT_EQ(where("/a/3"), "2:25") << "a character beyond ASCII is one column";
  EXPECT_EQ(where("/a/3/b"), "2:30");
  EXPECT_EQ(where("/c~1d"), "4:2");
  EXPECT_EQ(node.object()[1].key_line, 3);
  EXPECT_EQ(node.object()[1].key_column, 3);
  EXPECT_EQ(find_pointer(node, "/a/4"), nullptr);
  EXPECT_EQ(find_pointer(node, "/a/x"), nullptr);
  EXPECT_EQ(find_pointer(node, "/a/0/x"), nullptr);
}

TEST(ParseText, ReadsEveryConstruct) {
  const Node node = parse_text(every_construct);
  EXPECT_EQ(node.find("note")->text(), "größer als – and é\U0001F600 \"quoted\" \\ / \b\f\n\r\t\x01");
  const std::vector<double> numbers{0, -0.0, 1, -1.5, 2e3, 1.25e-3, 9007199254740991.0, 1e308, 5e-324, 0.1};
  ASSERT_EQ(node.find("numbers")->array().size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(node.find("numbers")->array()[i].number(), numbers[i]);
  EXPECT_TRUE(find_pointer(node, "/words/0")->boolean());
  EXPECT_TRUE(find_pointer(node, "/words/2")->is_null());
  EXPECT_EQ(find_pointer(node, "/deep/a/b/0/1/c")->text(), "d");
}

TEST(ParseText, AcceptsAByteOrderMarkAndWindowsLineEnds) {
  const Node node = parse_text("\xef\xbb\xbf{\r\n  \"a\": 1\r\n}\r\n");
  EXPECT_EQ(node.find("a")->number(), 1.0);
  EXPECT_EQ(node.find("a")->origin.line, 2);
  EXPECT_EQ(node.find("a")->origin.column, 8);
  EXPECT_EQ(node.origin.column, 1);
}

TEST(ParseText, AcceptsTwoHundredLevelsAndNoMore) {
  const auto nested = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(message_of(nested(max_depth)), "accepted");
  EXPECT_EQ(message_of(nested(max_depth + 1)), "t:1:201: nested deeper than 200 levels");
  EXPECT_THAT(message_of(std::string(100000, '[')), HasSubstr("nested deeper"));
}

TEST(ParseText, RefusesEveryTruncation) {
  const std::string whole = every_construct;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string part = whole.substr(0, length);
    const std::string message = message_of(part);
    ASSERT_TRUE(message.find("the file ends too early") != std::string::npos ||
                message == "t: is empty, expected JSON" || message.find("not UTF-8") != std::string::npos)
        << length << ": " << message;
    ASSERT_EQ(message.find('\n'), std::string::npos);
  }
}

// The grammar is nlohmann's; what this reader refuses beyond it are duplicates, depth, and bytes after a NUL. So
// whatever it accepts nlohmann accepts, and what only it refuses it refuses for one of these reasons.
TEST(ParseText, AgreesWithTheGrammarOnMutatedText) {
  std::mt19937 random(1);
  const std::string whole = every_construct;
  const std::string signs = std::string("{}[]\",:0129-+.eE \n\t\\/utfnNI'#") + '\0' + "\x7f\x80\xc3\xff";
  int accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    std::string text = whole;
    for (int change = 0; change < 1 + round % 3; ++change) {
      const std::size_t at = random() % text.size();
      const char sign = signs[random() % signs.size()];
      const std::uint32_t kind = random() % 3;
      if (kind == 0) text[at] = sign;
      if (kind == 1) text.insert(at, 1, sign);
      if (kind == 2) text.erase(at, 1 + random() % 8);
    }
    const std::string message = message_of(text);
    ASSERT_EQ(message.find('\n'), std::string::npos) << message;
    if (message == "accepted") {
      ++accepted;
      ASSERT_TRUE(nlohmann::json::accept(text)) << text;
    } else if (nlohmann::json::accept(text)) {
      ASSERT_TRUE(message.find("is already written") != std::string::npos ||
                  message.find("NUL byte") != std::string::npos)
          << message << '\n'
          << text;
    }
  }
  EXPECT_GT(accepted, 500) << "the mutations must leave some texts valid";
}

TEST(ParseText, RefusesRandomBytesWithoutACrash) {
  std::mt19937 random(2);
  for (int round = 0; round < 5000; ++round) {
    std::string text(1 + random() % 40, ' ');
    for (char& c : text) c = static_cast<char>(random() & 0xffU);
    if (round % 2 == 0) text.insert(0, "{\"a\": ");
    ASSERT_EQ(message_of(text).find('\n'), std::string::npos);
  }
}

TEST(ParseText, AgreesWithTheGrammarOnUtf8) {
  // All leading bytes with the second bytes at the edges of every rule, and continuation bytes missing or not.
  for (int first = 0x80; first < 0x100; ++first) {
    for (const int second : {0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0}) {
      for (const char* tail : {"", "\x80", "\xbf\x80", "\x80\x80\x80"}) {
        const std::string text =
            std::string("[\"") + static_cast<char>(first) + static_cast<char>(second) + tail + "\"]";
        EXPECT_EQ(message_of(text) == "accepted", nlohmann::json::accept(text)) << first << ' ' << second;
      }
    }
  }
}

TEST(ParseText, WhatOnlyAnAttackHoldsIsRefusedAtItsPlace) {
  const std::string long_key(json_limits.key + 1, 'k');
  EXPECT_EQ(message_of("{ \"a\": 1,\n  \"" + long_key + "\": 1 }"),
            "t:2:3: a key of 1001 bytes; the longest that is read has 1000");
  EXPECT_EQ(message_of("{ \"" + long_key.substr(1) + "\": 1 }"), "accepted");
  std::string many = "{";
  for (std::size_t i = 0; i < json_limits.members; ++i) many += "\"k" + std::to_string(i) + "\":0,";
  EXPECT_EQ(message_of(many + "\"last\":0}"), "t:1:98892: more than 10000 members in one object");
  many.pop_back();
  EXPECT_EQ(message_of(many + "}"), "accepted");
  std::string values = "[0";
  for (std::size_t i = 1; i < json_limits.values; ++i) values += ",0";
  EXPECT_THAT(message_of(values + "]"), HasSubstr("more than 1000000 values, which no file of ours needs"));
  EXPECT_EQ(message_of("[" + std::string(json_limits.bytes, ' ') + "]"), "t: is larger than 64 MB");
}

/// Every value knows its place: names a kilobyte long, a hundred deep, above a thousand values.
TEST(ParseText, LongNamesAboveManyValuesAreBounded) {
  std::string text;
  for (int i = 0; i < 150; ++i) text += "{\"" + std::string(json_limits.key, 'k') + "\":";
  text += "[0";
  for (int i = 0; i < 10'000; ++i) text += ",0";
  text += "]" + std::string(150, '}');
  EXPECT_THAT(message_of(text), HasSubstr("more than 128 MB of keys above values"));
}

}  // namespace test_json_parser
}  // namespace gripline
