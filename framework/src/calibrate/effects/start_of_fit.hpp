// Where a fit of a world begins: what the world says of itself, but for what is read off the logs before any fit.
#pragma once

#include <list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/effects/effect_trial.hpp"
#include "measured/estimates/yaw_rate_offset.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::calibrate {

struct StartOfFit {
  std::vector<double> given;   // all parameters of the forecaster, as the world has them
  std::vector<double> values;  // those, delays as map or logs have them, an offset of the yaw rate within yaw's limits
  std::vector<Unknown> unknowns;
  std::vector<Unknown> limited;  // those of them whose range yaw limits
};

/// `tree`: the world of `world` as it is written. `by_yaw`: how far an offset of the yaw rate may go. `chosen`:
/// pointers or groups of unknowns to keep; empty for all. Throws InputError where the tree's unknowns are wrong.
StartOfFit start_of_fit(const Node& tree, const Trial& world, const measured::LogMap& map,
                        const std::list<measured::SessionFile>& files,
                        const std::optional<measured::YawRateOffset>& by_yaw, std::span<const std::string> chosen = {});

}  // namespace gripline::calibrate
