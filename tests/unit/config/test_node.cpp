#include "config/node.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>

#include "config/json_file.hpp"
#include "support/json_samples.hpp"

namespace gripline {
namespace test_node {

using testing_support::every_construct;

/// The same tree: kinds, keys in order, values bit by bit.
bool same(const Node& a, const Node& b) {
  if (a.is_array() && b.is_array()) return std::ranges::equal(a.array(), b.array(), same);
  if (a.is_object() && b.is_object()) {
    return std::ranges::equal(a.object(), b.object(), [](const Member& x, const Member& y) {
      return x.key == y.key && same(x.value, y.value);
    });
  }
  if (a.is_number() && b.is_number()) {
    return a.number() == b.number() && std::signbit(a.number()) == std::signbit(b.number());
  }
  if (a.is_text() && b.is_text()) return a.text() == b.text();
  if (a.is_boolean() && b.is_boolean()) return a.boolean() == b.boolean();
  return a.is_null() && b.is_null();
}

TEST(JsonText, IsReadBackAsTheSameTreeAndTheSameBytes) {
  const Node node = parse_text(every_construct);
  const std::string text = to_json_text(node);
  const Node again = parse_text(text);
  EXPECT_TRUE(same(node, again));
  EXPECT_EQ(to_json_text(again), text);
  EXPECT_TRUE(nlohmann::json::accept(text));
}

TEST(JsonText, HasThisForm) {
  EXPECT_EQ(to_json_text(parse_text(R"({"b":[1,{"x":true}],"a":{},"c":[],"d":"é\n"})")),
            "{\n  \"b\": [\n    1,\n    {\n      \"x\": true\n    }\n  ],\n  \"a\": {},\n  \"c\": [],\n  \"d\": "
            "\"é\\n\"\n}\n");
}

TEST(JsonText, KeepsEveryBitOfANumber) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 20000; ++round) {
    const double value = round % 2 == 0 ? std::bit_cast<double>(random()) : static_cast<double>(random() >> 11U);
    if (!std::isfinite(value)) continue;
    const Node again = parse_text(number_text(value));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(again.number()), std::bit_cast<std::uint64_t>(value)) << number_text(value);
  }
  EXPECT_EQ(number_text(4), "4");
  EXPECT_EQ(number_text(100000), "100000");
  EXPECT_EQ(number_text(0.02), "0.02");
  EXPECT_EQ(number_text(0.0), "0");
  EXPECT_EQ(number_text(-0.0), "-0.0");
  EXPECT_EQ(number_text(1e300), "1e+300");
  EXPECT_THROW((void)number_text(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(JsonText, OfTreesMadeByTheProgram) {
  Node node;
  node.set("seed", Node(7)).origin.line = 3;
  node.set("name", Node("elm"));
  node.set("on", Node(true));
  node.set("list", Node(Node::Array{Node(1.5), Node::null()}));
  node.set("seed", Node(8U));
  node.erase("name");
  EXPECT_EQ(to_json_text(node), "{\n  \"seed\": 8,\n  \"on\": true,\n  \"list\": [\n    1.5,\n    null\n  ]\n}\n");
}

TEST(ContentText, IgnoresOrderNotesAndRemovedMembers) {
  const Node a = parse_text(R"({ "b": 1.0, "a": { "note": "x", "y": [null, 2] }, "gone": null })");
  const Node b = parse_text(R"({ "a": { "y": [null, 2e0] }, "note": ["other"], "b": 1 })");
  EXPECT_EQ(content_text(a), R"({"a":{"y":[null,2]},"b":1})");
  EXPECT_EQ(content_text(a), content_text(b));
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(Json, DoesNotDependOnTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const std::string c_before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
  }
  const Node node = parse_text("[1234567.5, 1.5e-3]");
  const std::string text = content_text(node);
  std::setlocale(LC_NUMERIC, c_before.c_str());
  std::locale::global(before);
  EXPECT_EQ(node.array()[0].number(), 1234567.5);
  EXPECT_EQ(node.array()[1].number(), 0.0015);
  EXPECT_EQ(text, "[1234567.5,0.0015]");
}

}  // namespace test_node
}  // namespace gripline
