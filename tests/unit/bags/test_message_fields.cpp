#include "bags/message_fields.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "config/errors.hpp"
#include "support/bag_writing.hpp"

namespace gripline::bags {
namespace test_message_fields {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::MessageBytes;

constexpr const char* state_text =
    "uint8 gear\nfloat64 speed\nint16[3] wheel\nstring name\nfloat32[] slip\nWheel[] wheels\nbool on\nuint16 last\n"
    "================\nMSG: car_msgs/Wheel\nint8 index\nfloat64 load\nstring label\n";
const std::vector<std::string> state_paths = {"gear", "speed", "wheel[2]", "slip[1]", "wheels[1].load", "on", "last"};

Schema state(Wire wire) { return parse_schema("car_msgs/State", state_text, wire, {}); }

std::vector<std::byte> state_bytes(MessageBytes m) {
  m.add(std::uint8_t{3}).add(12.5).add(std::int16_t{-1}).add(std::int16_t{-2}).add(std::int16_t{-300});
  m.text("blue").add(std::uint32_t{2}).add(0.25f).add(-0.5f);
  m.add(std::uint32_t{2});
  m.add(std::int8_t{1}).add(1000.0).text("a");
  m.add(std::int8_t{2}).add(2000.0).text("bb");
  return m.add(std::uint8_t{1}).add(std::uint16_t{65535}).bytes();
}

std::vector<double> read(const Schema& schema, const std::vector<std::string>& paths,
                         std::span<const std::byte> bytes) {
  FieldReader reader(schema, paths, 0);
  const auto values = reader.read(bytes);
  return {values.begin(), values.end()};
}

std::string why_not(const Schema& schema, const std::vector<std::string>& paths, std::span<const std::byte> bytes) {
  try {
    read(schema, paths, bytes);
  } catch (const InputError& e) {
    return e.what();
  }
  return "read";
}

TEST(MessageFields, RosOneIsReadWithoutPadding) {
  EXPECT_THAT(read(state(Wire::ros1), state_paths, state_bytes(MessageBytes(Wire::ros1))),
              ElementsAre(3, 12.5, -300, -0.5, 2000, 1, 65535));
}

TEST(MessageFields, CdrIsAlignedAndOfEitherOrderOfBytes) {
  for (const bool big : {false, true})
    EXPECT_THAT(read(state(Wire::cdr), state_paths, state_bytes(MessageBytes(Wire::cdr, big))),
                ElementsAre(3, 12.5, -300, -0.5, 2000, 1, 65535))
        << big;
}

/// Bytes written by hand: where each number stands, not only that writer and reader agree.
TEST(MessageFields, CdrByHand) {
  const Schema s =
      parse_schema("car_msgs/A", "uint8 a\nfloat64 b\nuint16 c\nuint32 d\nstring e\nfloat32 f\n", Wire::cdr, {});
  const unsigned char little[] = {0, 1, 0,    0,                     // encapsulation
                                  7, 9, 9,    9,   9,   9, 9,    9,  // a and 7 bytes of padding, from here on counted
                                  0, 0, 0,    0,   0,   0, 0xF8, 0x3F,  // b = 1.5 at 8
                                  2, 1, 9,    9,                        // c = 258 at 16, padding
                                  4, 3, 2,    1,                        // d at 20
                                  2, 0, 0,    0,   'x', 0, 9,    9,     // e at 24: two bytes with its zero, padding
                                  0, 0, 0x20, 0x40};                    // f = 2.5 at 32
  EXPECT_THAT(read(s, {"a", "b", "c", "d", "f"}, std::as_bytes(std::span(little))),
              ElementsAre(7, 1.5, 258, 0x01020304, 2.5));
  const unsigned char big[] = {0, 0, 0, 0, 7, 9, 9, 9, 9, 9, 9, 9, 0x3F, 0xF8, 0, 0, 0,    0,    0, 0,
                               1, 2, 9, 9, 1, 2, 3, 4, 0, 0, 0, 2, 'x',  0,    9, 9, 0x40, 0x20, 0, 0};
  EXPECT_THAT(read(s, {"a", "b", "c", "d", "f"}, std::as_bytes(std::span(big))),
              ElementsAre(7, 1.5, 258, 0x01020304, 2.5));
  // The second version of CDR aligns eight bytes to four.
  const unsigned char second[] = {0, 7, 0, 0, 7, 9, 9, 9, 0, 0, 0,   0, 0, 0, 0xF8, 0x3F, 2,    1,
                                  9, 9, 4, 3, 2, 1, 2, 0, 0, 0, 'x', 0, 9, 9, 0,    0,    0x20, 0x40};
  EXPECT_THAT(read(s, {"b", "d", "f"}, std::as_bytes(std::span(second))), ElementsAre(1.5, 0x01020304, 2.5));
}

TEST(MessageFields, AnEmptyArrayIsNotAlignedFor) {
  const Schema s = parse_schema("car_msgs/A", "float64[] a\nuint32 b\n", Wire::cdr, {});
  const unsigned char bytes[] = {0, 1, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0};
  const auto values = read(s, {"a[0]", "b"}, std::as_bytes(std::span(bytes)));
  EXPECT_TRUE(std::isnan(values[0])) << "an array that is too short for it";
  EXPECT_EQ(values[1], 5);
}

TEST(MessageFields, StampsAndTimesCountFromZero) {
  const std::int64_t zero = 1'700'000'000'250'000'000, stamp = zero + 1'500'000'000;
  for (const Wire wire : {Wire::ros1, Wire::cdr}) {
    const Schema s = parse_schema("car_msgs/A", "std_msgs/Header header\nduration for\n", wire,
                                  {{"std_msgs/Header", testing_support::header_text}});
    FieldReader reader(s, {"header.stamp", "for"}, zero);
    EXPECT_TRUE(reader.has_header());
    const auto bytes = MessageBytes(wire).header(stamp).add(std::int32_t{-1}).add(std::int32_t{250'000'000}).bytes();
    EXPECT_THAT(reader.read(bytes), ElementsAre(1.5, -0.75));
    EXPECT_EQ(reader.stamp(), stamp);
  }
  EXPECT_FALSE(FieldReader(state(Wire::cdr), {}, 0).has_header());
}

TEST(MessageFields, AQuaternionHasAYaw) {
  const Schema s = parse_schema("geometry_msgs/Pose", common_definitions().at("geometry_msgs/Pose"), Wire::ros1,
                                common_definitions());
  FieldReader reader(s, {"orientation.yaw", "orientation.z", "position.y"}, 0);
  EXPECT_TRUE(reader.turns(0));
  EXPECT_FALSE(reader.turns(1));
  for (const double yaw : {-3.1, -1.0, 0.0, 0.4, 3.0}) {
    // With 0.2 rad of roll before it: the turn about the vertical is still the yaw.
    const double cr = std::cos(0.1), sr = std::sin(0.1), cy = std::cos(yaw / 2), sy = std::sin(yaw / 2);
    const auto values =
        reader.read(MessageBytes(Wire::ros1).numbers({1, 2, 3, cy * sr, sy * sr, sy * cr, cy * cr}).bytes());
    EXPECT_NEAR(values[0], yaw, 1e-12);
    EXPECT_NEAR(values[1], sy * cr, 1e-15);
    EXPECT_EQ(values[2], 2);
  }
  const auto unknown = reader.read(MessageBytes(Wire::ros1).numbers({1, 2, 3, 0, 0, 0, 0}).bytes());
  EXPECT_TRUE(std::isnan(unknown[0])) << "of a driver that knows no orientation";
}

TEST(MessageFields, WhatIsNoNumberIsRefused) {
  const auto why = [](const std::string& path, Wire wire = Wire::ros1) { return why_not(state(wire), {path}, {}); };
  EXPECT_THAT(why("spead"), HasSubstr("\"spead\" of car_msgs/State: no \"spead\"; did you mean \"speed\"?"));
  EXPECT_THAT(why("name"), HasSubstr("it is a text, not a number"));
  EXPECT_THAT(why("wheel"), HasSubstr("wheel is an array: expected wheel[0]"));
  EXPECT_THAT(why("wheel[3]"), HasSubstr("wheel has 3 elements, counted from 0"));
  EXPECT_THAT(why("wheel[x]"), HasSubstr("expected wheel[0]"));
  EXPECT_THAT(why("wheel["), HasSubstr("expected wheel[0]"));
  EXPECT_THAT(why("speed[0]"), HasSubstr("speed is not an array"));
  EXPECT_THAT(why("speed.x"), HasSubstr("speed is a number and has no members"));
  EXPECT_THAT(why("wheels[0]"), HasSubstr("it is a car_msgs/Wheel, not a number; its members: index, load, label"));
  EXPECT_THAT(why("wheels[0].yaw"), HasSubstr("no \"yaw\""));
}

TEST(MessageFields, BytesThatAreNotTheTypesAreRefused) {
  for (const Wire wire : {Wire::ros1, Wire::cdr}) {
    const auto whole = state_bytes(MessageBytes(wire));
    for (std::size_t n = 0; n < whole.size(); ++n)
      EXPECT_THAT(why_not(state(wire), state_paths, std::span(whole).first(n)), testing::Not("read")) << n;
    auto longer = whole;
    longer.resize(longer.size() + 4);
    EXPECT_THAT(why_not(state(wire), state_paths, longer), HasSubstr("4 bytes more than car_msgs/State has"));
  }
}

/// Lengths of four thousand million elements: refused at once, nothing reserved, nothing counted through.
TEST(MessageFields, LengthsBeyondTheMessageAreRefused) {
  const std::uint32_t many = 0xFFFFFFFF;
  for (const char* text :
       {"float64[] a\n", "string[] a\n", "Wheel[] a\n================\nMSG: car_msgs/Wheel\nint8 i\n"}) {
    const Schema s = parse_schema("car_msgs/A", text, Wire::ros1, {});
    EXPECT_THAT(why_not(s, {}, MessageBytes(Wire::ros1).add(many).add(0.0).bytes()),
                HasSubstr("an array of 4294967295 elements, where 8 bytes are left"));
  }
  const Schema text = parse_schema("car_msgs/A", "string a\n", Wire::ros1, {});
  EXPECT_THAT(why_not(text, {}, MessageBytes(Wire::ros1).add(many).bytes()), HasSubstr("it ends within a field"));
  const Schema nothing =
      parse_schema("car_msgs/A", "N[] a\n================\nMSG: car_msgs/N\nint8 A=1\n", Wire::ros1, {});
  EXPECT_EQ(why_not(nothing, {}, MessageBytes(Wire::ros1).add(many).bytes()), "read") << "elements without bytes";
}

TEST(MessageFields, OtherEncapsulationsAreNamed) {
  const Schema s = parse_schema("std_msgs/Int8", "int8 data\n", Wire::cdr, {});
  const unsigned char packed[] = {0x28, 0xb5, 0x2f, 0xfd, 1}, listed[] = {0, 3, 0, 0, 1};
  EXPECT_THAT(why_not(s, {}, std::as_bytes(std::span(packed))), HasSubstr("it is compressed (zstd)"));
  EXPECT_THAT(why_not(s, {}, std::as_bytes(std::span(listed))),
              HasSubstr("it is not plain CDR: it begins with the identifier 3"));
  const Schema names = parse_schema("car_msgs/A", "string[] a\n", Wire::cdr, {});
  const unsigned char second[] = {0, 7, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_THAT(why_not(names, {}, std::as_bytes(std::span(second))),
              HasSubstr("an array of texts in the second version of CDR, which is not read"));
  const Schema wide = parse_schema("car_msgs/A", "wstring a\n", Wire::cdr, {});
  EXPECT_THAT(why_not(wide, {}, MessageBytes(Wire::cdr).add(std::uint32_t{0}).bytes()), HasSubstr("wide characters"));
}

}  // namespace test_message_fields
}  // namespace gripline::bags
