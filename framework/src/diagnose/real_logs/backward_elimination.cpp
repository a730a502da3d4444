#include "diagnose/real_logs/backward_elimination.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace gripline::diagnose {

using calibrate::Addition;
using calibrate::ForecastChange;
using calibrate::SteeringAsymmetry;
using calibrate::Trial;
using calibrate::Unknown;

namespace {

/// Whether an addition is the offset of a steering whose curve is there too. It stays with the curve as the term of
/// lower order: that the fitted time determines it and that predictions are better with it, significantly or not, is
/// enough.
bool is_offset_of_curve(const std::vector<Addition>& added, std::size_t index) {
  return added[index].asymmetry == SteeringAsymmetry::offset &&
         std::ranges::find(added, SteeringAsymmetry::curve, &Addition::asymmetry) != added.end();
}

/// A world with one effect less, and what that does to predictions.
struct Ablation {
  std::unique_ptr<Trial> rest;
  ForecastChange reported;  // of reported errors, by the effect
  double significance = 0;  // that the effect helps, in standard deviations
  bool needed = false;
};

void take_out(Selection& selection, std::size_t index, std::unique_ptr<Trial> rest) {
  selection.trial = std::move(rest);
  selection.added.erase(selection.added.begin() + static_cast<std::ptrdiff_t>(index));
}

/// How far from doing nothing the fitted time says that an addition is, in half widths of its 95 % interval on that
/// side: above 1 an interval of one of its parameters leaves out the value that does nothing.
double determined(const Selection& selection, const Addition& addition, const calibrate::Bootstrap& boot) {
  const Trial& found = *selection.trial;
  double most = 0.0;
  for (std::size_t i = 0; i < found.unknowns.size(); ++i) {
    const Unknown& u = found.unknowns[i];
    if (!addition.owns(u.pointer) || std::ranges::find(selection.tested, u.pointer) == selection.tested.end()) continue;
    const double value = found.params[u.index], off = value - u.prior;
    const double half = off > 0.0 ? value - boot.interval[i].low : boot.interval[i].high - value;
    if (half > 0.0) most = std::max(most, std::abs(off) / half);
  }
  return most;
}

/// Takes out what the fitted time does not determine beside the others, the least determined first. Gives the normal
/// equations of what is left, nothing where no effect is.
calibrate::BlockedNormalEquations keep_determined(const EffectSearch& search, Selection& selection) {
  while (!selection.added.empty()) {
    const Trial& found = *selection.trial;
    calibrate::BlockedNormalEquations blocks = search.fits.errors(found).linearise(found.params, found.unknowns);
    const calibrate::Bootstrap boot =
        calibrate::bootstrap(blocks, found.params, found.unknowns, search.options.fit.seed);
    const auto how = [&](const Addition& addition) { return determined(selection, addition, boot); };
    const auto least = std::ranges::min_element(selection.added, {}, how);
    if (how(*least) > 1.0) return blocks;
    // Of a steering's curve and its offset the curve goes first.
    const auto gone = std::ranges::find_if(selection.added, [&](const Addition& one) {
      return least->asymmetry == SteeringAsymmetry::offset && one.asymmetry == SteeringAsymmetry::curve &&
             !(how(one) > 1.0);
    });
    const auto index =
        static_cast<std::size_t>((gone == selection.added.end() ? least : gone) - selection.added.begin());
    auto rest = search.fits.without(found, blocks, selection.added[index]);
    search.validate(*rest);
    take_out(selection, index, std::move(rest));
  }
  return {};
}

/// Asks what predictions are without one of the effects, beside all others (`now` are the errors with it) and beside
/// all that were there at `first`.
Ablation evaluate_without(const EffectSearch& search, const Selection& selection, std::size_t index,
                          const calibrate::BlockedNormalEquations& blocks, const UnfittedErrors& now,
                          const UnfittedErrors& first) {
  Ablation out;
  out.rest = search.fits.without(*selection.trial, blocks, selection.added[index]);
  search.validate(*out.rest);
  const UnfittedErrors without = search.unfitted_errors(*out.rest);
  const UnfittedChange by_it = compare_unfitted(now, without);
  out.reported = change_of(search.reported(now), search.reported(without));
  out.significance = by_it.significance;
  // Several may be needed together, none of them significant beside the rest: then those that went count with it.
  const double together = compare_unfitted(first, without).significance;
  const bool significant = std::max(by_it.significance, together) > least_significance;
  out.needed = by_it.smaller && (significant || is_offset_of_curve(selection.added, index));
  return out;
}

/// Evaluates the world without each of the effects, the least significant of an earlier time first. If that one is
/// still not needed, the others are not evaluated: it goes.
std::vector<Ablation> evaluate_each(const EffectSearch& search, Selection& selection,
                                    const calibrate::BlockedNormalEquations& blocks, const UnfittedErrors& first,
                                    std::map<std::string, double>& significance) {
  std::vector<Addition>& added = selection.added;
  const UnfittedErrors now = search.unfitted_errors(*selection.trial);
  std::ranges::stable_sort(added, {}, [&](const Addition& addition) {
    const auto known = significance.find(addition.name);
    return known == significance.end() ? 0.0 : known->second;
  });
  std::vector<Ablation> out;
  for (std::size_t i = 0; i < added.size(); ++i) {
    search.tell(0.75 + 0.2 * static_cast<double>(i) / static_cast<double>(added.size()), "without " + added[i].name);
    out.push_back(evaluate_without(search, selection, i, blocks, now, first));
    const bool again = i == 0 && significance.contains(added[i].name);
    significance[added[i].name] = out[i].significance;
    if (again && !out[i].needed) break;
  }
  return out;
}

}  // namespace

std::vector<MissingEffect> eliminate_backward(const EffectSearch& search, Selection& selection) {
  if (selection.added.empty()) return {};
  search.fits.refit_until_still(*selection.trial);  // as those without one of the effects are that it is compared with
  search.validate(*selection.trial);
  // What is left is never significantly worse than this.
  const UnfittedErrors first = search.unfitted_errors(*selection.trial);
  std::map<std::string, double> significance;  // of effects that were evaluated
  for (;;) {
    const calibrate::BlockedNormalEquations blocks = keep_determined(search, selection);
    if (selection.added.empty()) return {};
    std::vector<Ablation> ablations = evaluate_each(search, selection, blocks, first, significance);
    const auto worst = std::ranges::min_element(
        ablations, {}, [](const Ablation& one) { return one.needed ? INFINITY : one.significance; });
    if (!worst->needed) {
      take_out(selection, static_cast<std::size_t>(worst - ablations.begin()), std::move(worst->rest));
      continue;
    }
    // All of them were evaluated beside each other.
    std::vector<MissingEffect> named;
    for (std::size_t i = 0; i < ablations.size(); ++i)
      named.push_back({selection.added[i], false, {}, ablations[i].reported});
    std::ranges::stable_sort(named, {}, [](const MissingEffect& one) { return one.change.change; });
    return named;
  }
}

}  // namespace gripline::diagnose
