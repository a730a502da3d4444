// An OUT folder as compare writes it, made up: cars that follow a closed course at speeds that friction allows, beliefs
// that follow the truth or do not. For tests of the report only; nothing in it is a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "support/report_sample_run.hpp"

namespace gripline::sample {

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
    {"text": "elm.mean_deviation_m <= constant_speed.mean_deviation_m", "holds": false, "values": {"left": 0.0831, "right": 0.0712, "medians_hold": false, "runs_held": 1, "runs": 5, "share": 0.8}},
    {"text": "elm.violation_s <= 0.54", "holds": false, "values": {"left": 0.48, "right": 0.54, "medians_hold": true, "runs_held": 3, "runs": 5, "share": 0.8}}],
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
