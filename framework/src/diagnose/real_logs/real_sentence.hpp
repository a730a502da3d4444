// The diagnosis of a real car in a few sentences: what calibrating its world and the effects named take off the error
// of predictions, how the car corners, and what is left.
#pragma once

#include <string>

#include "diagnose/real_logs/cornering.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// `d` has the delays.
std::string real_sentence(const Diagnosis& d, const MissingEffects& found, const Cornering& corners);

}  // namespace gripline::diagnose
