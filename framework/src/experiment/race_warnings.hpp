// What an experiment of races says that was most likely not meant, although it can be raced.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/errors.hpp"
#include "experiment/experiment.hpp"

namespace gripline {

/// One warning, at the delays, where the world's sensors show the car as it was and the nominal model of one of these
/// stacks has no effect that reads past commands. `effect` is the id of one that states late readings by its parameter
/// T [s]. Makes effects, each stack's in a process of its own; what cannot be made gives no warning.
std::vector<Diagnostic> late_sensor_warnings(const RaceSpec& race, const std::vector<std::string>& stacks,
                                             std::string_view effect);

/// One for each claim, at its place, that names a lap which no run drives: the world ends before it.
std::vector<Diagnostic> claim_warnings(const RaceSpec& race);

}  // namespace gripline
