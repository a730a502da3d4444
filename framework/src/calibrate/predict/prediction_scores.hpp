// How far off predictions are at each horizon, beside those of models that know nothing of the car.
#pragma once

#include <string>
#include <vector>

#include "calibrate/forecast/horizon_table.hpp"
#include "calibrate/predict/judged_log.hpp"

namespace gripline::calibrate {

/// A model's predictions of a log: starts x horizons x 6 readings.
struct NamedPredictions {
  std::string name;
  std::vector<double> readings;
};

/// Those of every baseline on the judged log, then `predicted` as "this world". `wheelbase` [m].
std::vector<NamedPredictions> beside_baselines(const JudgedLog& judged, std::vector<double> predicted,
                                               double wheelbase);

/// Errors at one horizon, a row for each model. `of`: judged.counted() of that horizon.
std::vector<HorizonRow> errors_at(const JudgedLog& judged, std::span<const NamedPredictions> models,
                                  std::size_t horizon, const CountedStarts& of);

/// How far predicted places lie from those of the log, the measures that forecasts of paths are compared by: mean over
/// starts of the mean over all horizons (ADE) and of the last one (FDE). NaN of no start.
struct Displacement {
  double average = 0, last = 0;  // [m]
  std::size_t starts = 0;        // that count and of which every place is known
};
Displacement displacement_of(const JudgedLog& judged, std::span<const double> predicted, double slowest);

}  // namespace gripline::calibrate
