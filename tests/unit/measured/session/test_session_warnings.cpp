#include "measured/session/session_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_session_warnings {

using testing::HasSubstr;
using namespace test;

std::string warnings_of(const std::filesystem::path& log, const LogMap& map) {
  std::string names;
  for (const Finding& f : consistency_warnings(read_session(log, map))) names += f.check + " " + f.found + "; ";
  return names;
}

/// What is not refused and inconsistent is warned of.
TEST(SessionWarnings, ASpeedOfAnotherScaleIsFound) {
  const LogMap map = map_of(channels_json(""));
  for (const double right : {1.0, 0.95, 1.05}) EXPECT_EQ(warnings_of(own_log(right), map), "") << right;
  for (const double wrong : {0.63, 0.88, 1.15, 1.5})
    EXPECT_THAT(warnings_of(own_log(wrong), map), HasSubstr("times the speed at which x and y move")) << wrong;
  // A stretch alone, as of wheels that spin, is no scale.
  const auto part = log_of("t,px,py,psi,v,r,steer",
                           [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                             out << t << ',' << x << ',' << y << ',' << yaw << ',' << (t < 30.0 ? 12.0 : 10.0) << ','
                                 << rate << ',' << delta << '\n';
                           });
  EXPECT_EQ(warnings_of(part, map), "");
}

/// A car whose heading is off its path; the map reads the heading, or the course.
TEST(SessionWarnings, ACourseThatStandsForYawIsFound) {
  const auto log = log_of("t,px,py,psi,course,v,side,r,steer", [](std::ostream& out, double t, double x, double y,
                                                                  double yaw, double rate, double delta) {
    const double lean = 0.06 * std::sin(0.8 * t + 1.0);
    out << t << ',' << x << ',' << y << ',' << yaw + lean << ',' << yaw << ',' << 10.0 * std::cos(lean) << ','
        << -10.0 * std::sin(lean) << ',' << rate << ',' << delta << '\n';
  });
  const auto warnings = [&](const char* yaw, const char* side) {
    std::string text = channels_json(std::string(R"(, "vy": ")") + side + "\"");
    text.replace(text.find("psi"), 3, yaw);
    return warnings_of(log, map_of(text));
  };
  EXPECT_EQ(warnings("psi", "side"), "");
  EXPECT_THAT(warnings("course", "side"), HasSubstr("yaw is where x and y move"));
  EXPECT_EQ(warnings("course", "0 * side"), "") << "of a car that does not slide both are one";
  EXPECT_EQ(warnings("course", "0.8 * r"), "") << "vy of a point ahead";
}

TEST(SessionWarnings, SteeringThatTheCarDoesNotFollowIsFound) {
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
    for (const Finding& f : consistency_warnings(read_session(log, map_of(text)))) names.append(f.check).append(" ");
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

/// No rate of rows hides that vy has the wrong sign, and none makes a right one seem wrong.
TEST(SessionWarnings, AVyOfTheWrongSignIsFoundAtAnyRate) {
  for (const double hertz : {100.0, 50.0, 20.0, 10.0})
    for (const double sign : {1.0, -1.0}) {
      std::string names;
      for (const Finding& f : consistency_warnings(quick_weave(1.0 / hertz, sign))) names.append(f.check).append(" ");
      EXPECT_EQ(names, sign > 0 ? "" : "vy ") << hertz << " Hz";
    }
}

/// A minute of a full-size car that weaves; its place comes `late` [s]. `sign`: of vy as written.
SessionFile weave_with_late_place(double late, double sign) {
  constexpr double h = 0.001;
  constexpr long every = 20;
  std::vector<std::pair<double, double>> path(1);
  SessionFile file;
  Session& s = file.session;
  s.has.fill(true);
  double yaw = 0.0;
  for (long k = 0; k < 60000; ++k) {
    const double t = h * static_cast<double>(k);
    const double vx = 10.0 + std::sin(0.3 * t), rate = 0.5 * std::sin(0.8 * t), vy = 0.5 * rate;
    if (k % every == 0) {
      const auto [x, y] = path[static_cast<std::size_t>(std::max(0L, k - std::lround(late / h)))];
      s.t.push_back(t);
      s.command.push_back({0.3, 0.3 * rate});
      for (const double value : {x, y, yaw, vx, sign * vy, rate}) s.reading.push_back(value);
    }
    const auto [x, y] = path.back();
    path.emplace_back(x + h * (vx * std::cos(yaw) - vy * std::sin(yaw)),
                      y + h * (vx * std::sin(yaw) + vy * std::cos(yaw)));
    yaw += h * rate;
  }
  return file;
}

/// It moves sideways by where the car was heading then.
TEST(SessionWarnings, APlaceThatIsLateTurnsNoSign) {
  const auto warnings = [](double late, double sign, bool known) {
    const SessionFile file = weave_with_late_place(late, sign);
    std::string names;
    const auto found =
        known ? consistency_warnings(file, [late](const SessionFile&) { return late; }) : consistency_warnings(file);
    for (const Finding& f : found) names.append(f.check).append(" ");
    return names;
  };
  EXPECT_EQ(warnings(0.15, 1.0, false), "vy ");
  EXPECT_EQ(warnings(0.15, 1.0, true), "");
  EXPECT_EQ(warnings(0.02, 1.0, true), "");
  EXPECT_EQ(warnings(0.02, -1.0, true), "vy ");
}

TEST(SessionWarnings, SpeedsThatNoPlaceIsComparedWithAreSaid) {
  const auto warnings = [](double every) {
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
    for (const Finding& f : consistency_warnings(read_session(log, map_of(channels_json("")))))
      names += f.check + ": " + f.done + "; ";
    return names;
  };
  EXPECT_EQ(warnings(0.5), "");
  EXPECT_THAT(warnings(5.0), HasSubstr("units: not compared"));
}

}  // namespace test_session_warnings
}  // namespace gripline::measured
