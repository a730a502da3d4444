// Kind "diagnose": drives cars with something hidden, diagnoses their logs, and judges what was found.
//
//   {"kind": "diagnose", "nominal": WORLD, "driver": {"model", "planner", "controller"}, "seed": 1,
//    "held_out_driver": {...}, "nominal_uncertainty": {...}, "exclude": [...],
//    "cases": {name: {"hidden": a merge patch on the nominal world, "missing": [[ids], ...] sets that are right (none:
//                     what is hidden is unknown, or nothing is missing), "round_trip": true}},
//    "claims": ["name.named == 1", ...]}
//
// Each case writes OUT/<name>/: the drive, a second drive held out, diagnosis.json, augmented_world.json; a round trip
// also drives the world that was found (round_trip/) and diagnoses that log with it as the nominal one.
#pragma once

#include "diagnose/scoring/answer.hpp"
#include "experiment/claims.hpp"
#include "plugin/registry.hpp"
#include "race/stack.hpp"
#include "util/progress.hpp"

namespace gripline::diagnose {

/// What became of one case. `value` looks up a column of a claim.
struct CaseOutcome {
  std::string name, sentence;
  Verdict verdict = Verdict::nothing_missing;
  std::vector<std::pair<std::string, double>> values;
};
struct DiagnoseOutcome {
  std::vector<CaseOutcome> cases;
  std::vector<ClaimResult> claims;
};

/// A diagnosis beside what is true. The round trip is not part of it.
CaseOutcome outcome_of(std::string name, const Answer& truth, const Diagnosis& d);

/// Columns that claims about a case may name.
std::span<const std::string> outcome_columns();

/// diagnoses.csv: one row per case, numbers with six digits, nothing where a case has none.
std::string outcome_csv(const DiagnoseOutcome& outcome);

/// Reads an experiment whole and runs nothing. Throws InputError with every error of the tree.
void check_diagnose_experiment(const Node& tree, const Registry& registry);
/// `only`: names of cases; empty: all. Claims about others are skipped. Throws InputError at a name that is not a case.
DiagnoseOutcome run_diagnose_experiment(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                        std::span<const std::string> only = {}, const ProgressCallback& progress = {});

}  // namespace gripline::diagnose
