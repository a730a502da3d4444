// Loggers' tables of a car that weaves at 10 m/s, in columns of their own, and what reading them says.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "config/errors.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_file.hpp"
#include "support/scratch.hpp"

namespace gripline::test {

/// A car that weaves at 10 m/s: its rows by a printer of one row.
template <class Row>
std::filesystem::path log_of(const std::string& header, Row row, double seconds = 40.0, double dt = 0.05) {
  const auto file = testing_support::scratch("log.csv");
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

inline std::filesystem::path plain_log() {
  return log_of("t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad",
                [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                  out << t << ',' << x << ',' << y << ',' << std::remainder(yaw + 3.0, 2 * std::numbers::pi) - 0.0
                      << ",10,0," << rate << ",0.2," << delta << '\n';
                });
}

inline measured::LogMap map_of(const std::string& text) {
  const auto file = testing_support::scratch("map.json");
  std::ofstream(file) << text;
  return measured::load_log_map(file);
}

inline std::string channels_json(const std::string& more) {
  return R"({"time": {"column": "t"}, "channels": {"x": {"column": "px"}, "y": {"column": "py"},
    "yaw": {"column": "psi"}, "vx": {"column": "v"}, "yaw_rate": {"column": "r"}, "d": {"formula": "0.2 + 0 * t"},
    "delta": {"column": "steer"})" +
         more + "}}";
}

inline std::filesystem::path own_log(double speed_factor = 1, double steer_sign = 1, double yaw_sign = 1) {
  return log_of("t,px,py,psi,v,r,steer",
                [&](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                  out << t << ',' << x << ',' << y << ',' << yaw_sign * yaw << ',' << 10 * speed_factor << ',' << rate
                      << ',' << steer_sign * delta << '\n';
                });
}

inline std::string why(const std::filesystem::path& log, const measured::LogMap& map) {
  try {
    measured::check_session(measured::read_session(log, map), 10.0);
  } catch (const InputError& e) {
    return e.what();
  }
  return "fine";
}

/// What reading found, a line each.
inline std::string notes_of(const measured::SessionFile& file) {
  std::string all;
  for (const measured::Finding& f : file.findings)
    all.append(f.check).append(": ").append(f.found).append("; ").append(f.done) += '\n';
  return all;
}

/// Of log_with.
inline measured::LogMap speed_map(const std::string& delta = R"("steer")") {
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

}  // namespace gripline::test
