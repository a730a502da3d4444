// Units and signs are tested with whole files in test_log_file.cpp; here is what few files show.
#include "measured/log/log_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "support/circling_session.hpp"
#include "support/sample_roads.hpp"

namespace gripline::measured {
namespace test_log_checks {

using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;

/// Rows of a car on a circle to the left, steered to the left.
RawLog circling(double dt) {
  const Session session = test::circling_session(dt);
  RawLog raw;
  raw.t = session.t;
  raw.reading = session.reading;
  raw.d.assign(raw.t.size(), 0.2);
  raw.delta.assign(raw.t.size(), 0.1);
  for (std::size_t i = 0; i < raw.t.size(); ++i) raw.row.push_back(i);
  return raw;
}

std::string why_refused(const std::function<void(const CsvTable&)>& check) {
  CsvTable table;
  table.file = "log.csv";
  try {
    check(table);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(LogChecks, AYawThatWrapsByATurnIsInRadians) {
  RawLog raw = circling(0.5);
  const auto check = [&](const CsvTable& table) { check_yaw_is_radians(table, raw); };
  for (std::size_t i = 0; i < raw.size(); ++i)
    raw.at(i, Channel::yaw) = std::remainder(raw.at(i, Channel::yaw), 2.0 * pi);
  EXPECT_EQ(why_refused(check), "accepted");
  for (std::size_t i = 0; i < raw.size(); ++i) raw.at(i, Channel::yaw) *= 180.0 / pi;
  EXPECT_THAT(why_refused(check), HasSubstr("rows: it looks like degrees; expected rad"));
}

TEST(LogChecks, UnitsThatAgreeAreSaidToBePlausible) {
  const RawLog raw = circling(0.02);
  std::vector<Finding> health;
  EXPECT_EQ(why_refused([&](const CsvTable& table) { check_units(table, raw, {.v_ref = 8.0}, health); }), "accepted");
  ASSERT_EQ(health.size(), 1u);
  EXPECT_EQ(health[0].level, Finding::Level::good);
  EXPECT_EQ(health[0].done, "plausible");
}

/// Axes by turns: no unit, and not only a frame of the other hand.
TEST(LogChecks, ChannelsThatAreSwappedAreTold) {
  std::vector<Finding> health;
  const auto why_swapped = [&](std::size_t a, std::size_t b) {
    RawLog raw = circling(0.02);
    for (std::size_t i = 0; i < raw.size(); ++i) std::swap(raw.at(i, a), raw.at(i, b));
    return why_refused([&](const CsvTable& table) { check_units(table, raw, {.v_ref = 8.0}, health); });
  };
  EXPECT_THAT(why_swapped(Channel::vx, Channel::vy), HasSubstr("times: vx_mps and vy_mps look swapped"));
  EXPECT_THAT(why_swapped(Channel::x, Channel::y),
              HasSubstr("the frame seems to be left-handed, or x_m and y_m are swapped; expected y to the left of x"));
}

/// Places are read in the first half of a log, all else in the second: nothing can be compared but commands with their
/// limits.
TEST(LogChecks, ChannelsThatAreNeverReadTogetherAreTakenOnTrust) {
  RawLog raw = circling(0.02);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool places = raw.t[i] < 30.0;
    for (const std::size_t c : {Channel::x, Channel::y}) raw.at(i, c) = places ? raw.at(i, c) : NAN;
    for (const std::size_t c : {Channel::yaw, Channel::vx, Channel::yaw_rate}) raw.at(i, c) = places ? NAN : 1.0;
  }
  std::vector<Finding> health;
  const auto check = [&](const CsvTable& table) { check_units(table, raw, {.v_ref = 8.0, .delta_max = 0.4}, health); };
  EXPECT_EQ(why_refused(check), "accepted");
  ASSERT_EQ(health.size(), 1u);
  EXPECT_EQ(health[0].level, Finding::Level::bad);
  EXPECT_THAT(health[0].done, HasSubstr("taken on trust"));
  raw.delta.assign(raw.size(), 0.9);
  EXPECT_THAT(why_refused(check), HasSubstr("it looks like the angle of the handwheel"));
}

/// A log along an ellipse that lies to the left of the x axis, by a road that may lie elsewhere.
class Places : public testing::Test {
 protected:
  static RoadTable road() {
    RoadTable table = test::ellipse();
    for (PlanePoint& p : table.points) p.y += 300.0;
    return table;
  }
  static std::string why(double shift, double side) {
    RawLog raw = circling(0.02);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const double a = 2.0 * pi * static_cast<double>(i) / static_cast<double>(raw.size());
      raw.at(i, Channel::x) = 100.0 * std::cos(a) + shift;
      raw.at(i, Channel::y) = side * (60.0 * std::sin(a) + 300.0);
    }
    const Road where(std::make_shared<const Track>(to_track(road())));
    return why_refused([&](const CsvTable& table) { check_place(table, raw, where); });
  }
};

TEST_F(Places, ALogOfAnotherRoadIsRefused) {
  EXPECT_EQ(why(0.0, 1.0), "accepted");
  EXPECT_EQ(why(5.0, 1.0), "accepted");  // a log may lie a little beside its road
  EXPECT_THAT(why(1000.0, 1.0), HasSubstr(": it is from another track"));
  EXPECT_THAT(why(0.0, -1.0), HasSubstr("with the sign of y_m changed on it: the frame seems to be left-handed"));
}

}  // namespace test_log_checks
}  // namespace gripline::measured
