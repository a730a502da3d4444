#include "sweep/kinds.hpp"

#include <unistd.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "calibrate/measured_kind/measured_experiment.hpp"
#include "diagnose/scoring/diagnose_experiment.hpp"
#include "experiment/experiment.hpp"
#include "experiment/force_validation.hpp"
#include "experiment/offline_validation.hpp"
#include "experiment/race_columns.hpp"
#include "experiment/race_results.hpp"
#include "experiment/race_runner.hpp"
#include "util/child_process.hpp"
#include "util/clock.hpp"
#include "util/disk.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr double silence_s = 3600;  // time limit of kinds other than races, whose simulations end by themselves

std::string this_machine() {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  return host;
}

Record record_of(const RaceSpec& race, const RunResult& result) {
  Record record;
  record.status = status_name(result.summary.status);
  record.message = result.summary.message;
  record.drive = result.drive;
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
    return score_values(validate_forces(race, rows, scratch).scores);
  }
  if (kind == "diagnose") return diagnose::run_diagnose_experiment(tree, registry, scratch).cases.at(0).values;
  if (kind == "measured") return measured_values(tree, registry);
  throw std::logic_error("no run of kind " + kind);
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
  const ChildResult result =
      run_in_child(limits.timeout_s > 0 ? limits.timeout_s : silence_s, [&](const SendMessage& send) {
        limit_data(limits.memory_mb);
        if (!disk().make_folders(scratch)) throw std::runtime_error("cannot make " + scratch.string());
        for (const auto& [name, value] : values_of_kind(file, kind, tree, registry, scratch))
          if (std::isfinite(value)) send(name + "=" + number_text(value));
      });
  for (const std::string& message : result.messages) {
    const std::size_t equals = message.rfind('=');
    double value = 0;
    std::from_chars(message.data() + equals + 1, message.data() + message.size(), value);
    record.values.emplace_back(message.substr(0, equals), value);
  }
  record.status = result.completed ? "done" : "error";
  if (!result.completed) {
    record.message = result.failure;
    record.values.clear();
  }
  record.times.emplace_back("cpu_s", children_cpu_s() - before);
  record.node = this_machine();
  return record;
}

bool may_be_retried(const Record& record) {
  // The words of describe_end(): the process was killed by a user, or by the system when memory ran out.
  return record.broken() && (record.message.find("was ended by signal 9 ") != std::string::npos ||
                             record.message.find("was ended by signal 15 ") != std::string::npos ||
                             record.message.find("cannot write ") != std::string::npos);
}

}  // namespace gripline::sweep
