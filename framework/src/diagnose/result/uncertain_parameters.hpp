// What a case says of the nominal model and of effects, checked against what there is: parameters that are not known
// exactly, effects that must not be named.
#pragma once

#include <vector>

#include "diagnose/model/candidates.hpp"
#include "diagnose/result/case_file.hpp"

namespace gripline::diagnose {

/// Parameters of the nominal model with their standard deviations, in their own units: those of options.uncertainty, or
/// where it is empty those of options.guessed that the model has. Parameters without a deviation are left out. Throws
/// InputError for a stated one that the model has not.
std::vector<Nuisance> uncertain_parameters(const CaseOptions& options, const Catalogue& catalogue);

/// Throws InputError, with the nearest id, where options.exclude has one that is no candidate.
void check_excluded(const CaseOptions& options, const Catalogue& catalogue);

}  // namespace gripline::diagnose
