// How a real car answers its steering, beside what the worlds given and found would show in the same corners.
#pragma once

#include <list>
#include <optional>
#include <string>

#include "diagnose/real_logs/missing_effects.hpp"
#include "measured/estimates/steady_turning.hpp"

namespace gripline::diagnose {

struct Cornering {
  std::optional<measured::SteadyTurning> by_log;  // empty where the logs do not show it
  std::optional<double> given, found;             // gradients of the worlds [rad s2/m]
  std::string why_not;                            // TurningByLogs::why_not
};

Cornering cornering_of(const std::list<measured::SessionFile>& files, const WorldSpec& given,
                       const MissingEffects& found);

}  // namespace gripline::diagnose
