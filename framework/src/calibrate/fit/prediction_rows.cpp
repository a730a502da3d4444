#include "calibrate/fit/prediction_rows.hpp"

#include <cmath>

namespace gripline::calibrate {

HorizonRow row_of_predictions(const std::string& name, std::span<const FitLog> logs,
                              const std::vector<std::vector<double>>& predicted) {
  std::vector<double> when, shown, truth;
  double offset = 0.0;  // logs follow one another in time, so that no block is of two
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const FitLog& log = logs[l];
    const std::size_t horizons = log.starts.horizons.size();
    for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
      when.push_back(offset + log.starts.time[i] - log.session->t.front());
      const auto first = static_cast<std::ptrdiff_t>((i * horizons + horizons - 1) * channels);
      constexpr auto count = static_cast<std::ptrdiff_t>(channels);
      shown.insert(shown.end(), predicted[l].begin() + first, predicted[l].begin() + first + count);
      truth.insert(truth.end(), log.truth.begin() + first, log.truth.begin() + first + count);
    }
    offset += block_length * std::ceil((log.session->t.back() - log.session->t.front()) / block_length + 1.0);
  }
  return horizon_row(name, when, shown, truth);
}

HorizonRow row_of_model(const std::string& name, const PredictionErrors& errors, std::span<const double> params) {
  auto predicted = errors.errors(params);
  for (std::size_t l = 0; l < predicted.size(); ++l)
    for (std::size_t k = 0; k < predicted[l].size(); ++k) predicted[l][k] += errors.logs()[l].truth[k];
  return row_of_predictions(name, errors.logs(), predicted);
}

}  // namespace gripline::calibrate
