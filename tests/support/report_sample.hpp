// An OUT folder as compare writes it, made up: cars that follow a closed course at speeds that friction allows, beliefs
// that follow the truth or do not. For tests of the report only; nothing in it is a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <string>
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
  for (const double value : values) {
    if (!row.empty()) row += ',';
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

/// Drives one run and writes its folder.
inline RunResult write_run(const fs::path& folder, const Course& course, const StackPlan& stack, int seed,
                           const SampleOptions& options) {
  fs::create_directories(folder);
  std::ofstream steps(folder / "steps.csv"), replay(folder / "replay.csv"), tyres(folder / "tyres.csv"),
      timing(folder / "timing.csv");
  steps << "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad,x_true_m,y_true_m,yaw_true_rad,vx_true_mps,"
           "vy_true_mps,yaw_rate_true_radps,d_applied,delta_applied_rad,mu_belief_front,mu_belief_rear,mu_true,s_m,"
           "offset_m,lap,outside,v_ref_mps,iterations,solved\n";
  replay << "t_s,mu_sigma_front,mu_sigma_rear,slip_front_rad,slip_rear_rad,force_front_n,force_rear_n";
  for (const char* kind : {"plan", "ref"})
    for (int k = 0; k < 10; ++k) replay << ',' << kind << k << "_x_m," << kind << k << "_y_m";
  replay << '\n';
  tyres << "t_s,axle,slip_rad,learned_n,sigma_n,true_n\n";
  timing << "step,solve_ms,update_ms\n";

  std::mt19937 random(static_cast<unsigned>(1000 * seed) + static_cast<unsigned>(stack.name.size()));
  std::normal_distribution<double> noise(0, 1);
  constexpr int n = 400;
  const double radius = 0.85 * half_width * options.scale;
  RunResult result;
  double s = 0, v = 0.1, offset = 0, belief = 1.0, yaw_before = course.at(0).yaw, yaw = yaw_before, lap_start = 0;
  double v_before = v, wobble = 0;
  int lap = 0;
  std::vector<double> allowed;
  double planned_for = -1;
  for (long step = 0; lap < options.laps && step < 20000; ++step) {
    const double t = static_cast<double>(step) * options.dt, mu = friction(t);
    const double sees = t < 6.2 ? 1.0 : 1.0 + stack.learns * (mu - 1.0);
    belief += (sees - belief) * 0.02 + 0.0008 * noise(random) * stack.learns * (t > 6.2);
    const double plan_mu = std::max(0.3, belief) * stack.caution;
    if (std::abs(plan_mu - planned_for) > 0.01) allowed = allowed_speed(course, planned_for = plan_mu, n);
    const double v_ref = allowed[static_cast<std::size_t>(s / course.length() * n) % n];
    const auto point = course.at(s);
    v += std::clamp(v_ref - v, -5 * options.dt, 5 * options.dt);
    const double excess = std::max(0.0, v * v * std::abs(point.kappa) / 9.81 - 0.97 * mu);
    wobble += options.dt * (-2.5 * wobble + 0.08 * noise(random) / std::sqrt(options.dt) * 0.2);
    const double wanted = 0.6 * radius * std::tanh(point.kappa * options.scale) + 0.25 * wobble -
                          1.5 * excess * (point.kappa > 0 ? 1 : -1);
    offset += (wanted - offset) * std::min(1.0, 5 * options.dt);
    if (t > stack.lost_s) offset = -0.2 - 3 * (t - stack.lost_s);
    if (t > stack.lost_s + 30) break;
    if (t <= stack.lost_s) s += v * options.dt / (1 - point.kappa * offset);
    const auto here = course.at(s, offset);
    yaw += std::remainder(here.yaw - yaw, 2 * std::numbers::pi);
    const double rate = step == 0 ? 0 : (yaw - yaw_before) / options.dt, ax = (v - v_before) / options.dt;
    const double slip = rate * v * 0.041 / (0.36 * mu) * 0.3,
                 delta = std::clamp(0.062 * point.kappa + 0.4 * slip, -0.35, 0.35);
    const bool outside = std::abs(offset) > half_width * options.scale;
    const double d = std::clamp(0.2 + ax / 5, -0.1, 1.0), vy = -0.02 * rate;
    steps << cells({t,
                    here.x + 0.002 * noise(random),
                    here.y + 0.002 * noise(random),
                    yaw + 0.005 * noise(random),
                    v + 0.02 * noise(random),
                    vy + 0.02 * noise(random),
                    rate + 0.05 * noise(random),
                    d,
                    delta,
                    here.x,
                    here.y,
                    yaw,
                    v,
                    vy,
                    rate,
                    d,
                    delta,
                    belief * 0.98,
                    belief * 1.02,
                    mu,
                    std::fmod(s, course.length()),
                    offset,
                    static_cast<double>(lap),
                    outside ? 1.0 : 0.0,
                    v_ref,
                    3.0 + (step % 50 == 0),
                    1});
    timing << cells({static_cast<double>(step), stack.solve_ms * std::exp(0.25 * noise(random)),
                     0.03 * std::exp(0.2 * noise(random))});
    if (step % 5 == 0) {
      std::vector<double> row{t,
                              stack.learns > 0 ? 0.02 + 0.15 * std::exp(-t / 4) : nan,
                              stack.learns > 0 ? 0.02 + 0.12 * std::exp(-t / 4) : nan,
                              slip,
                              0.8 * slip,
                              lateral_force(0.19 * mu, slip),
                              lateral_force(0.17 * mu, slip)};
      for (const bool plan : {true, false})
        for (int k = 1; k <= 10; ++k) {
          const auto ahead =
              course.at(s + v * 0.04 * k,
                        plan ? offset + (0.5 * radius * std::tanh(course.at(s + v * 0.04 * k).kappa) - offset) * 0.1 * k
                             : 0.5 * radius * std::tanh(course.at(s + v * 0.04 * k).kappa));
          row.push_back(ahead.x);
          row.push_back(ahead.y);
        }
      replay << cells(row);
    }
    if (step % 50 == 0 && t >= options.tyres_from)
      for (const char* axle : {"front", "rear"})
        for (int k = -20; k <= 20; ++k) {
          const double a = 0.03 * k, peak = axle[0] == 'f' ? 0.192 : 0.1737;
          const double learned = lateral_force(peak * belief, a) * (1 - 0.35 * std::exp(-t / 4));
          tyres << t << ',' << axle << ','
                << cells({a, stack.learns > 0 ? learned : nan, 0.004 + 0.05 * a * a,
                          lateral_force(peak * mu / 0.909, a)});
        }
    result.violation += outside ? options.dt : 0;
    result.deviation += std::abs(offset - wanted) + 0.02;
    result.mu_rmse += (belief - mu) * (belief - mu);
    yaw_before = yaw;
    v_before = v;
    ++result.steps;
    if (s >= (lap + 1) * course.length() && t < stack.lost_s) {
      result.laps.push_back(t - lap_start);
      result.factors.push_back(friction((t + lap_start) / 2) / 0.909);
      lap_start = t;
      ++lap;
    }
  }
  result.simulated = static_cast<double>(result.steps) * options.dt;
  result.deviation /= static_cast<double>(result.steps);
  result.mu_rmse = std::sqrt(result.mu_rmse / static_cast<double>(result.steps));
  return result;
}

inline void write_track(const fs::path& folder, const Course& course, double scale) {
  std::ofstream track(folder / "track.csv");
  track << "s_m,x_m,y_m,left_x_m,left_y_m,right_x_m,right_y_m\n";
  for (int i = 0; i < 400; ++i) {
    const double s = course.length() * i / 400;
    const auto c = course.at(s), l = course.at(s, half_width * scale), r = course.at(s, -half_width * scale);
    track << cells({s, c.x, c.y, l.x, l.y, r.x, r.y});
  }
}

inline void write_line(const fs::path& folder, const Course& course, double scale) {
  std::ofstream line(folder / "line.csv");
  line << "s_m,x_m,y_m\n";
  for (int i = 0; i < 400; ++i) {
    const double s = course.length() * i / 400;
    const auto p = course.at(s, 0.5 * half_width * scale * std::tanh(course.at(s).kappa * scale));
    line << cells({s, p.x, p.y});
  }
}

inline double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

/// A name as one CSV cell.
inline std::string quoted(const std::string& name) {
  if (name.find_first_of(",\"\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + '"';
}

/// Writes the whole OUT folder.
inline void write_sample(const fs::path& folder, const SampleOptions& options = {}) {
  fs::create_directories(folder);
  const Course course(options.scale);
  write_track(folder, course, options.scale);
  std::ofstream(folder / "scene.json")
      << R"({"name": "sample", "kind": "race", "world": "sample_course", "note": "Tyres wear from 14.4 s on. Made up for tests.", "dt": 0.02, "laps": )"
      << options.laps << R"(, "car": {"m": 0.041, "lf": 0.029, "lr": 0.033, "length": 0.06, "width": 0.03}})";
  std::ofstream runs(folder / "runs.csv"), table(folder / "table.csv");
  runs << "stack,seed,status,needs_truth";
  table << "stack,needs_truth,runs,finished,crashed";
  for (int lap = 0; lap < options.laps; ++lap) {
    runs << ",lap" << lap << "_s";
    table << ",lap" << lap << "_s";
  }
  runs << ",mean_deviation_m,violation_s,mu_rmse,solve_ms_median,solver_failures,steps,simulated_s\n";
  table << ",mean_deviation_m,violation_s,mu_rmse,solve_ms_median,solver_failures,steps,simulated_s,violation_s_max";
  for (int lap = 0; lap < options.laps; ++lap) table << ",pace_ratio" << lap;
  table << '\n';
  for (const StackPlan& stack : options.stacks) {
    std::vector<std::vector<double>> columns(static_cast<std::size_t>(options.laps) + 7);
    for (int seed = 1; seed <= options.seeds; ++seed) {
      const RunResult r = write_run(folder / stack.name / std::to_string(seed), course, stack, seed, options);
      write_line(folder / stack.name / std::to_string(seed), course, options.scale);
      std::vector<double> row = r.laps;
      row.resize(static_cast<std::size_t>(options.laps), nan);
      for (const double value :
           {r.deviation, r.violation, r.mu_rmse, stack.solve_ms, 0.0, static_cast<double>(r.steps), r.simulated})
        row.push_back(value);
      for (std::size_t i = 0; i < row.size(); ++i) columns[i].push_back(row[i]);
      runs << quoted(stack.name) << ',' << seed << (std::isfinite(stack.lost_s) ? ",crashed," : ",finished,")
           << (stack.truth ? 1 : 0) << ',' << cells(row);
    }
    std::vector<double> row;
    for (const auto& column : columns) row.push_back(median_of(column));
    const auto& violations = columns[static_cast<std::size_t>(options.laps) + 1];
    row.push_back(*std::max_element(violations.begin(), violations.end()));
    for (int lap = 0; lap < options.laps; ++lap) {
      const std::vector<double> limit = allowed_speed(course, 0.97 * friction(3.0 + 7.0 * lap), 400);
      double seconds = lap == 0 ? 0.3 : 0;
      for (const double v : limit) seconds += course.length() / 400 / v;
      row.push_back(row[static_cast<std::size_t>(lap)] / seconds);
    }
    const int lost = std::isfinite(stack.lost_s) ? options.seeds : 0;
    table << quoted(stack.name) << ',' << (stack.truth ? 1 : 0) << ',' << options.seeds << ',' << options.seeds - lost
          << ',' << lost << ',' << cells(row);
  }
  std::ofstream(folder / "claims.json") << R"({"claims": [
    {"text": "elm.violation_s <= none.violation_s", "holds": true, "values": {"left": 0.46, "right": 4.32, "runs_held": 5, "runs": 5}},
    {"text": "elm.mean_deviation_m <= constant_speed.mean_deviation_m", "holds": false, "values": {"left": 0.0831, "right": 0.0712, "runs_held": 1, "runs": 5}}],
    "skipped": [{"text": "elm.solve_ms_median < gp_own_mu.solve_ms_median", "why": "a row was left out by --only"}]})";
}

/// A race of which nothing is left but its beginning: one row crashed after three steps, one never began.
inline void write_broken_sample(const fs::path& folder) {
  fs::create_directories(folder / "elm" / "1");
  std::ofstream(folder / "scene.json")
      << R"({"name": "broken", "kind": "race", "world": "nowhere", "note": ["One `base` row,", "and a gain of -3."], "dt": 0.02, "laps": 4})";
  std::ofstream(folder / "runs.csv") << "stack,seed,status,needs_truth,lap0_s,lap1_s,violation_s,solve_ms_median\n"
                                        "elm,1,crashed,0,,,0.04,0.1\n"
                                        "lost,1,plugin_error,0,,,,\n";
  std::ofstream(folder / "table.csv")
      << "stack,needs_truth,runs,finished,crashed,lap0_s,lap1_s,violation_s,solve_ms_median\n"
         "elm,0,1,0,1,,,0.04,0.1\n"
         "lost,0,1,0,0,,,,\n";
  std::ofstream(folder / "elm" / "1" / "steps.csv")
      << "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,mu_belief_front,mu_belief_rear,mu_true,s_m,offset_m,lap\n"
         "0,0,0,0,0.1,0,0,1,1,0.9,0,0,0\n0.02,0.002,0,0,0.1,0,0,1,1,0.9,0.002,0,0\n0.04,0.004,0,0,0.1,0,0,1,1,0.9,0."
         "004,0,0\n";
}

/// An OUT folder as `compare` writes it for the kind diagnose: two cases, one of them with files of its own.
inline void write_cases_sample(const fs::path& folder) {
  fs::create_directories(folder / "drag" / "drive");
  std::ofstream(folder / "scene.json") << R"({"name": "hidden_things", "kind": "diagnose", "note": "Made up."})";
  std::ofstream(folder / "diagnoses.csv")
      << "case,verdict,named,nothing_missing,indistinguishable,unknown,right,confidence,before,after,closure\n"
         "drag,named,1,0,0,0,1,0.99995,5.19,0.945,1\n"
         "nothing,unknown,0,0,0,1,0,1,0.94,0.94,0\n";
  std::ofstream(folder / "claims.json") << R"({"claims": [
    {"text": "drag.closure >= 0.9", "holds": true, "values": {"left": 1, "right": 0.9, "runs_held": 1, "runs": 1}}]})";
  std::ofstream(folder / "drag" / "diagnosis_report.json")
      << R"({"sentence": "aero_drag (a = -0.42 m/s2) is missing.", "log": "steps.csv"})";
  std::ofstream(folder / "drag" / "report.html") << "its own page";
  std::ofstream(folder / "drag" / "drive" / "steps.csv") << "t_s,x_m,y_m\n0,0,0\n0.02,1,0\n0.04,2,0\n";
}

/// Numbers as a JSON array, null for NaN.
inline std::string json_array(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) {
    if (text.size() > 1) text += ',';
    const std::string cell = cells({value});
    text += std::isnan(value) ? "null" : cell.substr(0, cell.size() - 1);
  }
  return text + "]";
}

/// An OUT folder as `compare` writes it for validations.
/// `own_drives`: each estimator was asked about a drive of its own.
inline void write_validation_sample(const fs::path& folder, bool own_drives = false) {
  fs::create_directories(folder);
  std::ofstream scores(folder / "validation.csv"), traces(folder / "validation_traces.csv");
  scores << "estimator,channel,unit,n,r2,rmse\n";
  traces << "estimator,channel,t_s,truth,predicted,slip_rad\n";
  const char* channels[] = {"e_vx", "e_vy", "e_omega", "force_front"};
  const char* units[] = {"m/s2", "m/s2", "rad/s2", "N"};
  for (const char* estimator : {"elm", "gp"})
    for (int c = 0; c < 4; ++c) {
      scores << estimator << ',' << channels[c] << ',' << units[c] << ",350," << 0.99 - 0.01 * c << ",0.0" << c + 2
             << '\n';
      for (int i = 0; i < 350; ++i) {
        const double t = 0.02 * i + (own_drives && estimator[0] == 'g' ? 1 : 0), slip = 0.3 * std::sin(1.3 * t);
        const double truth = c == 3 ? lateral_force(0.19, slip) : std::sin(1.1 * t + c) * (c + 1);
        const double off = (estimator[0] == 'e' ? 0.05 : 0.08) * std::sin(9 * t);
        traces << estimator << ',' << channels[c] << ','
               << cells({t, truth, truth + off * (c == 3 ? 0.1 : 1), c == 3 ? slip : nan});
      }
    }
}

/// An OUT folder as `diagnose` writes it.
inline void write_diagnosis_sample(const fs::path& folder) {
  fs::create_directories(folder);
  std::ofstream(folder / "diagnosis.json") << R"({"verdict": "named",
    "named": [{"effect": "friction_patch", "params": {"k": -0.18, "s0": 0.62, "w": 0.12},
               "ci95": {"k": [-0.2, -0.16], "s0": [0.615, 0.625], "w": [0.11, 0.13]}, "confidence": 0.991}],
    "equivalent": [], "unknown": null, "nominal_fit": {"Df": 0.1914},
    "gap": {"horizon_s": 1.0, "before": 3.41, "after": 0.06, "closure": 0.985},
    "ranking": [{"effect": "friction_patch", "gain": 812.4, "held_out": 0.06, "selected_fraction": 0.99},
                {"effect": "bank", "gain": 341.2, "held_out": 1.9, "selected_fraction": 0.01},
                {"effect": "downforce", "gain": 44.7, "held_out": 3.2, "selected_fraction": 0}],
    "manoeuvre": null})";
  const Course course(1);
  std::vector<double> x, y, lx, ly, rx, ry, t, f, ex, ey, v, e_vx, e_vy, e_w, a_vx, a_vy, a_w, size, d, delta;
  for (int i = 0; i < 300; ++i) {
    const double s = course.length() * i / 300;
    const auto c = course.at(s), l = course.at(s, half_width), r = course.at(s, -half_width);
    x.push_back(c.x), y.push_back(c.y), lx.push_back(l.x), ly.push_back(l.y), rx.push_back(r.x), ry.push_back(r.y);
  }
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1);
  for (int i = 0; i < 1500; ++i) {
    const double share = std::fmod(i / 375.0, 1.0);
    const auto p = course.at(share * course.length(), 0.04 * noise(random));
    const double patch = std::abs(share - 0.62) < 0.06 ? 1 : 0;
    t.push_back(0.02 * i), f.push_back(share), ex.push_back(p.x), ey.push_back(p.y);
    v.push_back(2 + 0.5 * std::sin(7 * share)), d.push_back(0.3 * std::cos(9 * share)),
        delta.push_back(0.062 * p.kappa);
    e_vx.push_back(0.1 * noise(random)), e_vy.push_back(-0.9 * patch + 0.1 * noise(random)),
        e_w.push_back(5 * patch * p.kappa + noise(random));
    a_vx.push_back(0.1 * noise(random)), a_vy.push_back(0.1 * noise(random)), a_w.push_back(noise(random));
    size.push_back(1 + 5 * patch + 0.3 * std::abs(noise(random)));
  }
  std::vector<double> tt, measured, before, after;
  for (int i = 0; i < 500; ++i) {
    const double time = 0.02 * i, since = std::fmod(time, 1.0);
    tt.push_back(time);
    measured.push_back(2 + std::sin(time));
    before.push_back(i % 50 == 49 ? nan : 2 + std::sin(time) + 0.3 * since * since);
    after.push_back(i % 50 == 49 ? nan : 2 + std::sin(time) + 0.01 * since);
  }
  std::ofstream out(folder / "diagnosis_report.json");
  out << R"({"sentence": "The track is slippery at 62 % of the lap: 18 % less grip (16 to 20 %) over an eighth of the lap; 99 % sure.",)"
      << R"("log": "measured.csv", "world": "worlds/diagnose_rc43.json", "effects": {"friction_patch": {"words": )"
      << R"("friction differs on one stretch of the lap", "params": {"k": {"words": "share of grip", "unit": "1"}}}}, "track": {"x_m": )"
      << json_array(x) << R"(, "y_m": )" << json_array(y) << R"(, "left_x_m": )" << json_array(lx)
      << R"(, "left_y_m": )" << json_array(ly) << R"(, "right_x_m": )" << json_array(rx) << R"(, "right_y_m": )"
      << json_array(ry) << R"(}, "residual": {"t_s": )" << json_array(t) << R"(, "lap_fraction": )" << json_array(f)
      << R"(, "x_m": )" << json_array(ex) << R"(, "y_m": )" << json_array(ey) << R"(, "vx_mps": )" << json_array(v)
      << R"(, "d": )" << json_array(d) << R"(, "delta_rad": )" << json_array(delta) << R"(, "e_vx": )"
      << json_array(e_vx) << R"(, "e_vy": )" << json_array(e_vy) << R"(, "e_omega": )" << json_array(e_w)
      << R"(, "after_e_vx": )" << json_array(a_vx) << R"(, "after_e_vy": )" << json_array(a_vy)
      << R"(, "after_e_omega": )" << json_array(a_w) << R"(, "size": )" << json_array(size)
      << R"(}, "horizon": {"horizon_s": [0.1, 0.2, 0.5, 1, 2], "before": [0.2, 0.5, 1.6, 3.41, 7.9], "after": [0.02, 0.02, 0.04, 0.06, 0.13]},)"
      << R"("traces": [{"channel": "vx_mps", "t_s": )" << json_array(tt) << R"(, "measured": )" << json_array(measured)
      << R"(, "before": )" << json_array(before) << R"(, "after": )" << json_array(after)
      << R"(}], "seen_at": [{"effect": "aero_drag", "param": "a", "unit": "m/s2", "size": 0.021}],)"
      << R"("health": [{"check": "dropped rows", "found": "2.0 %", "done": "interpolated", "level": "note"}, {"check": "time", "found": "even, 50 Hz", "done": "", "level": "good"}],)"
      << R"("patch": {"plant": {"effects": [{"plugin": "friction_patch", "params": {"k": -0.18, "s0": 0.62, "w": 0.12}}]}}})";
}

}  // namespace gripline::sample
