#include "calibrate/witnesses.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace gripline::calibrate {
namespace {

/// How sure a change is to be a decrease, in standard deviations of a normal distribution.
double deviations_of(const ForecastChange& change) {
  constexpr double least = 1e-12;
  return boost::math::quantile(boost::math::normal(), std::clamp(change.certainty, least, 1.0 - least));
}

}  // namespace

bool WitnessErrors::held_out_says() const { return held_out.stretches() >= fewest_stretches; }

double WitnessErrors::rms() const { return held_out_says() ? held_out.rms() : own.rms(); }

WitnessChange compare(const WitnessErrors& with, const WitnessErrors& without) {
  const ForecastChange own = change_of(with.own, without.own);
  if (!with.held_out_says()) return {deviations_of(own), own.change < 0.0};
  const ForecastChange held_out = change_of(with.held_out, without.held_out);
  return {(deviations_of(own) + deviations_of(held_out)) / std::sqrt(2.0), own.change < 0.0 && held_out.change < 0.0};
}

}  // namespace gripline::calibrate
