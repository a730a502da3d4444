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

/// Delays that the map states are kept and are no unknowns; where they are to be found, the search starts from what the
/// channels show of each other (the middle one of several logs), unless the world was fitted before.
void start_delays(const measured::LogMap& map, const std::list<measured::SessionFile>& files,
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
