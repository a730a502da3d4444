// Errors at the last horizon of all starts of several logs, as one row of a table.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/fit/prediction_errors.hpp"
#include "calibrate/forecast/horizon_table.hpp"

namespace gripline::calibrate {

/// Of predictions by log: starts x horizons x 6.
HorizonRow row_of_predictions(const std::string& name, std::span<const FitLog> logs,
                              const std::vector<std::vector<double>>& predicted);
/// Of the predictions that a model makes with these parameters.
HorizonRow row_of_model(const std::string& name, const PredictionErrors& errors, std::span<const double> params);

}  // namespace gripline::calibrate
