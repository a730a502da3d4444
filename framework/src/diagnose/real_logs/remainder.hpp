// Where the prediction errors that are left are largest.
#pragma once

#include <string>
#include <vector>

#include "calibrate/fit/forecast_errors.hpp"

namespace gripline::diagnose {

/// The third of the starts with the most (or least) of one thing that has the largest share of the errors.
struct Remainder {
  std::string of;    // "speed", "yaw rate", "throttle", "steering", "time"; empty: no errors
  bool most = true;  // the upper third
  double from = 0;   // where that third begins (or ends), SI
  double share = 0;  // of the squared errors
};

/// Of readings between those of a channel; a thing that more than a tenth of the starts have no reading of is left out.
/// `errors` are of all starts of `logs` that have a truth, over predictions of `horizon` seconds.
Remainder remainder_of(const std::vector<calibrate::FitLog>& logs, const calibrate::ForecastErrors& errors,
                       double horizon);

}  // namespace gripline::diagnose
