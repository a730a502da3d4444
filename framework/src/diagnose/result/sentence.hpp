// A diagnosis in one sentence: what is missing, how large, how certain, and what that does to predictions.
#pragma once

#include <string>

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

std::string sentence(const Diagnosis& d);

/// "The yaw-rate channel is 0.12 s late (0.1 to 0.14). ", of a delay of a channel.
std::string delay_sentence(const NamedEffect& delay);

}  // namespace gripline::diagnose
