// With innovations e of variance S, both functions of the noise parameters, the cost is sum (e^2 / S + log S) / 2, its
// gradient and expected information are
//
//   g_a = sum (dS_a / S) (1 - e^2 / S) / 2 + e de_a / S,   I_ab = sum dS_a dS_b / (2 S^2) + de_a de_b / S
//
// (Gupta and Mehra 1974). The derivatives dS and de are differences of filter passes.
#include "diagnose/inference/noise_estimate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diagnose/inference/newton_step.hpp"
#include "measured/noise.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// One unknown of the noise.
struct Unknown {
  enum class Kind { level, colour, acceleration, time, steady, moving, bend, parameter } kind;
  std::size_t which = 0;      // channel, acceleration, command or member of the model
  double longest_step = 1.0;  // of the logarithm; of a colour, a bend or a parameter itself, in its scale
  double least = 0.0, most = std::numeric_limits<double>::infinity();
  std::size_t of = 0;  // the member's parameter
  double scale = 1.0;
};

/// A filter's path depends on which colours are zero: while they are unknown none is.
constexpr double hardly_coloured = 1e-7;
constexpr double difference = 1e-3;  // step of differences, in the unknowns' own scales

double& value_of(MeasuredNoise& m, const Unknown& u) {
  switch (u.kind) {
    case Unknown::Kind::level:
      return m.noise.sensor[u.which];
    case Unknown::Kind::colour:
      return m.noise.colour[u.which];
    case Unknown::Kind::acceleration:
      return m.noise.process[u.which];
    case Unknown::Kind::steady:
      return m.noise.command.steady[u.which];
    case Unknown::Kind::moving:
      return m.noise.command.moving[u.which];
    case Unknown::Kind::bend:
      return m.bend[u.which];
    case Unknown::Kind::parameter:
      return m.model.values[u.which][u.of];
    case Unknown::Kind::time:
      break;
  }
  return m.noise_time;
}

/// Whether another value of it is another linear model.
bool changes_model(const Unknown& u) {
  using enum Unknown::Kind;
  return u.kind == time || u.kind == bend || u.kind == parameter;
}

bool is_of_commands(const Unknown& u) { return u.kind == Unknown::Kind::steady || u.kind == Unknown::Kind::moving; }

/// A value after a step: a colour, a bend and a parameter (in its scales) move by an addition, all others by a factor's
/// logarithm.
double after(double value, const Unknown& u, double step) {
  using enum Unknown::Kind;
  return u.kind == colour || u.kind == bend || u.kind == parameter ? value + step * u.scale : value * std::exp(step);
}

/// Moves one unknown within its range.
void move(MeasuredNoise& m, const Unknown& u, double step) {
  double& value = value_of(m, u);
  value = std::clamp(after(value, u, step), u.least, u.most);
  if (u.kind == Unknown::Kind::colour && value == 0.0) value = hardly_coloured;
}

/// Step of a difference: of a colour towards white, of all others downwards where a step up would leave the range.
double difference_step(MeasuredNoise at, const Unknown& u) {
  const double value = value_of(at, u);
  const bool down = u.kind == Unknown::Kind::colour ? value > 0.0 : after(value, u, difference) > u.most;
  return down ? -difference : difference;
}

/// Whether an unknown stands at an end of its range and would leave it: an acceleration as calm as it may be, and all
/// but colours at the upper end.
bool would_leave(MeasuredNoise at, const Unknown& u, double gradient) {
  const double value = value_of(at, u);
  if (gradient > 0.0) return u.kind == Unknown::Kind::acceleration && value <= 1.0001 * u.least;
  return u.kind != Unknown::Kind::colour && value >= u.most;
}

/// The innovations of all logs under some noise.
class Innovations {
 public:
  explicit Innovations(const Problem& problem) : problem_(problem) {}

  /// The next noise is of another kind.
  void forget() { time_ = 0.0; }
  const std::vector<Likelihood::Innovation>& under(const MeasuredNoise& m) {
    if (m.noise_time != time_ || m.bend != bend_ || m.model.values != values_) linearise_all_logs(m);
    rows_.clear();
    FilterOptions options;
    options.innovations = true;
    for (const LinearModel& lm : logs_) {
      const Likelihood l = filter(lm, m.noise, options);
      rows_.insert(rows_.end(), l.innovations.begin(), l.innovations.end());
    }
    return rows_;
  }

 private:
  void linearise_all_logs(const MeasuredNoise& m) {
    time_ = m.noise_time;
    bend_ = m.bend;
    values_ = m.model.values;
    const StagedCar car = problem_.catalogue->build(m.model);
    logs_.clear();
    const Stepping stepping{problem_.substeps, m.noise_time, m.noise.command != UnknownCommands{}};
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

  const Problem& problem_;
  double time_ = 0.0;
  Commands bend_{};
  std::vector<std::vector<double>> values_;
  std::vector<LinearModel> logs_;
  std::vector<Likelihood::Innovation> rows_;
};

/// The noise that a problem and a fit believe.
MeasuredNoise as_believed(const Problem& problem, const Fit& fitted) {
  return {.noise = fitted.noise, .noise_time = problem.noise_time, .bend = problem.bend, .model = fitted.model};
}

double cost_of(std::span<const Likelihood::Innovation> rows) {
  double sum = 0.0;
  for (const auto& row : rows) sum += 0.5 * (row.error * row.error / row.variance + std::log(row.variance));
  return sum;
}

/// Gradient and expected information of the cost.
struct Scores {
  VectorXd gradient;
  MatrixXd information;
};

Scores scores_at(Innovations& innovations, const MeasuredNoise& at, std::span<const Unknown> unknowns) {
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
    MeasuredNoise moved = at;
    const Unknown& u = unknowns[static_cast<std::size_t>(a)];
    const double step = difference_step(at, u);
    move(moved, u, step);
    const auto& other = innovations.under(moved);
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

/// Whether something is left unknown of a command between samples.
bool is_unknown_command(const Unknown& u, MeasuredNoise& m) {
  return is_of_commands(u) && value_of(m, u) > 1.01 * u.least;
}

bool is_read(const Problem& problem, std::size_t channel) {
  return std::ranges::any_of(problem.traces, [channel](const Trace& trace) {
    for (std::size_t k = 0; k < trace.size(); ++k)
      if (!std::isnan(trace.log.reading[k * channels + channel])) return true;
    return false;
  });
}

/// The scatter of the sensors from sample to sample: the least that their noise can be, whatever is believed of it.
Channels white_levels(const Problem& problem) {
  std::vector<Log> logs;
  for (const Trace& trace : problem.traces) logs.push_back(trace.log);
  const Channels seen = measured::estimate_noise(logs);
  Channels level = problem.sensor;
  for (std::size_t c = 0; c < channels; ++c)
    if (problem.colour[c] != 0.0 && seen[c] > 0.0) level[c] = std::min(level[c], seen[c]);
  return level;
}

/// The parameters of a model's effects but of shapes along the lap, which have many and imitate no bend.
void add_parameters(const Problem& problem, const ModelSpec& model, std::vector<Unknown>& list) {
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = problem.catalogue->candidates()[model.members[i]];
    if (c.fitted.size() > thresholds::full_penalty_parameters) continue;
    for (std::size_t f = 0; f < c.fitted.size(); ++f) {
      const abi::ParamDecl& decl = c.decl(f);
      list.push_back({Unknown::Kind::parameter, i, 1.0, decl.lo, decl.hi, c.fitted[f], decl.scale});
    }
  }
}

/// Those that matter only where commands are unknown stand last, from the first bend on.
std::vector<Unknown> list_unknowns(const Problem& problem, const ModelSpec& model, const NoiseUnknowns& asked) {
  std::vector<Unknown> list;
  const Channels scatter = white_levels(problem);
  using enum Unknown::Kind;
  const auto add_level = [&](std::size_t c) { list.push_back({level, c, 1.0, thresholds::least_level * scatter[c]}); };
  for (std::size_t c = 0; asked.sensors && c < channels; ++c) {
    if (!is_read(problem, c)) continue;
    add_level(c);
    list.push_back({colour, c, 0.4, -thresholds::most_colour, thresholds::most_colour});
  }
  for (std::size_t i = 0; i < noise_states; ++i) list.push_back({acceleration, i, 2.0, least_variance(problem, i)});
  if (asked.correlation_time)
    list.push_back({time, 0, 1.0, thresholds::shortest_noise_time, thresholds::longest_noise_time});
  if (!asked.commands) return list;
  std::vector<Log> logs;
  for (const Trace& trace : problem.traces) logs.push_back(trace.log);
  const Commands curvature = measured::command_curvature(logs);
  for (const Unknown::Kind kind : {steady, moving, bend})
    for (std::size_t i = 0; i < curvature.size(); ++i) {
      if (!(curvature[i] > 0.0) || (kind == bend && problem.held)) continue;
      const double most = thresholds::most_command * (kind == steady ? curvature[i] : 1.0);
      if (kind == bend)
        list.push_back({kind, i, 0.1, -thresholds::most_bend, thresholds::most_bend});
      else
        list.push_back({kind, i, 1.0, thresholds::least_command * most, most});
    }
  // What commands do between samples scatters readings, and was believed to be the sensors'.
  for (std::size_t c = 0; !asked.sensors && c < channels; ++c)
    if (is_read(problem, c)) add_level(c);
  if (!problem.held) add_parameters(problem, model, list);
  return list;
}

/// The step of Fisher scoring, and the gain that it predicts. What would leave its range is left out of the system.
struct Step {
  VectorXd of;
  double predicted;
};

Step scoring_step(Scores scores, std::span<const Unknown> unknowns, const MeasuredNoise& m) {
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

/// Fisher scoring with step halving. Gives the information at the end.
MatrixXd improve(Innovations& innovations, std::span<const Unknown> unknowns, MeasuredNoise& m) {
  const auto n = static_cast<Index>(unknowns.size());
  double cost = cost_of(innovations.under(m));
  Scores scores;
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
        move(trial, unknowns[a], part * std::clamp(step[static_cast<Index>(a)], -longest, longest));
      }
      reached = cost_of(innovations.under(trial));
      if (reached < cost) break;
    }
    if (!(reached < cost)) break;
    m = trial;
    const double won = cost - reached;
    cost = reached;
    if (won < thresholds::noise_settled && predicted < 2.0 * thresholds::noise_settled) break;
  }
  return scores.information;
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
  std::vector<Log> logs;
  for (const Trace& trace : problem.traces) logs.push_back(trace.log);
  const Channels seen = measured::estimate_noise(logs);
  for (std::size_t c = 0; c < channels; ++c) {
    if (scatter_of(m.noise.sensor[c], m.noise.colour[c]) < thresholds::most_scatter * seen[c]) continue;
    m.noise.sensor[c] = problem.sensor[c];
    m.noise.colour[c] = problem.colour[c];
  }
}

/// Takes back colours that are not significant.
void forget_faint_colours(std::span<const Unknown> unknowns, const MatrixXd& covariance, MeasuredNoise& m) {
  for (std::size_t a = 0; a < unknowns.size(); ++a) {
    const Unknown& u = unknowns[a];
    if (u.kind != Unknown::Kind::colour) continue;
    const auto i = static_cast<Index>(a);
    double& rho = m.noise.colour[u.which];
    const bool significant =
        std::abs(rho) > thresholds::significant_colour * std::sqrt(std::max(0.0, covariance(i, i)));
    if (!significant || std::abs(rho) < thresholds::least_colour) rho = 0.0;
  }
}

/// Takes back what the log does not ask for of commands between samples: noise without which it is hardly less likely,
/// bends that are not significant, and those at an end of their range, which are an effect's.
void forget_undetermined(std::span<const Unknown> unknowns, const MatrixXd& covariance, Innovations& innovations,
                         MeasuredNoise& m) {
  double cost = cost_of(innovations.under(m));
  for (std::size_t a = 0; a < unknowns.size(); ++a) {
    const Unknown& u = unknowns[a];
    MeasuredNoise without = m;
    if (is_of_commands(u)) {
      value_of(without, u) = 0.0;
      const double less = cost_of(innovations.under(without));
      if (is_unknown_command(u, m) && less > cost + thresholds::significant_colour) continue;
      m = without;
      cost = less;
    } else if (u.kind == Unknown::Kind::bend) {
      const auto i = static_cast<Index>(a);
      const double sigma = i < covariance.rows() ? std::sqrt(std::max(0.0, covariance(i, i))) : 1.0;
      const double size = std::abs(value_of(m, u));
      if (size < thresholds::significant_colour * sigma || size >= u.most) value_of(m, u) = 0.0;
    }
  }
}

/// White noise of the sensors that were coloured, as large as they scatter from sample to sample.
void whiten(const Problem& problem, Noise& noise) {
  noise.sensor = white_levels(problem);
  noise.colour = {};
}

/// The unknowns that something is left of, with the effects' parameters or without.
std::vector<Unknown> left_of(std::span<const Unknown> unknowns, MeasuredNoise& m, bool parameters) {
  std::vector<Unknown> left;
  for (const Unknown& u : unknowns)
    if (u.kind == Unknown::Kind::parameter ? parameters : value_of(m, u) != 0.0) left.push_back(u);
  return left;
}

/// Takes back what the log does not ask for and measures the rest of the noise anew where commands lose what mattered.
/// Parameters move with bends only.
void settle(const Problem& problem, std::span<const Unknown> unknowns, const MatrixXd& information,
            Innovations& innovations, MeasuredNoise& m) {
  const MatrixXd covariance = information.ldlt().solve(MatrixXd::Identity(information.rows(), information.cols()));
  forget_faint_colours(unknowns, covariance, m);
  if (std::ranges::none_of(unknowns, is_of_commands)) return;
  const double before = cost_of(innovations.under(m));
  forget_undetermined(unknowns, covariance, innovations, m);
  if (std::abs(cost_of(innovations.under(m)) - before) > thresholds::noise_settled)
    improve(innovations, left_of(unknowns, m, m.bend != problem.bend), m);
}

/// The fit counted all samples, noise only the first: takes out of measured noise what the effects' parameters gain by
/// their own move to those. The fitted model moves by what bends moved it.
void take_out_own_move(const Problem& problem, const Fit& fitted, Innovations& innovations, MeasuredNoise& m) {
  std::vector<Unknown> parameters;
  add_parameters(problem, fitted.model, parameters);
  if (parameters.empty()) return;
  MeasuredNoise alone = as_believed(problem, fitted);
  innovations.forget();
  const double before = cost_of(innovations.under(alone));
  improve(innovations, parameters, alone);
  m.gain -= before - cost_of(innovations.under(alone));
  MeasuredNoise moved = as_believed(problem, fitted);
  for (const Unknown& u : parameters) move(moved, u, (value_of(m, u) - value_of(alone, u)) / u.scale);
  m.model = moved.model;
}

}  // namespace

MeasuredNoise measure_noise(const Problem& problem, const Fit& fitted, const NoiseUnknowns& asked) {
  Innovations innovations(problem);
  MeasuredNoise m = as_believed(problem, fitted);
  const double before = cost_of(innovations.under(m));
  if (asked.begin_white) whiten(problem, m.noise);
  const std::vector<Unknown> unknowns = list_unknowns(problem, fitted.model, asked);
  for (const Unknown& u : unknowns) {
    if (u.kind == Unknown::Kind::colour && m.noise.colour[u.which] == 0.0) m.noise.colour[u.which] = hardly_coloured;
    if (is_of_commands(u) && value_of(m, u) == 0.0) value_of(m, u) = thresholds::first_command * u.most;
  }
  if (asked.commands) innovations.forget();
  const auto first_bend =
      std::ranges::find_if(unknowns, [](const Unknown& u) { return u.kind == Unknown::Kind::bend; });
  const auto needed = static_cast<std::size_t>(first_bend - unknowns.begin());
  const MatrixXd information = improve(innovations, std::span(unknowns).first(needed), m);
  MeasuredNoise bent = m;
  if (std::ranges::any_of(unknowns, [&](const Unknown& u) { return is_unknown_command(u, m); })) {
    const MatrixXd beside_bends = improve(innovations, unknowns, bent);
    settle(problem, unknowns, beside_bends, innovations, bent);
  }
  if (bent.bend != problem.bend)
    m = bent;
  else  // the parameters, and what noise was beside them, stay where they are without bends
    settle(problem, unknowns, information, innovations, m);
  if (asked.sensors) keep_credible(problem, m);
  m.gain = before - cost_of(innovations.under(m));
  if (m.bend != problem.bend) take_out_own_move(problem, fitted, innovations, m);
  return m;
}

double colour_statistic(const Problem& problem, const Fit& fitted) {
  Innovations innovations(problem);
  Channels last{}, product{}, square{}, count{};
  for (const Likelihood::Innovation& row : innovations.under(as_believed(problem, fitted))) {
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
  MeasuredNoise m = as_believed(problem, fitted);
  std::vector<Unknown> unknowns;
  for (const Unknown& u : list_unknowns(problem, fitted.model, {.sensors = false, .commands = true})) {
    if (u.kind != Unknown::Kind::moving) continue;
    value_of(m, u) = tenth;
    unknowns.push_back(u);
  }
  Innovations innovations(problem);
  const Scores scores = scores_at(innovations, m, unknowns);
  double most = 0.0;
  for (Index i = 0; i < scores.gradient.size(); ++i)
    most = std::max(most, -scores.gradient[i] / std::sqrt(scores.information(i, i) + 1e-12));
  return most;
}

double gain_of_bends(const Problem& problem, const Fit& fitted) {
  std::vector<Unknown> unknowns = list_unknowns(problem, fitted.model, {.sensors = false, .commands = true});
  std::erase_if(unknowns, [](const Unknown& u) { return u.kind != Unknown::Kind::bend; });
  if (unknowns.empty()) return 0.0;
  const auto bends = static_cast<Index>(unknowns.size());
  add_parameters(problem, fitted.model, unknowns);
  Innovations innovations(problem);
  const Scores scores = scores_at(innovations, as_believed(problem, fitted), unknowns);
  const MatrixXd regular = scores.information + 1e-6 * MatrixXd(scores.information.diagonal().asDiagonal());
  const auto gain_of_last = [&](Index n) {
    const VectorXd gradient = scores.gradient.tail(n);
    return 0.5 * gradient.dot(regular.bottomRightCorner(n, n).ldlt().solve(gradient));
  };
  const Index parameters = scores.gradient.size() - bends;
  return gain_of_last(scores.gradient.size()) - (parameters > 0 ? gain_of_last(parameters) : 0.0);
}

MeasuredNoise higher_peak(const MeasuredNoise& all, const MeasuredNoise& fewer) {
  return fewer.gain > all.gain + thresholds::noise_gain ? fewer : all;
}

bool is_other(const Problem& problem, const MeasuredNoise& measured) {
  const auto differs = [](double a, double b) {
    return std::max(a, b) > thresholds::other_noise_factor * std::min(a, b);
  };
  bool other = differs(measured.noise_time, problem.noise_time);
  for (std::size_t i = 0; i < measured.bend.size(); ++i) {
    other |= differs(measured.noise.command.steady[i], problem.command.steady[i]);
    other |= differs(measured.noise.command.moving[i], problem.command.moving[i]);
    other |= std::abs(measured.bend[i] - problem.bend[i]) > thresholds::other_bend;
  }
  for (std::size_t c = 0; c < channels; ++c) {
    other |= differs(measured.noise.sensor[c], problem.sensor[c]);
    other |= std::abs(measured.noise.colour[c] - problem.colour[c]) > thresholds::other_colour;
  }
  return other;
}

bool is_simpler(const Problem& problem, const MeasuredNoise& measured) {
  bool gone = false, come = false;
  const auto count = [&](double believed, double now) {
    gone |= believed != 0.0 && now == 0.0;
    come |= believed == 0.0 && now != 0.0;
  };
  for (std::size_t c = 0; c < channels; ++c) count(problem.colour[c], measured.noise.colour[c]);
  for (std::size_t i = 0; i < measured.bend.size(); ++i) {
    count(problem.bend[i], measured.bend[i]);
    count(problem.command.steady[i], measured.noise.command.steady[i]);
    count(problem.command.moving[i], measured.noise.command.moving[i]);
  }
  return gone && !come;
}

void believe(Problem& problem, const MeasuredNoise& measured) {
  problem.sensor = measured.noise.sensor;
  problem.colour = measured.noise.colour;
  problem.noise_time = measured.noise_time;
  problem.command = measured.noise.command;
  if (problem.bend != measured.bend)
    for (Trace& trace : problem.traces) trace.bend_commands(measured.bend);
  problem.bend = measured.bend;
  problem.penalty_per_parameter = problem.penalty_of_readings();
}

}  // namespace gripline::diagnose
