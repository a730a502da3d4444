#include "diagnose/inference/bases.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gripline::diagnose {
namespace {

double cubic_spline(double x) {
  const double z = std::abs(x);
  if (z < 1.0) return (4.0 - 6.0 * z * z + 3.0 * z * z * z) / 6.0;
  if (z < 2.0) return (2.0 - z) * (2.0 - z) * (2.0 - z) / 6.0;
  return 0.0;
}

Basis place_basis(const Trace& trace) {
  Basis b{thresholds::place_knots, std::vector<double>(trace.size() * thresholds::place_knots)};
  const auto knots = static_cast<double>(thresholds::place_knots);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t i = 0; i < thresholds::place_knots; ++i) {
      const double x = knots * trace.at[k].lap_fraction - static_cast<double>(i);
      b.value[k * thresholds::place_knots + i] = cubic_spline(x - knots * std::round(x / knots));
    }
  return b;
}

Basis time_basis(const Trace& trace, std::size_t knots, double end) {
  Basis b{knots, std::vector<double>(trace.size() * knots)};
  const double spacing = end / static_cast<double>(knots - 1);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t i = 0; i < knots; ++i)
      b.value[k * knots + i] = cubic_spline(trace.at[k].t / spacing - static_cast<double>(i));
  return b;
}

/// Root mean square: scaled by it, features bend where the car drives.
double typical(const std::vector<double>& signal) {
  double sum = 0.0;
  for (const double v : signal) sum += v * v;
  return std::max(1e-9, std::sqrt(sum / static_cast<double>(signal.size())));
}

/// Speeds, commands and their rates at every sample.
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
    const auto c = trace.command(k);
    const auto before = trace.command(k == 0 ? 0 : k - 1);
    s.d.push_back(c.d);
    s.delta.push_back(c.delta);
    s.d_rate.push_back((c.d - before.d) / trace.log.dt);
    s.delta_rate.push_back((c.delta - before.delta) / trace.log.dt);
  }
  return s;
}

/// A function of one or two scaled signals.
struct Feature {
  double (*function)(double z, double w);
  std::size_t first, second;
};

/// Each signal alone, bent and squared, and products of pairs.
std::vector<Feature> features(std::size_t signals) {
  std::vector<Feature> all;
  for (std::size_t i = 0; i < signals; ++i) {
    all.push_back({[](double z, double) { return z; }, i, i});
    all.push_back({[](double z, double) { return std::abs(z); }, i, i});
    all.push_back({[](double z, double) { return z * std::abs(z); }, i, i});
    all.push_back({[](double z, double) { return std::tanh(4.0 * z); }, i, i});
    all.push_back({[](double z, double) { return z * z * z; }, i, i});
    for (std::size_t j = i + 1; j < signals; ++j) {
      all.push_back({[](double z, double w) { return z * w; }, i, j});
      all.push_back({[](double z, double w) { return z * std::abs(w); }, i, j});
      all.push_back({[](double z, double w) { return std::abs(z) * w; }, i, j});
    }
  }
  return all;
}

/// A signal over its root mean square; one that is always positive (a speed) less its mean.
std::vector<double> scaled(const std::vector<double>& signal) {
  const std::size_t n = signal.size();
  double mean = 0.0;
  if (std::all_of(signal.begin(), signal.end(), [](double v) { return v > 0.0; }))
    for (const double v : signal) mean += v / static_cast<double>(n);
  std::vector<double> z(n);
  for (std::size_t k = 0; k < n; ++k) z[k] = signal[k] - mean;
  const double scale = typical(z);
  for (double& v : z) v /= scale;
  return z;
}

Basis feature_basis(const std::vector<const std::vector<double>*>& of) {
  const std::size_t n = of.front()->size();
  std::vector<std::vector<double>> z;
  for (const auto* signal : of) z.push_back(scaled(*signal));
  const std::vector<Feature> f = features(of.size());
  Basis b{f.size(), std::vector<double>(n * f.size())};
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < f.size(); ++i)
      b.value[k * f.size() + i] = f[i].function(z[f[i].first][k], z[f[i].second][k]);
  return b;
}

}  // namespace

double end_time(const Problem& problem) {
  double end = 0.0;
  for (const Trace& t : problem.traces) end = std::max(end, t.at.back().t);
  return end;
}

std::size_t time_knots(const Problem& problem) {
  return static_cast<std::size_t>(std::clamp(end_time(problem) / thresholds::time_spacing, thresholds::least_time_knots,
                                             thresholds::most_time_knots)) +
         1;
}

Basis wave(const Trace& trace, double frequency) {
  Basis b{2, std::vector<double>(trace.size() * 2)};
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const double turn = 2.0 * std::numbers::pi * frequency * trace.at[k].t;
    b.value[2 * k] = std::cos(turn);
    b.value[2 * k + 1] = std::sin(turn);
  }
  return b;
}

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

Basis basis_of(const Problem& problem, const Trace& trace, Where where) {
  if (where == Where::position) return place_basis(trace);
  if (where == Where::time) return time_basis(trace, time_knots(problem), end_time(problem));
  const Signals s = signals(trace);
  if (where == Where::state) return feature_basis({&s.vx, &s.vy, &s.omega});
  return feature_basis({&s.d, &s.delta, &s.delta_rate, &s.d_rate});
}

std::vector<Regressor> accelerations(const Basis& basis, std::size_t samples) {
  std::vector<Regressor> regressors;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < basis.functions; ++i) {
      Regressor d;
      d.rate.assign(samples * 3, 0.0);
      for (std::size_t k = 0; k < samples; ++k) d.rate[k * 3 + c] = basis.value[k * basis.functions + i];
      regressors.push_back(std::move(d));
    }
  return regressors;
}

ScoreSystem basis_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const BasisOf& basis) {
  return score_system(problem, fitted, along, [&](const Trace& trace, const LinearModel&) {
    return accelerations(basis(trace), trace.size());
  });
}

}  // namespace gripline::diagnose
