// A diagnosis in one sentence: what is missing, how large, how certain, and what that does to predictions.
#pragma once

#include <string>

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

std::string sentence(const Diagnosis& d);

}  // namespace gripline::diagnose
