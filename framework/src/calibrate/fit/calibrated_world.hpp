// A world as predictions need it, and a fitted one as JSON.
#pragma once

#include <filesystem>
#include <list>
#include <span>
#include <string>
#include <vector>

#include "calibrate/fit/fit.hpp"

namespace gripline::calibrate {

/// Steps, speeds and lengths of a world's car.
ForecastOptions forecast_options(const WorldSpec& world);

/// Speed below which no start counts [m/s].
double slowest_start(const WorldSpec& world);

/// Fixes or starts each delay of a fit, in `values`. One that the map states is fixed to that (of a log in gripline's
/// own columns, to what the world has) and taken out of `unknowns`. The search for another starts, with its prior,
/// where the map says, else at what the channels show of each other (measured::stated_or_found_delays, the middle one
/// of several logs), as near as its bounds allow; one that was fitted before stays where it is.
void fix_or_start_delays(const measured::LogMap& map, const std::list<measured::SessionFile>& files,
                         const Forecaster& forecaster, const Node& world, std::vector<double>& values,
                         std::vector<Unknown>& unknowns);

/// How late a fit found yaw and yaw rate to be, `params` being all of the forecaster's. A delay that is not among
/// `fitted` is taken as known: stated, or kept at its prior.
measured::TurningLateness turning_lateness(const Forecaster& forecaster, std::span<const double> params,
                                           std::span<const FittedParameter> fitted);

/// What a fit was made from.
struct FitSource {
  std::vector<std::string> logs;
  std::string map;
};

/// The world with what was found written at its pointers, and a record under "calibration": delays, observer, friction,
/// parameters with intervals, errors. File names in it are made relative to `folder`, where it is to be written.
Node fitted_world(Node world, const WorldSpec& spec, const Forecaster& forecaster, const FitResult& result,
                  const FitSource& source, const std::filesystem::path& folder);

}  // namespace gripline::calibrate
