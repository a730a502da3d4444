#include "diagnose/real_logs/held_out_comparison.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace gripline::diagnose {

using calibrate::ForecastChange;

namespace {

/// How sure a change is to be a decrease, in standard deviations of a normal distribution.
double deviations_of(const ForecastChange& change) {
  constexpr double least = 1e-12;
  return boost::math::quantile(boost::math::normal(), std::clamp(change.certainty, least, 1.0 - least));
}

}  // namespace

bool UnfittedErrors::held_out_counts() const { return held_out.stretches() >= calibrate::fewest_stretches; }

double UnfittedErrors::rms() const { return held_out_counts() ? held_out.rms() : validation.rms(); }

UnfittedChange compare_unfitted(const UnfittedErrors& with, const UnfittedErrors& without) {
  const ForecastChange validation = change_of(with.validation, without.validation);
  if (!with.held_out_counts()) return {deviations_of(validation), validation.change < 0.0};
  const ForecastChange held_out = change_of(with.held_out, without.held_out);
  return {(deviations_of(validation) + deviations_of(held_out)) / std::sqrt(2.0),
          validation.change < 0.0 && held_out.change < 0.0};
}

}  // namespace gripline::diagnose
