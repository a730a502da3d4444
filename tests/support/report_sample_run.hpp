// One made-up run of a race: a car that follows a closed course at speeds that friction allows, its belief, and the
// tables that it leaves. For tests of the report only; nothing in it is a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace gripline::sample {

namespace fs = std::filesystem;

struct StackPlan {
  std::string name;
  bool truth = false;
  double learns = 1;   ///< 0: believes mu = 1 for ever; 1: follows the truth
  double caution = 1;  ///< share of the possible speed that is driven
  double solve_ms = 0.8;
  double lost_s = std::numeric_limits<double>::infinity();  ///< from then on it leaves the road; it crashes 30 s later
};

struct SampleOptions {
  std::vector<StackPlan> stacks{{"none", false, 0, 0.93, 0.7},
                                {"constant_speed", false, 0, 0.62, 0.7},
                                {"elm", false, 1, 0.9, 0.8},
                                {"gp", true, 0.9, 0.92, 4.2},
                                {"oracle", true, 1, 0.96, 0.7}};
  int seeds = 1;
  int laps = 4;
  double dt = 0.02;
  double scale = 1;       ///< of the course
  double tyres_from = 0;  ///< no curve is known before [s]
};

/// The course: position, direction and curvature over its length.
class Course {
 public:
  explicit Course(double scale) {
    constexpr int n = 720;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      x_.push_back(
          1.7 * scale *
          (2.1 * std::cos(a) + 0.42 * std::cos(2 * a + 0.6) + 0.20 * std::sin(3 * a) + 0.17 * std::cos(5 * a)));
      y_.push_back(
          1.7 * scale *
          (1.25 * std::sin(a) + 0.30 * std::sin(2 * a) - 0.17 * std::cos(3 * a + 0.5) + 0.16 * std::sin(4 * a)));
    }
    s_.push_back(0);
    for (int i = 1; i <= n; ++i) s_.push_back(s_.back() + std::hypot(x_[i % n] - x_[i - 1], y_[i % n] - y_[i - 1]));
    for (int i = 0; i < n; ++i) {
      const int b = (i + n - 1) % n, c = (i + 1) % n;
      yaw_.push_back(std::atan2(y_[c] - y_[b], x_[c] - x_[b]));
    }
    for (int i = 0; i < n; ++i) {
      const int b = (i + n - 1) % n, c = (i + 1) % n;
      kappa_.push_back(std::remainder(yaw_[c] - yaw_[b], 2 * std::numbers::pi) /
                       std::hypot(x_[c] - x_[b], y_[c] - y_[b]));
    }
  }
  struct Point {
    double x, y, yaw, kappa;
  };
  [[nodiscard]] Point at(double s, double n = 0) const {
    const double length = s_.back();
    s -= length * std::floor(s / length);
    const std::size_t count = x_.size();
    const auto i = static_cast<std::size_t>(std::upper_bound(s_.begin(), s_.end(), s) - s_.begin() - 1) % count;
    const std::size_t j = (i + 1) % count;
    const double w = (s - s_[i]) / (s_[i + 1] - s_[i]);
    const double yaw = yaw_[i] + w * std::remainder(yaw_[j] - yaw_[i], 2 * std::numbers::pi);
    return {x_[i] + w * (x_[j] - x_[i]) - n * std::sin(yaw), y_[i] + w * (y_[j] - y_[i]) + n * std::cos(yaw), yaw,
            kappa_[i] + w * (kappa_[j] - kappa_[i])};
  }
  [[nodiscard]] double length() const { return s_.back(); }

 private:
  std::vector<double> x_, y_, s_, yaw_, kappa_;
};

inline double friction(double t) { return t < 14.4 ? 0.909 : std::max(0.909 - (t - 14.4) / 44, 0.55); }

/// Speed the course allows at station s with mu: corners by v^2 |kappa| = mu g, braking and driving by 4 m/s2.
inline std::vector<double> allowed_speed(const Course& course, double mu, int n) {
  std::vector<double> v(static_cast<std::size_t>(n));
  const double ds = course.length() / n;
  for (int i = 0; i < n; ++i) v[i] = std::min(3.4, std::sqrt(mu * 9.81 / (std::abs(course.at(i * ds).kappa) + 0.05)));
  for (int k = 2 * n - 1; k >= 0; --k) v[k % n] = std::min(v[k % n], std::sqrt(std::pow(v[(k + 1) % n], 2) + 8 * ds));
  for (int k = 1; k < 2 * n; ++k) v[k % n] = std::min(v[k % n], std::sqrt(std::pow(v[(k - 1) % n], 2) + 8 * ds));
  return v;
}

inline std::string cells(const std::vector<double>& values) {
  std::string row;
  char text[32];
  bool first = true;
  for (const double value : values) {
    if (!std::exchange(first, false)) row += ',';
    if (!std::isnan(value)) row.append(text, static_cast<std::size_t>(std::snprintf(text, sizeof text, "%.6g", value)));
  }
  return row + '\n';
}

struct RunResult {
  std::vector<double> laps, factors;
  double violation = 0, deviation = 0, simulated = 0, mu_rmse = 0;
  long steps = 0;
};

inline constexpr double half_width = 0.185, nan = std::numeric_limits<double>::quiet_NaN();

inline double lateral_force(double peak, double slip) { return peak * std::sin(1.3 * std::atan(3.0 * slip)); }

/// The tables of one run, with their headers written.
struct RunTables {
  std::ofstream steps, replay, tyres, timing;

  explicit RunTables(const fs::path& folder)
      : steps(folder / "steps.csv"),
        replay(folder / "replay.csv"),
        tyres(folder / "tyres.csv"),
        timing(folder / "timing.csv") {
    steps << "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad,x_true_m,y_true_m,yaw_true_rad,vx_true_mps,"
             "vy_true_mps,yaw_rate_true_radps,d_applied,delta_applied_rad,mu_belief_front,mu_belief_rear,mu_true,s_m,"
             "offset_m,lap,outside,v_ref_mps,iterations,solved\n";
    replay << "t_s,mu_sigma_front,mu_sigma_rear,slip_front_rad,slip_rear_rad,force_front_n,force_rear_n";
    for (const char* kind : {"plan", "ref"})
      for (int k = 0; k < 10; ++k) replay << ',' << kind << k << "_x_m," << kind << k << "_y_m";
    replay << '\n';
    tyres << "t_s,axle,slip_rad,learned_n,sigma_n,true_n\n";
    timing << "step,solve_ms,update_ms\n";
  }
};

/// A car on the course at one control step; SI units as in steps.csv.
struct RunStep {
  long number = 0;
  int lap = 0;
  double t = 0, s = 0, v = 0.1, v_ref = 0, offset = 0, yaw = 0, rate = 0, d = 0, delta = 0, slip = 0;
  double mu = 0, belief = 1;
  bool outside = false;
  Course::Point here{};
};

using Noise = std::function<double()>;

inline void write_step_row(RunTables& tables, const RunStep& now, const Course& course, double solve_ms,
                           const Noise& noise) {
  const double vy = -0.02 * now.rate;
  tables.steps << cells({now.t,
                         now.here.x + 0.002 * noise(),
                         now.here.y + 0.002 * noise(),
                         now.yaw + 0.005 * noise(),
                         now.v + 0.02 * noise(),
                         vy + 0.02 * noise(),
                         now.rate + 0.05 * noise(),
                         now.d,
                         now.delta,
                         now.here.x,
                         now.here.y,
                         now.yaw,
                         now.v,
                         vy,
                         now.rate,
                         now.d,
                         now.delta,
                         now.belief * 0.98,
                         now.belief * 1.02,
                         now.mu,
                         std::fmod(now.s, course.length()),
                         now.offset,
                         static_cast<double>(now.lap),
                         now.outside ? 1.0 : 0.0,
                         now.v_ref,
                         3.0 + (now.number % 50 == 0),
                         1});
  tables.timing << cells(
      {static_cast<double>(now.number), solve_ms * std::exp(0.25 * noise()), 0.03 * std::exp(0.2 * noise())});
}

inline void write_replay_row(RunTables& tables, const RunStep& now, const Course& course, double radius, bool learns) {
  std::vector<double> row{now.t,
                          learns ? 0.02 + 0.15 * std::exp(-now.t / 4) : nan,
                          learns ? 0.02 + 0.12 * std::exp(-now.t / 4) : nan,
                          now.slip,
                          0.8 * now.slip,
                          lateral_force(0.19 * now.mu, now.slip),
                          lateral_force(0.17 * now.mu, now.slip)};
  for (const bool plan : {true, false})
    for (int k = 1; k <= 10; ++k) {
      const double s = now.s + now.v * 0.04 * k, line = 0.5 * radius * std::tanh(course.at(s).kappa);
      const auto ahead = course.at(s, plan ? now.offset + (line - now.offset) * 0.1 * k : line);
      row.push_back(ahead.x);
      row.push_back(ahead.y);
    }
  tables.replay << cells(row);
}

inline void write_tyre_rows(RunTables& tables, const RunStep& now, bool learns) {
  for (const char* axle : {"front", "rear"})
    for (int k = -20; k <= 20; ++k) {
      const double a = 0.03 * k, peak = axle[0] == 'f' ? 0.192 : 0.1737;
      const double learned = lateral_force(peak * now.belief, a) * (1 - 0.35 * std::exp(-now.t / 4));
      tables.tyres << now.t << ',' << axle << ','
                   << cells({a, learns ? learned : nan, 0.004 + 0.05 * a * a, lateral_force(peak * now.mu / 0.909, a)});
    }
}

/// Moves the car on by a control step; returns the offset that it wants. The order in which noise is drawn is part of
/// the sample.
inline double advance(RunStep& now, const Course& course, const StackPlan& stack, const SampleOptions& options,
                      double radius, double& wobble, const Noise& noise) {
  const auto point = course.at(now.s);
  now.v += std::clamp(now.v_ref - now.v, -5 * options.dt, 5 * options.dt);
  const double excess = std::max(0.0, now.v * now.v * std::abs(point.kappa) / 9.81 - 0.97 * now.mu);
  wobble += options.dt * (-2.5 * wobble + 0.08 * noise() / std::sqrt(options.dt) * 0.2);
  const double wanted =
      0.6 * radius * std::tanh(point.kappa * options.scale) + 0.25 * wobble - 1.5 * excess * (point.kappa > 0 ? 1 : -1);
  now.offset += (wanted - now.offset) * std::min(1.0, 5 * options.dt);
  if (now.t > stack.lost_s) now.offset = -0.2 - 3 * (now.t - stack.lost_s);
  if (now.t > stack.lost_s + 30) return wanted;
  if (now.t <= stack.lost_s) now.s += now.v * options.dt / (1 - point.kappa * now.offset);
  const double yaw_before = now.yaw;
  now.here = course.at(now.s, now.offset);
  now.yaw += std::remainder(now.here.yaw - now.yaw, 2 * std::numbers::pi);
  now.rate = now.number == 0 ? 0 : (now.yaw - yaw_before) / options.dt;
  now.slip = now.rate * now.v * 0.041 / (0.36 * now.mu) * 0.3;
  now.delta = std::clamp(0.062 * point.kappa + 0.4 * now.slip, -0.35, 0.35);
  now.outside = std::abs(now.offset) > half_width * options.scale;
  return wanted;
}

/// Drives one run and writes its folder.
inline RunResult write_run(const fs::path& folder, const Course& course, const StackPlan& stack, int seed,
                           const SampleOptions& options) {
  fs::create_directories(folder);
  RunTables tables(folder);
  std::mt19937 random(static_cast<unsigned>(1000 * seed) + static_cast<unsigned>(stack.name.size()));
  std::normal_distribution<double> normal(0, 1);
  const Noise noise = [&] { return normal(random); };
  constexpr int n = 400;
  const double radius = 0.85 * half_width * options.scale;
  RunResult result;
  RunStep now;
  now.yaw = course.at(0).yaw;
  double wobble = 0, lap_start = 0, planned_for = -1;
  std::vector<double> allowed;
  for (; now.lap < options.laps && now.number < 20000; ++now.number) {
    now.t = static_cast<double>(now.number) * options.dt;
    now.mu = friction(now.t);
    const double sees = now.t < 6.2 ? 1.0 : 1.0 + stack.learns * (now.mu - 1.0);
    now.belief += (sees - now.belief) * 0.02 + 0.0008 * noise() * stack.learns * (now.t > 6.2);
    const double plan_mu = std::max(0.3, now.belief) * stack.caution;
    if (std::abs(plan_mu - planned_for) > 0.01) allowed = allowed_speed(course, planned_for = plan_mu, n);
    now.v_ref = allowed[static_cast<std::size_t>(now.s / course.length() * n) % n];
    const double v_before = now.v;
    const double wanted = advance(now, course, stack, options, radius, wobble, noise);
    if (now.t > stack.lost_s + 30) break;
    now.d = std::clamp(0.2 + (now.v - v_before) / options.dt / 5, -0.1, 1.0);
    write_step_row(tables, now, course, stack.solve_ms, noise);
    if (now.number % 5 == 0) write_replay_row(tables, now, course, radius, stack.learns > 0);
    if (now.number % 50 == 0 && now.t >= options.tyres_from) write_tyre_rows(tables, now, stack.learns > 0);
    result.violation += now.outside ? options.dt : 0;
    result.deviation += std::abs(now.offset - wanted) + 0.02;
    result.mu_rmse += (now.belief - now.mu) * (now.belief - now.mu);
    ++result.steps;
    if (now.s >= (now.lap + 1) * course.length() && now.t < stack.lost_s) {
      result.laps.push_back(now.t - lap_start);
      result.factors.push_back(friction((now.t + lap_start) / 2) / 0.909);
      lap_start = now.t;
      ++now.lap;
    }
  }
  result.simulated = static_cast<double>(result.steps) * options.dt;
  result.deviation /= static_cast<double>(result.steps);
  result.mu_rmse = std::sqrt(result.mu_rmse / static_cast<double>(result.steps));
  return result;
}

}  // namespace gripline::sample
