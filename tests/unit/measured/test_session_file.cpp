#include "measured/session_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <random>
#include <sstream>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "support/scratch.hpp"

namespace gripline::measured {
namespace test_session_file {

using testing::AllOf;
using testing::HasSubstr;
using testing_support::scratch;
constexpr double pi = std::numbers::pi;

/// A car that weaves at 10 m/s: its rows by a printer of one row.
template <class Row>
std::filesystem::path log_of(const std::string& header, Row row, double seconds = 40.0, double dt = 0.05) {
  const auto file = scratch("log.csv");
  std::ofstream out(file);
  out.precision(12);
  out << header << '\n';
  double x = 0, y = 0, yaw = 0;
  const auto rows = std::lround(seconds / dt);
  for (long k = 0; k < rows; ++k) {
    const double t = static_cast<double>(k) * dt;
    const double rate = 0.6 * std::sin(0.8 * t), delta = rate * 2.6 / 10.0;
    row(out, t, x, y, yaw, rate, delta);
    x += 10.0 * dt * std::cos(yaw + 0.5 * dt * rate);
    y += 10.0 * dt * std::sin(yaw + 0.5 * dt * rate);
    yaw += dt * rate;
  }
  return file;
}

std::filesystem::path plain_log() {
  return log_of("t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad",
                [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                  out << t << ',' << x << ',' << y << ',' << std::remainder(yaw + 3.0, 2 * pi) - 0.0 << ",10,0," << rate
                      << ",0.2," << delta << '\n';
                });
}

LogMap map_of(const std::string& text) {
  const auto file = scratch("map.json");
  std::ofstream(file) << text;
  return load_log_map(file);
}

std::string channels_json(const std::string& more) {
  return R"({"time": {"column": "t"}, "channels": {"x": {"column": "px"}, "y": {"column": "py"},
    "yaw": {"column": "psi"}, "vx": {"column": "v"}, "yaw_rate": {"column": "r"}, "d": {"formula": "0.2 + 0 * t"},
    "delta": {"column": "steer"})" +
         more + "}}";
}

std::filesystem::path own_log(double speed_factor = 1, double steer_sign = 1, double yaw_sign = 1) {
  return log_of("t,px,py,psi,v,r,steer",
                [&](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                  out << t << ',' << x << ',' << y << ',' << yaw_sign * yaw << ',' << 10 * speed_factor << ',' << rate
                      << ',' << steer_sign * delta << '\n';
                });
}

std::string why(const std::filesystem::path& log, const LogMap& map) {
  try {
    check_session(read_session(log, map), 10.0);
  } catch (const InputError& e) {
    return e.what();
  }
  return "fine";
}

TEST(SessionFile, ReadsGriplinesOwnColumnsAndUnwrapsYaw) {
  const SessionFile file = read_session(plain_log(), gripline_map());
  const Session& s = file.session;
  EXPECT_EQ(s.rows(), 800u);
  EXPECT_NEAR(file.row_step, 0.05, 1e-9);
  EXPECT_TRUE(file.has_throttle);
  for (std::size_t i = 1; i < s.rows(); ++i) EXPECT_LT(std::abs(s.at(i, 2) - s.at(i - 1, 2)), 0.2);
  EXPECT_EQ(s.command[5].d, 0.2);
}

TEST(SessionFile, UnitsSignsAndFormulasAreApplied) {
  const auto log = log_of(
      "ms;east;kmh;wheel;gas;off", [](std::ostream& out, double t, double x, double, double, double, double delta) {
        out << 1000 * t << ';' << x << ";36;" << -15 * delta * 180 / pi << ";25;" << (t > 20 ? 1 : 0) << '\n';
      });
  const LogMap map = map_of(R"map({"time": {"column": "ms", "unit": "ms"}, "channels": {
    "vx": {"column": "kmh", "unit": "km/h"}, "yaw_rate": {"formula": "0 * kmh"},
    "delta": {"formula": "wheel / 15", "unit": "deg", "sign": -1},
    "d": {"formula": "if(off > 0.5, 0, gas / 100)"}}})map");
  const Session s = read_session(log, map).session;
  EXPECT_NEAR(s.t[1], 0.05, 1e-12);
  EXPECT_NEAR(s.at(3, 3), 10.0, 1e-12);
  EXPECT_NEAR(s.command[100].delta, 0.6 * std::sin(0.8 * 5.0) * 0.26, 1e-9);
  EXPECT_EQ(s.command[100].d, 0.25);
  EXPECT_EQ(s.command[500].d, 0.0);
  EXPECT_FALSE(s.has[0]);
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

TEST(SessionFile, ACommandThatChangesMoreOftenThanTheMapSaysIsSaid) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double) {
                            out << t << ",10," << rate << ',' << 0.01 * std::sin(std::floor(t / 0.1 + 1e-6)) << '\n';
                          });
  const auto said = [&](const char* every) {
    std::string text = R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
      "delta": {"column": "delta_rad", "kind": "command", "every": ")";
    text.append(every).append("\"}}}");
    for (const Finding& f : read_session(log, map_of(text)).findings)
      if (f.check == "steering") return std::string(f.found).append("; ").append(f.done);
    return std::string();
  };
  EXPECT_EQ(said("0.1 s"), "");
  EXPECT_EQ(
      said("0.2 s"),
      "changes every 0.1 s, the map says read every 0.2 s; 397 of 399 changes are taken as they stand in the rows");
}

TEST(SessionFile, ChangesThatComeTooSoonForAWhileAreCountedAsTheyAreRead) {
  // Every 0.1 s for the first four seconds, every 0.2 s after: read one by one, changes up to about 12 s stand.
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double) {
                            const double pace = t < 4.0 - 1e-6 ? 0.1 : 0.2;
                            out << t << ",10," << rate << ',' << 0.01 * std::sin(std::floor(t / pace + 1e-6)) << '\n';
                          });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
    "delta": {"column": "delta_rad", "kind": "command", "every": "0.2 s"}}})");
  const SessionFile file = read_session(log, map);
  std::string done;
  for (const Finding& f : file.findings)
    if (f.check == "steering") done = f.done;
  const CommandGrid grid(file.session, 0.01);
  std::size_t stand = 0, changes = 0;
  for (std::size_t i = 1; i < file.session.rows(); ++i) {
    if (file.session.command[i].delta == file.session.command[i - 1].delta) continue;
    ++changes;
    const auto k = static_cast<std::size_t>(std::lround((file.session.t[i] - grid.t0) / grid.dt));
    stand += grid.fixed_at[1][k - 8] < file.session.t[i] - 1e-9;  // no straight line leads there
  }
  EXPECT_GT(stand, 40u);
  EXPECT_LT(stand, changes / 2);
  EXPECT_EQ(done, std::to_string(stand).append(" of ").append(std::to_string(changes)) +
                      " changes are taken as they stand in the rows");
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

TEST(SessionFile, AColumnThatIsNotThereIsToldAtTheMapWithTheNearestName) {
  const LogMap map = map_of(channels_json(R"(, "vy": {"column": "stear"})"));
  const std::string message = why(own_log(), map);
  EXPECT_THAT(message, AllOf(HasSubstr("map.json"), HasSubstr("/channels/vy"), HasSubstr("did you mean \"steer\"?")));
  EXPECT_THAT(why(own_log(), gripline_map()), HasSubstr("columns missing"));
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

std::string notes_of(const SessionFile& file) {
  std::string all;
  for (const Finding& f : file.findings)
    all.append(f.check).append(": ").append(f.found).append("; ").append(f.done) += '\n';
  return all;
}

LogMap speed_map(const std::string& delta = R"("steer")") {
  return map_of(R"({"time": "t", "channels": {"vx": "v", "yaw_rate": "r", "delta": )" + delta + "}}");
}

/// A log of t, v, r and steer whose times and speeds are printed by the caller.
template <class Begin>
std::filesystem::path log_with(Begin begin, double dt = 0.05) {
  return log_of(
      "t,v,r,steer",
      [&](std::ostream& out, double t, double, double, double, double rate, double delta) {
        begin(out, t);
        out << ',' << rate << ',' << delta << '\n';
      },
      40.0, dt);
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

TEST(SessionFile, AColumnThatIsReadStandsOnceInTheHeader) {
  const auto twice = [](const char* header) {
    return log_of(header, [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
      out << t << ',' << x << ',' << y << ',' << yaw << ",10," << rate << ",0.2," << delta << ',' << x << '\n';
    });
  };
  EXPECT_THAT(why(twice("t_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,d,delta_rad,x_m"), gripline_map()),
              HasSubstr("column x_m stands more than once in the header"));
  EXPECT_EQ(why(twice("t_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,d,delta_rad,spare"), gripline_map()), "fine");
  const LogMap map = map_of(R"({"time": "t", "channels": {"x": "x", "y": "y", "delta": "delta"}})");
  EXPECT_THAT(why(twice("t,x,y,yaw,v,r,d,delta,x"), map), HasSubstr("column x stands more than once"));
  EXPECT_EQ(why(twice("t,x,y,d,v,r,d,delta,spare"), map), "fine") << "one that is not read";
}

TEST(SessionFile, TextWhereNumbersBelongIsSaid) {
  const auto some =
      log_with([](std::ostream& out, double t) { out << t << ',' << (t > 9.99 && t < 10.99 ? "10 m/s" : "10"); });
  const SessionFile file = read_session(some, speed_map());
  EXPECT_TRUE(std::isnan(file.session.at(200, Channel::vx)));
  EXPECT_THAT(notes_of(file), HasSubstr("cells: v: 20 are no numbers, the first \"10 m/s\" in line 202; taken"));
  const auto all = log_with([](std::ostream& out, double t) { out << t << ",1.0D+01"; });
  EXPECT_THAT(why(all, speed_map()), AllOf(HasSubstr("column v: none of its cells is a number"),
                                           HasSubstr("\"1.0D+01\""), HasSubstr("log.csv:2:")));
  const auto time = log_with([](std::ostream& out, double t) { out << t << " PM,10"; });
  EXPECT_THAT(why(time, speed_map()), AllOf(HasSubstr("column t: none"), HasSubstr("times are read as 12.5, 1:02.5")));
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

TEST(SessionChecks, AGoodLogPasses) { EXPECT_EQ(why(own_log(), map_of(channels_json(""))), "fine"); }

TEST(SessionChecks, UnitsAndSignsAreToldWithTheirEvidence) {
  const LogMap map = map_of(channels_json(""));
  EXPECT_THAT(why(own_log(3.6), map), HasSubstr("times the speed at which x and y move: vx looks like km/h"));
  EXPECT_THAT(why(own_log(1, -1), map), AllOf(HasSubstr("turns against its steering"), HasSubstr("correlate at -")));
  EXPECT_THAT(why(own_log(1, 60), map), HasSubstr("degrees"));
  EXPECT_THAT(why(own_log(1, 1, 57.3), map), HasSubstr("yaw looks like degrees"));
  EXPECT_THAT(why(own_log(1, 1, -1), map), HasSubstr("other sign"));
}

/// Advice that is followed leaves the right speed, not one that is off by a sixth and passes.
TEST(SessionChecks, UnitsOfSpeedNearEachOtherAreToldApart) {
  const LogMap map = map_of(channels_json(""));
  EXPECT_THAT(why(own_log(3600.0 / 1852.0), map), HasSubstr("vx looks like knots (\"unit\": \"kn\")"));
  EXPECT_THAT(why(own_log(1 / 0.44704), map), HasSubstr("vx looks like mph (\"unit\": \"mph\")"));
  EXPECT_THAT(why(own_log(1 / 0.3048), map), HasSubstr("vx looks like ft/s (\"unit\": \"ft/s\")"));
  for (const double none : {0.3048, 1.75, 2.8, 4.2})
    EXPECT_THAT(why(own_log(none), map), HasSubstr("; expected about 1")) << none;
}

/// A receiver at 5 Hz beside a gyroscope in every row.
TEST(SessionChecks, ChannelsThatAreReadLessOftenThanRowsAreCheckedAllTheSame) {
  const auto log = [](double speed_factor) {
    return log_of("t,px,py,psi,v,r,steer",
                  [=](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                    out << t << ',';
                    if (std::lround(t / 0.05) % 4 == 0)
                      out << x << ',' << y << ',' << yaw << ',' << 10 * speed_factor;
                    else
                      out << ",,,";
                    out << ',' << rate << ',' << delta << '\n';
                  });
  };
  const LogMap map = map_of(channels_json(""));
  EXPECT_EQ(why(log(1.0), map), "fine");
  EXPECT_THAT(why(log(3.6), map), HasSubstr("vx looks like km/h"));
}

/// The weaving car with a throttle, through a map with this unit of time, formulas of the place and throttle.
std::string why_with(const char* time, const char* place, const char* d) {
  const auto log = log_of("t,px,py,psi,v,steer,go",
                          [](std::ostream& out, double t, double px, double py, double psi, double, double delta) {
                            out << t << ',' << px << ',' << py << ',' << psi << ',' << 10.0 + 3.0 * std::sin(0.3 * t)
                                << ',' << delta << ',' << 0.3 + 0.2 * std::cos(0.3 * t) << '\n';
                          });
  std::string text = R"({"time": {"column": "t", "unit": ")";
  text.append(time).append(R"("}, "channels": {"x": "px)").append(place).append(R"(", "y": "py)").append(place);
  text.append(R"(", "yaw": "psi", "vx": "v", "d": ")").append(d).append(R"(", "delta": "steer"}})");
  return why(log, map_of(text));
}

TEST(SessionChecks, UnitsAndSignsThatAMapGivesToGoodNumbersAreTold) {
  EXPECT_EQ(why_with("s", "", "go"), "fine");
  EXPECT_THAT(why_with("ms", "", "go"), HasSubstr("time was taken for milliseconds and is seconds"));
  EXPECT_THAT(why_with("s", " / 1000", "go"), HasSubstr("x and y were taken for millimetres and are metres"));
  EXPECT_THAT(why_with("s", "", "-go"), HasSubstr("d is never above 0"));
}

TEST(SessionChecks, AYawInRadiansThatIsTakenForDegreesIsTold) {
  const auto log = log_of("t,px,py,psi,v,steer",
                          [](std::ostream& out, double t, double, double, double, double, double) {  // a circle
                            const double yaw = 0.5 * t;
                            out << t << ',' << 20 * std::sin(yaw) << ',' << -20 * std::cos(yaw) << ','
                                << std::remainder(yaw, 2 * pi) << ",10,0.13\n";
                          });
  const LogMap map = map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "vx": "v", "delta": "steer",
    "yaw": {"column": "psi", "unit": "deg"}}})");
  EXPECT_THAT(why(log, map), HasSubstr("yaw was taken for degrees and is radians"));
}

TEST(SessionChecks, SteeringThatTheCarDoesNotFollowIsDoubted) {
  const auto found = [](const char* formula, const char* sideways) {
    const auto log = log_of("t,px,py,psi,v,r,steer", [](std::ostream& out, double t, double x, double y, double yaw,
                                                        double rate, double delta) {
      const double lean = 0.05 * std::sin(0.8 * t + 1.0);  // the heading is off the path
      out << t << ',' << x << ',' << y << ',' << yaw + lean << ",10," << rate << ',' << delta << '\n';
    });
    std::string text = R"({"time": "t", "channels": {"x": "px", "y": "py", "yaw": "psi", "vx": "v", "yaw_rate": "r",
      "delta": ")";
    text.append(formula).append(R"(", "vy": ")").append(sideways).append("\"}}");
    std::string names;
    for (const Finding& f : doubts_about(read_session(log, map_of(text)))) names.append(f.check).append(" ");
    return names;
  };
  EXPECT_EQ(found("steer", "-10 * sin(0.05 * sin(0.8 * t + 1.0))"), "");
  EXPECT_EQ(found("0.2 * sin(3.1 * t)", "-10 * sin(0.05 * sin(0.8 * t + 1.0))"), "delta ");
  EXPECT_EQ(found("steer", "10 * sin(0.05 * sin(0.8 * t + 1.0))"), "vy ");
}

/// A minute of a small car that weaves quickly, with noise of its sensors; a row every `dt`. `sign`: of vy as written.
SessionFile quick_weave(double dt, double sign) {
  constexpr double h = 0.001;
  const auto vx = [](double t) { return 1.5 + 0.3 * std::sin(0.5 * t); };
  const auto vy = [](double t) { return 0.12 * std::sin(9.0 * t) + 0.03 * std::sin(2.0 * t); };
  const auto rate = [](double t) { return 1.4 * std::sin(9.0 * t + 0.2) + 0.4 * std::sin(2.0 * t); };
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  SessionFile file;
  Session& s = file.session;
  s.has.fill(true);
  const auto every = static_cast<long>(std::round(dt / h));
  double x = 0.0, y = 0.0, yaw = 0.0;
  for (long k = 0; k < 60000; ++k) {
    const double t = h * static_cast<double>(k);
    if (k % every == 0) {
      s.t.push_back(t);
      s.command.push_back({0.3, 0.12 * std::sin(9.0 * t + 0.2) + 0.04 * std::sin(2.0 * t)});
      for (const auto& [value, noise] :
           {std::pair(x, 0.01), {y, 0.01}, {yaw, 0.001}, {vx(t), 0.01}, {sign * vy(t), 0.01}, {rate(t), 0.001}})
        s.reading.push_back(value + noise * normal(random));
    }
    x += h * (vx(t) * std::cos(yaw) - vy(t) * std::sin(yaw));
    y += h * (vx(t) * std::sin(yaw) + vy(t) * std::cos(yaw));
    yaw += h * rate(t);
  }
  return file;
}

/// No rate of rows hides that vy has the wrong sign, and none makes a right one doubtful.
TEST(SessionChecks, AVyOfTheWrongSignIsDoubtedAtAnyRate) {
  for (const double hertz : {100.0, 50.0, 20.0, 10.0})
    for (const double sign : {1.0, -1.0}) {
      std::string names;
      for (const Finding& f : doubts_about(quick_weave(1.0 / hertz, sign))) names.append(f.check).append(" ");
      EXPECT_EQ(names, sign > 0 ? "" : "vy ") << hertz << " Hz";
    }
}

/// What a map says of its units is not found wrong with them.
TEST(SessionChecks, UnitsAreJudgedInTheFramesThatTheMapStates) {
  const auto map = [](const char* yaw, const char* vx) {
    return map_of(std::string(R"({"time": "t", "channels": {"x": "px", "y": "py", "yaw": {"column": "psi")") + yaw +
                  R"(}, "vx": {"column": "v")" + vx + R"(}, "vy": "side", "yaw_rate": "r", "delta": "steer"}})");
  };
  const auto log = log_of("t,px,py,psi,v,side,r,steer", [](std::ostream& out, double t, double x, double y, double yaw,
                                                           double rate, double delta) {
    out << t << ',' << x << ',' << y << ',' << yaw + 1.5 << ",-10,0," << rate << ',' << delta << '\n';
  });
  const char *const pose = R"(, "frame": {"yaw": 1.5})", *const velocity = R"(, "frame": {"yaw": "180 deg"})";
  EXPECT_EQ(why(log, map(pose, velocity)), "fine");
  EXPECT_THAT(why(log, map(pose, "")), HasSubstr("its sign is turned"));
  EXPECT_THAT(why(log, map("", velocity)), HasSubstr("deg off the path"));
}

/// The weaving car with a speed that follows a throttle against drag, and one row in `every` of placeholders; the first
/// `without` seconds have no place.
std::filesystem::path pushed_log(double sign, long every, double without, double place) {
  double v = 10.0;
  long row = 0;
  return log_of("t,px,py,psi,v,r,steer,d", [=](std::ostream& out, double t, double x, double y, double yaw, double rate,
                                               double delta) mutable {
    const double d = 0.3 + 0.5 * std::sin(0.9 * t) + 0.2 * std::sin(0.23 * t);
    v += 0.05 * (4 * d - 0.12 * v);
    const bool wrong = every > 0 && row++ % every == 0;
    const bool none = wrong || t < without;
    // The path is that of 10 m/s: as near to v as checks of units ask.
    out << t << ',' << (none ? place : x + 20) << ',' << (none ? place : y + 20) << ',' << yaw << ','
        << (every == 0 && without == 0 ? v : 10) << ',' << rate << ',' << delta << ',' << sign * d << '\n';
  });
}
LogMap pushed_map() {
  return map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "yaw": "psi", "vx": "v", "yaw_rate": "r",
    "delta": "steer", "d": "d"}})");
}

TEST(SessionChecks, AThrottleOfTheWrongSignIsRefused) {
  EXPECT_EQ(why(pushed_log(1, 0, 0, 0), pushed_map()), "fine");
  EXPECT_THAT(why(pushed_log(-1, 0, 0, 0), pushed_map()),
              AllOf(HasSubstr("the car speeds up against its throttle: d and acceleration correlate at -"),
                    HasSubstr("turn d's sign (\"sign\": -1)")));
}

/// One row in twelve: nearly every other window begins or ends there.
TEST(SessionChecks, PlaceholdersInSomeRowsAreNoUnit) {
  for (const double place : {-9999.0, 0.0}) {
    EXPECT_EQ(why(pushed_log(1, 12, 0, place), pushed_map()), "fine") << place;
    EXPECT_EQ(why(pushed_log(1, 60, 0, place), pushed_map()), "fine") << place;
  }
}

TEST(SessionFile, PlaceholdersBeforeTheFirstFixAreLeftOut) {
  const SessionFile file = read_session(pushed_log(1, 0, 4.99, -9999), pushed_map());
  EXPECT_TRUE(std::isnan(file.session.at(99, Channel::x)));
  EXPECT_FALSE(std::isnan(file.session.at(100, Channel::x)));
  EXPECT_THAT(notes_of(file), HasSubstr("place: 100 rows at the beginning show -9999, -9999, far from the rest"));
}

/// A receiver of 1 Hz in rows of 20 Hz, with what the map says of it.
std::string why_of_held_place(double factor, const char* hold) {
  double px = 0, py = 0;
  const auto log = log_of("t,px,py,psi,v,r,steer", [&](std::ostream& out, double t, double x, double y, double yaw,
                                                       double rate, double delta) {
    if (std::abs(t - std::round(t)) < 1e-6) px = x, py = y;
    out << t << ',' << px << ',' << py << ',' << yaw << ',' << 10 * factor << ',' << rate << ',' << delta << '\n';
  });
  std::string text = R"({"time": "t", "channels": {"x": {"column": "px"HOLD}, "y": {"column": "py"HOLD}, "yaw": "psi",
    "vx": "v", "yaw_rate": "r", "delta": "steer"}})";
  for (std::size_t at; (at = text.find("HOLD")) != std::string::npos;) text.replace(at, 4, hold);
  return why(log, map_of(text));
}

TEST(SessionChecks, SpeedsAreComparedWithPlacesThatAreHeld) {
  for (const char* hold : {"", R"(, "hold": "held")"}) {
    EXPECT_EQ(why_of_held_place(1.0, hold), "fine") << hold;
    EXPECT_THAT(why_of_held_place(3.6, hold), HasSubstr("vx looks like km/h")) << hold;
  }
}

TEST(SessionChecks, SpeedsThatNoPlaceIsComparedWithAreSaid) {
  const auto doubts = [](double every) {
    const auto log = log_of("t,px,py,psi,v,r,steer", [&](std::ostream& out, double t, double x, double y, double yaw,
                                                         double rate, double delta) {
      out << t << ',';
      if (std::abs(std::remainder(t, every)) < 1e-6)
        out << x << ',' << y;
      else
        out << ',';
      out << ',' << yaw << ",10," << rate << ',' << delta << '\n';
    });
    std::string names;
    for (const Finding& f : doubts_about(read_session(log, map_of(channels_json("")))))
      names += f.check + ": " + f.done + "; ";
    return names;
  };
  EXPECT_EQ(doubts(0.5), "");
  EXPECT_THAT(doubts(5.0), HasSubstr("units: not compared"));
}

TEST(SessionChecks, AParkedCarIsRefused) {
  const auto log = log_of("t,px,py,psi,v,r,steer", [](std::ostream& out, double t, double, double, double, double,
                                                      double) { out << t << ",1,2,0.1,0.001,0,0\n"; });
  EXPECT_THAT(why(log, map_of(channels_json(""))), HasSubstr("the car is parked"));
}

TEST(SessionChecks, AFewSecondsOfAParkedCarAreNoLogOfDriving) {
  // A receiver's place wanders by centimetres, its speed by millimetres per second: neither is a unit's mistake.
  const auto log = log_of(
      "t,px,py,psi,v,r,steer",
      [](std::ostream& out, double t, double, double, double, double, double) {
        out << t << ',' << 173.5 + 0.01 * std::sin(5 * t) << ',' << -130.9 + 0.01 * std::cos(3 * t) << ",0.1,"
            << 0.003 * std::sin(7 * t) << ",0,0\n";
      },
      8.0);
  EXPECT_THAT(why(log, map_of(channels_json(""))), HasSubstr("the car is parked"));
}

}  // namespace test_session_file
}  // namespace gripline::measured
