#include "diagnose/inference/noise_scoring.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double difference = 1e-3;  // step of differences, in the unknowns' own scales

template <class Measured>
auto& value_in(Measured& m, const NoiseParameter& p) {
  switch (p.kind) {
    case NoiseParameter::Kind::level:
      return m.noise.sensor[p.which];
    case NoiseParameter::Kind::colour:
      return m.noise.colour[p.which];
    case NoiseParameter::Kind::acceleration:
      return m.noise.process[p.which];
    case NoiseParameter::Kind::steady:
      return m.noise.command.steady[p.which];
    case NoiseParameter::Kind::moving:
      return m.noise.command.moving[p.which];
    case NoiseParameter::Kind::bend:
      return m.bend[p.which];
    case NoiseParameter::Kind::parameter:
      return m.model.values[p.which][p.of];
    case NoiseParameter::Kind::time:
      break;
  }
  return m.noise_time;
}

/// Whether another value of it is another linear model.
bool changes_model(const NoiseParameter& p) {
  using enum NoiseParameter::Kind;
  return p.kind == time || p.kind == bend || p.kind == parameter;
}

/// A value after a step: a colour, a bend and a parameter (in its scales) move by an addition, all others by a factor's
/// logarithm.
double after(double value, const NoiseParameter& p, double step) {
  using enum NoiseParameter::Kind;
  return p.kind == colour || p.kind == bend || p.kind == parameter ? value + step * p.scale : value * std::exp(step);
}

/// Step of a difference: of a colour towards white, of all others downwards where a step up would leave the range.
double difference_step(const MeasuredNoise& at, const NoiseParameter& p) {
  const double value = value_of(at, p);
  const bool down = p.kind == NoiseParameter::Kind::colour ? value > 0.0 : after(value, p, difference) > p.most;
  return down ? -difference : difference;
}

/// Whether an unknown stands at an end of its range and would leave it: an acceleration as calm as it may be, and all
/// but colours at the upper end.
bool would_leave(const MeasuredNoise& at, const NoiseParameter& p, double gradient) {
  const double value = value_of(at, p);
  if (gradient > 0.0) return p.kind == NoiseParameter::Kind::acceleration && value <= 1.0001 * p.least;
  return p.kind != NoiseParameter::Kind::colour && value >= p.most;
}

/// The step of Fisher scoring, and the gain that it predicts. What would leave its range is left out of the system.
struct Step {
  VectorXd of;
  double predicted;
};

Step scoring_step(NoiseScores scores, std::span<const NoiseParameter> unknowns, const MeasuredNoise& m) {
  for (std::size_t a = 0; a < unknowns.size(); ++a) {
    const auto i = static_cast<Index>(a);
    if (!would_leave(m, unknowns[a], scores.gradient[i])) continue;
    scores.information.row(i).setZero();
    scores.information.col(i).setZero();
    scores.information(i, i) = 1.0;
    scores.gradient[i] = 0.0;
  }
  const VectorXd step = -scores.information.ldlt().solve(scores.gradient);
  return {step, -0.5 * step.dot(scores.gradient)};
}

}  // namespace

double& value_of(MeasuredNoise& m, const NoiseParameter& p) { return value_in(m, p); }
double value_of(const MeasuredNoise& m, const NoiseParameter& p) { return value_in(m, p); }

void move_by(MeasuredNoise& m, const NoiseParameter& p, double step) {
  double& value = value_of(m, p);
  value = std::clamp(after(value, p, step), p.least, p.most);
  if (p.kind == NoiseParameter::Kind::colour && value == 0.0) value = hardly_coloured;
}

/// Whether the logs as they are linearised do for this noise. With what commands do between samples they do also where
/// nothing of that is unknown, but not the reverse.
bool Innovations::are_along(const MeasuredNoise& m) const {
  const bool commands = m.noise.command != UnknownCommands{};
  return m.noise_time == time_ && m.bend == bend_ && m.model.values == values_ && (commands_ || !commands);
}

const std::vector<Likelihood::Innovation>& Innovations::under(const MeasuredNoise& m) {
  if (!are_along(m)) linearise_all_logs(m);
  rows_.clear();
  FilterOptions options;
  options.innovations = true;
  for (const LinearModel& lm : logs_) {
    const Likelihood l = filter(lm, m.noise, options);
    rows_.insert(rows_.end(), l.innovations.begin(), l.innovations.end());
  }
  return rows_;
}

void Innovations::linearise_all_logs(const MeasuredNoise& m) {
  time_ = m.noise_time;
  bend_ = m.bend;
  values_ = m.model.values;
  commands_ = m.noise.command != UnknownCommands{};
  const StagedCar car = problem_.catalogue->build(m.model);
  logs_.clear();
  const Stepping stepping{problem_.substeps, m.noise_time, commands_};
  std::size_t left = thresholds::noise_samples;
  for (const Trace& trace : problem_.traces) {
    if (left < 2) break;
    if (bend_ == problem_.bend) {
      logs_.push_back(linearise(car, trace, stepping));
    } else {
      Trace bent = trace;
      bent.bend_commands(bend_);
      logs_.push_back(linearise(car, bent, stepping));
    }
    logs_.back().n = std::min(logs_.back().n, left);
    left -= logs_.back().n;
  }
}

double cost_of(std::span<const Likelihood::Innovation> rows) {
  double sum = 0.0;
  for (const auto& row : rows) sum += 0.5 * (row.error * row.error / row.variance + std::log(row.variance));
  return sum;
}

NoiseScores scores_at(Innovations& innovations, const MeasuredNoise& at, std::span<const NoiseParameter> unknowns) {
  const std::vector<Likelihood::Innovation> base = innovations.under(at);
  const auto n = static_cast<Index>(unknowns.size()), rows = static_cast<Index>(base.size());
  MatrixXd dS(rows, n), de(rows, n);  // over S, and over its root
  VectorXd excess(rows), ratio(rows);
  // Those along the same motion first: a model is linearised once less.
  std::vector<Index> order(unknowns.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_partition(order.begin(), order.end(),
                        [&](Index a) { return !changes_model(unknowns[static_cast<std::size_t>(a)]); });
  for (const Index a : order) {
    MeasuredNoise perturbed = at;
    const NoiseParameter& p = unknowns[static_cast<std::size_t>(a)];
    const double step = difference_step(at, p);
    move_by(perturbed, p, step);
    const auto& other = innovations.under(perturbed);
    for (Index r = 0; r < rows; ++r) {
      const auto& x = base[static_cast<std::size_t>(r)];
      const auto& y = other[static_cast<std::size_t>(r)];
      dS(r, a) = (y.variance - x.variance) / (step * x.variance);
      de(r, a) = (y.error - x.error) / (step * std::sqrt(x.variance));
    }
  }
  for (Index r = 0; r < rows; ++r) {
    const auto& x = base[static_cast<std::size_t>(r)];
    ratio[r] = x.error / std::sqrt(x.variance);
    excess[r] = 0.5 * (1.0 - ratio[r] * ratio[r]);
  }
  return {dS.transpose() * excess + de.transpose() * ratio, 0.5 * dS.transpose() * dS + de.transpose() * de};
}

MatrixXd fit_noise(Innovations& innovations, std::span<const NoiseParameter> unknowns, MeasuredNoise& m) {
  const auto n = static_cast<Index>(unknowns.size());
  double cost = cost_of(innovations.under(m));
  NoiseScores scores;
  for (int iteration = 0; iteration < thresholds::noise_iterations; ++iteration) {
    scores = scores_at(innovations, m, unknowns);
    scores.information.diagonal() = scores.information.diagonal() * (1.0 + 1e-9) + VectorXd::Constant(n, 1e-6);
    const auto [step, predicted] = scoring_step(scores, unknowns, m);
    double reached = cost;
    MeasuredNoise trial = m;
    for (const double part : {1.0, 0.4, 0.4 * 0.4}) {
      trial = m;
      for (std::size_t a = 0; a < unknowns.size(); ++a) {
        const double longest = unknowns[a].longest_step;
        move_by(trial, unknowns[a], part * std::clamp(step[static_cast<Index>(a)], -longest, longest));
      }
      reached = cost_of(innovations.under(trial));
      if (reached < cost) break;
    }
    if (!(reached < cost)) break;
    m = trial;
    const double won = cost - reached;
    cost = reached;
    if (won < thresholds::noise_converged && predicted < 2.0 * thresholds::noise_converged) break;
  }
  return scores.information;
}

}  // namespace gripline::diagnose
