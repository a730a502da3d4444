#include "diagnose/inference/constancy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "diagnose/inference/bases.hpp"
#include "diagnose/inference/focused_test.hpp"
#include "diagnose/inference/predicted_motion.hpp"
#include "measured/replay/replay.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// What a member adds to the rates or readings along a trace, its memory included.
Regressor contribution(const Catalogue& catalogue, const ModelSpec& model, std::size_t member, const Trace& trace) {
  const StagedCar with = catalogue.build(model), without = catalogue.build(catalogue.without(model, member));
  Regressor d;
  if (catalogue.candidates()[member].effect->stage() == Stage::reading) {
    d.reading.resize(trace.size() * channels);
    for (std::size_t k = 0; k < trace.size(); ++k) {
      const double* const x = trace.motion.data() + k * channels;
      Reading<double> a{x[0], x[1], x[2], x[3], x[4], x[5]}, b = a;
      with.read(&a, 1, &trace.at[k], nullptr);
      without.read(&b, 1, &trace.at[k], nullptr);
      const double off[channels] = {a.x - b.x, a.y - b.y, a.yaw - b.yaw, a.vx - b.vx, a.vy - b.vy, a.omega - b.omega};
      std::copy_n(off, channels, d.reading.begin() + static_cast<std::ptrdiff_t>(k * channels));
    }
    return d;
  }
  const std::vector<double> high = rates_at_samples(with, trace, simulate_memory(with, trace));
  const std::vector<double> low = rates_at_samples(without, trace, simulate_memory(without, trace));
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) d.rate[k * 3 + c] = high[k * channels + 3 + c] - low[k * channels + 3 + c];
  return d;
}

/// Functions by which a contribution could vary, without a constant: values at every sample of each.
using Variation = std::vector<std::vector<double>>;

/// Legendre polynomials of the log's time.
Variation with_time(const Trace& trace, double end) {
  Variation f(4, std::vector<double>(trace.size()));
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const double x = 2.0 * trace.at[k].t / end - 1.0;
    f[0][k] = x;
    f[1][k] = 0.5 * (3.0 * x * x - 1.0);
    f[2][k] = 0.5 * (5.0 * x * x * x - 3.0 * x);
    f[3][k] = 0.125 * (35.0 * x * x * x * x - 30.0 * x * x + 3.0);
  }
  return f;
}

/// Speed and lateral acceleration, each scaled to mean zero and deviation one, and their squares.
Variation with_driving(const Trace& trace) {
  const std::size_t n = trace.size();
  Variation f(4, std::vector<double>(n));
  for (std::size_t k = 0; k < n; ++k) {
    f[0][k] = trace.motion[k * channels + 3];
    f[1][k] = std::abs(trace.motion[k * channels + 3] * trace.motion[k * channels + 5]);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    double mean = 0.0, square = 0.0;
    for (const double v : f[i]) mean += v / static_cast<double>(n);
    for (const double v : f[i]) square += (v - mean) * (v - mean) / static_cast<double>(n);
    const double scale = std::max(1e-9, std::sqrt(square));
    for (std::size_t k = 0; k < n; ++k) {
      f[i][k] = (f[i][k] - mean) / scale;
      f[i + 2][k] = f[i][k] * f[i][k] - 1.0;
    }
  }
  return f;
}

/// The side to which the car turns, smoothly from -1 (right) to 1 (left).
Variation with_side(const Trace& trace) {
  const std::size_t n = trace.size();
  Variation f(1, std::vector<double>(n));
  double square = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    f[0][k] = trace.motion[k * channels + 3] * trace.motion[k * channels + 5];
    square += f[0][k] * f[0][k] / static_cast<double>(n);
  }
  const double scale = std::max(1e-9, 0.5 * std::sqrt(square));
  for (double& v : f[0]) v = std::tanh(v / scale);
  return f;
}

void add_varied(const Regressor& d, const Variation& variation, std::vector<Regressor>& out) {
  for (const std::vector<double>& f : variation) {
    Regressor varied = d;
    const std::size_t n = f.size();
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t c = 0; c < 3 && !d.rate.empty(); ++c) varied.rate[k * 3 + c] *= f[k];
      for (std::size_t c = 0; c < channels && !d.reading.empty(); ++c) varied.reading[k * channels + c] *= f[k];
    }
    out.push_back(std::move(varied));
  }
}

/// A kind of variation: its functions among those of a member.
struct Kind {
  Where where;
  Index first, count;
};
constexpr Kind by_time{Where::time, 0, 4}, by_driving{Where::state, 4, 4}, by_side{Where::state, 8, 1};
constexpr Index functions = 9;  // of each member

/// The model's own parameters, then for every member its contribution times the functions of each kind.
ScoreSystem variations(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  const double end = end_time(problem);
  return score_system(problem, fitted, along, [&](const Trace& trace, const LinearModel&) {
    std::vector<Regressor> all;
    const Variation time = with_time(trace, end), driving = with_driving(trace), side = with_side(trace);
    for (const std::size_t member : fitted.model.members) {
      const Regressor d = contribution(*problem.catalogue, fitted.model, member, trace);
      add_varied(d, time, all);
      add_varied(d, driving, all);
      add_varied(d, side, all);
    }
    return all;
  });
}

/// variations(), along predicted motion where the smoothed motion holds noise.
ScoreSystem variations_driven(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  if (!motion_holds_noise(problem, fitted.noise)) return variations(problem, fitted, along);
  const Problem predicted = along_predictions(problem, fitted, along);
  return variations(predicted, fitted, with_own_along(predicted, fitted, along));
}

/// The test of some members' variations of one kind.
ResidualTest test_of(const ScoreSystem& system, std::span<const Index> members, const Kind& kind, bool process_noise) {
  std::vector<Index> rows;
  for (Index i = 0; i < system.own_params; ++i) rows.push_back(i);
  for (const Index m : members)
    for (Index f = 0; f < kind.count; ++f) rows.push_back(system.own_params + m * functions + kind.first + f);
  return focused_test(system, rows, kind.where, process_noise);
}

}  // namespace

std::vector<ResidualTest> constancy(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  if (fitted.model.members.empty()) return {};
  const ScoreSystem system = variations_driven(problem, fitted, along);
  std::vector<Index> members(fitted.model.members.size());
  std::iota(members.begin(), members.end(), Index{0});
  const bool process_noise = has_strong_process_noise(problem, fitted.noise);
  return {test_of(system, members, by_time, process_noise), test_of(system, members, by_driving, process_noise),
          test_of(system, members, by_side, process_noise)};
}

std::vector<double> constancy_by_member(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  std::vector<double> statistic;
  if (fitted.model.members.empty()) return statistic;
  const ScoreSystem system = variations_driven(problem, fitted, along);
  const bool process_noise = has_strong_process_noise(problem, fitted.noise);
  for (Index m = 0; m < static_cast<Index>(fitted.model.members.size()); ++m) {
    const std::span<const Index> one(&m, 1);
    statistic.push_back(std::max(test_of(system, one, by_time, process_noise).statistic,
                                 test_of(system, one, by_side, process_noise).statistic));
  }
  return statistic;
}

}  // namespace gripline::diagnose
