#include "diagnose/inference/adequacy.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "diagnose/inference/bases.hpp"
#include "diagnose/inference/constancy.hpp"
#include "diagnose/inference/focused_test.hpp"
#include "diagnose/inference/predicted_motion.hpp"
#include "diagnose/inference/spectral_line.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// Gain and accelerations of each knot by itself, so that no function hides behind its neighbour's opposite.
struct KnotEvidence {
  std::vector<double> gain;
  std::vector<Eigen::Vector3d> step;
};
KnotEvidence knot_evidence(const ScoreTest& s, Index knots) {
  KnotEvidence out{std::vector<double>(static_cast<std::size_t>(knots), 0.0),
                   std::vector<Eigen::Vector3d>(static_cast<std::size_t>(knots), Eigen::Vector3d::Zero())};
  for (Index i = 0; i < knots; ++i) {
    Eigen::Matrix3d information;
    Eigen::Vector3d score;
    for (Index a = 0; a < 3; ++a) {
      score[a] = s.score[a * knots + i];
      for (Index b = 0; b < 3; ++b) information(a, b) = s.information(a * knots + i, b * knots + i);
    }
    const Eigen::Vector3d size = information.diagonal().cwiseMax(1e-300).cwiseSqrt();
    const Eigen::Matrix3d unit = size.cwiseInverse().asDiagonal() * information * size.cwiseInverse().asDiagonal();
    const Eigen::Vector3d scaled = size.cwiseInverse().asDiagonal() * score;
    const Eigen::Vector3d found = (unit + 1e-3 * Eigen::Matrix3d::Identity()).ldlt().solve(scaled);
    out.gain[static_cast<std::size_t>(i)] = std::max(0.0, 0.5 * scaled.dot(found));
    out.step[static_cast<std::size_t>(i)] = size.cwiseInverse().asDiagonal() * found;
  }
  return out;
}

/// Knots of a basis: how many, whether they close a circle, and the axis' value at a (fractional) knot.
struct Knots {
  Index count;
  bool periodic;
  std::function<double(double)> value;
};

/// The interval around the strongest knot whose gains keep above a share of it, centred on the gains.
void locate(const ScoreTest& s, const Knots& knots, ResidualTest& test) {
  const auto [gain, step] = knot_evidence(s, knots.count);
  const auto peak = static_cast<Index>(std::max_element(gain.begin(), gain.end()) - gain.begin());
  const Index count = knots.count;
  const auto at = [&gain = gain, count, periodic = knots.periodic](Index i) -> double {
    if (periodic) i = (i % count + count) % count;
    return i >= 0 && i < count ? gain[static_cast<std::size_t>(i)] : 0.0;
  };
  const double enough = at(peak) / thresholds::interval_ratio;
  Index from = peak, to = peak;
  while (peak - from < count / 3 && at(from - 1) > enough) --from;
  while (to - peak < count / 3 && at(to + 1) > enough) ++to;
  double sum = 0.0, centre = 0.0;
  for (Index i = from - 1; i <= to + 1; ++i) {
    sum += at(i);
    centre += at(i) * static_cast<double>(i);
  }
  centre /= sum;
  const double half = 0.5 * static_cast<double>(to - from + 1);
  test.from = knots.value(centre - half);
  test.to = knots.value(centre + half);
  for (std::size_t c = 0; c < 3; ++c) test.size[c] = step[static_cast<std::size_t>(peak)][static_cast<Index>(c)];
}

Knots knots_of(const Problem& problem, Where where) {
  if (where == Where::position)
    return {thresholds::place_knots, true, [](double x) { return x / static_cast<double>(thresholds::place_knots); }};
  const double end = end_time(problem);
  const std::size_t count = time_knots(problem);
  const double spacing = end / static_cast<double>(count - 1);
  return {static_cast<Index>(count), false, [=](double x) { return std::clamp(x * spacing, 0.0, end); }};
}

/// What the statistic of a joint test counts for, by how well commands are known.
double by_commands(const Problem& problem) {
  const bool uncertain = problem.hold().halves || problem.unrounded;
  return uncertain ? thresholds::misfit / thresholds::misfit_uncertain_commands : 1.0;
}

/// The joint test of all functions of one kind.
ResidualTest test_kind(const Problem& problem, const Fit& fitted, std::span<const Linearised> along, Where where) {
  const ScoreSystem system =
      basis_system(problem, fitted, along, [&](const Trace& trace) { return basis_of(problem, trace, where); });
  const ScoreTest s = score_test(system.normal.N, system.normal.g, system.own_params);
  ResidualTest test;
  test.where = where;
  test.gain = s.gain;
  test.dof = s.dof;
  const auto dof = static_cast<double>(std::max<std::size_t>(1, s.dof));
  test.statistic = (2.0 * s.gain - dof) / std::sqrt(2.0 * dof);
  test.statistic *= by_commands(problem);
  if (where == Where::position || where == Where::time) locate(s, knots_of(problem, where), test);
  return test;
}

/// Whether an acceleration other than this one is random.
bool noise_beside(const Problem& problem, const Fit& fitted, std::size_t channel) {
  const std::array<double, noise_states> ratio = process_noise_ratio(problem, fitted.noise);
  for (std::size_t c = 0; c < noise_states; ++c)
    if (c != channel && ratio[c] > thresholds::noticeable_process_noise) return true;
  return false;
}

/// One focused test per acceleration, each with its own few functions.
void add_focused(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                 std::vector<ResidualTest>& tests) {
  const ScoreSystem system = basis_system(problem, fitted, along, simple_basis);
  constexpr std::size_t functions = along_functions + across_functions;
  for (std::size_t channel = 0; channel < noise_states; ++channel) {
    std::vector<Index> rows;
    for (Index i = 0; i < system.own_params; ++i) rows.push_back(i);
    const std::size_t first = channel == 0 ? 0 : along_functions;
    const std::size_t last = channel == 0 ? along_functions : functions;
    for (std::size_t f = first; f < last; ++f)
      rows.push_back(system.own_params + static_cast<Index>(channel * functions + f));
    tests.push_back(focused_test(system, rows, Where::state, noise_beside(problem, fitted, channel)));
  }
}

/// A road shakes a car in all directions; process noise in some accelerations only (ratios at least
/// thresholds::noticeable_process_noise) is a deficient model's. The statistic is the smaller of two, in standard
/// deviations: how significant the largest variance is, and how far the calmest stays below a
/// thresholds::uneven_ratio-th of it. Which kind of function is missing the tests before tell better: `kind` is their
/// strongest.
ResidualTest test_uneven_noise(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                               const ResidualTest& kind) {
  ResidualTest test;
  test.where = kind.where;
  test.quantity = "noise";
  test.dof = noise_states;
  test.focused = true;
  const std::array<double, noise_states> ratio = process_noise_ratio(problem, fitted.noise);
  const double most = std::ranges::max(ratio), even = most / thresholds::uneven_ratio;
  if (most < thresholds::noticeable_process_noise || std::ranges::min(ratio) > even) return test;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Linearised& one : along) {
    FilterOptions options;
    options.noise_gradient = true;
    const Likelihood l = filter(one.lm, fitted.noise, options);
    for (std::size_t i = 0; i < noise_states; ++i)
      for (std::size_t j = 0; j < noise_states; ++j)
        information(static_cast<Index>(i), static_cast<Index>(j)) += l.noise_information[i][j];
  }
  const Eigen::Matrix3d covariance = information.inverse();
  double random = 0.0, calm = 0.0;
  for (std::size_t c = 0; c < noise_states; ++c) {
    const auto i = static_cast<Index>(c);
    if (!(covariance(i, i) > 0.0)) continue;
    const double variance = fitted.noise.process[c], sigma = std::sqrt(covariance(i, i));
    random = std::max(random, variance / sigma);
    calm = std::max(calm, (std::pow(even * problem.process_unit[c], 2) - variance) / sigma);
  }
  test.statistic = std::min(random, calm);
  return test;
}

}  // namespace

const ResidualTest& strongest(std::span<const ResidualTest> tests) {
  const auto rank = [](const ResidualTest& t) {
    return std::pair(t.statistic > thresholds::misfit && !t.focused, t.statistic);
  };
  return *std::max_element(tests.begin(), tests.end(),
                           [&](const ResidualTest& a, const ResidualTest& b) { return rank(a) < rank(b); });
}

std::vector<ResidualTest> residual_tests(const Problem& problem, const Fit& fitted) {
  std::vector<ResidualTest> tests;
  const std::vector<Linearised> along = linearise_all(problem, fitted.model);
  const Problem predicted = along_predictions(problem, fitted, along);
  const bool noisy = motion_holds_noise(problem, fitted.noise);
  const std::vector<Linearised> driven = noisy ? with_own_along(predicted, fitted, along) : along;
  for (const Where where : {Where::position, Where::time, Where::state, Where::input})
    tests.push_back(test_kind(predicted, fitted, driven, where));
  const ResidualTest over_time = tests[1];
  tests.push_back(test_uneven_noise(problem, fitted, along, strongest(tests)));
  tests.push_back(test_spectral_line(problem, fitted, along));
  tests.back().statistic *= by_commands(problem);
  add_focused(predicted, fitted, driven, tests);
  for (ResidualTest& test : constancy(problem, fitted, along)) {
    // An effect that changes with time has no interval of its own: its errors are largest where those of all are.
    if (test.where == Where::time) test.from = over_time.from, test.to = over_time.to;
    tests.push_back(std::move(test));
  }
  return tests;
}

}  // namespace gripline::diagnose
