#include "calibrate/predict/prediction_scores.hpp"

#include <cmath>
#include <utility>

#include "calibrate/forecast/baselines.hpp"
#include "measured/channels.hpp"

namespace gripline::calibrate {

using measured::Channel;

std::vector<NamedPredictions> beside_baselines(const JudgedLog& judged, std::vector<double> predicted,
                                               double wheelbase) {
  const FitLog& log = judged.log();
  std::vector<NamedPredictions> all;
  for (std::size_t b = 0; b < baseline_names.size(); ++b)
    all.push_back({baseline_names[b], baseline(static_cast<Baseline>(b), *log.session, log.starts, wheelbase)});
  all.push_back({"this world", std::move(predicted)});
  return all;
}

std::vector<HorizonRow> errors_at(const JudgedLog& judged, std::span<const NamedPredictions> models,
                                  std::size_t horizon, const CountedStarts& of) {
  std::vector<HorizonRow> rows;
  for (const NamedPredictions& model : models) {
    std::vector<double> at_horizon;  // starts that count x 6
    for (const std::size_t i : of.start) {
      const double* const p = model.readings.data() + judged.log().starts.reading_index(i, horizon);
      at_horizon.insert(at_horizon.end(), p, p + channels);
    }
    rows.push_back(horizon_row(model.name, of.time, at_horizon, of.truth));
  }
  return rows;
}

Displacement displacement_of(const JudgedLog& judged, std::span<const double> predicted, double slowest) {
  const FitLog& log = judged.log();
  const std::size_t h = log.starts.horizons.size();
  Displacement out;
  for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
    if (!judged.counts(i, slowest)) continue;
    double sum = 0.0, distance = 0.0;
    for (std::size_t j = 0; j < h; ++j) {
      const std::size_t at = log.starts.reading_index(i, j), x = at + Channel::x, y = at + Channel::y;
      distance = std::hypot(predicted[x] - log.truth[x], predicted[y] - log.truth[y]);
      sum += distance;
    }
    if (!std::isfinite(sum)) continue;
    out.average += sum / static_cast<double>(h);
    out.last += distance;
    ++out.starts;
  }
  out.average /= static_cast<double>(out.starts);
  out.last /= static_cast<double>(out.starts);
  return out;
}

}  // namespace gripline::calibrate
