// What was found of a real car, as tables for people. Each begins with a blank line; empty where there is nothing to
// show.
#pragma once

#include <string>

#include "diagnose/real_logs/cornering.hpp"

namespace gripline::diagnose {

/// Effects named, with their values.
std::string named_table(const MissingEffects& found);
/// What calibration, beside the effects named, made of the world's own parameters that the logs determine.
std::string calibrated_table(const MissingEffects& found);
/// What the effects that were fitted do by themselves, the largest gain first; or, in words, why none was fitted.
std::string tried_table(const MissingEffects& found);
/// What the effects named do to each log.
std::string sessions_table(const MissingEffects& found);
/// Why there is no understeer gradient.
std::string no_understeer(const Cornering& corners);

}  // namespace gripline::diagnose
