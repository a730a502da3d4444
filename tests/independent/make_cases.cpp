// Cases for `gripline diagnose --score` from equations of their own: nothing of framework/ or plugins/ is included.
// Equations: framework/doc/models.md (dynamic), framework/doc/effects.md; formats: framework/doc/diagnose-cases.md.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using State = std::array<double, 8>;  // x, y, yaw, vx, vy, yaw rate, throttle and steering behind their lags
using Six = std::array<double, 6>;
constexpr double pi = std::numbers::pi;

/// A car of framework/doc/diagnose-cases.md and what is usual for it.
struct Kind {
  const char* name;
  double m, Iz, lf, lr, Bf, Cf, Df, Br, Cr, Dr, Cm1, Cm2, Cb, Cr0, Cd, v_ref;
  Six sigma;
  double shaking;                       // process noise of the yaw acceleration [rad/s2]
  double half_width, length, sharpest;  // of roads [m]
  double grip, drive, brake, top;       // what the driver plans with [m/s2, m/s2, m/s2, m/s]
};
const std::array<Kind, 2> kinds = {{
    {"rc43", 0.041,  27.8e-6, 0.029,  0.033, 2.579,  1.2,     0.192, 3.3852,
     1.2691, 0.1737, 0.287,   0.0545, 0.287, 0.0518, 0.00035, 2.0,   {0.005, 0.005, 0.005, 0.02, 0.02, 0.05},
     0.8,    0.26,   12.0,    0.3,    5.2,   2.0,    2.5,     2.6},
    {"full", 1500, 2250,  1.2,  1.4,  10,  1.4,  7923, 11,
     1.4,    6792, 6500,  70,   9000, 220, 0.45, 25.0, {0.05, 0.05, 0.005, 0.05, 0.05, 0.01},
     0.05,   8.0,  900.0, 30.0, 6.0,  2.0, 3.5,  27.0},
}};

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double from, double to) {
    return from + (to - from) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
  }
  double normal() { return std::sqrt(-2.0 * std::log(uniform(1e-12, 1.0))) * std::cos(uniform(0.0, 2.0 * pi)); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  double sign() { return below(2) == 0 ? -1.0 : 1.0; }

 private:
  std::mt19937_64 engine_;
};

/// Name of an effect, its parameter, and typical sizes of the two cars; both signs where `either`.
struct Hidden {
  const char* id;
  const char* param;
  double low[2], high[2];
  bool either;
};
const std::vector<Hidden> catalogue = {
    {"aero_drag", "a", {0.2, 0.15}, {0.8, 0.6}, false},
    {"rolling_res", "a", {0.15, 0.1}, {0.6, 0.4}, false},
    {"drive_gain", "k", {0.06, 0.06}, {0.2, 0.2}, true},
    {"back_emf", "k", {0.05, 0.05}, {0.18, 0.18}, true},
    {"motor_lag", "tau", {0.03, 0.05}, {0.15, 0.3}, false},
    {"steer_lag", "tau", {0.02, 0.03}, {0.06, 0.15}, false},
    {"input_delay", "T", {0.02, 0.03}, {0.06, 0.15}, false},
    {"steer_gain", "k", {0.04, 0.04}, {0.15, 0.15}, true},
    {"steer_offset", "d0", {0.005, 0.005}, {0.03, 0.03}, true},
    {"friction_scale", "k", {0.05, 0.05}, {0.15, 0.15}, true},
    {"front_grip", "k", {0.05, 0.05}, {0.13, 0.13}, true},
    {"rear_grip", "k", {0.04, 0.04}, {0.1, 0.1}, true},
    {"front_stiff", "k", {0.1, 0.1}, {0.3, 0.3}, true},
    {"rear_stiff", "k", {0.1, 0.1}, {0.25, 0.25}, true},
    {"mass", "k", {0.05, 0.05}, {0.25, 0.25}, false},
    {"yaw_inertia", "k", {0.1, 0.1}, {0.35, 0.35}, true},
    {"downforce", "k", {0.05, 0.05}, {0.25, 0.25}, false},
    {"diff_yaw", "k", {1.0, 0.3}, {5.0, 1.2}, false},
    {"vx_scale", "k", {0.01, 0.01}, {0.05, 0.05}, true},
    {"vx_bias", "b", {0.02, 0.1}, {0.08, 0.5}, true},
    {"yawrate_bias", "b", {0.04, 0.006}, {0.15, 0.03}, true},
};
using Effects = std::map<std::string, double>;
double of(const Effects& e, const char* id) {
  const auto found = e.find(id);
  return found == e.end() ? 0.0 : found->second;
}

struct Command {
  double d, delta;
};

/// A closed line of points about 1/1200 of its length apart, with a speed to drive at each.
struct Line {
  std::vector<std::array<double, 2>> at;
  std::vector<double> speed;
  double step = 0;
  std::size_t wrap(double i) const {
    const auto n = static_cast<double>(at.size());
    return static_cast<std::size_t>(i - n * std::floor(i / n)) % at.size();
  }
};

double turn_at(const Line& line, std::size_t i, std::size_t reach) {
  const std::size_t n = line.at.size();
  const auto &a = line.at[(i + n - reach) % n], &b = line.at[i], &c = line.at[(i + reach) % n];
  const double from = std::atan2(b[1] - a[1], b[0] - a[0]), to = std::atan2(c[1] - b[1], c[0] - b[0]);
  return std::remainder(to - from, 2.0 * pi) / (static_cast<double>(reach) * line.step);
}

Line draw_line(const Kind& kind, Dice& dice) {
  constexpr std::size_t n = 1200;
  for (;;) {
    std::array<double, 6> size{}, phase{};
    for (std::size_t k = 2; k < 6; ++k) {
      size[k] = 0.42 * dice.normal() / static_cast<double>(k * k);
      phase[k] = dice.uniform(0.0, 2.0 * pi);
    }
    Line line;
    double length = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2.0 * pi * static_cast<double>(i) / n;
      double radius = 1.0;
      for (std::size_t k = 2; k < 6; ++k) radius += size[k] * std::cos(static_cast<double>(k) * angle + phase[k]);
      line.at.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    for (std::size_t i = 0; i < n; ++i)
      length += std::hypot(line.at[(i + 1) % n][0] - line.at[i][0], line.at[(i + 1) % n][1] - line.at[i][1]);
    const double scale = kind.length * dice.uniform(0.8, 1.25) / length;
    for (auto& p : line.at) p = {p[0] * scale, p[1] * scale};
    line.step = length * scale / n;
    double sharpest = 0.0;
    for (std::size_t i = 0; i < n; ++i) sharpest = std::max(sharpest, std::abs(turn_at(line, i, 10)));
    if (sharpest * kind.sharpest < 1.0 && sharpest * kind.sharpest > 0.5) return line;
  }
}

void plan_speed(const Kind& kind, Line& line, double pace) {
  const std::size_t n = line.at.size();
  line.speed.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    line.speed[i] = pace * std::min(kind.top, std::sqrt(kind.grip / std::max(1e-3, std::abs(turn_at(line, i, 12)))));
  for (std::size_t i = 0; i < 2 * n; ++i) {
    double& next = line.speed[(i + 1) % n];
    next = std::min(next, std::sqrt(std::pow(line.speed[i % n], 2) + 2.0 * kind.drive * line.step));
  }
  for (std::size_t i = 2 * n; i-- > 0;)
    line.speed[i % n] =
        std::min(line.speed[i % n], std::sqrt(std::pow(line.speed[(i + 1) % n], 2) + 2.0 * kind.brake * line.step));
}

/// The car's equations with what is hidden; d and delta are the commands after delays.
State rates(const Kind& k, const Effects& e, const State& s, Command given, const std::array<double, 3>& shaken) {
  State out{};
  const double lag_d = of(e, "motor_lag"), lag_delta = of(e, "steer_lag");
  if (lag_d > 0.0) out[6] = (given.d - s[6]) / lag_d;
  if (lag_delta > 0.0) out[7] = (given.delta - s[7]) / lag_delta;
  const double d = lag_d > 0.0 ? s[6] : given.d;
  const double delta = (1.0 + of(e, "steer_gain")) * (lag_delta > 0.0 ? s[7] : given.delta) + of(e, "steer_offset");
  const double vx = s[3], vy = s[4], w = s[5], u = vx / k.v_ref;
  const double cm2 = k.Cm2 + of(e, "back_emf") * k.Cm1 / k.v_ref, cm1 = k.Cm1 * (1.0 + of(e, "drive_gain"));
  const double force = d >= 0.0 ? (cm1 - cm2 * vx) * d : k.Cb * d;
  const double m = k.m * (1.0 + of(e, "mass")), inertia = k.Iz * (1.0 + of(e, "yaw_inertia"));
  const double both = (1.0 + of(e, "mass")) * (1.0 + of(e, "friction_scale")) * (1.0 + of(e, "downforce") * u * u);
  const double front_peak = k.Df * both * (1.0 + of(e, "front_grip")),
               rear_peak = k.Dr * both * (1.0 + of(e, "rear_grip"));
  const double front_slip = delta - std::atan2(w * k.lf + vy, std::abs(vx));
  const double rear_slip = std::atan2(w * k.lr - vy, std::abs(vx));
  const double front = front_peak * std::sin(k.Cf * std::atan(k.Bf * (1.0 + of(e, "front_stiff")) * front_slip));
  const double rear = rear_peak * std::sin(k.Cr * std::atan(k.Br * (1.0 + of(e, "rear_stiff")) * rear_slip));
  const double resisting = k.Cr0 + k.Cd * vx * vx;
  out[0] = vx * std::cos(s[2]) - vy * std::sin(s[2]);
  out[1] = vx * std::sin(s[2]) + vy * std::cos(s[2]);
  out[2] = w;
  out[3] = (force - resisting - front * std::sin(delta)) / m + vy * w - of(e, "aero_drag") * u * u -
           of(e, "rolling_res") + shaken[0];
  out[4] = (rear + front * std::cos(delta)) / m - vx * w + shaken[1];
  out[5] = (front * k.lf * std::cos(delta) - rear * k.lr) / inertia - of(e, "diff_yaw") * w + shaken[2];
  return out;
}

Six shown(const Effects& e, const State& s) {
  return {s[0], s[1], s[2], (1.0 + of(e, "vx_scale")) * s[3] + of(e, "vx_bias"), s[4], s[5] + of(e, "yawrate_bias")};
}

struct Drive {
  std::vector<Command> command;
  std::vector<Six> reading;
  double laps = 0;
};
struct Conditions {
  double seconds, shaking = 0, shaking_time = 0.25;
  bool held = false;  // commands act as they are until the next, not linear in between
};

constexpr double sample = 0.02, step = 0.001;

/// Looks ahead along the line, holds its speed, with unsteady hands and feet.
class Driver {
 public:
  Driver(const Kind& kind, const Line& line, double unsteady, double start, Dice& dice)
      : kind_(kind), line_(line), unsteady_(unsteady), here_(start), dice_(dice) {}
  Command decide(const State& s, double t) {
    const double v = std::hypot(s[3], s[4]);
    double best = 1e300, found = here_;
    for (double i = here_ - 5.0; i < here_ + 60.0; i += 1.0) {
      const auto& p = line_.at[line_.wrap(i)];
      const double off = std::hypot(p[0] - s[0], p[1] - s[1]);
      if (off < best) best = off, found = i;
    }
    here_ = found;
    away = best;
    const double big = kind_.v_ref / 2.0;  // 1 for the small car
    const double ahead = (0.10 * std::sqrt(kind_.half_width / 0.26) + 0.17 * (kind_.m > 1.0 ? 2.4 : 1.0) * v);
    const auto& aim = line_.at[line_.wrap(here_ + ahead / line_.step)];
    const double bearing =
        std::remainder(std::atan2(aim[1] - s[1], aim[0] - s[0]) - s[2] - std::atan2(s[4], s[3]), 2.0 * pi);
    const double bend = 2.0 * std::sin(bearing) / ahead, L = kind_.lf + kind_.lr;
    const double wave = kind_.m > 1.0 ? 0.012 : 0.03;
    double delta = std::atan(L * bend) + (kind_.m > 1.0 ? 0.0018 : 0.0055) * bend * v * v;
    hands_ += (0.3 * dice_.normal() - 0.12 * hands_);
    feet_ += (0.3 * dice_.normal() - 0.12 * feet_);
    delta += unsteady_ * wave * (0.25 * hands_ + 0.2 * std::sin(3.1 * t / std::sqrt(big)));
    const double want = line_.speed[line_.wrap(here_ + 0.12 * v / line_.step)];
    double d = kind_.m > 1.0 ? 0.09 + 0.35 * (want - s[3]) : 0.36 + 0.8 * (want - s[3]);
    d += unsteady_ * (0.08 * feet_ + 0.1 * std::sin(1.7 * t / std::sqrt(big)));
    steer_ += 0.5 * (delta - steer_);
    return {std::round(std::clamp(d, -1.0, 1.0) * 1e5) * 1e-5,
            std::round(std::clamp(steer_, -0.35, 0.35) * 1e6) * 1e-6};
  }
  double away = 0;
  double travelled() const { return here_; }

 private:
  const Kind& kind_;
  const Line& line_;
  double unsteady_, here_, steer_ = 0, hands_ = 0, feet_ = 0;
  Dice& dice_;
};

/// Empty when the car is lost.
Drive drive(const Kind& kind, const Effects& e, Line line, double pace, const Conditions& c, Dice& dice) {
  plan_speed(kind, line, pace);
  const std::size_t start = dice.below(line.at.size()), n = line.at.size();
  const auto &a = line.at[start], &b = line.at[(start + 1) % n];
  State s{a[0], a[1], std::atan2(b[1] - a[1], b[0] - a[0]), 0.95 * line.speed[start], 0, 0, 0, 0};
  s[5] = s[3] * turn_at(line, start, 10);
  Driver driver(kind, line, dice.uniform(0.7, 1.3), static_cast<double>(start), dice);
  Drive out;
  out.command.push_back(driver.decide(s, 0.0));
  s[6] = out.command[0].d;
  s[7] = out.command[0].delta;
  const double delay = of(e, "input_delay");
  const auto command_at = [&](double t) -> Command {
    const double x = std::max(0.0, (t - delay) / sample);
    const std::size_t i = std::min(static_cast<std::size_t>(x + 1e-9), out.command.size() - 1);
    const std::size_t j = std::min(i + 1, out.command.size() - 1);
    const double share = c.held ? 0.0 : std::clamp(x - static_cast<double>(i), 0.0, 1.0);
    return {out.command[i].d + share * (out.command[j].d - out.command[i].d),
            out.command[i].delta + share * (out.command[j].delta - out.command[i].delta)};
  };
  const std::array<double, 3> size{0.1 * c.shaking, 0.1 * c.shaking, kind.shaking * c.shaking};
  std::array<double, 3> shaken{};
  for (std::size_t i = 0; i < 3; ++i) shaken[i] = size[i] > 0.0 ? size[i] * dice.normal() : 0.0;
  const double keeps = std::exp(-step / c.shaking_time);
  const auto samples = static_cast<std::size_t>(std::round(c.seconds / sample)) + 1;
  const auto after = [](const State& from, double h, const State& r) {
    State to = from;
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += h * r[i];
    return to;
  };
  for (std::size_t k = 0; k < samples; ++k) {
    out.reading.push_back(shown(e, s));
    const bool lost = driver.away > 1.5 * kind.half_width || s[3] < 0.32 * kind.v_ref || std::abs(s[4]) > 0.6 * s[3];
    if (lost) return {};
    if (k + 1 == samples) break;
    const double now = static_cast<double>(k) * sample;
    out.command.push_back(driver.decide(s, now));
    for (int i = 0; i < 20; ++i) {
      const double t = now + i * step;
      const State k1 = rates(kind, e, s, command_at(t), shaken);
      const State k2 = rates(kind, e, after(s, step / 3.0, k1), command_at(t + step / 3.0), shaken);
      const State k3 = rates(kind, e, after(s, 2.0 * step / 3.0, k2), command_at(t + 2.0 * step / 3.0), shaken);
      for (std::size_t j = 0; j < s.size(); ++j) s[j] += step * (0.25 * k1[j] + 0.75 * k3[j]);
      for (std::size_t j = 0; j < 3 && c.shaking > 0.0; ++j)
        shaken[j] = keeps * shaken[j] + std::sqrt(1.0 - keeps * keeps) * size[j] * dice.normal();
    }
  }
  out.laps = (driver.travelled() - static_cast<double>(start)) / static_cast<double>(n);
  return out;
}

std::string text(double v, int digits = 8) {
  std::ostringstream out;
  out.precision(digits);
  out << v;
  return out.str();
}

/// A number as a recorder writes it that knows multiples of `step` only; 0: all.
double rounded(double v, double step) { return step > 0.0 ? step * std::round(v / step) : v; }

/// `quantum`: of readings in standard deviations of their noise, of throttle and steering in hundredths and 5 mrad.
void write_log(const fs::path& file, const Drive& d, const Six& sigma, double colour, std::size_t every, double quantum,
               bool big, Dice* dice) {
  std::ofstream out(file);
  out << "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad\n";
  Six error{};
  char cell[60];
  for (std::size_t k = 0; k < d.reading.size(); k += every) {
    out << text(static_cast<double>(k) * sample, 6);
    for (std::size_t c = 0; c < 6; ++c) {
      if (dice != nullptr)
        error[c] =
            (k == 0 ? 0.0 : colour * error[c]) + std::sqrt(k == 0 ? 1.0 : 1.0 - colour * colour) * dice->normal();
      std::snprintf(cell, sizeof cell, ",%.*f", (dice == nullptr ? 6 : 4) - (c < 2 && big ? 1 : 0),
                    rounded(d.reading[k][c] + sigma[c] * error[c], quantum * sigma[c]));
      out << cell;
    }
    std::snprintf(cell, sizeof cell, ",%.5f,%.6f\n", rounded(d.command[k].d, 0.01 * quantum),
                  rounded(d.command[k].delta, 0.005 * quantum));
    out << cell;
  }
}

/// Sets of effects that say the same.
std::string equivalents(const std::vector<std::string>& ids) {
  const std::map<std::string, std::vector<std::string>> same = {{"friction_scale", {"front_grip", "rear_grip"}},
                                                                {"front_grip", {"friction_scale", "rear_grip"}},
                                                                {"rear_grip", {"friction_scale", "front_grip"}},
                                                                {"input_delay", {"sensor_latency"}}};
  std::vector<std::vector<std::string>> sets{{}};
  for (const std::string& id : ids) {
    std::vector<std::vector<std::string>> more;
    for (const auto& set : sets) {
      more.push_back(set);
      more.back().push_back(id);
      if (const auto other = same.find(id); other != same.end()) {
        more.push_back(set);
        more.back().insert(more.back().end(), other->second.begin(), other->second.end());
      }
    }
    sets = more;
  }
  std::string out;
  for (std::size_t i = 1; i < sets.size(); ++i) {
    out += i > 1 ? ", [" : "[";
    for (std::size_t j = 0; j < sets[i].size(); ++j) {
      out += j > 0 ? ", \"" : "\"";
      out += sets[i][j];
      out += "\"";
    }
    out += "]";
  }
  return out;
}

struct Condition {
  const char* name;
  double shaking_time = 0, colour = 0;
  std::size_t every = 1;
  bool brief = false, held = false;
  double quantum = 0;
  bool wrong_nominal = false, late = false;
};
const std::vector<Condition> all_conditions = {{"white"},
                                               {.name = "process", .shaking_time = 0.25},
                                               {.name = "slow", .shaking_time = 1.0},
                                               {.name = "quick", .shaking_time = 0.05},
                                               {.name = "ar03", .colour = 0.3},
                                               {.name = "ar06", .colour = 0.6},
                                               {.name = "ar08", .colour = 0.8},
                                               {.name = "ar09", .colour = 0.9},
                                               {.name = "thinned", .every = 2},
                                               {.name = "thinned3", .every = 3},
                                               {.name = "short", .brief = true},
                                               {.name = "held", .held = true},
                                               {.name = "quantised", .quantum = 1},
                                               {.name = "nominal", .wrong_nominal = true},
                                               {.name = "nominal_process", .shaking_time = 0.25, .wrong_nominal = true},
                                               {.name = "nominal_slow", .shaking_time = 1.0, .wrong_nominal = true},
                                               {.name = "late", .late = true},
                                               {.name = "late_process", .shaking_time = 0.25, .late = true},
                                               {.name = "late_ar08", .colour = 0.8, .late = true}};

/// A parameter of the car that the nominal one has wrong: by a normal of this relative size, at most twice it. Of
/// Cr0_over_m the size is in m/s2.
struct Uncertain {
  const char* name;
  double Kind::*value;
  double size;
};
const std::array<Uncertain, 6> uncertain = {{{"Df", &Kind::Df, 0.02},
                                             {"Dr", &Kind::Dr, 0.02},
                                             {"Bf", &Kind::Bf, 0.04},
                                             {"Br", &Kind::Br, 0.04},
                                             {"Cm1", &Kind::Cm1, 0.02},
                                             {"Cr0_over_m", &Kind::Cr0, 0.04}}};

/// Moves the car's parameters away from the nominal ones; gives by how much, in the order above.
std::vector<double> make_wrong(Kind& kind, Dice& dice) {
  std::vector<double> off;
  for (const Uncertain& u : uncertain) {
    off.push_back(u.size * std::clamp(dice.normal(), -2.0, 2.0));
    kind.*u.value += off.back() * (u.value == &Kind::Cr0 ? kind.m : kind.*u.value);
  }
  return off;
}

/// The uncertain parameters as members of an object, with these values; "null" without any.
std::string uncertain_json(const std::vector<double>& values) {
  if (values.empty()) return "null";
  std::string out = "{";
  for (std::size_t i = 0; i < values.size(); ++i)
    out += std::string(i > 0 ? ", \"" : "\"") + uncertain[i].name + "\": " + text(values[i]);
  return out + "}";
}

/// Channels that are late together, and what their delays are called.
struct LateChannels {
  std::vector<std::size_t> channel;
  std::vector<std::string> names;
};
const std::array<LateChannels, 4> late_channels = {{{{0, 1}, {"position_delay"}},
                                                    {{0, 1, 2}, {"position_delay", "yaw_delay"}},
                                                    {{3, 4}, {"velocity_delay"}},
                                                    {{5}, {"yaw_rate_delay"}}}};

/// What the channels showed so long ago: a cubic through four samples. The log begins so much later.
void make_late(Drive& d, const LateChannels& late, double seconds) {
  const auto back = static_cast<std::size_t>(std::ceil(seconds / sample));
  const double u = static_cast<double>(back) - seconds / sample;  // behind the sample that far back
  const std::array<double, 4> weight = {-u * (u - 1) * (u - 2) / 6, (u + 1) * (u - 1) * (u - 2) / 2,
                                        -(u + 1) * u * (u - 2) / 2, (u + 1) * u * (u - 1) / 6};
  const std::vector<Six> was = d.reading;
  for (std::size_t k = back + 1; k < was.size(); ++k)
    for (const std::size_t c : late.channel) {
      d.reading[k][c] = 0.0;
      for (std::size_t j = 0; j < 4; ++j) d.reading[k][c] += weight[j] * was[k - back - 1 + j][c];
    }
  d.reading.erase(d.reading.begin(), d.reading.begin() + static_cast<std::ptrdiff_t>(back + 1));
  d.command.erase(d.command.begin(), d.command.begin() + static_cast<std::ptrdiff_t>(back + 1));
}

void write_case(const fs::path& out, const std::string& kind_of_case, const Condition& condition, std::size_t i,
                std::uint64_t seed) {
  std::uint64_t mixed = seed * 1000003 + i;
  for (const char c : kind_of_case + condition.name) mixed = mixed * 31 + static_cast<unsigned char>(c);
  Dice dice(mixed);
  const std::size_t which = i % 2;
  Kind kind = kinds[which];
  const std::size_t count = kind_of_case == "none" ? 0 : kind_of_case == "single" ? 1 : 3;
  Effects effects;
  std::vector<std::string> ids;
  const auto of_grip = [](const std::string& id) {
    return id == "friction_scale" || id == "front_grip" || id == "rear_grip";
  };
  while (ids.size() < count) {
    const Hidden& h = catalogue[count == 1 ? (i / 2) % catalogue.size() : dice.below(catalogue.size())];
    const bool taken = std::any_of(ids.begin(), ids.end(),
                                   [&](const std::string& id) { return id == h.id || (of_grip(id) && of_grip(h.id)); });
    if (taken) continue;
    ids.emplace_back(h.id);
    effects[h.id] = (h.either ? dice.sign() : 1.0) * dice.uniform(h.low[which], h.high[which]);
  }
  const Line line = draw_line(kind, dice);
  const std::vector<double> off = condition.wrong_nominal ? make_wrong(kind, dice) : std::vector<double>{};
  const double lap = line.step * static_cast<double>(line.at.size()) / (0.75 * kind.v_ref);
  Conditions driven{.seconds = condition.brief ? std::round(lap * dice.uniform(0.5, 2.0)) : 60.0};
  driven.shaking = condition.shaking_time > 0.0 ? 1.0 : 0.0;
  if (condition.shaking_time > 0.0) driven.shaking_time = condition.shaking_time;
  driven.held = condition.held;
  Drive measured, held;
  for (double pace = dice.uniform(0.85, 1.05); measured.reading.empty(); pace *= 0.97)
    measured = drive(kind, effects, line, pace, driven, dice);
  for (double pace = dice.uniform(0.8, 1.0); held.reading.empty(); pace *= 0.97)
    held = drive(kind, effects, line, pace, {.seconds = which == 1 ? 36.0 : 20.0, .held = condition.held}, dice);

  std::vector<std::string> delays;
  double delay = 0.0;
  if (condition.late) {
    const LateChannels& late = late_channels[(i / 2 + 2 * which) % late_channels.size()];
    delay = dice.uniform(0.04, 0.12);
    make_late(measured, late, delay);
    delays = late.names;
  }

  char number[16];
  std::snprintf(number, sizeof number, "_%03zu", i);
  const std::string name = kind_of_case + "_" + condition.name + number;
  const fs::path folder = out / "cases" / name;
  fs::create_directories(folder);
  fs::create_directories(out / "tracks");
  std::ofstream track(out / "tracks" / (name + ".csv"));
  track << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  for (const auto& p : line.at)
    track << text(p[0]) << ',' << text(p[1]) << ',' << kind.half_width << ',' << kind.half_width << '\n';
  write_log(folder / "measured.csv", measured, kind.sigma, condition.colour, condition.every, condition.quantum,
            which == 1, &dice);
  write_log(folder / "heldout.csv", held, kind.sigma, 0.0, 1, 0.0, which == 1, nullptr);
  constexpr std::array<const char*, 6> names = {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps"};
  std::ofstream given(folder / "case.json");
  given << "{\n  \"vehicle\": \"" << kind.name << "\",\n  \"track\": \"" << name << ".csv\",\n  \"noise_sigma\": {";
  for (std::size_t c = 0; c < 6; ++c) given << (c > 0 ? ", \"" : "\"") << names[c] << "\": " << text(kind.sigma[c]);
  given << "}";
  if (condition.wrong_nominal) {
    std::vector<double> sizes;
    for (const Uncertain& u : uncertain) sizes.push_back(u.size);
    given << ",\n  \"nominal_uncertainty\": " << uncertain_json(sizes);
  }
  given << "\n}\n";
  std::ofstream answer(folder / "answer.json");
  answer << "{\n  \"kind\": \"" << kind_of_case << "\",\n  \"effects\": [";
  for (std::size_t j = 0; j < ids.size(); ++j) {
    const auto entry =
        std::find_if(catalogue.begin(), catalogue.end(), [&](const Hidden& h) { return h.id == ids[j]; });
    answer << (j > 0 ? ", " : "") << "{\"effect\": \"" << ids[j] << "\", \"params\": {\"" << entry->param
           << "\": " << text(effects[ids[j]]) << "}}";
  }
  for (std::size_t j = 0; j < delays.size(); ++j) {
    answer << (ids.size() + j > 0 ? ", " : "") << "{\"effect\": \"" << delays[j]
           << "\", \"params\": {\"T\": " << text(delay) << "}}";
  }
  std::vector<std::string> all = ids;
  all.insert(all.end(), delays.begin(), delays.end());
  answer << "],\n  \"equivalent\": [" << equivalents(all) << "],\n";
  if (condition.late) answer << "  \"late\": true,\n";
  if (condition.colour > 0.0) answer << "  \"noise_correlation\": " << condition.colour << ",\n";
  if (condition.every > 1) answer << "  \"thinned\": " << condition.every << ",\n";
  answer << "  \"nuisance\": " << uncertain_json(off) << ",\n  \"process_noise\": ";
  if (condition.shaking_time > 0.0)
    answer << "{\"ax_mps2\": 0.1, \"ay_mps2\": 0.1, \"yaw_acc_radps2\": " << kind.shaking
           << ", \"tau_s\": " << condition.shaking_time << "}";
  else
    answer << "null";
  answer << ",\n  \"laps\": " << text(measured.laps, 4) << ",\n  \"seed\": " << seed << "\n}\n";
}

}  // namespace

int main(int argc, char** argv) {
  std::string out, only;
  std::uint64_t seed = 1;
  std::size_t count = 10;
  bool wrong = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--seed" && more)
      seed = std::stoull(argv[++i]);
    else if (word == "--count" && more)
      count = std::stoul(argv[++i]);
    else if (word == "--only" && more)
      only = std::string(",") + argv[++i] + ",";
    else if (word.starts_with('-') || !out.empty())
      wrong = true;
    else
      out = word;
  }
  if (out.empty() || wrong) {
    std::cerr << "independent_cases OUT [--seed N] [--count N] [--only CONDITIONS]\n";
    return 2;
  }
  for (const std::string kind : {"none", "single", "triple"})
    for (const Condition& condition : all_conditions) {
      std::string name = ",";
      name += kind + "_" + condition.name + ",";
      if (!only.empty() && only.find(name) == std::string::npos) continue;
      for (std::size_t i = 0; i < count; ++i) write_case(out, kind, condition, i, seed);
      std::cout << kind << '_' << condition.name << '\n';
    }
  return 0;
}
