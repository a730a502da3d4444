#include "diagnose/real_logs/real_diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/real_logs/real_sentence.hpp"
#include "diagnose/result/named_delay.hpp"
#include "diagnose/result/verdict.hpp"
#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {
namespace {

NamedEffect named_effect(const MissingEffect& one) {
  NamedEffect named;
  named.effect = one.addition.name;
  named.measurement = one.measurement;
  for (const auto& v : one.params) named.params.push_back({v.name, v.unit, v.value, v.low, v.high, v.at_end()});
  named.confidence = std::min(one.change.certainty, thresholds::most_beside_unknown);
  named.rollout = error_change(one.change);
  return named;
}

/// Where what is left shows: there is always something.
ResidualTest unknown_in(const Remainder& remainder) {
  ResidualTest out;
  const std::string& of = remainder.of;
  out.where = of == "time" ? Where::time : of == "throttle" || of == "steering" ? Where::input : Where::state;
  out.quantity = of;
  return out;
}

}  // namespace

ErrorChange error_change(const calibrate::ForecastChange& change) { return {change.change, change.low, change.high}; }

Gap real_gap(const MissingEffects& found) {
  const auto closed = [&](double after) {
    return after < found.given ? (found.given - after) / (found.given - std::min(found.noise, after)) : 0.0;
  };
  Gap gap;
  gap.horizon = 1.0;
  gap.before = found.given;
  gap.after = found.found;
  gap.closure = closed(found.found);
  gap.closure_low = closed(found.given * (1.0 + found.all.high));
  gap.closure_high = closed(found.given * (1.0 + found.all.low));
  return gap;
}

Diagnosis real_diagnosis(const MissingEffects& found, std::span<const ChannelDelay> delays, const Cornering& corners) {
  Findings all;
  for (const MissingEffect& one : found.named) all.named.push_back(named_effect(one));
  for (const ScoredEffect& one : found.ranking)
    all.ranking.push_back({.effect = one.effect,
                           .less_error = one.less_error,
                           .held_out = one.tried ? one.error : NAN,
                           .selected_fraction = one.tried ? one.change.certainty : 0.0,
                           .rollout = error_change(one.change)});
  const std::string model = "/plant/params/";
  for (const calibrate::FittedParameter& p : found.parameters)
    if (p.unknown.pointer.starts_with(model))
      all.nominal_fit.emplace_back(p.unknown.pointer.substr(model.size()), p.value);
  all.gap = real_gap(found);
  all.unknown = unknown_in(found.remainder);
  std::vector<NamedEffect> late;
  for (const ChannelDelay& one : delays) late.push_back(named_delay(one));
  Diagnosis d = assemble(std::move(all), std::move(late));
  d.sentence = real_sentence(d, found, corners);
  return d;
}

bool is_answer(const Diagnosis& d, const MissingEffects& found) {
  const bool named = !d.named.empty() || !d.delays.empty();
  return found.at_noise() || (named && d.gap.closure > 0.0);
}

}  // namespace gripline::diagnose
