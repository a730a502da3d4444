// Parameters of the nominal model that are not known exactly, as a case says, checked against those that it has.
#pragma once

#include <vector>

#include "diagnose/model/candidates.hpp"
#include "diagnose/result/case_file.hpp"

namespace gripline::diagnose {

/// Parameters of the nominal model with their standard deviations, in their own units: those of options.uncertainty, or
/// where it is empty those of options.guessed that the model has. A `Nuisance` is an uncertain parameter, as fits call
/// it. Parameters without a deviation are left out. Throws InputError for a stated one that the model has not.
std::vector<Nuisance> uncertain_parameters(const CaseOptions& options, const Catalogue& catalogue);

}  // namespace gripline::diagnose
