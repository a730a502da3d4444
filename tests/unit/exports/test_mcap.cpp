#include "exports/mcap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "support/mcap_reading.hpp"

namespace gripline::exports {
namespace test_mcap {

using testing::ElementsAre;
using testing_support::McapFile;
using testing_support::read_mcap;

TEST(Mcap, IsWhatTheSpecificationSays) {
  McapWriter file("a library");
  const std::uint16_t schema = file.schema("Point", R"({"type": "object"})");
  const std::uint16_t left = file.channel(schema, "/left"), right = file.channel(schema, "/right");
  EXPECT_NE(left, right);
  file.message(left, 0, R"({"x": 1})");
  file.message(right, 1.5, R"({"x": 2})");
  file.message(left, 1234567.123456789, R"({"x": 3})");
  const McapFile found = read_mcap(std::move(file).finish());
  EXPECT_EQ(found.library, "a library");
  EXPECT_THAT(found.opcodes, ElementsAre(1, 3, 4, 4, 5, 5, 5, 15, 2));
  ASSERT_EQ(found.messages.size(), 3U);
  EXPECT_EQ(found.messages[1].topic, "/right");
  EXPECT_EQ(found.messages[1].log_time, 1'500'000'000U);
  EXPECT_EQ(found.messages[2].topic, "/left");
  EXPECT_EQ(found.messages[2].sequence, 1U);  // counted for each channel
  EXPECT_EQ(found.messages[2].data["x"], 3);
  EXPECT_NEAR(static_cast<double>(found.messages[2].log_time), 1234567.123456789e9, 200);
}

TEST(Mcap, AnEmptyFileIsWhole) {
  EXPECT_THAT(read_mcap(McapWriter("x").finish()).opcodes, ElementsAre(1, 15, 2));
  EXPECT_THROW(read_mcap("no file"), std::runtime_error);
}

TEST(Mcap, HeaderAndFooterByteByByte) {
  const std::string bytes = McapWriter("lib").finish();
  const std::string expected(
      "\x89MCAP0\r\n"
      "\x01\x0b\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0lib"
      "\x0f\x04\0\0\0\0\0\0\0\0\0\0\0"
      "\x02\x14\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
      "\x89MCAP0\r\n",
      8 + 20 + 13 + 29 + 8);
  EXPECT_EQ(bytes, expected);
}

}  // namespace test_mcap
}  // namespace gripline::exports
