// The numbers of a fit under the names that a result gives them.
#pragma once

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// The explanation with a fit as its model: nominal_fit and the parameters of the named effects, with their 95 %
/// intervals, are the fit's. The named effects must be in the order of its members. What is left of delays that were
/// taken off is not a parameter of the model.
Explanation with_fit(const Catalogue& catalogue, const Fit& fitted, Explanation explanation);

}  // namespace gripline::diagnose
