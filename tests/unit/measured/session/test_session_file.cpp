#include "measured/session/session_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_session_file {

using testing::AllOf;
using testing::HasSubstr;
using namespace test;
using testing_support::scratch;

TEST(SessionFile, ReadsGriplinesOwnColumnsAndUnwrapsYaw) {
  const SessionFile file = read_session(plain_log(), gripline_map());
  const Session& s = file.session;
  EXPECT_EQ(s.rows(), 800u);
  EXPECT_NEAR(file.row_step, 0.05, 1e-9);
  EXPECT_TRUE(file.has_throttle);
  for (std::size_t i = 1; i < s.rows(); ++i) EXPECT_LT(std::abs(s.at(i, 2) - s.at(i - 1, 2)), 0.2);
  EXPECT_EQ(s.command[5].d, 0.2);
}

TEST(SessionFile, HeldReadingsAreReadWhenTheyAreNew) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double delta) {
                            out << t << ',' << 10 + 0.001 * std::floor(t + 1e-9) << ',' << rate << ',' << delta << '\n';
                          });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"vx": {"column": "vx_mps", "hold": "held"},
    "yaw_rate": "yaw_rate_radps", "delta": "delta_rad"}})");
  const Session s = read_session(log, map).session;
  std::size_t read = 0;
  for (std::size_t i = 0; i < s.rows(); ++i) read += !std::isnan(s.at(i, 3));
  EXPECT_EQ(read, 40u);  // once a second
  EXPECT_TRUE(s.prescribed_speed);
}

TEST(SessionFile, AHeldReadingThatStaysIsOfACarThatStands) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double delta) {
                            const double v = t < 20.0 ? 10 + 0.001 * std::floor(t / 0.2 + 1e-9) : 0.0;
                            out << t << ',' << v << ',' << rate << ',' << delta << '\n';
                          });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"vx": {"column": "vx_mps", "hold": "held"},
    "yaw_rate": "yaw_rate_radps", "delta": "delta_rad"}})");
  const Session s = read_session(log, map).session;
  std::size_t moving = 0, standing = 0;
  for (std::size_t i = 0; i < s.rows(); ++i) (s.t[i] < 20.0 - 1e-9 ? moving : standing) += !std::isnan(s.at(i, 3));
  EXPECT_EQ(moving, 100u);
  EXPECT_NEAR(static_cast<double>(standing), 100.0, 3.0);
}

TEST(SessionFile, EmptyCellsOfAHeldColumnAreNoReadings) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double delta) {
                            out << t << ',';
                            if (t > 5.0 - 1e-9) out << 10 + 0.001 * std::floor(t / 0.2 + 1e-9);
                            out << ',' << rate << ',' << delta << '\n';
                          });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"vx": {"column": "vx_mps", "hold": "held"},
    "yaw_rate": "yaw_rate_radps", "delta": "delta_rad"}})");
  const Session s = read_session(log, map).session;
  std::size_t read = 0;
  for (std::size_t i = 0; i < s.rows(); ++i) read += s.t[i] < 15.0 - 1e-9 && !std::isnan(s.at(i, 3));
  EXPECT_EQ(read, 50u);  // five a second, from the fifth second on
}

TEST(SessionFile, ARowWhoseValidityIsMissingHasNoReadings) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad,status",
                          [](std::ostream& out, double t, double, double, double, double rate, double delta) {
                            out << t << ",10," << rate << ',' << delta << ',';
                            if (t < 10.0 - 1e-9) out << (t < 5.0 - 1e-9 ? 0 : 2);
                            out << '\n';
                          });
  for (const char* valid : {"status != 0", "!(status < 1)"}) {
    std::string text = R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
      "delta": "delta_rad"}, "valid": ")";
    const Session s = read_session(log, map_of(text.append(valid).append("\"}"))).session;
    ASSERT_GT(s.rows(), 200u);
    for (std::size_t i = 0; i < s.rows(); ++i)
      EXPECT_EQ(std::isnan(s.at(i, 3)), i < 100 || i >= 200) << valid << ", row " << i;
  }
}

TEST(SessionFile, SpeedsFollowFromPlacesWhereTheLogHasNone) {
  const auto log =
      log_of("t_s,x_m,y_m,delta_rad", [](std::ostream& out, double t, double x, double y, double, double,
                                         double delta) { out << t << ',' << x << ',' << y << ',' << delta << '\n'; });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "delta": "delta_rad"}})");
  const SessionFile file = read_session(log, map);
  EXPECT_TRUE(file.derived_velocity);
  EXPECT_TRUE(file.derived_yaw);
  EXPECT_NEAR(file.session.at(100, 3), 10.0, 1e-6);
  EXPECT_TRUE(file.session.has[2]);
  EXPECT_FALSE(file.session.has[5]);
}

TEST(SessionFile, ASpeedThatIsThereIsNotDerivedWithTheCourse) {
  const auto log = log_of("t_s,x_m,y_m,vx_mps,delta_rad",
                          [](std::ostream& out, double t, double x, double y, double, double, double delta) {
                            out << t << ',' << x << ',' << y << ",9.5," << delta << '\n';
                          });
  const LogMap map =
      map_of(R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "vx": "vx_mps", "delta": "delta_rad"}})");
  const SessionFile file = read_session(log, map);
  EXPECT_FALSE(file.derived_velocity);
  EXPECT_EQ(file.session.at(100, 3), 9.5);
  EXPECT_TRUE(file.session.has[2]);
}

/// The weaving car, its places those of an antenna ahead of the centre of gravity and to its left.
std::filesystem::path antenna_log(double ahead, double left) {
  return log_of("t,px,py,psi,r,steer", [=](std::ostream& out, double t, double x, double y, double yaw, double rate,
                                           double delta) {
    out << t << ',' << x + ahead * std::cos(yaw) - left * std::sin(yaw) << ','
        << y + ahead * std::sin(yaw) + left * std::cos(yaw) << ',' << yaw + 0.1 << ',' << rate << ',' << delta << '\n';
  });
}

TEST(SessionFile, AVelocityThatIsDerivedIsOfThePointThatThePlacesShow) {
  const SessionFile file = read_session(antenna_log(0.8, 0.5), map_of(R"({"time": "t", "channels": {
    "x": {"column": "px", "frame": {"x": "0.8 m", "y": "0.5 m"}}, "y": "py",
    "yaw": {"column": "psi", "frame": {"yaw": "0.1 rad"}}, "yaw_rate": "r", "delta": "steer"}})"));
  const Frame& of = file.session.velocity;
  EXPECT_EQ(of.x, 0.8);
  EXPECT_EQ(of.y, 0.5);
  EXPECT_EQ(of.yaw, 0.0) << "it is derived in the car's axes";
  const Session centre = at_centre_of_gravity(file);
  for (std::size_t i = 1; i < centre.rows(); ++i) {
    ASSERT_NEAR(centre.at(i, Channel::vx), 10.0, 0.03) << i;
    ASSERT_NEAR(centre.at(i, Channel::vy), 0.0, 0.2) << i << ": half a step late";
  }
}

/// How far to the side of the car a point lies changes its vx alone, how far ahead its vy alone.
TEST(SessionFile, BesideAVyThatIsReadADerivedVxIsOfThePlacesPoint) {
  const LogMap map = map_of(R"({"time": "t", "channels": {
    "x": {"column": "px", "frame": {"x": "0.8 m", "y": "0.5 m"}}, "y": "py",
    "yaw": {"column": "psi", "frame": {"yaw": "0.1 rad"}}, "yaw_rate": "r", "delta": "steer",
    "vy": {"formula": "0.2 * r", "frame": {"x": "0.2 m", "y": "0.9 m"}}}})");
  const Session centre = at_centre_of_gravity(read_session(antenna_log(0.8, 0.5), map));
  for (std::size_t i = 1; i < centre.rows(); ++i) {
    ASSERT_NEAR(centre.at(i, Channel::vx), 10.0, 0.03) << i;
    ASSERT_NEAR(centre.at(i, Channel::vy), 0.0, 1e-9) << i;
  }
}

/// vy of a unit that is turned by half a radian holds a part of the speed: vx along the car's axis is none of its own.
TEST(SessionFile, BesideAVyOfTurnedAxesADerivedVxIsAlongThem) {
  const std::string unit = R"("frame": {"x": "0.2 m", "y": "0.9 m", "yaw": "0.5 rad"})";
  const LogMap with_yaw = map_of(R"({"time": "t", "channels": {
    "x": {"column": "px", "frame": {"x": "0.8 m", "y": "0.5 m"}}, "y": "py",
    "yaw": {"column": "psi", "frame": {"yaw": "0.1 rad"}}, "yaw_rate": "r", "delta": "steer",
    "vy": {"formula": "cos(0.5) * 0.2 * r - (10 - 0.9 * r) * 0.4794255386", )" +
                                 unit + "}}}");
  const LogMap by_course = map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "delta": "steer",
    "vy": {"formula": "0 * r - 10 * 0.4794255386", )" +
                                  unit + "}}}");
  for (const Session& centre : {at_centre_of_gravity(read_session(antenna_log(0.8, 0.5), with_yaw)),
                                at_centre_of_gravity(read_session(antenna_log(0.0, 0.0), by_course))})
    for (std::size_t i = 1; i < centre.rows(); ++i) {
      ASSERT_NEAR(centre.at(i, Channel::vx), 10.0, 0.1) << i << ": half a step late";
      ASSERT_NEAR(centre.at(i, Channel::vy), 0.0, 0.1) << i;
    }
}

TEST(SessionFile, ACourseHasNoAxesThatAMapCouldTurn) {
  const SessionFile file = read_session(antenna_log(0.0, 0.0), map_of(R"({"time": "t", "channels": {
    "x": {"column": "px", "frame": {"yaw": "0.1 rad"}}, "y": "py", "yaw_rate": "r", "delta": "steer"}})"));
  ASSERT_TRUE(file.derived_yaw);
  const Session centre = at_centre_of_gravity(file);
  for (std::size_t i = 1; i < centre.rows(); ++i)
    ASSERT_EQ(centre.at(i, Channel::yaw), file.session.at(i, Channel::yaw)) << i;
}

/// What is read of a log with steering and, at some times, places.
Session session_of_places(bool (*shown)(double t)) {
  const auto log =
      log_of("t,px,py,steer", [=](std::ostream& out, double t, double x, double y, double, double, double d) {
        out << t << ',';
        if (shown(t))
          out << x << ',' << y;
        else
          out << ',';
        out << ',' << d << '\n';
      });
  return read_session(log, map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "delta": "steer"}})")).session;
}

TEST(SessionFile, OverAGapNoVelocityIsDerived) {
  const Session s = session_of_places([](double t) { return t < 10.0 - 1e-9 || t > 12.0 - 1e-9; });
  EXPECT_TRUE(std::isnan(s.at(240, Channel::vx)) && std::isnan(s.at(240, Channel::yaw)));
  EXPECT_NEAR(s.at(241, Channel::vx), 10.0, 1e-6);
}

TEST(SessionFile, FromPlacesThatAreAlwaysFarApartVelocitiesAreDerived) {
  const Session s = session_of_places([](double t) { return std::lround(t / 0.05) % 10 == 0; });  // at 2 Hz
  EXPECT_NEAR(s.at(100, Channel::vx), 10.0, 0.2);
}

TEST(SessionFile, LatitudeAndLongitudeBecomeAPlane) {
  const auto log =
      log_of("t,lat,lon,steer", [](std::ostream& out, double t, double x, double y, double, double, double d) {
        out << t << ',' << 48.0 + y / 111197.0 << ',' << 11.0 + x / 74631.0 << ',' << d << '\n';
      });
  const LogMap stated = map_of(R"({"time": "t", "channels": {"latitude": {"column": "lat", "unit": "deg"},
    "longitude": {"column": "lon", "unit": "deg"}, "delta": "steer"}})");
  EXPECT_NEAR(read_session(log, stated).session.at(400, 3), 10.0, 0.05);
  // A map that leaves the unit out: no radians are so large.
  const LogMap bare = map_of(R"({"time": "t", "channels": {"latitude": "lat", "longitude": "lon", "delta": "steer"}})");
  const SessionFile file = read_session(log, bare);
  EXPECT_NEAR(file.session.at(400, 3), 10.0, 0.05);
  EXPECT_TRUE(std::ranges::any_of(file.findings, [](const Finding& f) { return f.check == "unit"; }));
}

TEST(SessionFile, LatitudesInRadiansStayWhatTheyAre) {
  const auto log =
      log_of("t,lat,lon,steer", [](std::ostream& out, double t, double x, double y, double, double, double d) {
        out << t << ',' << 0.8 + y / 6371000.0 << ',' << 0.2 + x / (6371000.0 * 0.6967) << ',' << d << '\n';
      });
  const LogMap map = map_of(R"({"time": "t", "channels": {"latitude": "lat", "longitude": "lon", "delta": "steer"}})");
  const SessionFile file = read_session(log, map);
  EXPECT_NEAR(file.session.at(400, 3), 10.0, 0.1);
  EXPECT_FALSE(std::ranges::any_of(file.findings, [](const Finding& f) { return f.check == "unit"; }));
}

TEST(SessionFile, MapsAreReadStrictly) {
  const auto refused = [](const std::string& text) -> std::string {
    try {
      map_of(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return "read";
  };
  EXPECT_THAT(refused(channels_json(R"(, "vy": {"column": "v", "unit": "kg"})")),
              AllOf(HasSubstr("/channels/vy"), HasSubstr("unit")));
  EXPECT_THAT(refused(channels_json(R"(, "vi": {"column": "v"})")), HasSubstr("unknown key \"vi\""));
  EXPECT_THAT(refused(channels_json(R"(, "vy": {"column": "v", "formula": "v"})")), HasSubstr("either"));
  EXPECT_THAT(refused(channels_json(R"(, "vy": {"column": "v", "delay": "0.1 s"})")), HasSubstr("delay differs"));
  EXPECT_THAT(refused(R"({"time": "t", "channels": {"vx": "v", "yaw_rate": "r"}})"), HasSubstr("delta is missing"));
}

TEST(SessionFile, TimeMustRunForward) {
  const auto log = log_of("t,px,py,psi,v,r,steer", [](std::ostream& out, double t, double x, double y, double yaw,
                                                      double rate, double delta) {
    out << (t > 20 ? t - 5 : t) << ',' << x << ',' << y << ',' << yaw << ",10," << rate << ',' << delta << '\n';
  });
  EXPECT_THAT(why(log, map_of(channels_json(""))),
              AllOf(HasSubstr("time runs backward by 4.95 s, from 20 s to 15.05"), HasSubstr("cut the log")));
}

TEST(SessionFile, RowsBeforeTheFirstCommandAreLeftOut) {
  const auto log =
      log_of("t,v,r,steer", [](std::ostream& out, double t, double, double, double, double rate, double d) {
        out << t << ",10," << rate << ',';
        if (t > 20.0 - 1e-9) out << d + 1.0;
        out << '\n';
      });
  const SessionFile file = read_session(log, speed_map());
  EXPECT_EQ(file.session.rows(), 400u);
  EXPECT_NEAR(file.session.t.front(), 20.0, 1e-9);
  EXPECT_GT(file.session.command.front().delta, 0.5);
  EXPECT_EQ(file.session.reading.size(), 400u * channels);
  EXPECT_THAT(notes_of(file),
              HasSubstr("commands: 400 rows before the first value of throttle and steering; left out"));
}

TEST(SessionFile, RowsOfOneTimeStampFillEachOther) {
  const auto log =
      log_of("t,v,r,steer", [](std::ostream& out, double t, double, double, double, double rate, double d) {
        out << t << ",10,,\n" << t << ",11," << rate << ",\n" << t << ",,," << d + 1.0 << '\n';
      });
  const SessionFile file = read_session(log, speed_map());
  const Session& s = file.session;
  ASSERT_EQ(s.rows(), 800u);
  for (const std::size_t i : {0u, 100u, 799u}) {
    EXPECT_EQ(s.at(i, Channel::vx), 10.0);
    EXPECT_NEAR(s.at(i, Channel::yaw_rate), 0.6 * std::sin(0.8 * s.t[i]), 1e-9);
    EXPECT_GT(s.command[i].delta, 0.5);
  }
  EXPECT_THAT(notes_of(file), HasSubstr("rows: 1600 repeat a time stamp; they fill the empty cells"));
}

/// A car that weaves to the east at 48 deg N; the caller says where the longitude begins [deg].
std::filesystem::path log_on_earth(double longitude, double begin = 0.0) {
  return log_of("t,lat,lon,steer", [=](std::ostream& out, double t, double x, double y, double, double, double d) {
    out << t << ',';
    if (t < begin)
      out << "0,0";
    else
      out << 48.0 + y / 111197.0 << ',' << std::fmod(longitude + x / 74631.0, 360.0);
    out << ',' << d << '\n';
  });
}

LogMap earth_map(const std::string& latitude = R"({"column": "lat", "unit": "deg"})") {
  return map_of(R"({"time": "t", "channels": {"latitude": )" + latitude +
                R"(, "longitude": {"column": "lon", "unit": "deg"}, "delta": "steer"}})");
}

TEST(SessionFile, LongitudesThatAreDegreesAreConvertedOnce) {
  for (const double longitude : {352.0, 359.999}) {
    const SessionFile file = read_session(log_on_earth(longitude), earth_map());
    EXPECT_NEAR(file.session.at(400, Channel::vx), 10.0, 0.05);
    EXPECT_LT(std::abs(file.session.at(799, Channel::x)), 410.0);
    EXPECT_EQ(notes_of(file).find("unit: "), std::string::npos);
  }
}

/// Letters of a column's name are no arithmetic that converts already.
TEST(SessionFile, DegreesAreSeenWhateverTheColumnIsCalled) {
  std::ofstream out(scratch("pixhawk.csv"));
  out << "t,pixhawk_lat,pixhawk_lon,steer\n";
  for (int k = 0; k < 400; ++k) out << 0.02 * k << ',' << 48.0 + 1e-6 * k << ",11.0,0.01\n";
  out.close();
  const LogMap map =
      map_of(R"({"time": "t", "channels": {"latitude": "pixhawk_lat", "longitude": "pixhawk_lon", "delta": "steer"}})");
  const SessionFile file = read_session(scratch("pixhawk.csv"), map);
  EXPECT_THAT(notes_of(file), HasSubstr("taken for degrees"));
  EXPECT_NEAR(file.session.at(399, Channel::y), 44.4, 0.1);
}

TEST(SessionFile, ALatitudeBeyondThePoleIsRefused) {
  EXPECT_THAT(why(log_on_earth(11.0), earth_map(R"({"formula": "100 * lat", "unit": "deg"})")),
              AllOf(HasSubstr("the latitude is 4800 deg"), HasSubstr("NMEA's ddmm.mmmm"), HasSubstr(":2:")));
}

TEST(SessionFile, LatitudeAndLongitudeZeroAreNoPlace) {
  const SessionFile file = read_session(log_on_earth(11.0, 4.99), earth_map());
  EXPECT_TRUE(std::isnan(file.session.at(99, Channel::x)));
  EXPECT_EQ(file.session.at(100, Channel::x), 0.0);
  EXPECT_LT(std::abs(file.session.at(799, Channel::x)), 410.0);
  EXPECT_THAT(notes_of(file), HasSubstr("place: 100 rows have the latitude and longitude 0, 0"));
}

TEST(SessionFile, AColumnWithoutANumberIsAbsent) {
  const auto log = log_of("t_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double x, double y, double, double rate, double d) {
                            out << t << ',' << x << ',' << y << ",nan,10," << rate << ',' << d << '\n';
                          });
  const SessionFile file = read_session(log, gripline_map());
  EXPECT_TRUE(file.derived_yaw);
  EXPECT_TRUE(file.session.has[Channel::yaw]);  // the course
  EXPECT_THAT(notes_of(file), AllOf(HasSubstr("yaw: no number in its column; taken for absent"),
                                    HasSubstr("yaw: absent; the course over ground is taken")));
}

TEST(SessionFile, AClockThatIsSetAfterTheFirstRowsLeavesThemOut) {
  const auto log = log_with([](std::ostream& out, double t) { out << (t < 0.11 ? t : 1700000000.0 + t) << ",10"; });
  const SessionFile file = read_session(log, speed_map());
  EXPECT_EQ(file.session.rows(), 797u);
  EXPECT_GT(file.session.begin, 1.6e9);
  EXPECT_EQ(file.session.t.front(), 0.0);
  EXPECT_THAT(notes_of(file), HasSubstr("rows: 3 before the clock was set; left out"));
  const auto later = log_with([](std::ostream& out, double t) { out << (t < 20.0 - 1e-9 ? t : 90000.0 + t) << ",10"; });
  EXPECT_THAT(why(later, speed_map()), AllOf(HasSubstr("the clock was set here"), HasSubstr("log.csv:402:")));
}

TEST(SessionFile, ALogOfUnixTimeIsReadAsOneThatBeginsAtZero) {
  const auto log = [](double begin) {
    return log_of("t,v,r,steer", [begin](std::ostream& out, double t, double, double, double, double rate, double d) {
      out << std::fixed << std::setprecision(3) << begin + t << std::defaultfloat << ",10," << rate << ',' << d << '\n';
    });
  };
  const SessionFile zero = read_session(log(0.0), speed_map()),
                    since_1970 = read_session(log(1712345678.0), speed_map());
  EXPECT_EQ(since_1970.session.begin, 1712345678.0);
  EXPECT_EQ(since_1970.session.t, zero.session.t);
  EXPECT_EQ(since_1970.session.at(799, Channel::yaw_rate), zero.session.at(799, Channel::yaw_rate));
}

TEST(SessionFile, RowsInBurstsAreNoMilliseconds) {
  const auto log =
      log_of("t,v,r,steer", [](std::ostream& out, double t, double, double, double, double rate, double d) {
        out << t << ",10,,\n" << t + 6e-5 << ",," << rate << ",\n" << t + 1.2e-4 << ",,," << d << '\n';
        out << t + 1.8e-4 << ",,,\n";
      });
  EXPECT_NEAR(read_session(log, speed_map()).row_step, 0.0125, 1e-4);
  const auto in_ms = log_with([](std::ostream& out, double t) { out << 1e-3 * t << ",10"; });
  EXPECT_THAT(why(in_ms, speed_map()), HasSubstr("time was taken for milliseconds"));
}

TEST(SessionFile, PlaceholdersBeforeTheFirstFixAreLeftOut) {
  const auto log = log_of("t,px,py,psi,v,r,steer",
                          [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                            const bool fixed = t > 4.99;
                            out << t << ',' << (fixed ? x : -9999) << ',' << (fixed ? y : -9999) << ',' << yaw << ",10,"
                                << rate << ',' << delta << '\n';
                          });
  for (const char* hold : {"", R"(, "hold": "held")"}) {
    const SessionFile file = read_session(log, map_of(std::string(R"({"time": "t", "channels": {
      "x": {"column": "px")") + hold + R"(}, "y": {"column": "py")" +
                                                      hold + R"(}, "yaw": "psi", "vx": "v",
      "yaw_rate": "r", "delta": "steer"}})"));
    EXPECT_TRUE(std::isnan(file.session.at(0, Channel::x)));
    EXPECT_TRUE(std::isnan(file.session.at(99, Channel::x)));
    EXPECT_FALSE(std::isnan(file.session.at(100, Channel::x)));
    EXPECT_THAT(notes_of(file), HasSubstr("place: 100 rows at the beginning show -9999, -9999, far from the rest"));
  }
}

TEST(SessionFile, PlaceholdersAreSeenBehindRowsThatAreNotValid) {
  const auto log = log_of("t,px,py,psi,v,r,steer,ok", [](std::ostream& out, double t, double x, double y, double yaw,
                                                         double rate, double delta) {
    const bool valid = t > 1.99;
    if (t < 4.99) x = y = valid ? -9999 : 40 * t;
    out << t << ',' << x << ',' << y << ',' << yaw << ",10," << rate << ',' << delta << ',' << valid << '\n';
  });
  const SessionFile file = read_session(log, map_of(R"({"time": "t", "valid": "ok", "channels": {
    "x": "px", "y": "py", "yaw": "psi", "vx": "v", "yaw_rate": "r", "delta": "steer"}})"));
  for (const std::size_t row : {20u, 40u, 99u}) EXPECT_TRUE(std::isnan(file.session.at(row, Channel::x))) << row;
  EXPECT_FALSE(std::isnan(file.session.at(100, Channel::x)));
  EXPECT_THAT(notes_of(file), HasSubstr("place: 60 rows at the beginning show -9999, -9999, far from the rest"));
}

TEST(SessionFile, APlaceOnEarthOfBeforeTheFirstFixIsLeftOutWhereReadingsAreHeld) {
  const auto log =
      log_of("t,lat,lon,v,r,steer", [](std::ostream& out, double t, double, double, double, double rate, double delta) {
        const double read = 0.2 * std::floor(5.0 * t + 1e-6);  // in every fourth row
        const bool fixed = t > 1.99;
        out << t << ',' << (fixed ? 48 + 1e-4 * read : 45) << ',' << (fixed ? 11 + 1e-5 * read : 10) << ",10," << rate
            << ',' << delta << '\n';
      });
  const SessionFile file = read_session(log, map_of(R"({"time": "t", "channels": {
    "latitude": {"column": "lat", "unit": "deg", "hold": "held"},
    "longitude": {"column": "lon", "unit": "deg", "hold": "held"}, "vx": "v", "yaw_rate": "r", "delta": "steer"}})"));
  EXPECT_THAT(notes_of(file), HasSubstr("40 rows at the beginning show the latitude and longitude 45, 10 deg"));
  EXPECT_TRUE(std::isnan(file.session.at(0, Channel::x)));
  EXPECT_EQ(file.session.at(40, Channel::x), 0.0);
  EXPECT_TRUE(std::isnan(file.session.at(42, Channel::x))) << "held";
  EXPECT_NEAR(file.session.at(44, Channel::y), 1e-4 * 0.2 * 111200.0, 0.01);
}

TEST(SessionFile, ALatitudeWithoutALongitudeIsNoPlace) {
  const auto log = log_of("t,lat,lon,v,r,steer",
                          [](std::ostream& out, double t, double, double y, double, double rate, double delta) {
                            out << t << ',' << 48.0 + 1e-5 * y << ",,10," << rate << ',' << delta << '\n';
                          });
  const SessionFile file = read_session(log, map_of(R"({"time": "t", "channels": {"latitude": "lat",
    "longitude": "lon", "vx": "v", "yaw_rate": "r", "delta": "steer"}})"));
  EXPECT_FALSE(file.session.has[Channel::x]);
  EXPECT_FALSE(file.session.has[Channel::y]);
  EXPECT_THAT(notes_of(file), HasSubstr("no number in its column"));
}

}  // namespace test_session_file
}  // namespace gripline::measured
