#include "experiment/race_judging.hpp"

#include <algorithm>
#include <set>

#include "experiment/race_columns.hpp"
#include "util/resampling.hpp"
#include "util/text_table.hpp"

namespace gripline {
namespace {

/// Whether a lap begins with speed from better friction: then it may be faster than a flying lap at its own.
bool enters_faster(const RunSummary& run, std::size_t lap) {
  constexpr double drop = 0.05;  // of the friction factor: a fading that slow hardly matters
  return run.lap_mean_factors[lap - 1] > run.lap_mean_factors[lap] + drop;
}

/// `inside` says what of the car never left the road.
void add_beaten(const RunSummary& run, const LapTable& limits, const char* inside, std::vector<std::string>& beaten) {
  for (std::size_t lap = 1; lap < run.laps.size(); ++lap) {
    const std::optional<double> limit = limits.at(run.lap_mean_factors[lap]);
    if (!limit || run.laps[lap] >= *limit - limits.error || enters_faster(run, lap)) continue;
    beaten.push_back(run.stack + ", seed " + std::to_string(run.seed) + ": lap " + std::to_string(lap) + " took " +
                     cell_text(run.laps[lap], "%.3f") + " s " + inside + " the road, the limit is " +
                     cell_text(*limit, "%.3f") + " s with an error of " + cell_text(limits.error, "%.3f") + " s");
  }
}

/// The runs that a claim is asked of one by one: those that are equal to the last bit in both its rows only once.
std::vector<int> distinct_runs(const RaceResults& results, const Claim& claim) {
  std::vector<int> chosen;
  std::set<std::pair<std::string, std::string>> seen;
  const std::vector<const RunResult*> left = results.of(claim.left.stack), right = results.of(claim.right.stack);
  const auto drive = [](const std::vector<const RunResult*>& runs, std::size_t i) {
    return i < runs.size() ? runs[i]->drive : std::string();
  };
  for (std::size_t i = 0; i < results.race.seeds.size(); ++i) {
    const auto both = std::pair(drive(left, i), drive(right, i));
    const bool known =
        (claim.left.stack.empty() || !both.first.empty()) && (claim.right.stack.empty() || !both.second.empty());
    if (!known || seen.insert(both).second) chosen.push_back(static_cast<int>(i));
  }
  return chosen;
}

/// Whether all runs of the rows that a claim names were driven alone. A run that was lost has no times.
bool driven_alone(const RaceResults& results, const Claim& claim) {
  return std::ranges::all_of(results.runs, [&](const RunResult& run) {
    const bool named = run.summary.stack == claim.left.stack || run.summary.stack == claim.right.stack;
    return !named || run.summary.steps == 0 || run.timing.alone;
  });
}

/// "" or what the ends that a claim names are when the runs of a row are too few for an interval.
std::string range_note(const RaceResults& results, const Claim& claim) {
  std::string note;
  for (const ClaimTerm* term : {&claim.left, &claim.right}) {
    const std::string of(interval_of(term->column));
    if (of.empty()) continue;
    const std::size_t runs = results.values_of(results.distinct(term->stack), of).size();
    if (runs >= least_for_interval || runs < 2 || !note.empty()) continue;
    note = "_lo and _hi are the smallest and largest of " + std::to_string(runs) + " runs, no 95 % interval";
  }
  return note;
}

}  // namespace

std::vector<std::string> beaten_limits(const RaceResults& results) {
  std::vector<std::string> beaten;
  const WorldSpec& world = results.race.world;
  for (const RunResult& run : results.runs) {
    if (run.summary.steps == 0) continue;
    if (run.summary.violation_s <= 0.0) add_beaten(run.summary, world.time_optimal, "inside", beaten);
    if (run.summary.violation_body_s <= 0.0)
      add_beaten(run.summary, world.time_optimal_body, "with the whole car inside", beaten);
  }
  return beaten;
}

std::vector<ClaimResult> judge_all(const RaceResults& results) {
  std::vector<ClaimResult> judged;
  const auto present = [&](const ClaimTerm& term) {
    return term.stack.empty() || std::find(results.rows.begin(), results.rows.end(), term.stack) != results.rows.end();
  };
  for (const Claim& claim : results.race.claims) {
    ClaimResult skipped;
    skipped.text = claim.text;
    if (!present(claim.left) || !present(claim.right)) {
      skipped.why_skipped = "a row was left out by --only";
      judged.push_back(skipped);
    } else if (claim.about_time() && !driven_alone(results, claim)) {
      skipped.why_skipped = times_not_alone;
      judged.push_back(skipped);
    } else {
      const std::vector<int> chosen = distinct_runs(results, claim);
      judged.push_back(judge(claim, static_cast<int>(chosen.size()), results.race.claim_share,
                             [&](const std::string& stack, const std::string& column, int run) {
                               return results.value(stack, column,
                                                    run < 0 ? -1 : chosen[static_cast<std::size_t>(run)]);
                             }));
      judged.back().note = range_note(results, claim);
    }
  }
  return judged;
}

}  // namespace gripline
