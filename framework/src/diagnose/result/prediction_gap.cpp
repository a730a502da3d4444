#include "diagnose/result/prediction_gap.hpp"

#include <algorithm>
#include <array>

namespace gripline::diagnose {
namespace {

constexpr std::array<double, 5> horizons = {0.1, 0.2, 0.5, 1.0, 2.0};  // [s]
constexpr std::size_t reported = 3;                                    // the horizon of Gap
static_assert(horizons[reported] == Gap{}.horizon);

/// How much of the gap is closed, by the change of its error. A perfect model still shows the sensors' own noise: one
/// standard deviation.
void set_closure(Gap& gap, const ErrorChange& change) {
  const auto closed = [&](double after) { return (gap.before - after) / (gap.before - std::min(1.0, after)); };
  gap.change = change;
  gap.closure = gap.closure_low = gap.closure_high = 0.0;
  if (!change.helps()) return;
  gap.closure = closed(gap.after);
  gap.closure_low = closed(gap.before * (1.0 + change.high));
  gap.closure_high = closed(gap.before * (1.0 + change.low));
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

void measure_gap(const HoldOut& hold_out, const Catalogue& catalogue, Diagnosis& d) {
  const auto before = hold_out.predict(nominal_as_stated(catalogue, d.null_model), horizons);
  const auto after = d.fit.theta.empty() ? before : hold_out.predict(hold_out.refit(d.fit), horizons);
  d.horizons.clear();
  for (std::size_t i = 0; i < horizons.size(); ++i)
    d.horizons.push_back({horizons[i], before[i].rms(), after[i].rms()});
  d.gap.before = before[reported].rms();
  d.gap.after = after[reported].rms();
  set_closure(d.gap, compare(after[reported], before[reported]));
  d.named_gap = d.gap;
  if (d.null_model.theta.empty()) return;
  const StartErrors refitted = hold_out.predict_refitted(d.null_model);
  d.named_gap.before = refitted.rms();
  set_closure(d.named_gap, compare(after[reported], refitted));
}

void leave_gap_open(Diagnosis& d) {
  for (PredictionError& row : d.horizons) row.after = row.before;
  d.gap.after = d.gap.before;
  set_closure(d.gap, {});
  d.named_gap = d.gap;
}

ErrorChange begin_with_delays(const HoldOut& as_they_came, const HoldOut& on_time, const Catalogue& catalogue,
                              Diagnosis& d) {
  const Fit nominal = nominal_as_stated(catalogue, d.null_model);
  const auto errors = as_they_came.predict(nominal, horizons);
  for (std::size_t i = 0; i < horizons.size(); ++i) d.horizons[i].before = errors[i].rms();
  d.gap.before = errors[reported].rms();
  set_closure(d.gap, compare(on_time.predict_refitted(d.fit), errors[reported]));
  return compare(on_time.predict_refitted(nominal), errors[reported]);
}

}  // namespace gripline::diagnose
