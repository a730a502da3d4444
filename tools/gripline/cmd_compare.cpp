// gripline compare and gripline run.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "config/blame.hpp"
#include "config/errors.hpp"
#include "diagnose/scoring/diagnose_experiment.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/race_runner.hpp"
#include "experiment/race_tables.hpp"
#include "experiment/validation.hpp"
#include "gripline/race_options.hpp"
#include "util/progress.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

struct Selection {
  std::vector<std::string> stacks;
  std::vector<std::uint64_t> seeds;
  bool judged = true;  // are claims asked about?
};

void require_stack(const RaceSpec& race, const std::string& name) {
  std::vector<std::string> names;
  for (const StackSpec& stack : race.stacks) names.push_back(stack.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError("no stack \"" + name + "\" in " + race.name + did_you_mean(name, names));
}

std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> names;
  std::string name;
  std::istringstream rest(text);
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  while (std::getline(rest, name, ',')) {
    name.erase(std::find_if_not(name.rbegin(), name.rend(), blank).base(), name.end());
    name.erase(name.begin(), std::find_if_not(name.begin(), name.end(), blank));
    names.push_back(name);
  }
  if (text.ends_with(',')) names.emplace_back();
  if (std::all_of(names.begin(), names.end(), [](const std::string& one) { return one.empty(); }))
    throw InputError("--only names no stack; expected names with commas between them");
  if (std::find(names.begin(), names.end(), "") != names.end())
    throw InputError("--only " + text + ": a name is missing between commas");
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

/// Everything of this race in the folder: what was asked for now and what earlier calls left.
std::vector<RunResult> all_results(const RaceSpec& race, const RunnerOutcome& now, const std::filesystem::path& out) {
  std::vector<RunResult> all = results_in(race, out);
  const auto place = [&](const RunResult& run) {
    const auto stack = std::find_if(race.stacks.begin(), race.stacks.end(),
                                    [&](const StackSpec& s) { return s.name == run.summary.stack; });
    return std::pair(stack - race.stacks.begin(), run.summary.seed);
  };
  for (const RunResult& run : now.runs)
    if (std::none_of(all.begin(), all.end(), [&](const RunResult& other) { return place(other) == place(run); }))
      all.push_back(run);  // lost without a trace
  std::sort(all.begin(), all.end(), [&](const RunResult& a, const RunResult& b) { return place(a) < place(b); });
  return all;
}

/// What claims may be asked of: the experiment's own seeds, and stacks that have them all.
RaceResults judgeable(const RaceResults& all) {
  RaceResults judged = {all.race, {}, {}};
  const auto& seeds = all.race.seeds;
  for (const RunResult& run : all.runs)
    if (std::find(seeds.begin(), seeds.end(), run.summary.seed) != seeds.end()) judged.runs.push_back(run);
  for (const std::string& stack : all.rows)
    if (judged.of(stack).size() == seeds.size()) judged.rows.push_back(stack);
  return judged;
}

std::vector<std::string> rows_of(const RaceSpec& race, const std::vector<RunResult>& runs) {
  std::vector<std::string> rows;
  for (const StackSpec& stack : race.stacks)
    if (std::any_of(runs.begin(), runs.end(), [&](const RunResult& run) { return run.summary.stack == stack.name; }))
      rows.push_back(stack.name);
  return rows;
}

int race_and_report(const RaceSpec& race, const Selection& chosen, const Registry& registry,
                    const std::filesystem::path& out, int jobs, bool force) {
  const OutLock lock = open_out_folder(out, experiment_identity(race.tree), force);
  write_scene(out, race, registry);
  std::vector<RunId> ids;
  for (const std::string& stack : chosen.stacks)
    for (const std::uint64_t seed : chosen.seeds) ids.push_back({stack, seed});
  const RunnerOutcome outcome = run_all(race, ids, {out, jobs, true});
  const std::string interrupted = "interrupted: " + std::to_string(outcome.runs.size()) + " of " +
                                  std::to_string(ids.size()) +
                                  " runs are finished and kept; the same command goes on from here\n";
  if (outcome.interrupted && outcome.runs.empty()) {
    std::cerr << interrupted;
    return run_broke;
  }
  std::vector<RunResult> runs = all_results(race, outcome, out);
  const std::vector<std::string> rows = rows_of(race, runs);
  const RaceResults all = {race, std::move(runs), rows};
  const std::vector<ClaimResult> claims =
      outcome.interrupted ? std::vector<ClaimResult>{} : judge_all(judgeable(all), jobs == 1);
  write_tables(out, all, claims);
  const std::vector<ClaimResult> asked = chosen.judged ? claims : std::vector<ClaimResult>{};
  print_tables(std::cout, {race, outcome.runs, chosen.stacks}, asked);
  report_broken(outcome);
  if (outcome.kept > 0) std::cout << outcome.kept << " of " << ids.size() << " runs were already there.\n";
  if (all.runs.size() > outcome.runs.size())
    std::cout << "The files and the report have " << all.runs.size() - outcome.runs.size()
              << " more of this experiment's runs, from earlier calls.\n";
  std::cout << "results: " << out.string() << '\n';
  report_results(out);
  if (outcome.interrupted) {
    std::cerr << interrupted;
    return run_broke;
  }
  if (any_broken(outcome)) return run_broke;
  const bool failed = std::any_of(asked.begin(), asked.end(), [](const ClaimResult& c) { return c.holds == false; });
  return failed ? claim_failed : good;
}

/// The experiment with its assignments; an error that one of them makes is told at it.
template <class Read>
void read_with_blame(const RaceOptions& options, Read&& read) {
  try {
    read(options.assignments);
  } catch (const InputError& error) {
    throw blame_assignments(error, options.assignments, read);
  }
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

int diagnose_and_report(const Node& tree, const Registry& registry, const std::string& name,
                        const std::filesystem::path& out) {
  write_scene(out, name, "diagnose", tree);
  ToldProgress progress(std::cerr, name);
  const diagnose::DiagnoseOutcome outcome = diagnose::run_diagnose_experiment(tree, registry, out, progress.tell());
  progress.finish();
  write_claims(out, outcome.claims);
  for (const diagnose::CaseOutcome& c : outcome.cases) {
    write_scene(out / c.name, c.name + " of " + name, "diagnosis", Node{Node::Object{}});
    write_case_report(out / c.name);
  }
  for (const diagnose::CaseOutcome& c : outcome.cases)
    std::cout << c.name << ": " << diagnose::verdict_names[static_cast<std::size_t>(c.verdict)] << ": " << c.sentence
              << '\n';
  bool failed = false;
  for (const ClaimResult& claim : outcome.claims) {
    failed |= claim.holds == false;
    std::cout << (claim.holds == true ? "holds  " : "FAILS  ") << claim.text << '\n';
  }
  std::cout << "results: " << out.string() << '\n';
  report_results(out);
  return failed ? claim_failed : good;
}

}  // namespace

int run_compare(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("only", po::value<std::string>(), "stacks to run, a,b,c (default: all)");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "compare EXPERIMENT [options]");
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const Registry registry(Registry::search_path(options.plugin_dirs));
  Node tree;
  std::optional<RaceSpec> race;
  read_with_blame(options, [&](std::span<const std::string> assignments) {
    race.reset();
    tree = load_experiment(options.experiment, assignments);
    if (experiment_kind(tree) == "offline_validation")
      check_offline(tree, registry);
    else if (experiment_kind(tree) == "diagnose")
      diagnose::check_diagnose_experiment(tree, registry);
    else
      race.emplace(read_race(options.experiment, tree, registry));
  });
  const std::string kind = experiment_kind(tree);
  const std::filesystem::path out = out_of(options);
  const std::string name = options.experiment.stem().string();
  if (!race) {
    const OutLock lock = open_out_folder(out, experiment_identity(tree), options.force);
    if (kind == "diagnose") return diagnose_and_report(tree, registry, name, out);
    write_scene(out, name, kind, tree);
    ToldProgress progress(std::cerr, name);
    const std::vector<ChannelScore> scores = validate_offline(tree, registry, out, progress.tell());
    progress.finish();
    return validate_and_report(scores, out);
  }
  std::vector<std::string> only;
  if (given->count("only") > 0) only = split_names((*given)["only"].as<std::string>());
  const std::vector<std::string> rows = chosen_rows(*race, only);
  if (kind == "force_validation") {
    const OutLock lock = open_out_folder(out, experiment_identity(tree), options.force);
    write_scene(out, *race, registry);
    ToldProgress progress(std::cerr, name);
    const std::vector<ChannelScore> scores = validate_forces(*race, rows, out, progress.tell());
    progress.finish();
    return validate_and_report(scores, out);
  }
  if (kind != "race") {
    const std::vector<std::string> kinds = {"race", "offline_validation", "force_validation", "diagnose"};
    throw InputError(options.experiment.string() + ": /kind: \"" + kind + "\"" + did_you_mean(kind, kinds));
  }
  return race_and_report(*race, {rows, race->seeds}, registry, out, options.jobs, options.force);
}

int run_one(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("stack", po::value<std::string>(), "the stack to run");
  visible.add_options()("seed", po::value<std::string>(), "the seed (default: the experiment's first)");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "run EXPERIMENT --stack S [--seed N] [options]");
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const Registry registry(Registry::search_path(options.plugin_dirs));
  std::optional<RaceSpec> race;
  read_with_blame(options, [&](std::span<const std::string> assignments) {
    race.reset();
    race.emplace(read_race(options.experiment, load_experiment(options.experiment, assignments), registry));
  });
  if (given->count("stack") == 0 && race->stacks.size() != 1) {
    std::string names;
    for (const StackSpec& stack : race->stacks) names += (names.empty() ? "" : ", ") + stack.name;
    throw InputError("which stack? --stack one of: " + names);
  }
  const std::string stack = given->count("stack") > 0 ? (*given)["stack"].as<std::string>() : race->stacks[0].name;
  require_stack(*race, stack);
  std::uint64_t seed = race->seeds.front();
  if (given->count("seed") > 0) {
    const std::int64_t number = whole_number(*given, "seed", "--seed");
    if (number < 0 || number > largest_seed)
      throw InputError("--seed " + std::to_string(number) + ": expected 0 to " + std::to_string(largest_seed));
    seed = static_cast<std::uint64_t>(number);
  }
  return race_and_report(*race, {{stack}, {seed}, false}, registry, out_of(options), options.jobs, options.force);
}

}  // namespace gripline::tools
