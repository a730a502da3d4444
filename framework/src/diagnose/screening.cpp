#include "screening.hpp"

#include <numeric>

#include "score_test.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// The score test of some of the directions.
Score test_of(const Screening& s, std::size_t first, std::size_t count) {
  std::vector<Index> rows(s.own + count);
  std::iota(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(s.own), Index{0});
  std::iota(rows.begin() + static_cast<std::ptrdiff_t>(s.own), rows.end(), static_cast<Index>(first));
  // One direction counts as long as rounding allows: an effect that is a nuisance under another name differs from it
  // only by how far the nuisance is trusted. Of several, those that the others all but replace are left out.
  return score_test(s.normal.N(rows, rows), s.normal.g(rows), static_cast<Index>(s.own), count == 1 ? 1e-10 : 1e-6);
}

/// The best that one candidate offers: its directions together, or of a scan the best start.
Extension best_of(const Problem& problem, const Fit& fitted, const Screening& s, const Group& group) {
  const Candidate& c = problem.catalogue->candidates()[group.candidate];
  Extension best;
  best.candidate = group.candidate;
  best.gain = -1.0;
  const bool scanned = !group.starts.empty();
  const std::size_t tries = scanned ? group.count : 1, count = scanned ? 1 : group.count;
  for (std::size_t i = 0; i < tries; ++i) {
    const Score score = test_of(s, group.first + i, count);
    std::vector<double> values = scanned ? group.starts[i] : c.defaults;
    const std::size_t moving = std::min<std::size_t>(scanned ? 1 : c.fitted.size(), count);
    bool outside = false;
    for (std::size_t f = 0; f < moving; ++f) {
      const abi::ParamDecl& p = c.decl(f);
      const double limit = 20.0 * p.scale;
      const double wanted = p.neutral + std::clamp(score.step[static_cast<Index>(f)], -limit, limit);
      if (count == 1 && p.neutral <= p.lo && wanted < p.neutral) outside = true;
      values[c.fitted[f]] = std::clamp(wanted, p.lo, p.hi);
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

}  // namespace gripline::diagnose
