// Predictions by parameters that follow the session: a battery, a floor, a clock differ a little from one session to
// the next. What a world says about that ("session" of an unknown) is the width within which the log before a start may
// move its parameters; past predictions, judged by what the log has shown since, move them.
//
// Starts every half second are predicted 1 s ahead, and once the log shows what came of them their errors enter normal
// equations about the parameters of that moment,
//   A = a A + H,   r = a r + H z - g,   z = (A + P^-1)^-1 r,
// with H = J^T W J and g = J^T W e as in the fit, P the squared widths, a the forgetting over a minute. This is the
// information form of an extended Kalman filter for slow parameters (Ljung and Soederstroem, Theory and Practice of
// Recursive Identification, 1983).
//
// Starts slower than a quarter of v_ref count only until the first that is faster: a log that crawls throughout has
// no other data, and no model here has the static friction and the play that rule a crawl.
#pragma once

#include <optional>

#include "calibrate/fit/prediction_errors.hpp"
#include "calibrate/forecast/horizon_table.hpp"

namespace gripline::calibrate {

/// How past errors are weighed: over their root mean square at 1 s, as the fit left it.
struct SessionWeighing {
  std::array<double, channels> scale{1, 1, 1, 1, 1, 1};
  double weight = 0.25;  // of a start: those that follow each other err alike
};

/// From root mean square errors at 1 s; those that are not positive count as 1.
SessionWeighing session_weighing(const std::array<double, quantities>& rms);
/// From the record of a fit in the world; empty where it was not fitted.
std::optional<SessionWeighing> session_weighing(const Node& world);

/// Unknowns whose width from session to session is stated.
std::vector<Unknown> session_unknowns(std::span<const Unknown> unknowns);

/// As Forecaster::run: starts x horizons x 6 readings. A start's parameters follow from rows before it. `adapted`,
/// where given, gets the parameters at the end of the log.
std::vector<double> predict_session(const Forecaster& forecaster, const FitLog& log, std::span<const double> params,
                                    std::span<const Unknown> moving, const SessionWeighing& weighing,
                                    std::vector<double>* adapted = nullptr);

}  // namespace gripline::calibrate
