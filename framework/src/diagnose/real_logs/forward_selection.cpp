#include "diagnose/real_logs/forward_selection.hpp"

#include <algorithm>
#include <functional>

#include "calibrate/effects/yaw_limit.hpp"

namespace gripline::diagnose {

using calibrate::CandidateEffect;
using calibrate::EffectScore;
using calibrate::SteeringAsymmetry;
using calibrate::Trial;

namespace {

constexpr double agreed = 2.0;  // standard deviations over blocks of a score that is worth a fit
constexpr double worth = 0.02;  // of the squared errors: a hundredth of the error
// Share of its information that sets an effect apart from what is fitted, below which first order says little of it: a
// dead zone or an end of grip that no command reaches yet.
constexpr double hidden = 1e-2;
constexpr double faint = 0.5 * worth;   // a gain to first order below which even those are not fitted
constexpr double disputed_share = 0.5;  // of the largest gain, from where on what blocks do not agree on is fitted
constexpr double surpassed = 1.5;       // times its gain to first order a fit may reach, where another has reached more

/// Candidates beside one selection, by their gain to first order, and the best that was fitted.
struct Round {
  std::vector<CandidateEffect> candidates;
  std::vector<EffectScore> scores;  // largest gain first
  std::vector<ScoredEffect> rows;   // by score
  std::unique_ptr<Trial> best;      // null while none is worth its fit
  std::size_t best_score = 0;
};

std::vector<CandidateEffect> candidates_for(const EffectSearch& search, const Trial& base,
                                            std::span<const std::string> without) {
  auto candidates = calibrate::candidates_beside(base, search.registry, search.worlds.undetermined);
  std::erase_if(candidates, [&](const CandidateEffect& one) {
    return std::ranges::find(without, calibrate::addition_of(one, base).name) != without.end();
  });
  limit_to_yaw(candidates, search.by_yaw);
  return candidates;
}

Round score_round(const EffectSearch& search, const Trial& base, std::vector<CandidateEffect> candidates) {
  Round round;
  round.candidates = std::move(candidates);
  std::vector<calibrate::FitLog> fitted = search.logs.fitted;
  round.scores = score_candidates(base.vehicle.car(), round.candidates, search.forecast, fitted, base.params,
                                  base.unknowns, search.fits.weighing);
  std::ranges::stable_sort(round.scores, std::greater<>(), &EffectScore::gain);
  round.rows.reserve(round.scores.size());
  for (const EffectScore& one : round.scores)
    round.rows.push_back(
        {calibrate::addition_of(round.candidates[one.candidate], base).name, one.gain, false, 0.0, {}});
  return round;
}

/// Fits the candidate of a score, unless it stays behind the best so far, and keeps it if it is the best. Its row is
/// filled if it was validated: beside the calibrated world also where its fit was given up, whose decrease and change
/// are then of less than it can do; such a fit is never kept.
void try_candidate(const EffectSearch& search, const Selection& selection, Round& round, std::size_t index) {
  const Trial& base = *selection.trial;
  const EffectScore& score = round.scores[index];
  const CandidateEffect& effect = round.candidates[score.candidate];
  auto trial = search.fits.with(base, effect, score);
  const double rival = round.best ? round.best->cost : (1.0 - worth) * base.cost;
  const bool near = search.fits.refit_near(*trial, rival);
  if (!near && !selection.added.empty()) return;  // the first ones are reported whatever they do
  search.validate(*trial);
  ScoredEffect& row = round.rows[index];
  row = {calibrate::addition_of(effect, base).name, 1.0 - trial->cost / base.cost, true, trial->validation.rms(),
         change_of(trial->validation, base.validation)};
  // Whether it helps significantly is tested in the end, beside the others: what is still missing is noise here. Where
  // blocks do not agree on it, it must be sure by now.
  const bool disputed = !(score.score > agreed) && !(score.apart < hidden);
  if (!near || !(disputed ? row.change.helps() : row.change.change < 0.0) || !(trial->cost < rival)) return;
  round.best = std::move(trial);
  round.best_score = index;
}

/// Fits the best few whose blocks agree and, where none of them is kept, the best few of those that others hide. Beside
/// the calibrated world the best of all is fitted, too: it may show only in the few blocks that are fast enough for it.
void try_best(const EffectSearch& search, const Selection& selection, Round& round) {
  const std::size_t tries = search.options.tries, count = round.scores.size();
  const bool first_round = selection.added.empty();  // all fits are reported
  std::vector<bool> asked(count, false);
  const auto try_at = [&](std::size_t i) {
    asked[i] = true;
    try_candidate(search, selection, round, i);
  };
  for (std::size_t i = 0, tried = 0; i < count && tried < tries; ++i) {
    const bool among_best =
        first_round && round.scores[i].gain > std::max(worth, disputed_share * round.scores.front().gain);
    if (!(round.scores[i].score > agreed) && !among_best) continue;
    if (round.best && !first_round && surpassed * round.scores[i].gain < 1.0 - round.best->cost / selection.trial->cost)
      break;
    ++tried;
    try_at(i);
  }
  for (std::size_t i = 0, tried = 0; i < count && !round.best && tried < tries; ++i) {
    if (asked[i] || !(round.scores[i].apart < hidden) || !(round.scores[i].gain > faint)) continue;
    ++tried;
    try_at(i);
  }
}

void add_best(Selection& selection, Round& round) {
  const CandidateEffect& chosen = round.candidates[round.scores[round.best_score].candidate];
  const calibrate::Addition added = calibrate::addition_of(chosen, *selection.trial);
  for (const std::size_t i : chosen.tested)
    selection.tested.push_back(added.opened ? added.pointer : added.pointer + chosen.entry->params()[i].name);
  selection.added.push_back(added);
  selection.trial = std::move(round.best);
}

/// A steering that turns further to one side stands for one that is not straight at zero wherever a log turns mostly
/// one way, and almost every steering is off a little: the curve's term of lower order comes with it (marginality:
/// Nelder, A reformulation of linear models, JRSS A 140, 1977), whatever it takes off by itself. Backward elimination
/// says which of them stays.
void add_offset_of_curve(const EffectSearch& search, Selection& found) {
  if (found.added.back().asymmetry != SteeringAsymmetry::curve || found.added.size() >= search.options.most) return;
  auto candidates = candidates_for(search, *found.trial, {});
  std::erase_if(candidates, [](const CandidateEffect& one) { return one.asymmetry != SteeringAsymmetry::offset; });
  if (candidates.empty()) return;
  Round round = score_round(search, *found.trial, std::move(candidates));
  if (round.scores.empty()) return;
  const EffectScore& best = round.scores.front();
  round.best = search.fits.with(*found.trial, round.candidates[best.candidate], best);
  search.fits.refit_until_still(*round.best);
  search.validate(*round.best);
  add_best(found, round);
}

/// Adds effects until none is worth it; gives the rows of the first round.
std::vector<ScoredEffect> grow(const EffectSearch& search, Selection& found, std::span<const std::string> without) {
  const std::size_t most = search.options.most;
  const auto tell = [&] {
    search.tell(0.25 + 0.5 * static_cast<double>(found.added.size()) / static_cast<double>(most),
                found.added.empty() ? "looking for effects" : "beside " + found.added.back().name);
  };
  tell();
  std::vector<ScoredEffect> first;
  for (bool begun = false; found.added.size() < most; begun = true) {
    Round round = score_round(search, *found.trial, candidates_for(search, *found.trial, without));
    try_best(search, found, round);
    if (!begun) first = std::move(round.rows);
    if (!round.best) break;
    add_best(found, round);
    add_offset_of_curve(search, found);
    tell();
  }
  return first;
}

/// What sensors do comes before what the car does, where it explains about as much: a yaw rate that is read too large
/// hides parameters of the world, which the logs tell once it is known, and effects would be named in their place.
void add_measurements(const EffectSearch& search, Selection& found) {
  constexpr double as_much = 0.9;  // of the largest gain to first order
  const auto is_reading = [](const CandidateEffect& one) { return one.effect->stage() == Stage::reading; };
  while (found.added.size() < search.options.most) {
    auto candidates = candidates_for(search, *found.trial, {});
    std::erase_if(candidates, is_reading);
    const Round others = score_round(search, *found.trial, std::move(candidates));
    candidates = candidates_for(search, *found.trial, {});
    std::erase_if(candidates, std::not_fn(is_reading));
    Round round = score_round(search, *found.trial, std::move(candidates));
    try_best(search, found, round);
    if (!round.best) return;
    const ScoredEffect& best = round.rows[round.best_score];
    if (!best.change.helps()) return;
    if (!others.scores.empty() && best.less_error < as_much * others.scores.front().gain) return;
    add_best(found, round);
    open_undetermined(search, *found.trial);
    search.fits.refit_until_still(*found.trial);
    search.validate(*found.trial);
  }
}

/// Rows of effects beside the calibrated world.
std::vector<ScoredEffect> rank_alone(const EffectSearch& search) {
  const Selection nothing = nothing_added(search);
  Round round = score_round(search, *nothing.trial, candidates_for(search, *nothing.trial, {}));
  try_best(search, nothing, round);
  return std::move(round.rows);
}

}  // namespace

ForwardSelection select_forward(const EffectSearch& search) {
  ForwardSelection out{nothing_added(search), {}};
  add_measurements(search, out.found);
  if (!out.found.added.empty()) out.ranking = rank_alone(search);
  auto first = grow(search, out.found, {});
  if (out.ranking.empty()) out.ranking = std::move(first);
  return out;
}

void extend_forward(const EffectSearch& search, Selection& selection, std::span<const std::string> without) {
  grow(search, selection, without);
}

}  // namespace gripline::diagnose
