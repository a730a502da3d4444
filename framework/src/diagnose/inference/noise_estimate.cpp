#include "diagnose/inference/noise_estimate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/inference/newton_step.hpp"
#include "diagnose/inference/noise_scoring.hpp"
#include "measured/log/log_noise.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The noise that a problem and a fit assume.
MeasuredNoise assumed_noise(const Problem& problem, const Fit& fitted) {
  return {.noise = fitted.noise, .noise_time = problem.noise_time, .bend = problem.bend, .model = fitted.model};
}

bool is_of_commands(const NoiseParameter& p) {
  return p.kind == NoiseParameter::Kind::steady || p.kind == NoiseParameter::Kind::moving;
}

/// Whether something is left unknown of a command between samples.
bool is_unknown_command(const NoiseParameter& p, const MeasuredNoise& m) {
  return is_of_commands(p) && value_of(m, p) > 1.01 * p.least;
}

std::vector<Log> logs_of(const Problem& problem) {
  std::vector<Log> logs;
  for (const Trace& trace : problem.traces) logs.push_back(trace.log);
  return logs;
}

/// The scatter of the sensors from sample to sample: the least that their noise can be, whatever is assumed of it.
Channels white_levels(const Problem& problem) {
  const Channels seen = measured::estimate_noise(logs_of(problem));
  Channels level = problem.sensor;
  for (std::size_t c = 0; c < channels; ++c)
    if (problem.colour[c] != 0.0 && seen[c] > 0.0) level[c] = std::min(level[c], seen[c]);
  return level;
}

/// The parameters of a model's effects but of shapes along the lap, which have many and imitate no bend.
void add_parameters(const Problem& problem, const ModelSpec& model, std::vector<NoiseParameter>& list) {
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = problem.catalogue->candidates()[model.members[i]];
    if (c.fitted.size() > thresholds::full_penalty_parameters) continue;
    for (std::size_t f = 0; f < c.fitted.size(); ++f) {
      const abi::ParamDecl& decl = c.decl(f);
      list.push_back({.kind = NoiseParameter::Kind::parameter,
                      .which = i,
                      .least = decl.lo,
                      .most = decl.hi,
                      .of = c.fitted[f],
                      .scale = decl.scale});
    }
  }
}

/// What is measured of the noise.
struct NoiseParameterList {
  std::vector<NoiseParameter> noise;
  std::vector<NoiseParameter> beside_bends;  // matter only where commands are unknown: bends, and what these change
  std::vector<NoiseParameter> all() const {
    std::vector<NoiseParameter> both = noise;
    both.insert(both.end(), beside_bends.begin(), beside_bends.end());
    return both;
  }
};

/// What is unknown of commands between samples, and their bends.
void add_commands(const Problem& problem, NoiseParameterList& list) {
  using enum NoiseParameter::Kind;
  const Commands curvature = measured::command_curvature(logs_of(problem));
  for (const NoiseParameter::Kind kind : {steady, moving})
    for (std::size_t i = 0; i < curvature.size(); ++i) {
      if (!(curvature[i] > 0.0)) continue;
      const double most = thresholds::most_command * (kind == steady ? curvature[i] : 1.0);
      list.noise.push_back({.kind = kind, .which = i, .least = thresholds::least_command * most, .most = most});
    }
  for (std::size_t i = 0; !problem.hold().until_next && i < curvature.size(); ++i)
    if (curvature[i] > 0.0)
      list.beside_bends.push_back({.kind = bend,
                                   .which = i,
                                   .longest_step = 0.1,
                                   .least = -thresholds::most_bend,
                                   .most = thresholds::most_bend});
}

NoiseParameterList list_unknowns(const Problem& problem, const ModelSpec& model, const NoiseEstimateOptions& options) {
  NoiseParameterList list;
  const Channels scatter = white_levels(problem);
  using enum NoiseParameter::Kind;
  const auto level_of = [&](std::size_t c) {
    return NoiseParameter{.kind = level, .which = c, .least = thresholds::least_level * scatter[c]};
  };
  for (std::size_t c = 0; options.sensors && c < channels; ++c) {
    if (!problem.is_read(c)) continue;
    list.noise.push_back(level_of(c));
    list.noise.push_back({.kind = colour,
                          .which = c,
                          .longest_step = 0.4,
                          .least = -thresholds::most_colour,
                          .most = thresholds::most_colour});
  }
  for (std::size_t i = 0; i < noise_states; ++i)
    list.noise.push_back({.kind = acceleration, .which = i, .longest_step = 2.0, .least = least_variance(problem, i)});
  if (options.correlation_time)
    list.noise.push_back(
        {.kind = time, .least = thresholds::shortest_noise_time, .most = thresholds::longest_noise_time});
  if (!options.commands) return list;
  add_commands(problem, list);
  // Without bends to find, what follows is noise like the rest.
  std::vector<NoiseParameter>& rest = list.beside_bends.empty() ? list.noise : list.beside_bends;
  // What commands do between samples scatters readings, and was taken for the sensors'.
  for (std::size_t c = 0; !options.sensors && c < channels; ++c)
    if (problem.is_read(c)) rest.push_back(level_of(c));
  if (!problem.hold().until_next) add_parameters(problem, model, rest);
  return list;
}

/// Scatter that noise of this level and colour shows in fourth differences, as measured::estimate_noise has it for
/// white noise: their autocovariance weights the autocorrelations.
double scatter_of(double level, double rho) {
  const double share = (70.0 + rho * (-112.0 + rho * (56.0 + rho * (-16.0 + rho * 2.0)))) / 70.0;
  return level * std::sqrt(std::max(0.0, share));
}

/// Takes back the noise of channels that claim more of it than the scatter from sample to sample allows: what is slow
/// without that scatter is a missing effect, not noise of a sensor.
void keep_credible(const Problem& problem, MeasuredNoise& m) {
  const Channels seen = measured::estimate_noise(logs_of(problem));
  for (std::size_t c = 0; c < channels; ++c) {
    if (scatter_of(m.noise.sensor[c], m.noise.colour[c]) < thresholds::most_scatter * seen[c]) continue;
    m.noise.sensor[c] = problem.sensor[c];
    m.noise.colour[c] = problem.colour[c];
  }
}

/// Takes back colours that are not significant.
void forget_faint_colours(std::span<const NoiseParameter> unknowns, const MatrixXd& covariance, MeasuredNoise& m) {
  for (std::size_t a = 0; a < unknowns.size(); ++a) {
    const NoiseParameter& p = unknowns[a];
    if (p.kind != NoiseParameter::Kind::colour) continue;
    const auto i = static_cast<Index>(a);
    double& rho = m.noise.colour[p.which];
    const bool significant =
        std::abs(rho) > thresholds::significant_colour * std::sqrt(std::max(0.0, covariance(i, i)));
    if (!significant || std::abs(rho) < thresholds::least_colour) rho = 0.0;
  }
}

/// Takes back what the log does not ask for of commands between samples: noise without which it is hardly less likely,
/// bends that are not significant, and those at an end of their range, which are an effect's.
void forget_undetermined(std::span<const NoiseParameter> unknowns, const MatrixXd& covariance, Innovations& innovations,
                         MeasuredNoise& m) {
  double cost = cost_of(innovations.under(m));
  for (std::size_t a = 0; a < unknowns.size(); ++a) {
    const NoiseParameter& p = unknowns[a];
    MeasuredNoise without = m;
    if (is_of_commands(p)) {
      value_of(without, p) = 0.0;
      const double less = cost_of(innovations.under(without));
      if (is_unknown_command(p, m) && less > cost + thresholds::significant_colour) continue;
      m = without;
      cost = less;
    } else if (p.kind == NoiseParameter::Kind::bend) {
      const auto i = static_cast<Index>(a);
      const double sigma = i < covariance.rows() ? std::sqrt(std::max(0.0, covariance(i, i))) : 1.0;
      const double size = std::abs(value_of(m, p));
      if (size < thresholds::significant_colour * sigma || size >= p.most) value_of(m, p) = 0.0;
    }
  }
}

/// White noise of the sensors that were coloured, as large as they scatter from sample to sample.
void whiten(const Problem& problem, Noise& noise) {
  noise.sensor = white_levels(problem);
  noise.colour = {};
}

/// The unknowns that something is left of, with the effects' parameters or without.
std::vector<NoiseParameter> left_of(std::span<const NoiseParameter> unknowns, const MeasuredNoise& m, bool parameters) {
  std::vector<NoiseParameter> left;
  for (const NoiseParameter& p : unknowns)
    if (p.kind == NoiseParameter::Kind::parameter ? parameters : value_of(m, p) != 0.0) left.push_back(p);
  return left;
}

/// Takes back what the log does not ask for and measures the rest of the noise anew where commands lose what mattered.
/// Parameters move with bends only.
void prune_and_refit(const Problem& problem, std::span<const NoiseParameter> unknowns, const MatrixXd& information,
                     Innovations& innovations, MeasuredNoise& m) {
  const MatrixXd covariance = information.ldlt().solve(MatrixXd::Identity(information.rows(), information.cols()));
  forget_faint_colours(unknowns, covariance, m);
  if (std::ranges::none_of(unknowns, is_of_commands)) return;
  const double before = cost_of(innovations.under(m));
  forget_undetermined(unknowns, covariance, innovations, m);
  if (std::abs(cost_of(innovations.under(m)) - before) > thresholds::noise_converged)
    fit_noise(innovations, left_of(unknowns, m, m.bend != problem.bend), m);
}

/// The fit counted all samples, noise only the first: takes out of measured noise what the effects' parameters gain by
/// their own move to those. The fitted model moves by what bends moved it.
void take_out_own_move(const Problem& problem, const Fit& fitted, Innovations& innovations, MeasuredNoise& m) {
  std::vector<NoiseParameter> parameters;
  add_parameters(problem, fitted.model, parameters);
  if (parameters.empty()) return;
  MeasuredNoise alone = assumed_noise(problem, fitted);
  const double before = cost_of(innovations.under(alone));
  fit_noise(innovations, parameters, alone);
  m.gain -= before - cost_of(innovations.under(alone));
  MeasuredNoise moved = assumed_noise(problem, fitted);
  for (const NoiseParameter& p : parameters) move_by(moved, p, (value_of(m, p) - value_of(alone, p)) / p.scale);
  m.model = moved.model;
}

}  // namespace

MeasuredNoise measure_noise(const Problem& problem, const Fit& fitted, const NoiseEstimateOptions& options) {
  Innovations innovations(problem);
  MeasuredNoise m = assumed_noise(problem, fitted);
  const double before = cost_of(innovations.under(m));
  if (options.begin_white) whiten(problem, m.noise);
  const NoiseParameterList list = list_unknowns(problem, fitted.model, options);
  const std::vector<NoiseParameter> unknowns = list.all();
  for (const NoiseParameter& p : unknowns) {
    if (p.kind == NoiseParameter::Kind::colour && m.noise.colour[p.which] == 0.0)
      m.noise.colour[p.which] = hardly_coloured;
    if (is_of_commands(p) && value_of(m, p) == 0.0) value_of(m, p) = thresholds::first_command * p.most;
  }
  const MatrixXd information = fit_noise(innovations, list.noise, m);
  MeasuredNoise bent = m;
  if (std::ranges::any_of(unknowns, [&](const NoiseParameter& p) { return is_unknown_command(p, m); })) {
    const MatrixXd beside_bends = fit_noise(innovations, unknowns, bent);
    prune_and_refit(problem, unknowns, beside_bends, innovations, bent);
  }
  if (bent.bend != problem.bend)
    m = bent;
  else  // the parameters, and what noise was beside them, stay where they are without bends
    prune_and_refit(problem, unknowns, information, innovations, m);
  if (options.sensors) keep_credible(problem, m);
  m.gain = before - cost_of(innovations.under(m));
  if (m.bend != problem.bend) take_out_own_move(problem, fitted, innovations, m);
  return m;
}

double colour_statistic(const Problem& problem, const Fit& fitted) {
  Innovations innovations(problem);
  Channels last{}, product{}, square{}, count{};
  for (const Likelihood::Innovation& row : innovations.under(assumed_noise(problem, fitted))) {
    const double e = row.error / std::sqrt(row.variance);
    product[row.channel] += e * last[row.channel];
    square[row.channel] += e * e;
    count[row.channel] += 1.0;
    last[row.channel] = e;
  }
  double worst = 0.0;
  for (std::size_t c = 0; c < channels; ++c)
    if (square[c] > 0.0) worst = std::max(worst, std::abs(product[c]) / square[c] * std::sqrt(count[c]));
  return worst;
}

double unknown_commands_statistic(const Problem& problem, const Fit& fitted) {
  constexpr double tenth = 0.1;
  MeasuredNoise m = assumed_noise(problem, fitted);
  std::vector<NoiseParameter> unknowns;
  for (const NoiseParameter& p : list_unknowns(problem, fitted.model, {.sensors = false, .commands = true}).noise) {
    if (p.kind != NoiseParameter::Kind::moving) continue;
    value_of(m, p) = tenth;
    unknowns.push_back(p);
  }
  Innovations innovations(problem);
  const NoiseScores scores = scores_at(innovations, m, unknowns);
  double most = 0.0;
  for (Index i = 0; i < scores.gradient.size(); ++i)
    most = std::max(most, -scores.gradient[i] / std::sqrt(scores.information(i, i) + 1e-12));
  return most;
}

double gain_of_bends(const Problem& problem, const Fit& fitted) {
  std::vector<NoiseParameter> unknowns =
      list_unknowns(problem, fitted.model, {.sensors = false, .commands = true}).beside_bends;
  std::erase_if(unknowns, [](const NoiseParameter& p) { return p.kind != NoiseParameter::Kind::bend; });
  if (unknowns.empty()) return 0.0;
  const auto bends = static_cast<Index>(unknowns.size());
  add_parameters(problem, fitted.model, unknowns);
  Innovations innovations(problem);
  const NoiseScores scores = scores_at(innovations, assumed_noise(problem, fitted), unknowns);
  const MatrixXd regular = scores.information + 1e-6 * MatrixXd(scores.information.diagonal().asDiagonal());
  const auto gain_of_last = [&](Index n) {
    const VectorXd gradient = scores.gradient.tail(n);
    return 0.5 * gradient.dot(regular.bottomRightCorner(n, n).ldlt().solve(gradient));
  };
  const Index parameters = scores.gradient.size() - bends;
  return gain_of_last(scores.gradient.size()) - (parameters > 0 ? gain_of_last(parameters) : 0.0);
}

}  // namespace gripline::diagnose
