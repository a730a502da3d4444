// gripline compare and gripline run.
#include <algorithm>
#include <cstdio>
#include <iostream>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "diagnose/diagnose_experiment.hpp"
#include "out_folder.hpp"
#include "race_options.hpp"
#include "race_runner.hpp"
#include "race_tables.hpp"
#include "validation.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

struct Selection {
  std::vector<std::string> stacks;
  std::vector<std::uint64_t> seeds;
};

void require_stack(const RaceSpec& race, const std::string& name) {
  std::vector<std::string> names;
  for (const StackSpec& stack : race.stacks) names.push_back(stack.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError("no stack \"" + name + "\" in " + race.name + did_you_mean(name, names));
}

std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> names;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    if (comma > begin) names.push_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return names;
}

/// Rows in the order of the experiment, whatever the order asked for.
std::vector<std::string> chosen_rows(const RaceSpec& race, const std::vector<std::string>& only) {
  for (const std::string& name : only) require_stack(race, name);
  std::vector<std::string> rows;
  for (const StackSpec& stack : race.stacks)
    if (only.empty() || std::find(only.begin(), only.end(), stack.name) != only.end()) rows.push_back(stack.name);
  return rows;
}

/// What makes two calls the same experiment: its tree, not the rows chosen.
std::string identity_of(const RaceSpec& race) { return sha256_hex(content_text(race.tree)); }

void report_broken(const RunnerOutcome& outcome) {
  for (const RunResult& run : outcome.runs)
    if (!run.summary.message.empty() && run.summary.status != Status::finished)
      std::cerr << run.summary.stack << ", seed " << run.summary.seed << ": " << status_name(run.summary.status) << ": "
                << run.summary.message << '\n';
}

bool any_broken(const RunnerOutcome& outcome) {
  return std::any_of(outcome.runs.begin(), outcome.runs.end(), [](const RunResult& run) {
    return run.summary.status == Status::error || run.summary.status == Status::plugin_error;
  });
}

int race_and_report(const RaceSpec& race, const Selection& chosen, const Registry& registry,
                    const std::filesystem::path& out, int jobs, bool force) {
  open_out_folder(out, identity_of(race), force);
  write_scene(out, race, registry);
  std::vector<RunId> ids;
  for (const std::string& stack : chosen.stacks)
    for (const std::uint64_t seed : chosen.seeds) ids.push_back({stack, seed});
  const RunnerOutcome outcome = run_all(race, ids, {out, jobs, true});
  const RaceResults results = {race, outcome.runs, chosen.stacks};
  const std::vector<ClaimResult> claims =
      outcome.interrupted ? std::vector<ClaimResult>{} : judge_all(results, jobs == 1);
  write_tables(out, results, claims);
  print_tables(std::cout, results, claims);
  report_broken(outcome);
  if (outcome.kept > 0) std::cout << outcome.kept << " of " << ids.size() << " runs were already there.\n";
  std::cout << "results: " << out.string() << '\n';
  report_results(out);
  if (outcome.interrupted) {
    std::cerr << "interrupted: " << outcome.runs.size() << " of " << ids.size()
              << " runs are finished and kept; the same command goes on from here\n";
    return run_broke;
  }
  if (any_broken(outcome)) return run_broke;
  const bool failed = std::any_of(claims.begin(), claims.end(), [](const ClaimResult& c) { return c.holds == false; });
  return failed ? claim_failed : good;
}

/// The kinds that answer a question about estimators instead of racing.
int validate_and_report(const std::vector<ChannelScore>& scores, const std::filesystem::path& out) {
  for (const ChannelScore& s : scores) {
    char line[160];
    std::snprintf(line, sizeof line, "%-14s %-12s  R2 %8.4f   rmse %.4g %s   n %zu", s.estimator.c_str(),
                  s.channel.c_str(), s.r2, s.rmse, s.unit.c_str(), s.n);
    std::cout << line << '\n';
  }
  std::cout << "results: " << out.string() << '\n';
  report_results(out);
  return good;
}

int diagnose_and_report(const Node& tree, const Registry& registry, const std::filesystem::path& out) {
  const diagnose::DiagnoseOutcome outcome = diagnose::run_diagnose_experiment(tree, registry, out);
  for (const diagnose::CaseOutcome& c : outcome.cases)
    std::cout << c.name << ": " << diagnose::verdict_names[static_cast<std::size_t>(c.verdict)] << ": " << c.sentence
              << '\n';
  bool failed = false;
  for (const ClaimResult& claim : outcome.claims) {
    failed |= claim.holds == false;
    std::cout << (claim.holds == true ? "holds  " : "FAILS  ") << claim.text << '\n';
  }
  std::cout << "results: " << out.string() << '\n';
  return failed ? claim_failed : good;
}

}  // namespace

int run_compare(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("only", po::value<std::string>(), "stacks to run, a,b,c (default: all)");
  visible.add_options()("jobs,j", po::value<int>()->default_value(1), "runs at the same time");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "compare EXPERIMENT [options]");
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const int jobs = (*given)["jobs"].as<int>();
  if (jobs < 1) throw InputError("-j " + std::to_string(jobs) + ": at least one run at a time");
  Node tree = load_experiment(options.experiment, options.assignments);
  const Registry registry(Registry::search_path(options.plugin_dirs));
  const std::string kind = experiment_kind(tree);
  if (kind == "offline_validation") {
    open_out_folder(out_of(options), sha256_hex(content_text(tree)), options.force);
    return validate_and_report(validate_offline(tree, registry, out_of(options)), out_of(options));
  }
  if (kind == "diagnose") {
    open_out_folder(out_of(options), sha256_hex(content_text(tree)), options.force);
    return diagnose_and_report(tree, registry, out_of(options));
  }
  const RaceSpec race = read_race(options.experiment, std::move(tree), registry);
  std::vector<std::string> only;
  if (given->count("only") > 0) {
    only = split_names((*given)["only"].as<std::string>());
    if (only.empty()) throw InputError("--only names no stack; expected names with commas between them");
  }
  if (kind == "force_validation") {
    open_out_folder(out_of(options), identity_of(race), options.force);
    return validate_and_report(validate_forces(race, chosen_rows(race, only), out_of(options)), out_of(options));
  }
  if (kind != "race") {
    const std::vector<std::string> kinds = {"race", "offline_validation", "force_validation", "diagnose"};
    throw InputError(options.experiment.string() + ": /kind: \"" + kind + "\"" + did_you_mean(kind, kinds));
  }
  return race_and_report(race, {chosen_rows(race, only), race.seeds}, registry, out_of(options), jobs, options.force);
}

int run_one(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("stack", po::value<std::string>(), "the stack to run");
  visible.add_options()("seed", po::value<std::int64_t>(), "the seed (default: the experiment's first)");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "run EXPERIMENT --stack S [--seed N] [options]");
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const Registry registry(Registry::search_path(options.plugin_dirs));
  RaceSpec race = read_race(options.experiment, load_experiment(options.experiment, options.assignments), registry);
  if (given->count("stack") == 0 && race.stacks.size() != 1) {
    std::string names;
    for (const StackSpec& stack : race.stacks) names += (names.empty() ? "" : ", ") + stack.name;
    throw InputError("which stack? --stack one of: " + names);
  }
  const std::string stack = given->count("stack") > 0 ? (*given)["stack"].as<std::string>() : race.stacks[0].name;
  require_stack(race, stack);
  if (given->count("seed") > 0) {
    const std::int64_t seed = (*given)["seed"].as<std::int64_t>();
    if (seed < 0 || seed > largest_seed)
      throw InputError("--seed " + std::to_string(seed) + ": expected 0 to " + std::to_string(largest_seed));
    race.seeds = {static_cast<std::uint64_t>(seed)};
  }
  race.seeds.resize(1);
  race.claims.clear();
  return race_and_report(race, {{stack}, race.seeds}, registry, out_of(options), 1, options.force);
}

}  // namespace gripline::tools
