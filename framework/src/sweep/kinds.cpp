#include "sweep/kinds.hpp"

#include <atomic>
#include <charconv>
#include <cmath>

#include "calibrate/measured_kind/measured_experiment.hpp"
#include "config/errors.hpp"
#include "diagnose/scoring/diagnose_experiment.hpp"
#include "experiment/force_validation.hpp"
#include "experiment/offline_validation.hpp"
#include "experiment/race_columns.hpp"
#include "experiment/race_results.hpp"
#include "experiment/race_runner.hpp"
#include "experiment/run_folder.hpp"
#include "util/child_process.hpp"
#include "util/clock.hpp"
#include "util/disk.hpp"
#include "util/machine.hpp"
#include "util/shared_array.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr double silence_s = 3600;  // time limit of kinds other than races, whose simulations end by themselves

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

void check_race(const fs::path& file, const Node& tree, const Registry& registry) {
  (void)read_race(file, tree, registry);
}

void check_estimators(const fs::path&, const Node& tree, const Registry& registry) { check_offline(tree, registry); }

Values run_estimator(const fs::path&, const Node& tree, const Registry& registry, const fs::path& scratch) {
  return score_values(validate_offline(tree, registry, scratch));
}

Values run_forces(const fs::path& file, const Node& tree, const Registry& registry, const fs::path& scratch) {
  const RaceSpec race = read_race(file, tree, registry);
  std::vector<std::string> rows;
  for (const StackSpec& stack : race.stacks) rows.push_back(stack.name);
  return score_values(validate_forces(race, rows, scratch).scores);
}

void check_cases(const fs::path&, const Node& tree, const Registry& registry) {
  diagnose::check_diagnose_experiment(tree, registry);
}

Values run_case(const fs::path&, const Node& tree, const Registry& registry, const fs::path& scratch) {
  return diagnose::run_diagnose_experiment(tree, registry, scratch).cases.at(0).values;
}

void check_measured(const fs::path&, const Node& tree, const Registry& registry) {
  (void)calibrate::read_measured(tree, registry);
}

Values run_measured(const fs::path&, const Node& tree, const Registry& registry, const fs::path&) {
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

constexpr SweptKind kinds[] = {
    {"race", "stacks", "seeds", true, false, check_race, nullptr},  // the one of an experiment that says none
    {"offline_validation", "estimators", "seed", false, false, check_estimators, run_estimator},
    {"force_validation", "stacks", "seeds", true, false, check_race, run_forces},
    {"diagnose", "cases", "seed", false, true, check_cases, run_case},
    {"measured", nullptr, nullptr, false, false, check_measured, run_measured},
};

}  // namespace

const SweptKind& kind_of(const Node& tree) {
  std::vector<std::string> names;
  for (const SweptKind& one : kinds) names.emplace_back(one.name);
  return kinds[read_kind(tree, names)];
}

const SweptKind& kind_named(std::string_view name) {
  for (const SweptKind& one : kinds)
    if (one.name == name) return one;
  throw InputError("no kind of experiment is called \"" + std::string(name) + "\"");
}

RaceRuns::RaceRuns(const fs::path& file, Node tree, const Registry& registry)
    : race_(read_race(file, std::move(tree), registry)) {}

Attempt RaceRuns::run(const std::string& row, std::uint64_t seed, const fs::path& scratch, const RunLimits& limits,
                      FileHashes& hashes) const {
  const double before = children_cpu_s();
  const RunId id = {row, seed};
  RunnerOptions options{scratch, 1, false, limits.timeout_s, limits.memory_mb, &hashes};
  const RunnerOutcome outcome = run_all(race_, {id}, options);
  Attempt attempt;
  attempt.files = run_folder(scratch, id);
  attempt.interrupted = outcome.interrupted;
  attempt.cut_off = !outcome.cut_off.empty();
  if (!outcome.runs.empty()) attempt.record = record_of(race_, outcome.runs.front());
  attempt.record.times.emplace_back("cpu_s", children_cpu_s() - before);
  attempt.record.node = this_machine();
  return attempt;
}

Attempt run_other(const fs::path& file, const SweptKind& kind, const Node& tree, const Registry& registry,
                  const fs::path& scratch, const RunLimits& limits) {
  const double before = children_cpu_s();
  SharedArray<std::atomic<bool>> disk_refused(1);
  const auto work = [&](const SendMessage& send) {
    limit_data(limits.memory_mb);
    try {
      if (!disk().make_folders(scratch)) fail_with_errno("cannot make " + scratch.string());
      for (const auto& [name, value] : kind.run(file, tree, registry, scratch))
        if (std::isfinite(value)) send(name + "=" + number_text(value));
    } catch (const DiskError&) {
      disk_refused[0].store(true);
      throw;
    }
  };
  const ChildResult result = run_in_child(limits.timeout_s > 0 ? limits.timeout_s : silence_s, work);
  Attempt attempt;
  attempt.files = scratch;
  attempt.cut_off = !result.completed && (disk_refused[0].load() || ends_from_outside(result.signal));
  Record& record = attempt.record;
  record.status = result.completed ? "done" : "error";
  record.message = result.failure;
  for (const std::string& message : result.messages) {
    if (!result.completed) break;
    const std::size_t equals = message.rfind('=');
    double value = 0;
    std::from_chars(message.data() + equals + 1, message.data() + message.size(), value);
    record.values.emplace_back(message.substr(0, equals), value);
  }
  record.times.emplace_back("cpu_s", children_cpu_s() - before);
  record.node = this_machine();
  return attempt;
}

}  // namespace gripline::sweep
