// A small race and results of it, made up, for the tests of what is made of results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "experiment/race_results.hpp"
#include "support/host_support.hpp"

namespace gripline::testing_support {

/// A race of JSON stacks with the world's own lap table.
inline RaceSpec race_of(const char* claims = "[]", int seeds = 3) {
  Node world = merge(small_world(), json(R"({"duration": null, "laps": 2, "timeout": 9,
    "time_optimal_laps": [{"factor": 0.5, "lap": 8}, {"factor": 1, "lap": 7}]})"));
  inline_world_files(world);
  Node tree = json(R"({"base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"},
    "controller": {"plugin": "pure_pursuit"}}, "stacks": {"none": {}, "elm": {}, "oracle": {"estimator": {"plugin": "oracle"}}}})");
  tree.set("world", world);
  tree.set("claims", json(claims));
  Node count{Node::Object{}};
  count.set("count", Node(seeds));
  tree.set("seeds", count);
  return read_race("table.json", tree, plugins());
}

inline RunResult run_of(const std::string& stack, std::uint64_t seed, double violation, std::vector<double> laps) {
  RunResult run;
  run.summary.stack = stack;
  run.summary.seed = seed;
  run.summary.status = Status::finished;
  run.summary.laps = std::move(laps);
  run.summary.lap_mean_factors.assign(run.summary.laps.size(), 0.75);
  run.summary.violation_s = violation;
  run.summary.mean_deviation_m = 0.1 * violation;
  run.summary.steps = 100;
  run.summary.simulated_s = 2;
  run.timing.solve_ms_median = 1.5 + violation;
  run.timing.cpu_s = 0.25;
  run.timing.alone = true;
  return run;
}

/// elm: three runs of which one is a crash; none: three runs, one that drove no second lap; oracle: told the truth.
inline std::vector<RunResult> some_runs() {
  std::vector<RunResult> runs = {run_of("none", 1, 3, {8, 9}), run_of("none", 2, 5, {8.5}),
                                 run_of("none", 3, 4, {9, 7}), run_of("elm", 1, 1, {7.5, 7.25}),
                                 run_of("elm", 2, 2, {7, 7}),  run_of("elm", 3, 6, {7.2, 7})};
  runs[5].summary.status = Status::crashed;
  runs[4].summary.violation_after_adapt_s = 0.5;
  runs[5].summary.violation_after_adapt_s = 1.5;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    runs.push_back(run_of("oracle", seed, 0, {7, 7}));
    runs.back().summary.needs_truth = true;
  }
  return runs;
}

/// The cells of the last line that begins so, by their columns.
inline std::map<std::string, std::string> cells(const std::filesystem::path& file, const std::string& begins) {
  const std::vector<std::string> all = lines(file);
  std::map<std::string, std::string> found;
  for (const std::string& line : all) {
    if (line.rfind(begins, 0) != 0) continue;
    std::stringstream names(all[0]), values(line);
    for (std::string name; std::getline(names, name, ',');) {
      std::string value;
      std::getline(values, value, ',');
      found[name] = value;
    }
  }
  return found;
}

}  // namespace gripline::testing_support
