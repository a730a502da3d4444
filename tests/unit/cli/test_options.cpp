#include "cli/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"

namespace gripline::tools {
namespace test_options {

using testing::ElementsAreArray;

template <class Reads>
std::string refusal(const Reads& reads) {
  try {
    reads();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Options, NamesBetweenCommas) {
  struct Row {
    const char* text;
    Words names;
    const char* refused;
  };
  for (const Row& row : {Row{"slow", {"slow"}, ""},
                         {"slow,told", {"slow", "told"}, ""},
                         {" tyres , /plant/params/Iz\t", {"tyres", "/plant/params/Iz"}, ""},
                         {"with blank, told", {"with blank", "told"}, ""},
                         {"", {}, "--only names no stack; expected names with commas between them"},
                         {" ", {}, "--only names no stack; expected names with commas between them"},
                         {",", {}, "--only names no stack; expected names with commas between them"},
                         {"slow,,told", {}, "--only slow,,told: a name is missing between commas"},
                         {"slow, ,told", {}, "--only slow, ,told: a name is missing between commas"},
                         {",slow", {}, "--only ,slow: a name is missing between commas"},
                         {"slow,", {}, "--only slow,: a name is missing between commas"}}) {
    Words names;
    EXPECT_EQ(refusal([&] { names = names_of("--only", row.text, "stack"); }), row.refused) << row.text;
    EXPECT_THAT(names, ElementsAreArray(row.names)) << row.text;
  }
}

TEST(Options, WholeNumbersOfARange) {
  const auto read = [](const char* text, const WholeRange& range) {
    return refusal([&] { EXPECT_EQ(std::to_string(whole_number("--seed", text, range)), text); });
  };
  for (const char* text : {"0", "17", "4294967295"}) EXPECT_EQ(read(text, {0, 4294967295}), "") << text;
  for (const char* text : {"", "x", "1.5", "1e3", "+1", " 1", "1 "})
    EXPECT_EQ(read(text, {0, 9}), std::string("--seed ") + text + ": expected a whole number");
  for (const char* text : {"-1", "4294967296", "99999999999999999999", "-99999999999999999999"})
    EXPECT_EQ(read(text, {0, 4294967295}), std::string("--seed ") + text + ": expected 0 to 4294967295");
  EXPECT_EQ(read("0", {1, 8, "megabytes"}), "--seed 0: expected 1 to 8 megabytes");
}

TEST(Options, NumbersBetweenCommas) {
  const Expected time{"s", "times above 0 s", 1000.0}, factor{"", "factors above 0 and up to 10", 10.0};
  struct Row {
    const Expected& expected;
    const char* text;
    std::vector<double> numbers;
    const char* refused;
  };
  for (const Row& row : {Row{time, "0.5,1", {0.5, 1.0}, ""},
                         {time, " 0.5, 1 ", {0.5, 1.0}, ""},
                         {time, "200 ms,1s", {0.2, 1.0}, ""},
                         {time, "1000", {1000.0}, ""},
                         {time, "", {}, "--o has no number; expected times above 0 s"},
                         {time, ", ", {}, "--o has no number; expected times above 0 s"},
                         {time, "0.5,,1", {}, "--o 0.5,,1: a number is missing between commas"},
                         {time, "0.5,", {}, "--o 0.5,: a number is missing between commas"},
                         {time, "1,-2", {}, "--o -2: expected times above 0 s"},
                         {time, "0", {}, "--o 0: expected times above 0 s"},
                         {time, "nan", {}, "--o nan: expected times above 0 s"},
                         {time, "inf", {}, "--o inf: expected times above 0 s"},
                         {time, "1000.5", {}, "--o 1000.5: expected times above 0 s"},
                         {time, "2 m", {}, "--o 2 m: \"2 m\" is a length, expected a time [s]"},
                         {factor, "1, 0.9", {1.0, 0.9}, ""},
                         {factor, "1,x", {}, "--o x: expected factors above 0 and up to 10"},
                         {factor, "90 %", {}, "--o 90 %: expected factors above 0 and up to 10"},
                         {factor, "11", {}, "--o 11: expected factors above 0 and up to 10"}}) {
    std::vector<double> numbers;
    EXPECT_EQ(refusal([&] { numbers = quantities_of("--o", row.text, row.expected); }), row.refused) << row.text;
    EXPECT_THAT(numbers, ElementsAreArray(row.numbers)) << row.text;
  }
}

}  // namespace test_options
}  // namespace gripline::tools
