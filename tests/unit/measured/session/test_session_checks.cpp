#include "measured/session/session_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_session_checks {

using testing::AllOf;
using testing::HasSubstr;
using namespace test;
constexpr double pi = std::numbers::pi;

TEST(SessionChecks, AGoodLogPasses) { EXPECT_EQ(why(own_log(), map_of(channels_json(""))), "fine"); }

TEST(SessionChecks, UnitsAndSignsAreToldWithTheirEvidence) {
  const LogMap map = map_of(channels_json(""));
  EXPECT_THAT(why(own_log(3.6), map), HasSubstr("times the speed at which x and y move: vx looks like km/h"));
  EXPECT_THAT(why(own_log(1, -1), map), AllOf(HasSubstr("turns against its steering"), HasSubstr("correlate at -")));
  EXPECT_THAT(why(own_log(1, 60), map), HasSubstr("degrees"));
  EXPECT_THAT(why(own_log(1, 1, 57.3), map), HasSubstr("yaw looks like degrees"));
  EXPECT_THAT(why(own_log(1, 1, -1), map), HasSubstr("other sign"));
}

/// As of a gyroscope that is mounted upside down.
TEST(SessionChecks, AYawRateOfAnotherUnitAndTheOtherSignIsToldBoth) {
  const auto refused = [](const char* rate) {
    std::string text = channels_json("");
    text.replace(text.find("{\"column\": \"r\"}"), 15, std::string("{\"formula\": \"") + rate + "\"}");
    return why(own_log(), map_of(text));
  };
  EXPECT_EQ(refused("r"), "fine");
  EXPECT_THAT(refused("-deg(r)"), AllOf(HasSubstr("it looks like deg/s"), HasSubstr("has the other sign, too")));
  EXPECT_THAT(refused("-rad(r)"), AllOf(HasSubstr("yaw_rate was taken for deg/s"), HasSubstr("other sign, too")));
  EXPECT_THAT(refused("-5 * r"), HasSubstr("yaw: one of them has the other sign (\"sign\": -1)"));
}

/// Of a yaw and a yaw rate in different units the path tells which of them is wrong.
TEST(SessionChecks, TheChannelThatDoesNotTurnAsThePathDoesIsBlamed) {
  const auto refused = [](const char* yaw, const char* rate) {
    std::string text = channels_json("");
    text.replace(text.find("\"psi\""), 5, std::string("\"psi\", \"unit\": \"") + yaw + "\"");
    text.replace(text.find("\"r\""), 3, std::string("\"r\", \"unit\": \"") + rate + "\"");
    return why(own_log(), map_of(text));
  };
  EXPECT_EQ(refused("rad", "rad/s"), "fine");
  EXPECT_THAT(refused("rad", "deg/s"), HasSubstr("which turns as the path does: yaw_rate was taken for deg/s and is "
                                                 "rad/s"));
  EXPECT_THAT(refused("deg", "rad/s"), HasSubstr("yaw was taken for degrees and is radians"));
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
  EXPECT_THAT(why_with("s", "", "if(go > 0.3, go / 100, go - 0.3)"),
              AllOf(HasSubstr("d is hardly ever above 0"), HasSubstr("is it divided by 100 twice?")));
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

/// The weaving car with a speed that follows a throttle against drag, or, with one row in `every` of placeholders, 10
/// m/s.
std::filesystem::path pushed_log(double sign, long every = 0, double place = 0.0) {
  double v = 10.0;
  long row = 0;
  return log_of("t,px,py,psi,v,r,steer,d",
                [=](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) mutable {
                  const double d = 0.3 + 0.5 * std::sin(0.9 * t) + 0.2 * std::sin(0.23 * t);
                  v += 0.05 * (4 * d - 0.12 * v);
                  const bool wrong = every > 0 && row++ % every == 0;
                  // The path is that of 10 m/s: as near to v as checks of units ask.
                  out << t << ',' << (wrong ? place : x + 20) << ',' << (wrong ? place : y + 20) << ',' << yaw << ','
                      << (every == 0 ? v : 10) << ',' << rate << ',' << delta << ',' << sign * d << '\n';
                });
}
LogMap pushed_map() {
  return map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "yaw": "psi", "vx": "v", "yaw_rate": "r",
    "delta": "steer", "d": "d"}})");
}

/// A car that spins for a third of the log points elsewhere than it goes, and its channels are right.
TEST(SessionChecks, ACarThatSpinsIsNoWrongYaw) {
  const auto spinning = log_of("t,px,py,psi,v,r,steer", [](std::ostream& out, double t, double x, double y, double yaw,
                                                           double rate, double delta) {
    constexpr double begin = 10.0, end = 23.0, spin = 5 * 2 * pi / (end - begin);  // five turns
    const bool spins = t > begin && t < end;
    out << t << ',' << x << ',' << y << ',' << yaw + spin * (std::clamp(t, begin, end) - begin) << ',' << 10 << ','
        << rate + (spins ? spin : 0.0) << ',' << delta << '\n';
  });
  EXPECT_EQ(why(spinning, map_of(channels_json(""))), "fine");
  const auto stuck = log_of("t,px,py,psi,v,r,steer",
                            [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                              const bool stands = t > 10.0 && t < 23.0;
                              out << t << ',' << x << ',' << y << ',' << (stands ? -2.0 : yaw) << ',' << 10 << ','
                                  << rate << ',' << delta << '\n';
                            });
  EXPECT_THAT(why(stuck, map_of(channels_json(""))), HasSubstr("do not belong together")) << "a yaw that stands still";
}

/// The weaving car with channels by turns, through this map of them.
std::string why_of_axes(const char* x, const char* y, const char* vx, const char* vy, double across = 0.0) {
  const auto log = log_of("t,px,py,psi,v,side,steer", [=](std::ostream& out, double t, double px, double py, double psi,
                                                          double, double delta) {
    out << t << ',' << px << ',' << py << ',' << psi << ",10," << across * std::sin(0.8 * t) << ',' << delta << '\n';
  });
  std::string text = R"({"time": "t", "channels": {"yaw": "psi", "delta": "steer", "x": ")";
  text.append(x).append(R"(", "y": ")").append(y).append(R"(", "vx": ")").append(vx).append(R"(", "vy": ")");
  return why(log, map_of(text.append(vy).append(R"("}})")));
}

TEST(SessionChecks, ChannelsThatAreSwappedAreTold) {
  EXPECT_EQ(why_of_axes("px", "py", "v", "side"), "fine");
  EXPECT_THAT(why_of_axes("py", "px", "v", "side"),
              AllOf(HasSubstr("is always 90 deg"), HasSubstr("y points to the right, or x and y are swapped")));
  EXPECT_THAT(why_of_axes("px", "-py", "v", "side"),
              AllOf(HasSubstr("y points to the right"), testing::Not(HasSubstr("swapped"))));
  // Of a car that hardly slides, the forward speed would be that of a parked one; else centimetres are near.
  for (const double across : {0.05, 0.2, 2.0}) {
    EXPECT_THAT(why_of_axes("px", "py", "side", "v", across), HasSubstr("vx and vy look swapped")) << across;
    EXPECT_EQ(why_of_axes("px", "py", "v", "side", across), "fine") << across;
  }
}

/// In km/h the sideways speed of a car that slides is about the speed of its place in m/s: units are wrong, not axes.
TEST(SessionChecks, VelocitiesInAnotherUnitAreNotTakenForSwapped) {
  const auto log = log_of("t,px,py,psi,v,side,steer", [](std::ostream& out, double t, double px, double py, double psi,
                                                         double, double delta) {
    out << t << ',' << px << ',' << py << ',' << psi << ',' << 3.6 * 10 << ',' << 3.6 * 2.8 << ',' << delta << '\n';
  });
  const LogMap map = map_of(R"({"time": "t", "channels": {"x": "px", "y": "py", "yaw": "psi", "vx": "v", "vy": "side",
    "delta": "steer"}})");
  EXPECT_THAT(why(log, map), AllOf(HasSubstr("km/h"), testing::Not(HasSubstr("swapped"))));
}

/// What no log shows, but a world does: how far its wheels turn.
TEST(SessionChecks, TheAngleOfASteeringWheelIsTold) {
  const SessionFile file = read_session(own_log(), map_of(channels_json("")));  // steers by 0.156 rad
  EXPECT_NO_THROW(check_session(file, 10.0));
  EXPECT_NO_THROW(check_session(file, 10.0, 0.12)) << "a little beyond is an error of calibration";
  try {
    check_session(file, 10.0, 0.02);
    FAIL() << "accepted";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("and the world's delta_max is 0.02: it looks like the angle of the steering "
                                          "wheel"),
                                HasSubstr("divide by the steering ratio")));
  }
}

/// Ten half seconds that overlap by half are 2.75 s: what the message says, and not the 5 s of other readers.
TEST(SessionChecks, AShortLogIsToldHowMuchIsNeeded) {
  const auto lasting = [](double seconds) {
    return log_of(
        "t,px,py,psi,v,r,steer",
        [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
          out << t << ',' << x << ',' << y << ',' << yaw << ",10," << rate << ',' << delta << '\n';
        },
        seconds);
  };
  const LogMap map = map_of(channels_json(""));
  EXPECT_EQ(why(lasting(3.1), map), "fine");
  EXPECT_THAT(why(lasting(2.0), map),
              AllOf(HasSubstr("half seconds with a speed or a way"), HasSubstr("10 are needed")));
}

/// A compass in degrees from which a formula takes a yaw in radians belongs to no path.
TEST(SessionChecks, ACompassInDegreesThatWasTakenForRadiansIsAskedFor) {
  const auto compass = log_of("t,px,py,psi,v,r,steer", [](std::ostream& out, double t, double x, double y, double yaw,
                                                          double rate, double delta) {
    out << t << ',' << x << ',' << y << ',' << std::fmod(450.0 - yaw * 180.0 / pi, 360.0) << ",10," << rate << ','
        << delta << '\n';
  });
  std::string map = channels_json("");
  map.replace(map.find("{\"column\": \"psi\"}"), 17, "{\"formula\": \"pi/2 - psi\"}");
  const std::string rate = "\"yaw_rate\": {\"column\": \"r\"}, ";  // would tell it
  map.erase(map.find(rate), rate.size());
  EXPECT_THAT(why(compass, map_of(map)), HasSubstr("is it in degrees"));
}

TEST(SessionChecks, AThrottleOfTheWrongSignIsRefused) {
  EXPECT_EQ(why(pushed_log(1), pushed_map()), "fine");
  EXPECT_THAT(why(pushed_log(-1), pushed_map()),
              AllOf(HasSubstr("the car speeds up against its throttle: d and acceleration correlate at -"),
                    HasSubstr("turn d's sign (\"sign\": -1)")));
}

/// One row in twelve: nearly every other window begins or ends there.
TEST(SessionChecks, PlaceholdersInSomeRowsAreNoUnit) {
  for (const double place : {-9999.0, 0.0}) {
    EXPECT_EQ(why(pushed_log(1, 12, place), pushed_map()), "fine") << place;
    EXPECT_EQ(why(pushed_log(1, 60, place), pushed_map()), "fine") << place;
  }
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

}  // namespace test_session_checks
}  // namespace gripline::measured
