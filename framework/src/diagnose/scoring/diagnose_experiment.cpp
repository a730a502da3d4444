#include "diagnose/scoring/diagnose_experiment.hpp"

#include <algorithm>
#include <cmath>

#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "diagnose/result/report_data.hpp"
#include "experiment/experiment.hpp"
#include "experiment/result_files.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"
#include "util/csv_cell.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

namespace fs = std::filesystem;

struct HiddenCase {
  std::string name;
  WorldSpec world;  // with what is hidden
  Answer truth;
  bool round_trip = false;
};

struct DiagnoseExperiment {
  Node nominal_tree;
  WorldSpec nominal;
  StackSpec driver, other_driver;
  std::uint64_t seed = 1;
  CaseOptions options;
  std::vector<HiddenCase> cases;
  std::vector<Claim> claims;
};

Names read_names(const Node& node, Errors& errors) {
  Names names;
  if (node.is_text()) return {node.text()};
  if (!node.is_array()) {
    errors.add(node.origin, "expected an effect or a list of effects, found " + node.describe());
    return names;
  }
  for (const Node& id : node.array()) names.insert(read_text(id, errors));
  return names;
}

StackSpec read_driver(ObjectReader& r, const char* key, const DiagnoseExperiment& e, const Registry& registry,
                      Errors& errors) {
  Node stack(Node::Object{}, child_of(r.node().origin, key));
  if (const Node* given = r.require(key, "a model, a planner and a controller"); given != nullptr) stack = *given;
  return read_stack("driver", stack, registry, e.nominal.car, errors);
}

HiddenCase read_hidden(const Member& member, const DiagnoseExperiment& e, const Registry& registry, Errors& errors) {
  HiddenCase one;
  one.name = member.key;
  errors.set_context("case " + member.key);
  ObjectReader r(member.value, errors);
  Node tree = e.nominal_tree;
  const Node* const hidden = r.find("hidden");
  if (hidden != nullptr) tree = merge(tree, *hidden);
  inline_world_files(tree);
  // Without the nominal world, which has been told, there is none to read.
  if (!e.nominal_tree.is_null()) one.world = read_world(tree, registry, errors);
  for (const StackSpec* driver : {&e.driver, &e.other_driver}) check_sensors(*driver, one.world.sensors, errors);
  std::vector<Names> missing;  // sets that are right
  for (const Node& set : r.array("missing", false)) missing.push_back(read_names(set, errors));
  const bool hides = hidden != nullptr && !(hidden->is_object() && hidden->object().empty());
  one.truth = answer_of(std::move(missing), hides);
  one.round_trip = r.boolean("round_trip", false);
  r.finish();
  errors.set_context("");
  return one;
}

DiagnoseExperiment read_experiment(const Node& tree, const Registry& registry) {
  Errors errors;
  DiagnoseExperiment e;
  {
    ObjectReader r(tree, errors);
    r.find("kind");
    if (const Node* nominal = r.require("nominal", "a world file or an object"); nominal != nullptr) {
      e.nominal_tree = *nominal;
      inline_file(e.nominal_tree);
      inline_world_files(e.nominal_tree);
      e.nominal = read_world(e.nominal_tree, registry, errors);
    }
    e.driver = read_driver(r, "driver", e, registry, errors);
    e.other_driver = r.has("held_out_driver") ? read_driver(r, "held_out_driver", e, registry, errors) : e.driver;
    e.seed = static_cast<std::uint64_t>(r.integer("seed", {0, largest_seed}, 1));
    if (const Node* u = r.find("nominal_uncertainty"); u != nullptr) read_uncertainty(*u, e.options, errors);
    for (const Node& id : r.array("exclude", false)) e.options.exclude.push_back(read_text(id, errors));
    std::vector<std::string> names;
    ObjectReader cases = r.object("cases");
    for (const Member* member : cases.members()) {
      e.cases.push_back(read_hidden(*member, e, registry, errors));
      names.push_back(member->key);
    }
    for (const Node& node : names.empty() ? std::span<const Node>{} : r.array("claims", false))
      if (auto claim = read_claim(node, names, errors, outcome_columns())) e.claims.push_back(*std::move(claim));
    r.finish();
  }
  errors.throw_if_any();
  require_vehicle_model(e.nominal, "diagnose");
  return e;
}

/// Leaves only the cases of these names; all where there are none.
void choose_cases(std::span<const std::string> only, DiagnoseExperiment& e) {
  if (only.empty()) return;
  std::vector<std::string> known;
  for (const HiddenCase& one : e.cases) known.push_back(one.name);
  for (const std::string& name : only)
    if (std::ranges::find(known, name) == known.end())
      throw InputError("--only: no case \"" + name + "\" in this experiment" + did_you_mean(name, known));
  std::erase_if(e.cases, [&](const HiddenCase& one) { return std::ranges::find(only, one.name) == only.end(); });
}

bool is_left_out(const ClaimTerm& term, const DiagnoseOutcome& outcome) {
  return !term.stack.empty() &&
         std::ranges::none_of(outcome.cases, [&](const CaseOutcome& c) { return c.name == term.stack; });
}

/// One drive; its log is the run's steps.csv.
fs::path drive(const WorldSpec& spec, const StackSpec& driver, std::uint64_t seed, const fs::path& folder) {
  const RunSummary summary =
      RaceAssembly(spec, driver, {.seed = seed, .folder = folder, .cache_dir = plugin_cache_folder()}).run();
  if (summary.status != Status::finished)
    throw std::runtime_error(folder.string() + ": the driver did not finish: " + summary.message);
  return folder / "steps.csv";
}

Diagnosis diagnose_logs(const WorldSpec& nominal, const Registry& registry, const CaseOptions& options,
                        const fs::path& log, const fs::path& held_out, const fs::path& world_file,
                        const fs::path& out) {
  Diagnoser diagnoser(nominal, registry, options);
  const measured::LogExpectations expected{nominal.car.car.v_ref, &diagnoser.road(), nominal.car.car.delta_max};
  const std::vector<LogFile> logs{read_log_file(log, expected)}, held{read_log_file(held_out, expected)};
  Diagnosis d = diagnoser.run(logs, held);
  write_diagnosis(out, d, diagnoser, nominal, world_file, std::nullopt);
  write_file(out / result_files::diagnosis_report,
             to_json_text(report_data(d, diagnoser, log.filename().string(), world_file.filename().string(),
                                      world_patch(d, diagnoser, nominal))));
  return d;
}

/// Drives the world that was found and asks again, with that world as the nominal one: 1 when nothing is missing.
double round_trip(const DiagnoseExperiment& e, const Registry& registry, const fs::path& folder) {
  Errors errors;
  Node tree = load_json(folder / result_files::augmented_world);
  inline_world_files(tree);
  const WorldSpec found = read_world(tree, registry, errors);
  errors.throw_if_any();
  const fs::path again = folder / "round_trip";
  const fs::path log = drive(found, e.driver, e.seed + 100, again / "drive");
  const fs::path held = drive(found, e.other_driver, e.seed + 101, again / "held_out");
  const Diagnosis d =
      diagnose_logs(found, registry, CaseOptions{}, log, held, folder / result_files::augmented_world, again);
  return d.verdict == Verdict::nothing_missing ? 1.0 : 0.0;
}

CaseOutcome run_case(const DiagnoseExperiment& e, const HiddenCase& one, const Registry& registry,
                     const fs::path& out) {
  const fs::path folder = out / one.name;
  const fs::path log = drive(one.world, e.driver, e.seed, folder / "drive");
  const fs::path held = drive(one.world, e.other_driver, e.seed + 1, folder / "held_out");
  const Diagnosis d =
      diagnose_logs(e.nominal, registry, e.options, log, held, out / result_files::nominal_world, folder);
  CaseOutcome outcome = outcome_of(one.name, one.truth, d);
  if (one.round_trip) outcome.values.emplace_back("round_trip", round_trip(e, registry, folder));
  return outcome;
}

std::optional<double> look_up(std::span<const CaseOutcome> cases, const std::string& name, const std::string& column) {
  for (const CaseOutcome& c : cases)
    for (const auto& [key, value] : c.values)
      if (c.name == name && key == column) return value;
  return std::nullopt;
}

}  // namespace

CaseOutcome outcome_of(std::string name, const Answer& truth, const Diagnosis& d) {
  CaseOutcome outcome;
  outcome.name = std::move(name);
  outcome.sentence = d.sentence;
  outcome.verdict = d.verdict;
  double confidence = 1.0;
  for (const NamedEffect& n : d.named) confidence = std::min(confidence, n.confidence);
  for (std::size_t v = 0; v < verdict_names.size(); ++v)
    outcome.values.emplace_back(verdict_names[v], static_cast<std::size_t>(d.verdict) == v ? 1.0 : 0.0);
  outcome.values.emplace_back("right", judge(truth, d));
  outcome.values.emplace_back("confidence", confidence);
  outcome.values.emplace_back("before", d.gap.before);
  outcome.values.emplace_back("after", d.gap.after);
  outcome.values.emplace_back("closure", d.gap.closure);
  if (d.unknown) {
    outcome.values.emplace_back("from", d.unknown->from);
    outcome.values.emplace_back("to", d.unknown->to);
  }
  return outcome;
}

std::string outcome_csv(const DiagnoseOutcome& outcome) {
  std::string header = "case,verdict";
  for (const std::string& column : outcome_columns()) header += "," + column;
  std::string text;
  CsvWriter csv(text, header);
  for (const CaseOutcome& c : outcome.cases) {
    csv << csv_cell(c.name) << verdict_names[static_cast<std::size_t>(c.verdict)];
    for (const std::string& column : outcome_columns()) {
      const auto value = look_up(outcome.cases, c.name, column);
      csv << (value ? significant(*value, 6) : "");
    }
    csv.end_row();
  }
  return text;
}

std::span<const std::string> outcome_columns() {
  static const std::vector<std::string> names = {
      "named",  "nothing_missing", "indistinguishable", "unknown", "right", "confidence",
      "before", "after",           "closure",           "from",    "to",    "round_trip"};
  return names;
}

void check_diagnose_experiment(const Node& tree, const Registry& registry) { read_experiment(tree, registry); }

DiagnoseOutcome run_diagnose_experiment(const Node& tree, const Registry& registry, const fs::path& out,
                                        std::span<const std::string> only, const ProgressCallback& progress) {
  DiagnoseExperiment e = read_experiment(tree, registry);
  choose_cases(only, e);
  Diagnoser(e.nominal, registry, e.options);  // what it refuses is refused before anything is driven
  DiagnoseOutcome outcome;
  fs::create_directories(out);
  // What augmented worlds extend: the nominal world with everything it names in its place.
  write_file(out / result_files::nominal_world, to_json_text(e.nominal_tree));
  for (const HiddenCase& one : e.cases) {
    if (progress) progress(static_cast<double>(outcome.cases.size()), e.cases.size(), one.name);
    outcome.cases.push_back(run_case(e, one, registry, out));
  }
  write_file(out / result_files::diagnoses, outcome_csv(outcome));
  for (const Claim& claim : e.claims) {
    if (is_left_out(claim.left, outcome) || is_left_out(claim.right, outcome)) {
      ClaimResult& skipped = outcome.claims.emplace_back();
      skipped.text = claim.text;
      skipped.why_skipped = "a case was left out by --only";
      continue;
    }
    outcome.claims.push_back(judge(claim, 1, 1.0, [&](const std::string& name, const std::string& column, int) {
      return look_up(outcome.cases, name, column);
    }));
  }
  return outcome;
}

}  // namespace gripline::diagnose
