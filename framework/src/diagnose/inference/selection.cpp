#include "diagnose/inference/selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/bootstrap.hpp"
#include "diagnose/inference/constancy.hpp"
#include "diagnose/inference/support.hpp"
#include "measured/replay/replay.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

/// Whether the 95 % intervals of all of a member's parameters cover their neutral values. One that does not is enough
/// for the effect to be significant: the others may say where, or how wide.
bool may_be_nothing(const Catalogue& catalogue, const Fit& fitted, std::size_t which) {
  std::size_t at = catalogue.nuisances().size();
  for (std::size_t i = 0; i < which; ++i) at += catalogue.candidates()[fitted.model.members[i]].fitted.size();
  const Candidate& c = catalogue.candidates()[fitted.model.members[which]];
  const std::size_t all = fitted.theta.size();
  for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
    const double off = fitted.theta[at] - c.decl(f).neutral;
    if (std::abs(off) > normal_95 * std::sqrt(std::max(0.0, fitted.covariance[at * all + at]))) return false;
  }
  return true;
}

bool is_ample(const Fit& with, const Fit& without) {
  return with.evidence - without.evidence > thresholds::ample_evidence;
}

/// Effects with little evidence must also lower the error on hold-out data, unless there are none or most of that error
/// is strong process noise.
bool helps(const Problem& problem, const Fit& with, const Fit& without, const HoldOut& hold_out) {
  if (hold_out.empty() || is_ample(with, without) || has_strong_process_noise(problem, with.noise)) return true;
  return hold_out.predict_refitted(with).rms() < hold_out.predict_refitted(without).rms();
}

bool contains(const ModelSpec& larger, const ModelSpec& smaller) {
  return std::all_of(smaller.members.begin(), smaller.members.end(), [&](std::size_t m) { return larger.has(m); });
}

/// The fit of a smaller model; unfinished where its evidence is certainly not within `margin` of `above`.
const Fit& fit_if_near(SearchResult& found, const ModelSpec& model, const Noise& noise, double above, double margin) {
  Fit& rough = found.pool.rough_fit(model, noise);
  const bool near = rough.evidence > above - margin - unfinished_margin(above, found.null_model.evidence);
  return near ? found.pool.finish(rough) : rough;
}

/// Without the effects that may be nothing or do not help; the least supported are taken out first. Intervals are those
/// of a quadratic likelihood: where a nuisance at its limit cannot take an effect's place they are wider than what the
/// evidence, a ratio of likelihoods, says, and ample evidence counts.
Fit drop_insignificant(SearchResult& found, const HoldOut& hold_out) {
  const Catalogue& catalogue = *found.pool.problem().catalogue;
  Fit fit = found.best;
  for (;;) {
    const Fit* next = nullptr;
    for (std::size_t i = 0; i < fit.model.members.size(); ++i) {
      const ModelSpec smaller = catalogue.without(fit.model, fit.model.members[i]);
      const Fit& without = fit_if_near(found, smaller, fit.noise, fit.evidence, thresholds::ample_evidence);
      const bool idle = !is_ample(fit, without) &&
                        (may_be_nothing(catalogue, fit, i) || !helps(found.pool.problem(), fit, without, hold_out));
      if (idle && (next == nullptr || without.evidence > next->evidence)) next = &without;
    }
    if (next == nullptr) return fit;
    fit = found.pool.fit_once(next->model, next->noise);
  }
}

/// Where something is left: without the effects that generic functions of its kind explain as well, or that change with
/// time or from side to side.
Fit strip_unsupported(SearchResult& found, Fit fit, Where where) {
  const Problem& problem = found.pool.problem();
  while (!fit.model.members.empty()) {
    const std::vector<Linearised> along = linearise_all(problem, fit.model);
    const std::vector<double> support = support_beside(problem, fit, along, where),
                              varies = constancy_by_member(problem, fit, along);
    auto which = std::min_element(support.begin(), support.end()) - support.begin();
    if (support[static_cast<std::size_t>(which)] > thresholds::single_gain) {
      which = std::max_element(varies.begin(), varies.end()) - varies.begin();
      if (varies[static_cast<std::size_t>(which)] < thresholds::misfit) break;
    }
    const std::size_t member = fit.model.members[static_cast<std::size_t>(which)];
    fit = found.pool.fit_once(problem.catalogue->without(fit.model, member), fit.noise);
  }
  return fit;
}

}  // namespace

SelectedModel select_model(SearchResult& found, const HoldOut& hold_out) {
  SelectedModel out;
  out.fit = drop_insignificant(found, hold_out);
  out.tests = residual_tests(found.pool.problem(), out.fit);
  const ResidualTest left = strongest(out.tests);
  if (!(left.statistic > thresholds::misfit) && !found.exhausted) return out;
  const Fit whole = out.fit;
  out.fit = strip_unsupported(found, std::move(out.fit), left.where);
  const bool stripped = out.fit.model.members.size() < whole.model.members.size();
  if (stripped) out.tests = residual_tests(found.pool.problem(), out.fit);
  out.unknown = strongest(out.tests);
  // Whatever else may explain them, effects that make predictions better are worth having.
  if (stripped && hold_out.change(whole, out.fit).helps()) out.fit = whole;
  return out;
}

Rivals rivals_of(const SearchResult& found, const Fit& selected) {
  Rivals out;
  out.models.push_back(&selected);
  for (const Fit* one : found.pool.all()) {
    if (out.models.size() >= thresholds::max_rivals) break;
    if (one->model.members != selected.model.members && one->evidence > selected.evidence - thresholds::rival_range)
      out.models.push_back(one);
  }
  std::stable_sort(out.models.begin(), out.models.end(),
                   [](const Fit* a, const Fit* b) { return a->evidence > b->evidence; });
  out.bootstrap = block_bootstrap(found.pool.problem(), out.models);
  out.posterior = posterior(out.models);
  return out;
}

double Rivals::bootstrap_of(std::size_t candidate) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < models.size(); ++i)
    if (models[i]->model.has(candidate)) sum += bootstrap[i];
  return sum;
}

double Rivals::posterior_of(std::size_t candidate) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < models.size(); ++i)
    if (models[i]->model.has(candidate)) sum += posterior[i];
  return sum;
}

std::vector<const Fit*> indistinguishable_from(const Fit& selected, const Rivals& rivals, const SearchResult& found,
                                               const HoldOut& hold_out) {
  const Problem& problem = found.pool.problem();
  const double far = -std::log(1.0 - thresholds::set_coverage);
  std::vector<const Fit*> equals{&selected};
  std::vector<double> odds{1.0};  // over the selected one
  for (const Fit* rival : rivals.models) {
    const double behind = selected.evidence - rival->evidence;
    if (rival == &selected || rival->model.members.empty() || contains(rival->model, selected.model)) continue;
    // Best first: where the first is not as good as the selected one, none is.
    if (behind > (equals.size() == 1 ? thresholds::equal_evidence : far)) break;
    const bool ample = rival->model.members.size() == 1 && is_ample(*rival, found.null_model);
    bool idle = false;
    for (std::size_t i = 0; i < rival->model.members.size() && !ample; ++i)
      idle |= may_be_nothing(*problem.catalogue, *rival, i);
    if (idle || !helps(problem, *rival, found.null_model, hold_out)) continue;
    equals.push_back(rival);
    odds.push_back(std::exp(-behind));
  }
  const double all = std::accumulate(odds.begin(), odds.end(), 0.0);
  std::size_t enough = 0;
  for (double covered = 0.0; enough < odds.size() && covered < thresholds::set_coverage * all; ++enough)
    covered += odds[enough];
  equals.resize(enough);
  return equals;
}

bool place_may_be_time(const Problem& problem, const ModelSpec& model, std::size_t candidate) {
  const Catalogue& catalogue = *problem.catalogue;
  double laps = 0.0;
  bool differs = false;
  ModelSpec alone = catalogue.with(catalogue.null_model(), candidate);
  alone.values.front() = model.values[model.position(candidate)];
  const StagedCar car = catalogue.build(alone);
  for (const Trace& trace : problem.traces) {
    Trace elsewhere = trace;  // half a lap on
    double driven = 0.0;
    for (std::size_t k = 0; k < trace.size(); ++k) {
      double& place = elsewhere.at[k].lap_fraction;
      place = place < 0.5 ? place + 0.5 : place - 0.5;
      if (k == 0) continue;
      const double step = trace.at[k].lap_fraction - trace.at[k - 1].lap_fraction;
      driven += step - std::round(step);
    }
    laps += std::abs(driven);
    const std::vector<double> memory = simulate_memory(car, trace);
    differs |= rates_at_samples(car, trace, memory) != rates_at_samples(car, elsewhere, memory);
  }
  return differs && laps < thresholds::laps_to_tell_place_from_time;
}

}  // namespace gripline::diagnose
