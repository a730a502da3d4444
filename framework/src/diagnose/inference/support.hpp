// Whether a model's effects are still needed once generic functions may explain the log as well.
#pragma once

#include <span>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/residual_test.hpp"
#include "diagnose/model/regressors.hpp"

namespace gripline::diagnose {

/// For each member of the model: Wald's test that it is not at its neutral values with all functions of one kind in,
/// less the penalty of its parameters [log evidence]. Negative: the functions explain what it explained. `along` is
/// linearise_all.
std::vector<double> support_beside(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                                   Where where);

}  // namespace gripline::diagnose
