// How far off a model's predictions are, start by start, and whether another's are better.
#pragma once

#include <span>
#include <vector>

#include "calibrate/fit/fit.hpp"
#include "calibrate/fit/prediction_errors.hpp"

namespace gripline::calibrate {

inline constexpr double judged_every = 0.25;  // [s] between starts that are judged

/// Relative change of a root mean square error with its 95 % interval; negative: smaller.
struct ForecastChange {
  double change = 0, low = -1, high = 1;
  double certainty = 0.5;  // probability that it is negative; 0.5 where there is no interval
  bool helps() const { return high < 0.0; }
  bool harms() const { return low > 0.0; }
};

/// Squared errors over their scale (Weighing), by start, those beyond three times that counting as in a fit, and the
/// stretch of time and the log that each start belongs to.
struct ForecastErrors {
  std::vector<double> square;
  std::vector<std::size_t> stretch, log;
  double rms() const;
  std::size_t stretches() const;
  ForecastErrors of_log(std::size_t which) const;
};
inline constexpr std::size_t fewest_stretches = 3;  // for an interval
/// By the t distribution of stretches, whose errors count as independent; no interval below three of them.
ForecastChange change_of(const ForecastErrors& with, const ForecastErrors& without);

/// Whether a start has anything to be judged by.
bool has_truth(const FitLog& log, std::size_t start);
/// Errors of predictions with these parameters.
ForecastErrors forecast_errors(const Forecaster& forecaster, std::span<const double> params, const Weighing& weighing,
                               const std::vector<FitLog>& judged);

}  // namespace gripline::calibrate
