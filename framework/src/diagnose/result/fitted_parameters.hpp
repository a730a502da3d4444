// The numbers of a fit under the names that a result gives them.
#pragma once

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// Sets nominal_fit and the parameters of the named effects, with their 95 % intervals, from d.fit; d.named must be in
/// the order of its members. What is left of delays that were taken off is no parameter of the model.
void set_parameters(const Catalogue& catalogue, Diagnosis& d);

}  // namespace gripline::diagnose
