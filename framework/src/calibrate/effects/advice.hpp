// What a fitted world lacks, for people.
#pragma once

#include <optional>
#include <vector>

#include "calibrate/fit/fit.hpp"
#include "measured/estimates/yaw_rate_offset.hpp"

namespace gripline::calibrate {

/// Which of the registry's effects, added to the world's car, would help: a score test each, best first, those above
/// two standard deviations. None that only does what unknowns of the world do already, fitted or kept at their priors.
/// `by_yaw`: how far an offset of the yaw rate may go.
std::vector<Advice> advise(const WorldSpec& world, const Registry& registry, const ForecastOptions& forecast,
                           std::vector<FitLog>& logs, const FitResult& found,
                           const std::optional<measured::YawRateOffset>& by_yaw = std::nullopt);

}  // namespace gripline::calibrate
