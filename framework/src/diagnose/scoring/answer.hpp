// answer.json of a case: what is missing in truth, and how a diagnosis is judged by it
// (framework/doc/diagnose-cases.md). No other component reads an answer.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/model/candidates.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

using Names = std::set<std::string>;

struct Answer {
  std::string kind, condition = "white";
  Names names;                                                                 // of the effects that are missing
  std::vector<Names> right;                                                    // sets that count as right
  std::vector<std::pair<std::string, std::map<std::string, double>>> effects;  // with their true parameters
  std::map<std::string, double> nuisance;  // relative deviations of nominal parameters
  bool unknown = false;
  std::vector<std::string> where;                     // kinds of function that are right for an unknown effect
  std::optional<std::pair<double, double>> interval;  // where it is
};

/// Throws InputError, also when there is no such file.
Answer read_answer(const std::filesystem::path& file);

/// The answer to a case with these sets of effects that are right. Without one `unknown` is where something is hidden,
/// since it is in no catalogue, and `nothing_missing` where nothing is.
Answer answer_of(std::vector<Names> right, bool hidden);

/// The true model; empty when one of its effects is not in the catalogue.
std::optional<ModelSpec> true_model(const Catalogue& catalogue, const Answer& a);

/// 1 for the right verdict and names, 0.5 for a set of equals that is too large and holds them, else 0.
double judge(const Answer& a, const Diagnosis& d);
/// 1 when an unknown effect is located right, else 0.
double judge_place(const Answer& a, const Diagnosis& d);

}  // namespace gripline::diagnose
