#include "bags/bag_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "config/errors.hpp"
#include "support/bag_writing.hpp"
#include "support/scratch.hpp"

namespace gripline::bags {
namespace test_bag_table {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::MemoryBag;
using testing_support::MessageBytes;
using testing_support::Recording;
using testing_support::Weaving;
using testing_support::weaving_map;
using testing_support::weaving_recording;

measured::LogMap map_of(const std::string& text) {
  const auto file = testing_support::scratch("map.json");
  std::ofstream(file) << text;
  return measured::load_log_map(file);
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

std::string why(const Recording& recording, const std::string& map) {
  try {
    MemoryBag bag(recording);
    read_table(bag, map_of(map));
  } catch (const InputError& e) {
    return e.what();
  }
  return "read";
}

const std::vector<double>& column(const DelimitedTable& table, const std::string& name) {
  return table.column.at(static_cast<std::size_t>(table.find(name)));
}

TEST(BagTable, RowsOfOneTopicHaveTheOthersLinearBetweenMessages) {
  for (const Wire wire : {Wire::ros1, Wire::cdr}) {
    MemoryBag bag(weaving_recording(wire));
    const DelimitedTable t = read_table(bag, map_of(weaving_map()));
    ASSERT_EQ(t.rows(), 801u);
    for (std::size_t r = 0; r < 800; ++r) {
      // Times are of headers, from the first message on, which is the throttle's and the first stamp's.
      const double now = column(t, "time")[r];
      ASSERT_NEAR(now, 0.05 * static_cast<double>(r), 1e-9);
      ASSERT_NEAR(column(t, "/odom.twist.twist.angular.z")[r], Weaving::rate(now), 1e-12);
      ASSERT_NEAR(
          std::remainder(column(t, "/odom.pose.pose.orientation.yaw")[r] - Weaving::yaw(now), 2 * std::numbers::pi), 0,
          1e-9);
      ASSERT_NEAR(column(t, "/vesc/drive.drive.steering_angle")[r], Weaving::steer(now), 1e-4);
      ASSERT_NEAR(column(t, "/throttle.data")[r], Weaving::throttle(now), 1e-5);
    }
    EXPECT_THAT(t.found,
                Contains(HasSubstr("/odom: 801 messages at 20 Hz, times of their headers, recorded 4 ms later")));
    EXPECT_THAT(t.found, Contains(HasSubstr("/throttle: 401 messages at 10 Hz, times of recording")));
    EXPECT_THAT(t.found, Contains("rows are messages of /odom"));
    EXPECT_EQ(t.line.back(), 801);
  }
}

TEST(BagTable, WithoutANameTheTopicWithMostMessagesGivesTheRows) {
  MemoryBag bag(weaving_recording(Wire::ros1));
  const DelimitedTable t = read_table(bag, map_of(replaced(weaving_map(), R"("rows": "/odom")", "")));
  EXPECT_EQ(t.rows(), 1001u);  // the steering's
  EXPECT_THAT(t.found, Contains("rows are messages of /vesc/drive"));
  const auto& yaw = column(t, "/odom.pose.pose.orientation.yaw");
  double largest = 0;
  for (std::size_t r = 0; r < 1000; ++r)
    largest = std::max(
        largest, std::abs(std::remainder(yaw[r] - Weaving::yaw(0.04 * static_cast<double>(r)), 2 * std::numbers::pi)));
  EXPECT_LT(largest, 2e-4) << "also between messages on both sides of half a turn";
}

/// Three messages at 0, 1 and 2 s (a number and a switch) in rows of another topic.
Recording steps() {
  Recording all;
  const auto rows = all.topic("/rows", "std_msgs/Int8", "int8 data\n");
  const auto slow = all.topic("/slow", "car_msgs/A", "float64 a\nbool b\n");
  for (std::int64_t k = 0; k <= 10; ++k)
    all.add(rows, 500'000'000 + 250'000'000 * k, MessageBytes(Wire::ros1).add(std::int8_t{1}).bytes());
  for (std::int64_t k = 0; k <= 2; ++k)
    all.add(slow, 1'000'000'000 * (k + 1),
            MessageBytes(Wire::ros1).add(1.0 * static_cast<double>(k)).add(static_cast<std::uint8_t>(k % 2)).bytes());
  return all;
}

TEST(BagTable, HeldColumnsJumpAndNothingIsKnownBeforeTheFirstMessage) {
  MemoryBag bag(steps());
  const DelimitedTable t = read_table(bag, {{"/slow.a", false, false, {}}, {"/slow.b", true, false, {}}},
                                      {.rows = "/rows", .recorded = {}, .definitions = {}, .origin = {}});
  const auto &a = column(t, "/slow.a"), &b = column(t, "/slow.b");
  EXPECT_TRUE(std::isnan(a[0]) && std::isnan(a[1]) && std::isnan(b[1]));
  EXPECT_THAT(std::vector(a.begin() + 2, a.begin() + 8), ElementsAre(0, 0.25, 0.5, 0.75, 1, 1.25));
  EXPECT_THAT(std::vector(b.begin() + 2, b.end()), ElementsAre(0, 0, 0, 0, 1, 1, 1, 1, 0));
}

TEST(BagTable, LongSilenceIsNotBridged) {
  Recording all = steps();
  for (std::int64_t k = 0; k < 40; ++k)  // ten times a second until 8 s, then one at 10 s
    all.add(1, 4'000'000'000 + 100'000'000 * k, MessageBytes(Wire::ros1).add(2.0).add(std::uint8_t{0}).bytes());
  all.add(1, 10'000'000'000, MessageBytes(Wire::ros1).add(2.0).add(std::uint8_t{0}).bytes());
  all.add(0, 9'000'000'000, MessageBytes(Wire::ros1).add(std::int8_t{1}).bytes());
  MemoryBag bag(std::move(all));
  const DelimitedTable t = read_table(bag, {{"/slow.a", false, false, {}}},
                                      {.rows = "/rows", .recorded = {}, .definitions = {}, .origin = {}});
  EXPECT_TRUE(std::isnan(column(t, "/slow.a").back()));
}

TEST(BagTable, StampsThatAreNoTimesOfTheRecordingAreNotTaken) {
  Recording all;
  const auto odd = all.topic("/odd", "car_msgs/A",
                             std::string("Header header\nfloat64 a\n") + testing_support::rule +
                                 "MSG: std_msgs/Header\n" + testing_support::header_text);
  // Stamps since the computer's start, the recorder's since 1970.
  for (std::int64_t k = 0; k < 30; ++k)
    all.add(odd, 1'700'000'000'000'000'000 + 100'000'000 * k,
            MessageBytes(Wire::ros1).header(100'000'000 * (k + 1)).add(1.0).bytes());
  MemoryBag bag(all);
  const DelimitedTable t = read_table(bag, {{"/odd.a", false, false, {}}}, {});
  EXPECT_THAT(t.found, Contains(HasSubstr("times of recording")));
  EXPECT_NEAR(t.column[0].back(), 2.9, 1e-9);
  // Rising stamps but for one that is late, which is left out.
  Recording mended = all;
  mended.messages.clear();
  for (std::int64_t k = 0; k < 30; ++k)
    mended.add(odd, 5'000'000'000 + 100'000'000 * k,
               MessageBytes(Wire::ros1)
                   .header(5'000'000'000 + 100'000'000 * (k == 9 ? std::int64_t{2} : k))
                   .add(1.0 * static_cast<double>(k))
                   .bytes());
  mended.topics[0].messages = 30;
  MemoryBag second(mended);
  const DelimitedTable u = read_table(second, {{"/odd.a", false, false, {}}}, {});
  EXPECT_EQ(u.rows(), 29u);
  EXPECT_THAT(u.found, Contains(HasSubstr("1 out of order left out")));
  const DelimitedTable v = read_table(second, {{"/odd.a", false, false, {}}},
                                      {.rows = "", .recorded = true, .definitions = {}, .origin = {}});
  EXPECT_EQ(v.rows(), 30u);
}

/// A stamp may be wrong in either direction; it costs its own message alone.
TEST(BagTable, AStampThatJumpsAheadCostsItselfOnly) {
  Recording all;
  const auto odd = all.topic("/odd", "car_msgs/A",
                             std::string("Header header\nfloat64 a\n") + testing_support::rule +
                                 "MSG: std_msgs/Header\n" + testing_support::header_text);
  for (std::int64_t k = 0; k < 100; ++k)
    all.add(odd, 5'000'000'000 + 100'000'000 * k,
            MessageBytes(Wire::ros1)
                .header(5'000'000'000 + 100'000'000 * (k == 9 ? std::int64_t{59} : k))
                .add(1.0 * static_cast<double>(k))
                .bytes());
  MemoryBag bag(std::move(all));
  const DelimitedTable t = read_table(bag, {{"/odd.a", false, false, {}}}, {});
  ASSERT_EQ(t.rows(), 99u);
  EXPECT_THAT(t.found, Contains(HasSubstr("times of their headers")));
  EXPECT_THAT(t.found, Contains(HasSubstr("1 out of order left out")));
  EXPECT_EQ(column(t, "/odd.a")[9], 10);
  EXPECT_EQ(t.line[9], 11) << "the eleventh message";
}

TEST(BagTable, AnAngleInDegreesIsNotDrawnThroughItsJump) {
  Recording all = steps();
  const auto compass = all.topic("/compass", "std_msgs/Float64", "float64 data\n");
  for (std::int64_t k = 0; k <= 8; ++k)
    all.add(compass, 600'000'000 + 250'000'000 * k,
            MessageBytes(Wire::ros1)
                .add(k < 4 ? 350.0 + 2.0 * static_cast<double>(k) : 2.0 * static_cast<double>(k - 4))
                .bytes());
  MemoryBag bag(std::move(all));
  const DelimitedTable t = read_table(bag, {{"/compass.data", false, true, {}}},
                                      {.rows = "/rows", .recorded = {}, .definitions = {}, .origin = {}});
  const auto& yaw = t.column[1];
  EXPECT_NEAR(yaw[3], 355.2, 1e-9);
  EXPECT_TRUE(std::isnan(yaw[4])) << "between 356 and 0";
  EXPECT_NEAR(yaw[5], 1.2, 1e-9);
}

TEST(BagTable, WrongMapsAreToldWhatIsMeant) {
  const Recording all = weaving_recording(Wire::ros1, 2.0);
  const std::string map = weaving_map();
  EXPECT_THAT(why(all, replaced(map, "/odom.twist.twist.linear.x", "/odon.twist.twist.linear.x")),
              HasSubstr("/channels/vx: no topic \"/odon\" in drive.bag; did you mean \"/odom\"?"));
  EXPECT_THAT(why(all, replaced(map, "/odom.twist.twist.linear.x", "/odom.twist.twist.linear.s")),
              HasSubstr("did you mean \"twist.twist.linear.x\"?, in drive.bag"));
  EXPECT_THAT(why(all, replaced(map, "/odom.twist.twist.linear.x", "/odom.child_frame_id")),
              HasSubstr("it is a text, not a number"));
  EXPECT_THAT(why(all, replaced(map, R"("rows": "/odom")", R"("rows": "/odo")")),
              HasSubstr("/bag: no topic \"/odo\" in drive.bag; did you mean \"/odom\"?"));
  EXPECT_THAT(why(all, replaced(map, R"("bag": {)", R"("bag": {"row": "/odom", )")),
              HasSubstr("did you mean \"rows\"?"));
  EXPECT_THAT(why(all, replaced(map, R"("d": {"column": "/throttle.data")",
                                R"("d": {"formula": "`/throttle.data` + 0 * `/odom.pose.covariance[40]`")")),
              HasSubstr("covariance has 36 elements"));
  EXPECT_THAT(why(all, R"({"time": "time", "channels": {"vx": "v", "yaw_rate": "r", "delta": "d"}})"),
              HasSubstr("the map names no topic"));
  std::string both =
      replaced(map, R"("d": {"column": "/throttle.data")", R"("d": {"column": "/throttle.data", "hold": "held")");
  both = replaced(both, R"("delta": {"column": "/vesc/drive.drive.steering_angle")",
                  R"("delta": {"formula": "`/vesc/drive.drive.steering_angle` + 0 * `/throttle.data`")");
  EXPECT_THAT(why(all, both), HasSubstr("\"/throttle.data\" is wanted held here and linear at"));
}

TEST(BagTable, MessagesThatAreNotTheirTypeAreNamed) {
  Recording all = weaving_recording(Wire::cdr, 2.0);
  for (auto& message : all.messages)
    if (message.topic == 0 && message.time > testing_support::weaving_start + 1'000'000'000) message.bytes.resize(100);
  EXPECT_THAT(why(all, weaving_map()),
              HasSubstr("drive.bag: message 21 of /odom: an array of 36 elements, where 8 bytes are left"));
  Recording unknown = weaving_recording(Wire::cdr, 2.0);
  unknown.topics[0].type = "my_msgs/msg/State";
  EXPECT_THAT(why(unknown, weaving_map()), HasSubstr("its type my_msgs/State is not defined in the file"));
}

TEST(BagTable, AnElementThatNoMessageHasIsSaid) {
  Recording all = steps();
  const auto joints = all.topic("/joints", "car_msgs/J", "float64[] position\n");
  for (std::int64_t k = 0; k < 5; ++k)
    all.add(joints, 600'000'000 + 250'000'000 * k,
            MessageBytes(Wire::ros1).add(std::uint32_t{2}).add(1.0).add(2.0 + static_cast<double>(k)).bytes());
  const std::string map =
      R"({"time": "time", "bag": {"rows": "/joints"}, "channels": {"vx": {"column": "/joints.position[1]"},
    "yaw_rate": {"column": "/joints.position[0]"}, "delta": {"column": "/joints.position[2]"}}})";
  EXPECT_THAT(why(all, map), HasSubstr("/channels/delta: \"/joints.position[2]\" is in no row of drive.bag"));
  MemoryBag bag(all);
  const DelimitedTable t = read_table(bag, map_of(replaced(map, "position[2]", "position[1]")));
  EXPECT_THAT(column(t, "/joints.position[1]"), ElementsAre(2, 3, 4, 5, 6));
}

TEST(BagTable, ReadingEndsWhereEnoughWasSeen) {
  MemoryBag bag(weaving_recording(Wire::ros1));
  const DelimitedTable t = read_table(bag, {{"/throttle.data", false, false, {}}}, {}, 150);
  EXPECT_EQ(t.rows(), 50u);
  EXPECT_THAT(t.found, Contains(HasSubstr("only the first 5 s are looked at")));
}

}  // namespace test_bag_table
}  // namespace gripline::bags
