#include "sweep/kinds.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "calibrate/measured_experiment.hpp"
#include "diagnose/scoring/diagnose_experiment.hpp"
#include "experiment/experiment.hpp"
#include "experiment/force_validation.hpp"
#include "experiment/offline_validation.hpp"
#include "experiment/race_tables.hpp"
#include "util/child_process.hpp"
#include "util/disk.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr double patience_s = 3600;  // of kinds whose drives bound themselves

std::string this_machine() {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  return host;
}

/// CPU time of all children that ended so far [s].
double children_cpu_s() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Columns of runs.csv that come out the same each time, and pace ratios.
std::vector<std::string> recorded_columns(std::size_t laps) {
  std::vector<std::string> names = {"finished"};
  for (std::size_t i = 0; i < laps; ++i) {
    const std::string number = std::to_string(i);
    names.push_back("lap" + number + "_s");
    names.push_back("pace_ratio" + number);
  }
  for (const char* name :
       {"mean_deviation_m", "violation_s", "violation_body_s", "violation_after_adapt_s",
        "violation_body_after_adapt_s", "mu_rmse", "mu_visited_rmse", "solver_failures", "steps", "simulated_s"})
    names.emplace_back(name);
  return names;
}

Record record_of(const RaceSpec& race, const RunResult& result) {
  Record record;
  record.status = status_name(result.summary.status);
  record.message = result.summary.message;
  const RaceResults alone = {race, {}, {}};
  for (const std::string& column : recorded_columns(result.summary.laps.size()))
    if (const std::optional<double> value = alone.run_value(result, column)) record.values.emplace_back(column, *value);
  if (result.summary.mu_bias) record.values.emplace_back("mu_bias", *result.summary.mu_bias);
  record.times = {{"solve_ms_median", result.timing.solve_ms_median},
                  {"solve_ms_p99", result.timing.solve_ms_p99},
                  {"race_cpu_s", result.timing.cpu_s}};
  return record;
}

Values score_values(const std::vector<ChannelScore>& scores) {
  Values values;
  for (const ChannelScore& score : scores) {
    values.emplace_back(score.channel + "_r2", score.r2);
    values.emplace_back(score.channel + "_rmse", score.rmse);
  }
  return values;
}

Values measured_values(const Node& tree, const Registry& registry) {
  const calibrate::MeasuredOutcome outcome =
      calibrate::run_measured(calibrate::read_measured(tree, registry), registry, {});
  Values values;
  for (const calibrate::HorizonRow& row : outcome.rows) {
    std::string name = row.name;
    for (char& c : name)
      if (c == ' ') c = '_';
    for (std::size_t q = 0; q < calibrate::quantities; ++q)
      values.emplace_back(name + "." + calibrate::quantity_names[q], row.error[q].rms);
  }
  return values;
}

Values values_of_kind(const fs::path& file, const std::string& kind, const Node& tree, const Registry& registry,
                      const fs::path& scratch) {
  if (kind == "offline_validation") return score_values(validate_offline(tree, registry, scratch));
  if (kind == "force_validation") {
    const RaceSpec race = read_race(file, tree, registry);
    std::vector<std::string> rows;
    for (const StackSpec& stack : race.stacks) rows.push_back(stack.name);
    return score_values(validate_forces(race, rows, scratch));
  }
  if (kind == "diagnose") return diagnose::run_diagnose_experiment(tree, registry, scratch).cases.at(0).values;
  if (kind == "measured") return measured_values(tree, registry);
  throw std::logic_error("no run of kind " + kind);
}

void limit_data(std::size_t megabytes) {
  if (megabytes == 0) return;
  const rlim_t bytes = static_cast<rlim_t>(megabytes) << 20U;
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_DATA, &limit);
}

}  // namespace

void check_experiment(const fs::path& file, Node tree, const Registry& registry) {
  const std::string kind = experiment_kind(tree);
  if (kind == "offline_validation")
    check_offline(tree, registry);
  else if (kind == "diagnose")
    diagnose::check_diagnose_experiment(tree, registry);
  else if (kind == "measured")
    calibrate::read_measured(tree, registry);
  else
    read_race(file, std::move(tree), registry);
}

RaceRuns::RaceRuns(const fs::path& file, Node tree, const Registry& registry)
    : race_(read_race(file, std::move(tree), registry)) {}

Record RaceRuns::run(const std::string& row, std::uint64_t seed, const fs::path& scratch, const RunLimits& limits,
                     FileHashes& hashes, bool& interrupted) const {
  const double before = children_cpu_s();
  RunnerOptions options{scratch, 1, false, limits.timeout_s, limits.memory_mb, &hashes};
  const RunnerOutcome outcome = run_all(race_, {{row, seed}}, options);
  interrupted = outcome.interrupted;
  Record record;
  if (!outcome.runs.empty()) record = record_of(race_, outcome.runs.front());
  record.times.emplace_back("cpu_s", children_cpu_s() - before);
  record.node = this_machine();
  return record;
}

Record run_other(const fs::path& file, const std::string& kind, const Node& tree, const Registry& registry,
                 const fs::path& scratch, const RunLimits& limits) {
  const double before = children_cpu_s();
  Record record;
  const ChildAnswer answer =
      ask_child(limits.timeout_s > 0 ? limits.timeout_s : patience_s, [&](const TellParent& tell) {
        limit_data(limits.memory_mb);
        if (!disk().make_folders(scratch)) throw std::runtime_error("cannot make " + scratch.string());
        for (const auto& [name, value] : values_of_kind(file, kind, tree, registry, scratch))
          if (std::isfinite(value)) tell(name + "=" + number_text(value));
      });
  for (const std::string& told : answer.told) {
    const std::size_t equals = told.rfind('=');
    double value = 0;
    std::from_chars(told.data() + equals + 1, told.data() + told.size(), value);
    record.values.emplace_back(told.substr(0, equals), value);
  }
  record.status = answer.complete ? "done" : "error";
  if (!answer.complete) {
    record.message = answer.end;
    record.values.clear();
  }
  record.times.emplace_back("cpu_s", children_cpu_s() - before);
  record.node = this_machine();
  return record;
}

bool may_be_retried(const Record& record) {
  // As describe_end() says it: somebody, or the system when memory ran out, killed the process.
  return record.broken() && (record.message.find("was ended by signal 9 ") != std::string::npos ||
                             record.message.find("was ended by signal 15 ") != std::string::npos ||
                             record.message.find("cannot write ") != std::string::npos);
}

}  // namespace gripline::sweep
