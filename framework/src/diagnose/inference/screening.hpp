// Every candidate at once, along one linearisation: how much would each bring beside a fitted model, and with what values?
#pragma once

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/normal_equations.hpp"

namespace gripline::diagnose {

/// A fitted model with one candidate more.
struct Extension {
  std::size_t candidate = 0;
  double gain = 0;  // predicted rise of the log likelihood
  std::size_t dof = 0;
  ModelSpec start;  // the extended model at the predicted values
};
struct Screening {
  std::vector<Extension> extensions;  // best score first
  // Of everything: own parameters first, then the groups' directions.
  NormalEquations normal;
  std::size_t own = 0;
  std::vector<Group> groups;
};
Screening screen(const Problem& problem, const Fit& fitted);
/// Pairs of candidates with one parameter each, those that together would bring most first: two effects that hide each
/// other show little of either alone.
std::vector<Extension> best_pairs(const Problem& problem, const Fit& fitted, const Screening& screening);

}  // namespace gripline::diagnose
