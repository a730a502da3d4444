#include "experiment/race_columns.hpp"

#include <algorithm>
#include <cctype>

namespace gripline {
namespace {

using Value = std::optional<double>;

Value of_lap(const std::vector<double>& values, std::size_t lap) {
  return lap < values.size() ? Value(values[lap]) : std::nullopt;
}

template <LapTable WorldSpec::*limit>
Value pace_ratio(const WorldSpec& world, const RunResult& run, std::size_t lap) {
  const RunSummary& s = run.summary;
  if (lap >= s.laps.size()) return std::nullopt;
  const Value best = (world.*limit).at(s.lap_mean_factors[lap]);
  return best ? Value(s.laps[lap] / *best) : std::nullopt;
}

/// Empty for a run that left no results.
template <auto member>
Value of_summary(const WorldSpec&, const RunResult& run, std::size_t) {
  return run.summary.steps > 0 ? Value(run.summary.*member) : std::nullopt;
}
template <auto member>
Value of_timing(const WorldSpec&, const RunResult& run, std::size_t) {
  return run.summary.steps > 0 ? Value(run.timing.*member) : std::nullopt;
}
/// What the run cost: 0 for a run that was not driven because it equals another one.
Value cpu_s(const WorldSpec&, const RunResult& run, std::size_t) {
  if (run.summary.steps == 0) return std::nullopt;
  return run.driven_as ? 0.0 : run.timing.cpu_s;
}
Value simulated_s(const WorldSpec&, const RunResult& run, std::size_t) {
  if (run.summary.steps == 0) return std::nullopt;
  return run.driven_as ? 0.0 : run.summary.simulated_s;
}
template <Status status>
Value ended_as(const WorldSpec&, const RunResult& run, std::size_t) {
  return run.summary.status == status ? 1.0 : 0.0;
}

constexpr const char* both = "runs.csv table.csv";
constexpr const char* all = "runs.csv table.csv sweep";
constexpr const char* table = "table.csv";
constexpr const char* summed = "table.csv sweep";
using enum RowSum;

constexpr RaceColumn columns[] = {
    {all, "lapK_s", "s", median, true, "time of lap K; lap 0 includes the standing start",
     [](const WorldSpec&, const RunResult& run, std::size_t lap) { return of_lap(run.summary.laps, lap); }},
    {both, "lapK_mean_factor", "1", median, false, "mean friction factor of the steps of lap K",
     [](const WorldSpec&, const RunResult& run, std::size_t lap) { return of_lap(run.summary.lap_mean_factors, lap); }},
    {all, "mean_deviation_m", "m", median, true,
     "mean distance from the line that the planner follows; empty if it follows none",
     of_summary<&RunSummary::mean_deviation_m>},
    {"", "hilly_deviation_m", "m", median, true, "mean_deviation_m where the road is steeper than 3 %",
     of_summary<&RunSummary::hilly_deviation_m>},
    {all, "violation_s", "s", median, true, "time with the centre of gravity outside the road",
     of_summary<&RunSummary::violation_s>},
    {all, "violation_body_s", "s", median, true, "time with a corner of the car outside the road",
     of_summary<&RunSummary::violation_body_s>},
    {all, "violation_after_adapt_s", "s", median, true,
     "violation_s from the moment the stack trusts what it learned; empty if it never does",
     of_summary<&RunSummary::violation_after_adapt_s>},
    {all, "violation_body_after_adapt_s", "s", median, true, "violation_body_s from that moment",
     of_summary<&RunSummary::violation_body_after_adapt_s>},
    {all, "mu_rmse", "1", median, true,
     "root mean square of estimated minus true friction while the stack trusts its estimate",
     of_summary<&RunSummary::mu_rmse>},
    {all, "mu_visited_rmse", "1", median, true,
     "the same against the friction at the slips reached so far, from two laps after the stack began to trust",
     of_summary<&RunSummary::mu_visited_rmse>},
    {both, "solve_ms_median", "ms", median, true, "CPU time of a call of the controller, its median",
     of_timing<&RunTiming::solve_ms_median>},
    {both, "solve_ms_p95", "ms", median, true, "its 95 % quantile", of_timing<&RunTiming::solve_ms_p95>},
    {both, "solve_ms_p99", "ms", median, true, "its 99 % quantile", of_timing<&RunTiming::solve_ms_p99>},
    {both, "update_ms_median", "ms", median, true, "CPU time of a call of the estimator, its median",
     of_timing<&RunTiming::update_ms_median>},
    {both, "plan_latency_s", "s", largest, false,
     "longest time from the order of a plan to the step that first drove it; 0 where plans are made within the step",
     of_summary<&RunSummary::plan_latency_s>},
    {all, "solver_failures", "1", total, false,
     "solves that failed, the one before the first step included; \"failed\" in the printed table",
     of_summary<&RunSummary::solver_failures>},
    {all, "steps", "1", median, false, "control steps driven", of_summary<&RunSummary::steps>},
    {both, "cpu_s", "s", cost, false, "CPU time of the run's process; 0 for a run that was not driven again", cpu_s},
    {all, "simulated_s", "s", cost, false, "time driven; 0 for a run that was not driven again", simulated_s},
    {table, "runs", "1", total, false, "runs that differ",
     [](const WorldSpec&, const RunResult&, std::size_t) { return Value(1.0); }},
    {summed, "finished", "1", total, false, "of these, how many finished", ended_as<Status::finished>},
    {table, "crashed", "1", total, false, "of these, how many crashed", ended_as<Status::crashed>},
    {table, "violation_s_max", "s", largest, false, "violation_s of the worst run",
     of_summary<&RunSummary::violation_s>},
    {table, "violation_after_adapt_s_max", "s", largest, false, "violation_after_adapt_s of the worst run",
     of_summary<&RunSummary::violation_after_adapt_s>},
    {summed, "pace_ratioK", "1", median, true, "lap K over the time-optimal lap at its mean factor",
     pace_ratio<&WorldSpec::time_optimal>},
    {summed, "body_pace_ratioK", "1", median, true, "the same over the time-optimal lap with the whole car inside",
     pace_ratio<&WorldSpec::time_optimal_body>},
    {table, "seeds", "1", cost, false, "runs that were driven, equal ones too",
     [](const WorldSpec&, const RunResult& run, std::size_t) { return Value(run.driven_as ? 0.0 : 1.0); }},
};

bool is_of_laps(std::string_view name) { return name.find('K') != std::string_view::npos; }

bool stands_in(const RaceColumn& column, std::string_view file) {
  return std::string_view(column.files).find(file) != std::string_view::npos;
}

/// The column's name with the lap in the place of K.
std::string name_of(const RaceColumn& column, std::size_t lap) {
  std::string name = column.name;
  if (const std::size_t k = name.find('K'); k != std::string::npos) name.replace(k, 1, std::to_string(lap));
  return name;
}

/// The number in the place of K, if `name` follows `pattern`.
std::optional<std::size_t> lap_in(std::string_view name, std::string_view pattern) {
  const std::size_t k = pattern.find('K');
  const std::string_view before = pattern.substr(0, k), after = pattern.substr(k + 1);
  if (name.size() <= before.size() + after.size()) return std::nullopt;
  if (!name.starts_with(before) || !name.ends_with(after)) return std::nullopt;
  const std::string_view digits = name.substr(before.size(), name.size() - before.size() - after.size());
  if (!std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c) != 0; }))
    return std::nullopt;
  return std::stoul(std::string(digits.substr(0, 6)));
}

}  // namespace

std::span<const RaceColumn> race_columns() { return columns; }

std::optional<NamedColumn> find_race_column(std::string_view name) {
  for (const RaceColumn& column : columns) {
    if (!is_of_laps(column.name)) {
      if (name == column.name) return NamedColumn{&column, 0};
    } else if (const std::optional<std::size_t> lap = lap_in(name, column.name)) {
      return NamedColumn{&column, *lap};
    }
  }
  return std::nullopt;
}

std::vector<std::string> race_column_names(std::string_view file, std::size_t laps) {
  std::vector<std::string> names;
  for (const RaceColumn& column : columns)
    if (stands_in(column, file))
      for (std::size_t lap = 0; lap < (is_of_laps(column.name) ? laps : 1); ++lap)
        names.push_back(name_of(column, lap));
  return names;
}

std::vector<std::string> recorded_columns(std::size_t laps) {
  std::vector<std::string> names = {"finished"};
  for (std::size_t lap = 0; lap < laps; ++lap)
    for (const RaceColumn& column : columns)
      if (stands_in(column, "sweep") && is_of_laps(column.name)) names.push_back(name_of(column, lap));
  for (const RaceColumn& column : columns)
    if (stands_in(column, "sweep") && !is_of_laps(column.name) && column.name != names.front())
      names.emplace_back(column.name);
  return names;
}

std::string_view interval_of(std::string_view name) {
  for (const std::string_view end : {"_lo", "_hi"})
    if (name.ends_with(end)) return name.substr(0, name.size() - end.size());
  return {};
}

bool is_table_column(std::string_view name) {
  if (find_race_column(name)) return true;
  const std::optional<NamedColumn> of = find_race_column(interval_of(name));
  return of && of->column->has_interval;
}

}  // namespace gripline
