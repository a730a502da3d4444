#include "diagnose/result/prediction_gap.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gripline::diagnose {
namespace {

constexpr std::array<double, 5> horizons = {0.1, 0.2, 0.5, 1.0, 2.0};  // [s]
constexpr std::size_t reported = 3;                                    // the horizon of Gap
static_assert(horizons[reported] == Gap{}.horizon);

/// A gap and how much of it is closed, by the change of its error. A perfect model still shows the sensors' own noise:
/// one standard deviation.
Gap gap_of(double before, double after, const ErrorChange& change) {
  const auto closed = [&](double with) { return (before - with) / (before - std::min(1.0, with)); };
  Gap gap;
  gap.before = before;
  gap.after = after;
  gap.change = change;
  if (!change.helps()) return gap;
  gap.closure = closed(after);
  gap.closure_low = closed(before * (1.0 + change.high));
  gap.closure_high = closed(before * (1.0 + change.low));
  return gap;
}

}  // namespace

Fit nominal_as_stated(const Catalogue& catalogue, const Fit& null_model) {
  Fit stated = null_model;
  stated.model = catalogue.null_model();
  for (std::size_t i = 0; i < stated.model.nuisance.size(); ++i)
    if (catalogue.nuisances()[i].delay) stated.model.nuisance[i] = null_model.model.nuisance[i];
  stated.evaluation.reset();
  stated.theta.clear();
  stated.covariance.clear();
  return stated;
}

PredictionGaps measure_gaps(const HoldOut& hold_out, const Catalogue& catalogue, const Fit& null_model,
                            const Fit& found) {
  const auto before = hold_out.predict(nominal_as_stated(catalogue, null_model), horizons);
  const auto after = found.theta.empty() ? before : hold_out.predict(hold_out.refit(found), horizons);
  PredictionGaps gaps;
  for (std::size_t i = 0; i < horizons.size(); ++i)
    gaps.horizons.push_back({horizons[i], before[i].rms(), after[i].rms()});
  const StartErrors &stated = before[reported], &with = after[reported];
  gaps.gap = gap_of(stated.rms(), with.rms(), compare(with, stated));
  gaps.named_gap = gaps.gap;
  if (null_model.theta.empty()) return gaps;
  const StartErrors refitted = hold_out.predict_refitted(null_model);
  gaps.named_gap = gap_of(refitted.rms(), with.rms(), compare(with, refitted));
  return gaps;
}

PredictionGaps left_open(const PredictionGaps& measured) {
  PredictionGaps open;
  for (const PredictionError& row : measured.horizons) open.horizons.push_back({row.seconds, row.before, row.before});
  open.gap = open.named_gap = gap_of(measured.gap.before, measured.gap.before, {});
  return open;
}

GapsFromDelays gaps_from_delays(const HoldOut& as_they_came, const HoldOut& on_time, const Catalogue& catalogue,
                                const Findings& found) {
  const Fit nominal = nominal_as_stated(catalogue, found.null_model);
  const auto errors = as_they_came.predict(nominal, horizons);
  const StartErrors& late = errors[reported];
  PredictionGaps gaps = found;
  for (std::size_t i = 0; i < horizons.size(); ++i) gaps.horizons[i].before = errors[i].rms();
  gaps.gap = gap_of(late.rms(), found.gap.after, compare(on_time.predict_refitted(found.fit), late));
  return {std::move(gaps), compare(on_time.predict_refitted(nominal), late)};
}

}  // namespace gripline::diagnose
