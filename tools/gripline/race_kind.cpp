#include "gripline/race_kind.hpp"

#include <algorithm>
#include <iostream>

#include "config/errors.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/pairs.hpp"
#include "experiment/race_judging.hpp"
#include "experiment/race_printing.hpp"
#include "experiment/race_runner.hpp"
#include "experiment/race_tables.hpp"
#include "experiment/race_warnings.hpp"
#include "experiment/result_files.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"
#include "world/plausibility.hpp"

namespace gripline::tools {
namespace {

void report_broken(const RunnerOutcome& outcome) {
  for (const std::string& note : outcome.notes) std::cerr << escape_control(note) << '\n';
  for (const RunResult& run : outcome.runs)
    if (!run.summary.message.empty())
      std::cerr << run.summary.stack << ", seed " << run.summary.seed << ": " << status_name(run.summary.status) << ": "
                << escape_control(run.summary.message) << '\n';
}

bool any_broken(const RunnerOutcome& outcome) {
  return std::any_of(outcome.runs.begin(), outcome.runs.end(), [](const RunResult& run) {
    return run.summary.status == Status::error || run.summary.status == Status::plugin_error;
  });
}

/// Everything of this race in the folder: what was asked for now and what earlier calls left; of drawn seeds only those
/// of this draw.
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
  if (!race.seeds_text.empty())
    std::erase_if(all, [&](const RunResult& run) {
      return std::find(race.seeds.begin(), race.seeds.end(), run.summary.seed) == race.seeds.end();
    });
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

/// Whether claims were skipped although this call drove one run at a time: runs that it kept were driven beside others.
bool kept_times_not_alone(const ExperimentRequest& request, const std::vector<ClaimResult>& claims) {
  return request.jobs == 1 && std::any_of(claims.begin(), claims.end(), [](const ClaimResult& claim) {
           return claim.why_skipped == times_not_alone;
         });
}

/// What was edited since the folder was written last.
void print_changes(const std::filesystem::path& out, const std::vector<std::string>& changes) {
  constexpr std::size_t most = 12;
  if (changes.empty()) return;
  std::cout << "since the last call into " << out.string() << ":\n";
  for (std::size_t i = 0; i < std::min(changes.size(), most); ++i)
    std::cout << "  " << escape_control(changes[i]) << '\n';
  if (changes.size() > most) std::cout << "  and " << changes.size() - most << " more\n";
}

std::string interrupted_text(const RunnerOutcome& outcome, std::size_t asked) {
  return "interrupted: " + std::to_string(outcome.runs.size()) + " of " + std::to_string(asked) +
         " runs are finished and kept; the same command goes on from here\n";
}

/// Claims are judged on whole races only.
std::vector<ClaimResult> judged_claims(const RaceResults& all, bool interrupted) {
  if (!interrupted) return judge_all(judgeable(all));
  std::vector<ClaimResult> skipped;
  for (const Claim& claim : all.race.claims) {
    skipped.emplace_back();
    skipped.back().text = claim.text;
    skipped.back().why_skipped = "interrupted";
  }
  return skipped;
}

/// Without a baseline none of an earlier call stays: its runs may be others.
void write_results(const std::filesystem::path& out, const RaceResults& all, const std::vector<ClaimResult>& claims,
                   const std::string& baseline) {
  write_tables(out, all, claims);
  if (!baseline.empty()) return write_pairs(out, baseline, paired_differences(all, baseline));
  std::error_code ignored;
  std::filesystem::remove(out / result_files::pairs, ignored);
}

/// What was not raced now, and why.
void print_kept(const ExperimentRequest& request, const RunnerOutcome& outcome, std::size_t asked, std::size_t all,
                const std::vector<ClaimResult>& claims) {
  if (outcome.kept > 0) std::cout << outcome.kept << " of " << asked << " runs were already there.\n";
  if (kept_times_not_alone(request, claims))
    std::cout << "Times of runs from earlier calls were not measured with -j 1; --force or another --out drives them "
                 "again.\n";
  if (outcome.replaced > 0)
    std::cout << outcome.replaced << " finished runs of other inputs or another gripline were raced again.\n";
  if (all > outcome.runs.size())
    std::cout << "The files and the report have " << all - outcome.runs.size()
              << " more of this experiment's runs, from earlier calls.\n";
}

class RaceExperiment final : public Experiment {
 public:
  RaceExperiment(RaceSpec race, const Registry& registry) : race_(std::move(race)), registry_(registry) {}
  int run(const ExperimentRequest& request) override {
    RunSelection chosen = {chosen_rows(race_, request.only), race_.seeds, true, request.baseline};
    if (!request.baseline.empty()) {
      require_stack(race_, request.baseline);
      if (std::find(chosen.stacks.begin(), chosen.stacks.end(), request.baseline) == chosen.stacks.end())
        throw InputError("--baseline " + request.baseline + " is not among the rows that --only names");
    }
    if (!request.seeds_from.empty()) draw_seeds(request.seeds_from, chosen);
    return race_and_report(race_, chosen, registry_, request);
  }
  std::vector<Diagnostic> warnings(const std::vector<std::string>& only) const override {
    return race_warnings(race_, chosen_rows(race_, only), true);
  }

 private:
  void draw_seeds(const std::string& text, RunSelection& chosen) {
    require_drawn_seeds_fit(race_.tree, text);
    race_.seeds_text = text;
    race_.seeds = chosen.seeds = seeds_from(text, race_.seeds.size());
    std::cout << "seeds from \"" << text << "\":";
    for (const std::uint64_t seed : race_.seeds) std::cout << ' ' << seed;
    std::cout << '\n';
  }

  RaceSpec race_;
  const Registry& registry_;
};

}  // namespace

void require_stack(const RaceSpec& race, const std::string& name) {
  std::vector<std::string> names;
  for (const StackSpec& stack : race.stacks) names.push_back(stack.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError("no stack \"" + name + "\" in " + race.name + did_you_mean(name, names));
}

std::vector<std::string> chosen_rows(const RaceSpec& race, const std::vector<std::string>& only) {
  for (const std::string& name : only) require_stack(race, name);
  std::vector<std::string> rows;
  for (const StackSpec& stack : race.stacks)
    if (only.empty() || std::find(only.begin(), only.end(), stack.name) != only.end()) rows.push_back(stack.name);
  return rows;
}

std::vector<Diagnostic> race_warnings(const RaceSpec& race, const std::vector<std::string>& stacks, bool judged) {
  constexpr const char* late_readings = "sensor_latency";  // the shipped effect that states them
  std::vector<Diagnostic> all = plausibility_warnings(race.world, *race.tree.find("world"));
  const auto add = [&](const std::vector<Diagnostic>& more) { all.insert(all.end(), more.begin(), more.end()); };
  add(late_sensor_warnings(race, stacks, late_readings));
  if (judged) add(claim_warnings(race));
  return all;
}

int race_and_report(const RaceSpec& race, const RunSelection& chosen, const Registry& registry,
                    const ExperimentRequest& request) {
  const std::filesystem::path& out = request.out;
  EditedExperiment edited{&race.tree, [&] { return !results_in(race, out).empty(); }, {}};
  const OutLock lock =
      open_out_folder(out, experiment_identity(race.tree), {.force = request.force, .edited = &edited});
  print_changes(out, edited.changes);
  write_scene(out, race, registry);
  std::vector<RunId> ids;
  for (const std::string& stack : chosen.stacks)
    for (const std::uint64_t seed : chosen.seeds) ids.push_back({stack, seed});
  const RunnerOutcome outcome = run_all(race, ids, {out, request.jobs, true, request.timeout_s, request.memory_mb});
  if (outcome.interrupted && outcome.runs.empty()) {
    report_broken(outcome);
    std::cerr << interrupted_text(outcome, ids.size());
    return run_broke;
  }
  std::vector<RunResult> runs = all_results(race, outcome, out);
  const std::vector<std::string> rows = rows_of(race, runs);
  const RaceResults all = {race, std::move(runs), rows}, shown = {race, outcome.runs, chosen.stacks};
  const std::vector<ClaimResult> claims = judged_claims(all, outcome.interrupted);
  write_results(out, all, claims, chosen.baseline);
  const std::vector<ClaimResult> asked = chosen.judged && !outcome.interrupted ? claims : std::vector<ClaimResult>{};
  print_tables(std::cout, shown, asked);
  if (!chosen.baseline.empty()) print_pairs(std::cout, chosen.baseline, paired_differences(shown, chosen.baseline));
  report_broken(outcome);
  print_kept(request, outcome, ids.size(), all.runs.size(), asked);
  std::cout << "results: " << out.string() << '\n';
  const bool reported = report_results(out);
  if (outcome.interrupted) std::cerr << interrupted_text(outcome, ids.size());
  if (outcome.interrupted || any_broken(outcome) || !reported) return run_broke;
  const bool failed = std::any_of(asked.begin(), asked.end(), [](const ClaimResult& c) { return c.holds == false; });
  return failed ? claim_failed : good;
}

std::unique_ptr<Experiment> read_race_experiment(const std::filesystem::path& file, Node tree,
                                                 const Registry& registry) {
  return std::make_unique<RaceExperiment>(read_race(file, std::move(tree), registry), registry);
}

}  // namespace gripline::tools
