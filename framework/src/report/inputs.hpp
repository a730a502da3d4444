// What a report is made of: the files of an OUT folder, read into columns.
//
// The files of framework/doc/output.md (runs.csv, table.csv, claims.json, <stack>/<seed>/{config.json, steps.csv,
// summary.json, timing.csv}) and the following, which exist for the report only. Every one of them, every column and
// every cell may be missing: the report then leaves out what it cannot draw. Units are in the names, rows end in \n,
// numbers are std::to_chars.
//
// OUT/scene.json, once per experiment:
//   {"name": "table1", "kind": "race", "world": "ethz_wear", "note": "...", "dt": 0.02, "laps": 4,
//    "told": ["oracle"],      stacks that are given the ground truth
//    "car": {"m": 0.041, "lf": 0.029, "lr": 0.033, "length": 0.06, "width": 0.03}}
// OUT/track.csv, once per experiment, closed, the first point not repeated, at most about 2000 points:
//   s_m,x_m,y_m,left_x_m,left_y_m,right_x_m,right_y_m
//
// OUT/<stack>/<seed>/replay.csv, one row per 5th control step (steps 0, 5, 10, ...):
//   t_s                                    as in steps.csv
//   mu_sigma_front,mu_sigma_rear           standard deviation of the belief, same unit as mu_belief_*
//   slip_front_rad,slip_rear_rad           true slip angles
//   force_front_n,force_rear_n             true lateral forces per axle (left positive)
//   plan0_x_m,plan0_y_m .. plan9_x_m,plan9_y_m   the controller's predicted positions, spread evenly over its horizon,
//                                          the last one being the end of the horizon (any count from 2 to 50 works)
//   ref0_x_m,ref0_y_m .. ref9_x_m,ref9_y_m       the planner's reference points, chosen the same way
// OUT/<stack>/<seed>/line.csv, the line the planner follows first, closed, first point not repeated;
// that of the first run is drawn:
//   s_m,x_m,y_m
// OUT/<stack>/<seed>/tyres.csv, the learned tyre curve against the true one, one snapshot per second of simulated time
// from the start on; 41 slips per axle, equally spaced over -a .. a with a = 0.6 rad:
//   t_s,axle,slip_rad,learned_n,sigma_n,true_n      axle is front or rear; sigma_n may be empty
// OUT/<stack>/<seed>/timing.csv, one row per control step: every column that ends in _ms is a distribution; solve_ms,
//   update_ms, plan_ms and step_ms have names of their own in the report.
//
// OUT/validation_traces.csv, for the kinds offline_validation and force_validation, beside validation.csv:
//   estimator,channel,t_s,truth,predicted[,sigma][,slip_rad]     channel as in validation.csv; slip_rad for axle forces
//
// OUT/diagnosis_report.json, beside diagnosis.json (arrays of one length within each object; null is a gap):
//   sentence   one sentence: place, size, certainty          log, world   file names, as given
//   effects    {id: {words, params: {name: {words, unit}}}}      what the effects of the catalogue are
//   calibrated [{param, given, found, ci95}, ...]         the world's own parameters that were refitted
//   track      {x_m, y_m, left_x_m, left_y_m, right_x_m, right_y_m: []}
//   residual   {t_s, lap_fraction, x_m, y_m, vx_mps, vy_mps, yaw_rate_radps, d, delta_rad: []   where, in which state
//               e_vx, e_vy, e_omega: []                   what the nominal model leaves unexplained, smoothed, as rates
//               after_e_vx, after_e_vy, after_e_omega: []     the same with the named effects
//               size: []}                 RMS over the channels, in sensor sigmas, of the short window that starts here
//   horizon    {horizon_s, before, after: []}        RMS in sensor sigmas on held-out data
//   traces     [{channel: "vx_mps", t_s, measured, before, after: []}, ...]   held-out windows, null between windows
//   seen_at    [{effect, param, unit, size}, ...]         the smallest size of each effect that would have been seen
//   health     [{check, found, done, level: "good" | "note" | "bad"}, ...]    the data-health table
//   patch      {...}                       the JSON merge patch that augmented_world.json adds to the nominal world
//
// OUT/diagnoses.csv, of the kind diagnose: one row per case; OUT/<case>/ is a diagnosis with a page of its own:
//   case,verdict,right,confidence,before,after,closure and others
//
// OUT/measured.json, of the kind measured: what its page (measured_page.hpp) draws
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/columns.hpp"

namespace gripline::report {

/// What the folder of one run holds.
struct Run {
  Columns steps, replay, tyres, timing;
};

/// A row of the tables.
struct StackEntry {
  std::string name;
  bool needs_truth = false;
};

/// Which run, and how it ended; `status` and `message` are empty when runs.csv and summary.json do not say.
struct RunName {
  std::string stack, seed, status, message;
};

/// Everything found in an OUT folder.
struct Inputs {
  std::filesystem::path folder;
  nlohmann::json scene, claims, diagnosis, diagnosis_report, augmented_world, provenance, measured;  // null if absent
  Columns runs_table, table, pairs, track, line, validation, validation_traces, diagnoses;
  std::vector<StackEntry> stacks;  // in the order of table.csv
  std::vector<RunName> runs;       // in the order of runs.csv, else of the folders
};

/// A JSON file; null when it is not there. Throws InputError.
nlohmann::json read_json(const std::filesystem::path& file);

/// Reads all but the runs' own files. Throws InputError with one line if the folder holds nothing to report.
Inputs read_inputs(const std::filesystem::path& folder);

/// The sentence of a diagnosis in a folder; empty if there is none.
std::string sentence_of(const std::filesystem::path& folder);

/// Reads one run. Keep one in memory at a time: a report may have seventy.
Run read_run(const Inputs& inputs, const RunName& name);

/// The median of the values that are numbers; NaN if there are none.
double median_of_numbers(std::span<const double> values);

}  // namespace gripline::report
