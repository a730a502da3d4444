#include "diagnose/result/judgement.hpp"

#include <algorithm>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/result/closing.hpp"
#include "diagnose/result/fitted_parameters.hpp"
#include "diagnose/result/prediction_gap.hpp"

namespace gripline::diagnose {
namespace {

/// One diagnosis and what it is judged with.
class Judge {
 public:
  Judge(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options, Diagnosis& d)
      : found_(found),
        problem_(found.pool.problem()),
        catalogue_(*problem_.catalogue),
        hold_out_(hold_out),
        options_(options),
        d_(d) {}

  void run() {
    measure();
    drop_harmful();
    const bool gap_closes = closes();
    if (!gap_closes || !stands()) withdraw(gap_closes);
  }

 private:
  void measure() {
    measure_gap(hold_out_, catalogue_, d_);
    compare_named();
  }
  void compare_named();
  void drop_harmful();
  bool closes() const;
  bool stands() const;
  void withdraw(bool gap_closes);

  SearchResult& found_;
  const Problem& problem_;  // as the search left it: what the pool fits is along its references
  const Catalogue& catalogue_;
  const HoldOut& hold_out_;
  const JudgementOptions options_;
  Diagnosis& d_;
};

/// What each named effect does to predictions, beside the others.
void Judge::compare_named() {
  if (d_.named.empty()) return;
  if (d_.named.size() == 1 && catalogue_.nuisances().empty()) {
    d_.named.front().rollout = d_.gap.change;
    return;
  }
  const StartErrors with = hold_out_.predict_refitted(d_.fit);
  for (std::size_t i = 0; i < d_.named.size(); ++i) {
    const Fit& without = found_.pool.fit_once(catalogue_.without(d_.fit.model, d_.fit.model.members[i]), d_.fit.noise);
    d_.named[i].rollout = compare(with, hold_out_.predict_refitted(without));
  }
}

/// An effect that makes predictions worse is not kept, whatever its evidence: it stands for something else.
void Judge::drop_harmful() {
  for (;;) {
    const auto worst = std::ranges::max_element(d_.named, {}, [](const NamedEffect& n) { return n.rollout.low; });
    if (worst == d_.named.end() || !worst->rollout.harms()) return;
    const std::size_t member = d_.fit.model.members[static_cast<std::size_t>(worst - d_.named.begin())];
    d_.named.erase(worst);
    d_.fit = found_.pool.fit_once(catalogue_.without(d_.fit.model, member), d_.fit.noise);
    d_.verdict = Verdict::unknown;
    d_.equivalent.clear();
    d_.manoeuvre.clear();
    d_.tests = residual_tests(problem_, d_.fit);
    d_.unknown = strongest(d_.tests);
    for (NamedEffect& n : d_.named) n.confidence = std::min(n.confidence, thresholds::most_beside_unknown);
    set_parameters(catalogue_, d_);
    measure();
  }
}

/// Whether what was found closes some of the gap on the laps held out or, where these cannot tell, on the others.
/// Refitted parameters count with it: they take up most of an effect, and what predictions show of the rest is less
/// sure than its evidence. That it does no harm beside them is asked before (drop_harmful).
bool Judge::closes() const {
  if (d_.named.empty()) return true;
  const bool noisy = has_strong_process_noise(problem_, d_.fit.noise) || problem_.command != UnknownCommands{};
  const Closing answer =
      hold_out_.empty() ? Closing::ask_fitted
                        : closing(d_.gap, d_.fit.evidence - d_.null_model.evidence, noisy || options_.delays_taken_off);
  if (answer != Closing::ask_fitted) return answer == Closing::closes;
  // What delays that were taken off are wrong by shows in all data alike, as a small effect.
  if (options_.delays_taken_off && !hold_out_.empty()) return false;
  return closes_fitted(compare(hold_out_.predict_training(d_.fit), hold_out_.predict_training(d_.null_model)), noisy);
}

/// Whether a result that closes some of the gap predicts hold-out data well enough to be kept.
bool Judge::stands() const {
  if (hold_out_.empty()) return true;
  // Beside something unknown, effects that leave most of the gap open are imitations of it, unless each of them helps.
  const bool all_help = std::ranges::all_of(d_.named, [](const NamedEffect& n) { return n.rollout.helps(); });
  if (d_.verdict == Verdict::unknown && !all_help && d_.gap.closure < thresholds::closure_beside_unknown) return false;
  const bool process_noise = has_strong_process_noise(problem_, d_.fit.noise);
  // Where nothing is named only nuisances differ, and what has ample evidence may be small or rest during the laps held
  // out or drown in process noise: these must only do no harm.
  const bool ample =
      d_.named.empty() || d_.fit.evidence - d_.null_model.evidence > thresholds::ample_evidence || process_noise;
  if (!ample) return !(d_.gap.after >= d_.gap.before);
  const double worse = process_noise ? thresholds::worse_with_process_noise : thresholds::worse_on_hold_out;
  return !(d_.gap.after > worse * d_.gap.before);
}

/// What was found does not predict, and what is missing is not known: nothing, where the bare model leaves nothing to
/// find. The nominal model is returned, with its parameters refitted where that makes predictions better. `gap_closes`:
/// as closes() says of what was found.
void Judge::withdraw(bool gap_closes) {
  const bool was_known = d_.verdict == Verdict::named || d_.verdict == Verdict::indistinguishable;
  if (was_known && !gap_closes) {
    d_.tests = residual_tests(problem_, found_.null_model);
    if (!(strongest(d_.tests).statistic > thresholds::misfit)) d_.verdict = Verdict::nothing_missing;
  }
  if (d_.verdict != Verdict::nothing_missing) {
    d_.verdict = Verdict::unknown;
    if (!d_.unknown) d_.unknown = strongest(d_.tests);
  }
  d_.named.clear();
  d_.equivalent.clear();
  d_.manoeuvre.clear();
  d_.nominal_fit.clear();
  d_.fit = found_.null_model;
  if (!d_.fit.theta.empty()) {
    set_parameters(catalogue_, d_);
    measure_gap(hold_out_, catalogue_, d_);
    if (d_.gap.closure > 0.0) return;
    d_.nominal_fit.clear();
  }
  d_.fit = nominal_as_stated(catalogue_, d_.null_model);
  leave_gap_open(d_);
}

}  // namespace

void judge_by_predictions(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options, Diagnosis& d) {
  Judge(found, hold_out, options, d).run();
}

}  // namespace gripline::diagnose
