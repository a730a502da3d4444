#include "diagnose/inference/screening.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// The score test of some of the directions.
Score test_of(const Screening& s, std::span<const std::size_t> directions) {
  std::vector<Index> rows(s.own);
  std::iota(rows.begin(), rows.end(), Index{0});
  for (const std::size_t d : directions) rows.push_back(static_cast<Index>(d));
  // One direction counts as long as rounding allows: an effect that is a nuisance under another name differs from it
  // only by how far the nuisance is trusted. Of several, those that the others all but replace are left out.
  return score_test(s.normal.N(rows, rows), s.normal.g(rows), static_cast<Index>(s.own),
                    directions.size() == 1 ? 1e-10 : 1e-6);
}

/// A parameter moved by a step from where it does nothing, within its range; not farther than it can be trusted.
double moved(const abi::ParamDecl& p, double step) {
  const double limit = 20.0 * p.scale;
  return std::clamp(p.neutral + std::clamp(step, -limit, limit), p.lo, p.hi);
}
/// Whether it would have to leave its range to the side where nothing is.
bool leaves(const abi::ParamDecl& p, double step) { return p.neutral <= p.lo && step < 0.0; }

/// The best that one candidate offers: its directions together, or of a scan the best start.
Extension best_of(const Problem& problem, const Fit& fitted, const Screening& s, const Group& group) {
  const Candidate& c = problem.catalogue->candidates()[group.candidate];
  Extension best;
  best.candidate = group.candidate;
  best.gain = -1.0;
  const bool scanned = !group.starts.empty();
  const std::size_t tries = scanned ? group.count : 1, count = scanned ? 1 : group.count;
  for (std::size_t i = 0; i < tries; ++i) {
    std::vector<std::size_t> directions(count);
    std::iota(directions.begin(), directions.end(), group.first + i);
    const Score score = test_of(s, directions);
    std::vector<double> values = scanned ? group.starts[i] : c.defaults;
    const std::size_t moving = std::min<std::size_t>(scanned ? 1 : c.fitted.size(), count);
    bool outside = false;
    for (std::size_t f = 0; f < moving; ++f) {
      const double step = score.step[static_cast<Index>(f)];
      outside |= count == 1 && leaves(c.decl(f), step);
      values[c.fitted[f]] = moved(c.decl(f), step);
    }
    const double gain = outside ? 0.0 : score.gain;
    if (gain <= best.gain) continue;
    best.gain = gain;
    best.dof = scanned ? c.fitted.size() : score.dof;
    best.start = problem.catalogue->with(fitted.model, group.candidate);
    best.start.values[best.start.position(group.candidate)] = values;
  }
  return best;
}

}  // namespace

Screening screen(const Problem& problem, const Fit& fitted) {
  const Catalogue& catalogue = *problem.catalogue;
  Screening out;
  for (const Trace& trace : problem.traces) {
    auto [lm, directions, work] = linearise_own(catalogue, fitted.model, trace, problem.substeps);
    out.own = directions.size();
    std::vector<Group> groups;
    candidate_directions(catalogue, fitted.model, trace, lm, directions, groups);
    if (out.groups.empty()) out.groups = std::move(groups);  // they are the same along every trace
    out.normal.add(filter_along(lm, fitted.noise, directions));
  }
  out.normal.add_nuisances(catalogue, fitted.model);
  hold_at_limits(catalogue, fitted.model, out.normal);
  for (const Group& group : out.groups) out.extensions.push_back(best_of(problem, fitted, out, group));
  const auto worth = [&](const Extension& e) { return e.gain - problem.charge(e.dof); };
  std::stable_sort(out.extensions.begin(), out.extensions.end(),
                   [&](const Extension& a, const Extension& b) { return worth(a) > worth(b); });
  return out;
}

std::vector<Extension> best_pairs(const Problem& problem, const Fit& fitted, const Screening& screening) {
  const Catalogue& catalogue = *problem.catalogue;
  std::vector<Extension> pairs;
  for (const Group& a : screening.groups)
    for (const Group& b : screening.groups) {
      const Candidate &x = catalogue.candidates()[a.candidate], &y = catalogue.candidates()[b.candidate];
      if (a.first >= b.first || x.fitted.size() != 1 || y.fitted.size() != 1) continue;
      const std::array<std::size_t, 2> both = {a.first, b.first};
      const Score score = test_of(screening, both);
      if (score.dof < 2 || leaves(x.decl(0), score.step[0]) || leaves(y.decl(0), score.step[1])) continue;
      Extension pair;
      pair.candidate = a.candidate;
      pair.gain = score.gain;
      pair.dof = score.dof;
      pair.start = catalogue.with(catalogue.with(fitted.model, a.candidate), b.candidate);
      pair.start.values[pair.start.position(a.candidate)][x.fitted[0]] = moved(x.decl(0), score.step[0]);
      pair.start.values[pair.start.position(b.candidate)][y.fitted[0]] = moved(y.decl(0), score.step[1]);
      pairs.push_back(std::move(pair));
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Extension& a, const Extension& b) { return a.gain > b.gain; });
  return pairs;
}

}  // namespace gripline::diagnose
