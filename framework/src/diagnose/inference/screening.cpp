#include "diagnose/inference/screening.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>

#include "diagnose/inference/newton_step.hpp"
#include "diagnose/inference/predicted_motion.hpp"
#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// Rows of the model's own parameters and of some regressors.
std::vector<Index> rows_of(const Screening& s, std::span<const std::size_t> regressors) {
  std::vector<Index> rows(s.own_params);
  std::iota(rows.begin(), rows.end(), Index{0});
  for (const std::size_t d : regressors) rows.push_back(static_cast<Index>(d));
  return rows;
}

/// The score test of some regressors where nuisances stand at their limits: beside these they may come back from there,
/// so that an effect shows all that it brings in place of such a nuisance. An active-set method: all are free at first,
/// and those that would leave their limits are put there one by one, the worst first. The gain is of the own parameters
/// too, which alone have Screening::own_gain.
ScoreTest test_with_free_nuisances(const Catalogue& catalogue, const ModelSpec& model, const Screening& s,
                                   std::span<const std::size_t> regressors, double rank_tolerance) {
  const auto rows = rows_of(s, regressors);
  const auto own = static_cast<Index>(s.own_params), count = static_cast<Index>(regressors.size());
  const NormalEquations whole{s.normal.N(rows, rows), s.normal.g(rows)};
  NormalEquations reduced = whole;
  Eigen::VectorXd fixed_step = Eigen::VectorXd::Zero(own);
  std::vector<bool> fixed(catalogue.nuisances().size(), false);
  for (;;) {
    ScoreTest test = count > 0 ? score_test(reduced.N, reduced.g, own, rank_tolerance) : ScoreTest{};
    Eigen::MatrixXd base = reduced.N.topLeftCorner(own, own);
    base.diagonal() *= 1.0 + 1e-12;  // as score_test has it
    const Eigen::VectorXd beside = reduced.g.head(own) - reduced.N.topRightCorner(own, count) * test.step;
    Eigen::VectorXd step(own + count);
    step.head(own) = fixed_step + base.ldlt().solve(beside);
    step.tail(count) = test.step;
    const auto beyond = farthest_beyond(catalogue, model, step, fixed);
    if (!beyond) {
      test.gain = whole.g.dot(step) - 0.5 * step.dot(whole.N * step);
      return test;
    }
    fixed[beyond->nuisance] = true;
    fixed_step[static_cast<Index>(beyond->nuisance)] = beyond->step;
    fix_parameter(reduced, static_cast<Index>(beyond->nuisance), beyond->step);
  }
}

/// The score test of some of the regressors.
ScoreTest test_of(const Catalogue& catalogue, const ModelSpec& model, const Screening& s,
                  std::span<const std::size_t> regressors) {
  const double rank_tolerance =
      regressors.size() == 1 ? thresholds::rank_tolerance_one : thresholds::rank_tolerance_several;
  if (s.at_limit) {
    ScoreTest test = test_with_free_nuisances(catalogue, model, s, regressors, rank_tolerance);
    test.gain = std::max(0.0, test.gain - s.own_gain);
    return test;
  }
  const auto rows = rows_of(s, regressors);
  return score_test(s.normal.N(rows, rows), s.normal.g(rows), static_cast<Index>(s.own_params), rank_tolerance);
}

/// A parameter a step away from neutral, within its range and thresholds::longest_start.
double value_after(const abi::ParamDecl& p, double step) {
  const double limit = thresholds::longest_start * p.scale;
  return std::clamp(p.neutral + std::clamp(step, -limit, limit), p.lo, p.hi);
}
/// Whether the step leaves the range through a neutral value at its lower end.
bool leaves(const abi::ParamDecl& p, double step) { return p.neutral <= p.lo && step < 0.0; }

/// Moves the nuisances of a start within their limits to where they are best beside its effects: of a regressor `at` of
/// the screening, the value a step away from neutral. Left behind, where both act alike, they make the start worse than
/// the model that it extends.
void refit_nuisances(const Catalogue& catalogue, const Screening& s, std::span<const std::size_t> at,
                     std::span<const double> steps, ModelSpec& start) {
  const auto count = static_cast<Index>(catalogue.nuisances().size());
  if (count == 0) return;
  NormalEquations own{s.normal.N.topLeftCorner(count, count), s.normal.g.head(count)};
  for (std::size_t i = 0; i < at.size(); ++i) own.g -= s.normal.N.col(static_cast<Index>(at[i])).head(count) * steps[i];
  ModelSpec bare = catalogue.null_model();
  bare.nuisance = start.nuisance;
  const Eigen::VectorXd move = parameter_step(catalogue, bare, own, parameter_scales(catalogue, bare)).step;
  for (std::size_t i = 0; i < start.nuisance.size(); ++i) start.nuisance[i] += move[static_cast<Index>(i)];
  clamp_to_ranges(catalogue, bare, start.nuisance);
}

/// The best extension by one candidate: with all its regressors, or with the best start of a scan.
Extension best_of(const Problem& problem, const Fit& fitted, const Screening& s, const CandidateRegressors& group) {
  const Candidate& c = problem.catalogue->candidates()[group.candidate];
  Extension best;
  best.candidate = group.candidate;
  best.gain = -1.0;
  const bool scanned = !group.starts.empty();
  const std::size_t tries = scanned ? group.count : 1, count = scanned ? 1 : group.count;
  for (std::size_t i = 0; i < tries; ++i) {
    std::vector<std::size_t> regressors(count);
    std::iota(regressors.begin(), regressors.end(), group.first + i);
    const ScoreTest score = test_of(*problem.catalogue, fitted.model, s, regressors);
    std::vector<double> values = scanned ? group.starts[i] : c.defaults;
    const std::size_t moving = std::min<std::size_t>(scanned ? 1 : c.fitted.size(), count);
    bool outside = false;
    std::vector<double> steps;
    for (std::size_t f = 0; f < moving; ++f) {
      const std::size_t moved = scanned ? c.strength : f;
      const double step = score.step[static_cast<Index>(f)];
      outside |= count == 1 && leaves(c.decl(moved), step);
      values[c.fitted[moved]] = value_after(c.decl(moved), step);
      steps.push_back(values[c.fitted[moved]] - c.decl(moved).neutral);
    }
    const double gain = outside ? 0.0 : score.gain;
    if (gain <= best.gain) continue;
    best.gain = gain;
    best.dof = scanned ? c.fitted.size() : score.dof;
    best.start = problem.catalogue->with(fitted.model, group.candidate);
    best.start.values[best.start.position(group.candidate)] = values;
    refit_nuisances(*problem.catalogue, s, std::span(regressors).first(moving), steps, best.start);
  }
  return best;
}

}  // namespace

Screening screen(const Problem& problem, const Fit& fitted) {
  const Catalogue& catalogue = *problem.catalogue;
  Screening out;
  for (const Trace& trace : problem.traces) {
    Differentiated model = differentiate(problem, fitted.model, trace, fitted.noise);
    std::vector<Regressor>& regressors = model.linearised.own;
    out.own_params = regressors.size();
    std::vector<CandidateRegressors> groups;
    candidate_regressors(catalogue, fitted.model, model.motion_of(trace), regressors, groups);
    if (out.groups.empty()) out.groups = std::move(groups);  // the same along every trace: of catalogue and model alone
    out.normal.add(filter_along(model.linearised.lm, fitted.noise, regressors));
  }
  out.normal.add(nuisance_priors(catalogue, fitted.model));
  NormalEquations fixed = out.normal;
  out.at_limit = fix_at_limits(catalogue, fitted.model, fixed);
  if (out.at_limit) out.own_gain = test_with_free_nuisances(catalogue, fitted.model, out, {}, 0.0).gain;
  for (const CandidateRegressors& group : out.groups) out.extensions.push_back(best_of(problem, fitted, out, group));
  // What these logs say nothing of, such as brakes that were never used, comes last.
  const auto worth = [&](const Extension& e) {
    return e.dof == 0 ? -std::numeric_limits<double>::infinity() : e.gain - problem.penalty(e.dof);
  };
  std::stable_sort(out.extensions.begin(), out.extensions.end(),
                   [&](const Extension& a, const Extension& b) { return worth(a) > worth(b); });
  return out;
}

double information_beside(const Screening& screening, std::size_t regressor) {
  const auto rows = rows_of(screening, {&regressor, 1});
  const Eigen::VectorXd no_score = Eigen::VectorXd::Zero(static_cast<Index>(rows.size()));
  const ScoreTest test = score_test(screening.normal.N(rows, rows), no_score, static_cast<Index>(screening.own_params));
  return test.information(0, 0);
}

std::vector<Extension> best_pairs(const Problem& problem, const Fit& fitted, const Screening& screening) {
  const Catalogue& catalogue = *problem.catalogue;
  std::vector<Extension> pairs;
  for (const CandidateRegressors& a : screening.groups)
    for (const CandidateRegressors& b : screening.groups) {
      const Candidate &x = catalogue.candidates()[a.candidate], &y = catalogue.candidates()[b.candidate];
      if (a.first >= b.first || x.fitted.size() != 1 || y.fitted.size() != 1) continue;
      if (!catalogue.fits_filter(fitted.model, {a.candidate, b.candidate})) continue;  // either alone may
      const std::array<std::size_t, 2> both = {a.first, b.first};
      const ScoreTest score = test_of(catalogue, fitted.model, screening, both);
      if (score.dof < 2 || leaves(x.decl(0), score.step[0]) || leaves(y.decl(0), score.step[1])) continue;
      Extension pair;
      pair.candidate = a.candidate;
      pair.gain = score.gain;
      pair.dof = score.dof;
      pair.start = catalogue.with(catalogue.with(fitted.model, a.candidate), b.candidate);
      const std::array<double, 2> values = {value_after(x.decl(0), score.step[0]),
                                            value_after(y.decl(0), score.step[1])};
      pair.start.values[pair.start.position(a.candidate)][x.fitted[0]] = values[0];
      pair.start.values[pair.start.position(b.candidate)][y.fitted[0]] = values[1];
      const std::array<double, 2> steps = {values[0] - x.decl(0).neutral, values[1] - y.decl(0).neutral};
      refit_nuisances(catalogue, screening, both, steps, pair.start);
      pairs.push_back(std::move(pair));
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Extension& a, const Extension& b) { return a.gain > b.gain; });
  return pairs;
}

std::map<std::size_t, std::vector<std::size_t>> synonyms(const Screening& s) {
  const auto N = [&](std::size_t i, std::size_t j) { return s.normal.N(static_cast<Index>(i), static_cast<Index>(j)); };
  std::map<std::size_t, std::vector<std::size_t>> found;
  std::vector<std::size_t> gone;
  for (std::size_t a = 0; a < s.groups.size(); ++a)
    for (std::size_t b = a + 1; b < s.groups.size(); ++b) {
      const CandidateRegressors &x = s.groups[a], &y = s.groups[b];
      if (x.count != 1 || y.count != 1) continue;
      if (std::find(gone.begin(), gone.end(), x.candidate) != gone.end()) continue;
      const double xx = N(x.first, x.first), yy = N(y.first, y.first), xy = N(x.first, y.first);
      if (!(xx > 0.0 && yy > 0.0) || !(xy * xy >= (1.0 - thresholds::synonym_tolerance) * xx * yy)) continue;
      found[x.candidate].push_back(y.candidate);
      gone.push_back(y.candidate);
    }
  return found;
}

}  // namespace gripline::diagnose
