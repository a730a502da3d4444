#include "diagnose/inference/adequacy.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "diagnose/inference/constancy.hpp"
#include "diagnose/inference/score_test.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t place_knots = 24;
constexpr double time_spacing = 2.0;  // between knots [s]

double cubic_spline(double x) {
  const double z = std::abs(x);
  if (z < 1.0) return (4.0 - 6.0 * z * z + 3.0 * z * z * z) / 6.0;
  if (z < 2.0) return (2.0 - z) * (2.0 - z) * (2.0 - z) / 6.0;
  return 0.0;
}

/// Values of one basis at every sample of one trace: n x functions.
struct Basis {
  std::size_t functions = 0;
  std::vector<double> value;
};

Basis place_basis(const Trace& trace) {
  Basis b{place_knots, std::vector<double>(trace.size() * place_knots)};
  const auto knots = static_cast<double>(place_knots);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t i = 0; i < place_knots; ++i) {
      const double x = knots * trace.at[k].lap_fraction - static_cast<double>(i);
      b.value[k * place_knots + i] = cubic_spline(x - knots * std::round(x / knots));
    }
  return b;
}

std::size_t time_knots(const Problem& problem) {
  double end = 0.0;
  for (const Trace& t : problem.traces) end = std::max(end, t.at.back().t);
  return static_cast<std::size_t>(std::clamp(end / time_spacing, 4.0, 40.0)) + 1;
}

Basis time_basis(const Trace& trace, std::size_t knots, double end) {
  Basis b{knots, std::vector<double>(trace.size() * knots)};
  const double spacing = end / static_cast<double>(knots - 1);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t i = 0; i < knots; ++i)
      b.value[k * knots + i] = cubic_spline(trace.at[k].t / spacing - static_cast<double>(i));
  return b;
}

/// Scale of a signal: its root mean square, so that features bend where the car drives.
double typical(const std::vector<double>& signal) {
  double sum = 0.0;
  for (const double v : signal) sum += v * v;
  return std::max(1e-9, std::sqrt(sum / static_cast<double>(signal.size())));
}

struct Signals {
  std::vector<double> vx, vy, omega, d, delta, d_rate, delta_rate;
};
Signals signals(const Trace& trace) {
  Signals s;
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const double* const row = trace.motion.data() + k * channels;
    s.vx.push_back(row[3]);
    s.vy.push_back(row[4]);
    s.omega.push_back(row[5]);
    const auto c = trace.command(k, 0.0);
    const auto before = trace.command(k == 0 ? 0 : k - 1, 0.0);
    s.d.push_back(c.d);
    s.delta.push_back(c.delta);
    s.d_rate.push_back((c.d - before.d) / trace.log.dt);
    s.delta_rate.push_back((c.delta - before.delta) / trace.log.dt);
  }
  return s;
}

/// Features of scaled signals: each alone, bent, squared, and in pairs.
Basis feature_basis(const std::vector<const std::vector<double>*>& of) {
  const std::size_t n = of.front()->size();
  const std::size_t m = of.size();
  std::vector<std::vector<double>> scaled;
  for (const auto* signal : of) {
    double mean = 0.0;
    const bool positive = std::all_of(signal->begin(), signal->end(), [](double v) { return v > 0.0; });
    if (positive)  // a speed: what matters is how far it is from its mean
      for (const double v : *signal) mean += v / static_cast<double>(n);
    std::vector<double> z(n);
    for (std::size_t k = 0; k < n; ++k) z[k] = (*signal)[k] - mean;
    const double scale = typical(z);
    for (double& v : z) v /= scale;
    scaled.push_back(std::move(z));
  }
  std::vector<std::function<double(std::size_t)>> f;
  for (std::size_t i = 0; i < m; ++i) {
    const std::vector<double>& z = scaled[i];
    f.push_back([&z](std::size_t k) { return z[k]; });
    f.push_back([&z](std::size_t k) { return std::abs(z[k]); });
    f.push_back([&z](std::size_t k) { return z[k] * std::abs(z[k]); });
    f.push_back([&z](std::size_t k) { return std::tanh(4.0 * z[k]); });
    f.push_back([&z](std::size_t k) { return z[k] * z[k] * z[k]; });
    for (std::size_t j = i + 1; j < m; ++j) {
      const std::vector<double>& w = scaled[j];
      f.push_back([&z, &w](std::size_t k) { return z[k] * w[k]; });
      f.push_back([&z, &w](std::size_t k) { return z[k] * std::abs(w[k]); });
      f.push_back([&z, &w](std::size_t k) { return std::abs(z[k]) * w[k]; });
    }
  }
  Basis b{f.size(), std::vector<double>(n * f.size())};
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < f.size(); ++i) b.value[k * f.size() + i] = f[i](k);
  return b;
}

std::vector<Direction> accelerations(const Basis& basis, std::size_t n) {
  std::vector<Direction> directions;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < basis.functions; ++i) {
      Direction d;
      d.rate.assign(n * 3, 0.0);
      for (std::size_t k = 0; k < n; ++k) d.rate[k * 3 + c] = basis.value[k * basis.functions + i];
      directions.push_back(std::move(d));
    }
  return directions;
}

/// Evidence near each knot by itself: the three accelerations there, nothing else. Neighbours share some of it, but no
/// function can hide behind another's opposite. The stretch around the strongest knot that keeps above a third of it.
void locate(const Score& s, Index knots, const std::function<double(double)>& knot_value, bool periodic,
            BasisTest& test) {
  std::vector<double> gain(static_cast<std::size_t>(knots), 0.0);
  std::vector<Eigen::Vector3d> step(static_cast<std::size_t>(knots), Eigen::Vector3d::Zero());
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
    gain[static_cast<std::size_t>(i)] = std::max(0.0, 0.5 * scaled.dot(found));
    step[static_cast<std::size_t>(i)] = size.cwiseInverse().asDiagonal() * found;
  }
  const auto peak = static_cast<Index>(std::max_element(gain.begin(), gain.end()) - gain.begin());
  const auto at = [&](Index i) -> double {
    if (periodic) i = (i % knots + knots) % knots;
    return i >= 0 && i < knots ? gain[static_cast<std::size_t>(i)] : 0.0;
  };
  Index from = peak, to = peak;
  while (peak - from < knots / 3 && at(from - 1) > at(peak) / 3.0) --from;
  while (to - peak < knots / 3 && at(to + 1) > at(peak) / 3.0) ++to;
  double sum = 0.0, centre = 0.0;
  for (Index i = from - 1; i <= to + 1; ++i) {
    sum += at(i);
    centre += at(i) * static_cast<double>(i);
  }
  centre /= sum;
  const double half = 0.5 * static_cast<double>(to - from + 1);
  test.from = knot_value(centre - half);
  test.to = knot_value(centre + half);
  for (std::size_t c = 0; c < 3; ++c) test.size[c] = step[static_cast<std::size_t>(peak)][static_cast<Index>(c)];
}

}  // namespace

namespace {

double end_time(const Problem& problem) {
  double end = 0.0;
  for (const Trace& t : problem.traces) end = std::max(end, t.at.back().t);
  return end;
}

/// A cosine and a sine in time.
Basis wave(const Trace& trace, double frequency) {
  Basis b{2, std::vector<double>(trace.size() * 2)};
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const double turn = 2.0 * std::numbers::pi * frequency * trace.at[k].t;
    b.value[2 * k] = std::cos(turn);
    b.value[2 * k + 1] = std::sin(turn);
  }
  return b;
}

/// The basis of one kind.
Basis basis_of(const Problem& problem, const Trace& trace, Where where) {
  if (where == Where::position) return place_basis(trace);
  if (where == Where::time) return time_basis(trace, time_knots(problem), end_time(problem));
  const Signals s = signals(trace);
  if (where == Where::state) return feature_basis({&s.vx, &s.vy, &s.omega});
  return feature_basis({&s.d, &s.delta, &s.delta_rate, &s.d_rate});
}

using BasisOf = std::function<Basis(const Trace&)>;
ScoreSystem basis_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const BasisOf& basis_of) {
  return score_system(problem, fitted, along, [&](const Trace& trace, const LinearModel&) {
    return accelerations(basis_of(trace), trace.size());
  });
}

constexpr double highest = 3.0;  // frequency of a spectral line [Hz]; what is quicker moves no car

/// Periodogram of one unknown acceleration as the smoother saw it, tapered by a cosine (von Hann) so that slow parts do
/// not leak into quick ones: one ordinate per 1 / T.
std::vector<double> periodogram(const Likelihood& l, std::size_t states, std::size_t channel, double dt) {
  const std::size_t n = l.smoothed.size() / states;
  const auto bins = static_cast<std::size_t>(highest * dt * static_cast<double>(n));
  std::vector<double> power;
  for (std::size_t j = 1; j <= bins; ++j) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n);
    double re = 0.0, im = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double at = static_cast<double>(k);
      const double taper = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (at + 0.5) / static_cast<double>(n));
      const double y = taper * l.smoothed[k * states + states - noise_states + channel];
      re += y * std::cos(turn * at);
      im += y * std::sin(turn * at);
    }
    power.push_back(re * re + im * im);
  }
  return power;
}

/// Where in a spectrum a line stands out most: frequency, and minus the log of the chance that it does so by accident.
struct Line {
  double frequency = 0, gain = 0;
};
Line strongest_line(const std::vector<double>& power, double seconds) {
  constexpr std::ptrdiff_t reach = 16, own = 3;
  Line line;
  const auto bins = static_cast<std::ptrdiff_t>(power.size());
  std::vector<double> around;
  for (std::ptrdiff_t j = 0; bins >= 3 * reach && j < bins; ++j) {
    around.clear();
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, j - reach); i <= std::min(bins - 1, j + reach); ++i)
      if (std::abs(i - j) >= own) around.push_back(power[static_cast<std::size_t>(i)]);
    const double middle = upper_median(around);
    // Ordinates scatter exponentially about a smooth spectrum; the median of an exponential is log 2 of its mean.
    const double gain = middle > 0.0 ? std::numbers::ln2 * power[static_cast<std::size_t>(j)] / middle : 0.0;
    if (gain > line.gain) line = {static_cast<double>(j + 1) / seconds, gain};
  }
  return line;
}

/// A spectral line in what is left. A filter free to call anything random explains a steady oscillation by more noise; but an
/// oscillation is a line that stands out of the spectrum, and once its frequency is known the likelihood says whether
/// it is there.
BasisTest spectral_line(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  BasisTest test;
  test.where = Where::time;
  test.quantity = "frequency";
  double chances = 0.0;
  Line best;
  for (const auto& [lm, own, work] : along) {
    FilterWants wants;
    wants.smooth = true;
    const Likelihood l = filter(lm, fitted.noise, wants);
    for (std::size_t c = 0; c < noise_states; ++c) {
      const std::vector<double> power = periodogram(l, lm.states, c, lm.dt);
      chances += static_cast<double>(power.size());
      const Line line = strongest_line(power, static_cast<double>(lm.n) * lm.dt);
      if (line.gain > best.gain) best = line;
    }
  }
  // Most spectra have no such line, and then there is nothing to ask.
  if (chances == 0.0 || best.gain < std::log(chances) + 2.0) return test;
  const ScoreSystem system =
      basis_system(problem, fitted, along, [&](const Trace& trace) { return wave(trace, best.frequency); });
  const Score s = score_test(system.normal.N, system.normal.g, system.own);
  test.gain = s.gain;
  test.dof = s.dof;
  test.from = test.to = best.frequency;
  // The frequency was chosen among many; 4 stands for about one chance in thousands, as with the others.
  // On a rough road the spectrum that the frequency was read from is mostly the road's own: half of that.
  const double share = rough_road(problem, fitted.noise) ? 0.25 : 0.5;
  test.excess = share * (s.gain - 0.5 * static_cast<double>(s.dof) - std::log(chances));
  return test;
}

/// The shapes that most effects of a car have, few enough that a small remainder of such a shape is not lost among
/// dozens of functions: of speed and throttle along the car, of slip, turning and steering across it.
constexpr std::size_t along_functions = 8, across_functions = 9;
Basis simple_basis(const Trace& trace) {
  constexpr std::size_t functions = along_functions + across_functions;
  Basis b{functions, std::vector<double>(trace.size() * functions)};
  const Signals s = signals(trace);
  const double v = typical(s.vx), w = typical(s.omega), vy = typical(s.vy), delta = typical(s.delta);
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const double u = s.vx[k] / v, d = s.d[k], turn = s.omega[k] / w, slide = s.vy[k] / vy, steer = s.delta[k] / delta;
    const double row[functions] = {1.0,
                                   u,
                                   u * u,
                                   d,
                                   std::abs(d),
                                   d * u,
                                   d * std::abs(d),
                                   turn * turn,
                                   1.0,
                                   slide,
                                   turn,
                                   steer,
                                   u * turn,
                                   u * steer,
                                   turn * std::abs(turn),
                                   std::tanh(4.0 * turn),
                                   steer * std::abs(steer)};
    std::copy_n(row, functions, b.value.begin() + static_cast<std::ptrdiff_t>(k * functions));
  }
  return b;
}

/// Whether an acceleration other than this one is random: what a model lacks is mostly seen as noise in one of them.
bool rough_beside(const Problem& problem, const Fit& fitted, std::size_t channel) {
  const std::array<double, noise_states> rough = roughness(problem, fitted.noise);
  for (std::size_t c = 0; c < noise_states; ++c)
    if (c != channel && rough[c] > 0.1) return true;
  return false;
}

/// One test per acceleration, each with its own few functions.
void add_focused(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                 std::vector<BasisTest>& tests) {
  const ScoreSystem system = basis_system(problem, fitted, along, simple_basis);
  constexpr std::size_t functions = along_functions + across_functions;
  for (std::size_t channel = 0; channel < noise_states; ++channel) {
    std::vector<Index> rows;
    for (Index i = 0; i < system.own; ++i) rows.push_back(i);
    const std::size_t first = channel == 0 ? 0 : along_functions;
    const std::size_t last = channel == 0 ? along_functions : functions;
    for (std::size_t f = first; f < last; ++f) rows.push_back(system.own + static_cast<Index>(channel * functions + f));
    const Score s = score_test(system.normal.N(rows, rows), system.normal.g(rows), system.own);
    BasisTest test;
    test.where = Where::state;
    test.focused = true;
    test.gain = s.gain;
    test.dof = s.dof;
    // 3.5 standard deviations of a normal are as rare as 4 of the other tests' statistic. Where another acceleration is
    // random too, twice that: the functions are evaluated along a reference that carries the same
    // randomness, and the statistic is no chi-square any more.
    const double rare = rough_beside(problem, fitted, channel) ? 7.0 : 3.5;
    if (s.dof > 0) test.excess = structured / rare * as_normal(2.0 * s.gain, static_cast<double>(s.dof));
    tests.push_back(std::move(test));
  }
}

/// A road shakes a car in all directions. Random accelerations in some of them only (from a tenth of their usual size)
/// are what a model lacks, called random by a filter that is free to: they count by how sure it is of them, and of another
/// one's being less than a third of that. What kind of thing it is the other tests tell better, also where they are not
/// sure.
BasisTest uneven_noise(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                       const BasisTest& kind) {
  BasisTest test;
  test.where = kind.where;
  test.quantity = "noise";
  test.dof = noise_states;
  test.focused = true;
  const std::array<double, noise_states> rough = roughness(problem, fitted.noise);
  const double most = std::ranges::max(rough), even = most / 3.0;
  if (most < 0.1 || std::ranges::min(rough) > even) return test;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Linearised& one : along) {
    FilterWants wants;
    wants.process_slope = true;
    const Likelihood l = filter(one.lm, fitted.noise, wants);
    for (std::size_t i = 0; i < noise_states; ++i)
      for (std::size_t j = 0; j < noise_states; ++j)
        information(static_cast<Index>(i), static_cast<Index>(j)) += l.information[i][j];
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
  test.excess = std::min(random, calm);
  return test;
}

}  // namespace

const BasisTest& strongest(std::span<const BasisTest> tests) {
  const auto rank = [](const BasisTest& t) { return std::pair(t.excess > structured && !t.focused, t.excess); };
  return *std::max_element(tests.begin(), tests.end(),
                           [&](const BasisTest& a, const BasisTest& b) { return rank(a) < rank(b); });
}

std::vector<BasisTest> remainder(const Problem& problem, const Fit& fitted) {
  std::vector<BasisTest> tests;
  const std::vector<Linearised> along = linearise_all(problem, fitted.model);
  for (const Where where : {Where::position, Where::time, Where::state, Where::input}) {
    const ScoreSystem system =
        basis_system(problem, fitted, along, [&](const Trace& trace) { return basis_of(problem, trace, where); });
    const Score s = score_test(system.normal.N, system.normal.g, system.own);
    BasisTest test;
    test.where = where;
    test.gain = s.gain;
    test.dof = s.dof;
    const auto dof = static_cast<double>(std::max<std::size_t>(1, s.dof));
    test.excess = (2.0 * s.gain - dof) / std::sqrt(2.0 * dof);
    if (where == Where::position)
      locate(
          s, place_knots, [](double x) { return x / static_cast<double>(place_knots); }, true, test);
    if (where == Where::time) {
      const double end = end_time(problem);
      const double spacing = end / static_cast<double>(time_knots(problem) - 1);
      locate(
          s, static_cast<Index>(time_knots(problem)), [&](double x) { return std::clamp(x * spacing, 0.0, end); },
          false, test);
    }
    tests.push_back(std::move(test));
  }
  tests.push_back(uneven_noise(problem, fitted, along, strongest(tests)));
  tests.push_back(spectral_line(problem, fitted, along));
  add_focused(problem, fitted, along, tests);
  for (BasisTest& test : constancy(problem, fitted, along)) tests.push_back(std::move(test));
  return tests;
}

std::vector<double> support_beside(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                                   Where where) {
  const Catalogue& catalogue = *problem.catalogue;
  const ScoreSystem system =
      basis_system(problem, fitted, along, [&](const Trace& trace) { return basis_of(problem, trace, where); });
  const Index own = system.own, count = system.normal.g.size() - own;
  // Information on the own parameters once the basis may explain what it can, pseudo-inverted for safety.
  const MatrixXd cross = system.normal.N.topRightCorner(own, count);
  VectorXd size = system.normal.N.diagonal().tail(count).cwiseSqrt();
  for (Index i = 0; i < count; ++i)
    if (!(size[i] > 0.0)) size[i] = 1e-300;
  const MatrixXd unit = size.cwiseInverse().asDiagonal() * system.normal.N.bottomRightCorner(count, count) *
                        size.cwiseInverse().asDiagonal();
  const MatrixXd regular = unit + 1e-6 * MatrixXd::Identity(count, count);
  const MatrixXd scaled = cross * size.cwiseInverse().asDiagonal();
  const MatrixXd information =
      system.normal.N.topLeftCorner(own, own) - scaled * regular.ldlt().solve(scaled.transpose());
  const auto nuisances = static_cast<Index>(catalogue.nuisances().size());
  std::vector<double> support;
  Index at = nuisances;
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[fitted.model.members[i]];
    const auto p = static_cast<Index>(c.fitted.size());
    // Conditional on the others' values: generous to the effect.
    MatrixXd block = information.block(at, at, p, p);
    if (nuisances > 0) {
      const MatrixXd to = information.block(0, at, nuisances, p);
      block -= to.transpose() * information.topLeftCorner(nuisances, nuisances).ldlt().solve(to);
    }
    VectorXd off(p);
    for (Index f = 0; f < p; ++f) {
      const abi::ParamDecl& decl = c.decl(static_cast<std::size_t>(f));
      off[f] = fitted.model.values[i][c.fitted[static_cast<std::size_t>(f)]] - decl.neutral;
    }
    support.push_back(0.5 * off.dot(block * off) - problem.charge(static_cast<std::size_t>(p)));
    at += p;
  }
  return support;
}

}  // namespace gripline::diagnose
