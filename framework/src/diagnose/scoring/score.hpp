// Blind cases with answers: diagnoses every case of a folder and compares, by the rules of
// framework/doc/diagnose-cases.md.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "plugin/registry.hpp"

namespace gripline::diagnose {

struct CaseScore {
  std::string id, kind, vehicle, condition;  // condition: white, process_noise, wrong_nominal
  std::string truth, verdict, named;
  double right = 0;         // 1, 0.5 (a set of equals that holds the truth) or 0
  double lambda = 0;        // twice the log-likelihood gain of the truth with free starts every second
  double lambda_least = 0;  // the same of the least of several effects, over the truth without it
  double confidence = 0;    // of the least certain name; of "nothing" 1
  double closure = 0;       // NaN where it means nothing
  // Root of the parameters' summed squared errors over those of their true values; NaN without a right name.
  double parameter_error = 0;
  double covered = 0;  // share of parameters inside their interval; NaN likewise
  double error_before = 0, error_after = 0, error_true = 0;
  double located = 0;     // 1 or 0 for unknown cases, NaN otherwise
  double class_size = 0;  // of an indistinguishable verdict
  double cpu_s = 0;
};

/// Finds the world of a vehicle ("rc43", "full").
using WorldOf = std::function<std::filesystem::path(const std::string& vehicle)>;

/// Diagnoses one case folder (case.json, measured.csv, and for scoring answer.json, heldout.csv).
CaseScore score_case(const std::filesystem::path& folder, const Registry& registry, const WorldOf& world_of,
                     const std::filesystem::path& out);

/// Case folders below a folder, by name.
std::vector<std::filesystem::path> case_folders(const std::filesystem::path& folder);

}  // namespace gripline::diagnose
