// The parameters that a world's predictions of a log are made with.
#pragma once

#include <vector>

#include "calibrate/fit/session_adaptation.hpp"
#include "calibrate/fit/unknowns.hpp"

namespace gripline::calibrate {

/// Options of a forecaster whose predictions no later row touches, not even in their last digit.
ForecastOptions prediction_options(const WorldSpec& world);

struct PredictionParameters {
  std::vector<double> values;   // all of the forecaster's
  std::vector<Unknown> moving;  // with the session
  SessionWeighing weighing;
};

/// Parameters as the world, read from `tree`, has them, and which of them follow the session. A world that was never
/// fitted is judged by its model alone: no disturbance is carried on, and delays are what the map states. Throws
/// InputError.
PredictionParameters prediction_parameters(const Node& tree, const WorldSpec& world, const measured::LogMap& map,
                                           const Forecaster& forecaster);

}  // namespace gripline::calibrate
