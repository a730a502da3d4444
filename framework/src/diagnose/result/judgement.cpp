#include "diagnose/result/judgement.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/result/closing.hpp"
#include "diagnose/result/fitted_parameters.hpp"
#include "diagnose/result/prediction_gap.hpp"

namespace gripline::diagnose {
namespace {

/// What explanations of one search are judged with. Nothing of it changes but the pool, which grows.
class Judge {
 public:
  Judge(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options)
      : pool_(found.pool),
        null_model_(found.null_model),
        problem_(found.pool.problem()),
        catalogue_(*problem_.catalogue),
        hold_out_(hold_out),
        options_(options) {}

  Judgement measured(Explanation e) const;
  Judgement without_harmful(Judgement judged) const;
  bool closes(const Judgement& judged) const;
  bool stands(const Judgement& judged) const;
  Judgement withdrawn(const Judgement& judged, bool gap_closes) const;

 private:
  std::vector<ErrorChange> rollouts(const Explanation& e, const PredictionGaps& gaps) const;
  Explanation without(const Explanation& e, std::size_t i) const;

  ModelPool& pool_;
  const Fit& null_model_;
  const Problem& problem_;  // as the search left it: what the pool fits is along its references
  const Catalogue& catalogue_;
  const HoldOut& hold_out_;
  const JudgementOptions options_;
};

/// What each named effect does to predictions, beside the others.
std::vector<ErrorChange> Judge::rollouts(const Explanation& e, const PredictionGaps& gaps) const {
  if (e.named.empty()) return {};
  if (e.named.size() == 1 && catalogue_.nuisances().empty()) return {gaps.gap.change};
  std::vector<ErrorChange> changes;
  const StartErrors with = hold_out_.predict_refitted(e.fit);
  for (std::size_t i = 0; i < e.named.size(); ++i) {
    const Fit& rest = pool_.fit_once(catalogue_.without(e.fit.model, e.fit.model.members[i]), e.fit.noise);
    changes.push_back(compare(with, hold_out_.predict_refitted(rest)));
  }
  return changes;
}

Judgement Judge::measured(Explanation e) const {
  PredictionGaps gaps = measure_gaps(hold_out_, catalogue_, null_model_, e.fit);
  const std::vector<ErrorChange> changes = rollouts(e, gaps);
  for (std::size_t i = 0; i < changes.size(); ++i) e.named[i].rollout = changes[i];
  return {std::move(e), std::move(gaps)};
}

/// What stands without one of the named effects; something is missing that this one stood for.
Explanation Judge::without(const Explanation& e, std::size_t i) const {
  const Fit& rest = pool_.fit_once(catalogue_.without(e.fit.model, e.fit.model.members[i]), e.fit.noise);
  Explanation left;
  left.named = e.named;
  left.named.erase(left.named.begin() + static_cast<std::ptrdiff_t>(i));
  for (NamedEffect& n : left.named) n.confidence = std::min(n.confidence, thresholds::most_beside_unknown);
  left.tests = residual_tests(problem_, rest);
  left.unknown = strongest(left.tests);
  return with_fit(catalogue_, rest, std::move(left));
}

/// An effect that makes predictions worse is not kept, whatever its evidence: it stands for something else.
Judgement Judge::without_harmful(Judgement judged) const {
  for (;;) {
    const auto worst = std::ranges::max_element(judged.named, {}, [](const NamedEffect& n) { return n.rollout.low; });
    if (worst == judged.named.end() || !worst->rollout.harms()) return judged;
    judged = measured(without(judged, static_cast<std::size_t>(worst - judged.named.begin())));
  }
}

/// Whether what was found closes some of the gap on the laps held out or, where these are inconclusive, on the others.
/// Refitted parameters count with it: they take up most of an effect, and what predictions show of the rest is less
/// sure than its evidence. That it does no harm beside them is asked before (without_harmful).
bool Judge::closes(const Judgement& judged) const {
  if (judged.named.empty()) return true;
  const bool noisy = has_strong_process_noise(problem_, judged.fit.noise) || problem_.command != UnknownCommands{};
  const Closing answer = hold_out_.empty() ? Closing::inconclusive
                                           : closing(judged.gap, judged.fit.evidence - null_model_.evidence,
                                                     noisy || options_.delays_taken_off);
  if (answer != Closing::inconclusive) return answer == Closing::closes;
  // What delays that were taken off are wrong by shows in all data alike, as a small effect.
  if (options_.delays_taken_off && !hold_out_.empty() && !(judged.gap.change.change < -thresholds::more_than_delays))
    return false;
  return closes_on_training(compare(hold_out_.predict_training(judged.fit), hold_out_.predict_training(null_model_)),
                            noisy);
}

/// Whether a result that closes some of the gap predicts hold-out data well enough to be kept.
bool Judge::stands(const Judgement& judged) const {
  if (hold_out_.empty()) return true;
  // Beside something unknown, effects that leave most of the gap open are imitations of it, unless each of them helps.
  const bool all_help = std::ranges::all_of(judged.named, [](const NamedEffect& n) { return n.rollout.helps(); });
  if (judged.unknown && !all_help && judged.gap.closure < thresholds::closure_beside_unknown) return false;
  const bool process_noise = has_strong_process_noise(problem_, judged.fit.noise);
  // Where nothing is named only nuisances differ, and what has ample evidence may be small or rest during the laps held
  // out or drown in process noise: these must only do no harm.
  const bool ample =
      judged.named.empty() || judged.fit.evidence - null_model_.evidence > thresholds::ample_evidence || process_noise;
  if (!ample) return !(judged.gap.after >= judged.gap.before);
  const double worse = process_noise ? thresholds::worse_with_process_noise : thresholds::worse_on_hold_out;
  return !(judged.gap.after > worse * judged.gap.before);
}

/// What was found does not predict, and what is missing is not known: nothing, where the bare model leaves nothing to
/// find. The nominal model is returned, with its parameters refitted where that makes predictions better. `gap_closes`:
/// as closes() says of what was found.
Judgement Judge::withdrawn(const Judgement& judged, bool gap_closes) const {
  Explanation bare;
  bare.tests = judged.tests;
  bare.unknown = judged.unknown;
  if (!judged.unknown && !judged.named.empty()) {
    if (!gap_closes) bare.tests = residual_tests(problem_, null_model_);
    const ResidualTest& left = strongest(bare.tests);
    if (gap_closes || left.statistic > thresholds::misfit) bare.unknown = left;
  }
  if (!null_model_.theta.empty()) {
    PredictionGaps refitted = measure_gaps(hold_out_, catalogue_, null_model_, null_model_);
    if (refitted.gap.closure > 0.0) return {with_fit(catalogue_, null_model_, std::move(bare)), std::move(refitted)};
  }
  bare.fit = nominal_as_stated(catalogue_, null_model_);
  return {std::move(bare), left_open(judged)};
}

}  // namespace

Judgement judge_by_predictions(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options,
                               Explanation concluded) {
  const Judge judge(found, hold_out, options);
  Judgement judged = judge.without_harmful(judge.measured(std::move(concluded)));
  const bool gap_closes = judge.closes(judged);
  return gap_closes && judge.stands(judged) ? judged : judge.withdrawn(judged, gap_closes);
}

}  // namespace gripline::diagnose
