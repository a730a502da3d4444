#include "measured/log/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gripline::measured {
namespace {

constexpr std::size_t least_levels = 8;  // that differ: fewer are a switch, not a rounded signal
constexpr double off_step = 0.1;         // largest difference to a multiple, in steps: written with few digits

}  // namespace

double step_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::ranges::sort(values);
  if (values.size() < least_levels) return 0.0;
  const double span = values.back() - values.front(), same = 1e-9 * span;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] - values[i - 1] > same) gaps.push_back(values[i] - values[i - 1]);
  if (gaps.size() + 1 < least_levels) return 0.0;
  const double least = std::ranges::min(gaps);
  double steps = 0.0;
  for (const double gap : gaps) steps += std::round(gap / least);
  const double step = span / steps;
  const bool even = std::ranges::all_of(
      gaps, [step](double gap) { return std::abs(gap - step * std::round(gap / step)) < off_step * step; });
  return even ? step : 0.0;
}

Commands command_steps(std::span<const Log> stretches) {
  std::vector<double> d, delta;
  for (const Log& log : stretches)
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (!log.interpolated.empty() && log.interpolated[k]) continue;
      d.push_back(log.command[k].d);
      delta.push_back(log.command[k].delta);
    }
  return {step_of(std::move(d)), step_of(std::move(delta))};
}

Channels reading_steps(std::span<const Log> stretches) {
  Channels steps;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> values;
    for (const Log& log : stretches)
      for (std::size_t k = 0; k < log.size(); ++k) values.push_back(log.reading[k * channels + c]);
    steps[c] = step_of(values);
    if (c != Channel::yaw || steps[c] > 0.0) continue;
    for (double& yaw : values) yaw = std::remainder(yaw, 2.0 * std::numbers::pi);
    steps[c] = step_of(std::move(values));
  }
  return steps;
}

double rounding_noise(double step) { return step / std::sqrt(12.0); }

namespace {

// A hidden Markov model: the state is where within its step a command lies, in cells; the observation is the step.
constexpr std::size_t cells = 24;
using Cells = std::array<double, cells>;
using Moves = std::array<double, 2 * cells - 1>;  // densities by how many cells it moves within the step

double place_of(std::size_t cell) { return (static_cast<double>(cell) + 0.5) / cells - 0.5; }

/// Density of moving by `levels` and some cells, Student's t of three degrees of freedom; `scale` in steps.
Moves moves_of(double levels, double scale) {
  Moves density;
  for (std::size_t i = 0; i < density.size(); ++i) {
    const double z = (levels + (static_cast<double>(i) - (cells - 1.0)) / cells) / scale;
    density[i] = std::pow(1.0 + z * z / 3.0, -2.0) / scale;
  }
  return density;
}
double density(const Moves& moves, std::size_t from, std::size_t to) { return moves[to + cells - 1 - from]; }

double normalise(Cells& of) {
  double sum = 0.0;
  for (const double v : of) sum += v;
  for (double& v : of) v /= sum;
  return sum;
}

/// Probabilities of the cells by what came before; gives the log likelihood of the levels up to a constant.
double run_forward(const std::vector<double>& levels, double scale, std::vector<Cells>& forward) {
  forward.resize(levels.size());
  forward[0].fill(1.0 / cells);
  double likelihood = 0.0;
  for (std::size_t k = 1; k < levels.size(); ++k) {
    const Moves moves = moves_of(levels[k] - levels[k - 1], scale);
    for (std::size_t to = 0; to < cells; ++to) {
      double sum = 0.0;
      for (std::size_t from = 0; from < cells; ++from) sum += density(moves, from, to) * forward[k - 1][from];
      forward[k][to] = sum;
    }
    likelihood += std::log(normalise(forward[k]));
  }
  return likelihood;
}

/// The likeliest scale of moves over a step, between a sixteenth (about a cell) and eight (errors are white long before).
double likeliest_scale(const std::vector<double>& levels) {
  std::vector<Cells> forward;
  double best = 1.0, most = -std::numeric_limits<double>::infinity();
  for (int half_octave = -8; half_octave <= 6; ++half_octave) {
    const double scale = std::pow(2.0, 0.5 * half_octave), likelihood = run_forward(levels, scale, forward);
    if (likelihood > most) {
      most = likelihood;
      best = scale;
    }
  }
  return best;
}

/// Where within its step a command lies, in steps: mean, variance and regression of the next sample's on this one's.
struct Within {
  double mean = 0, variance = 0, autoregression = 0;
};

std::vector<Within> places_of(const std::vector<double>& levels) {
  std::vector<Cells> forward;
  const double scale = likeliest_scale(levels);
  run_forward(levels, scale, forward);
  std::vector<Within> places(levels.size());
  Cells after;  // likelihood of all that follows, by cell
  after.fill(1.0);
  for (std::size_t k = levels.size(); k-- > 0;) {
    double together = 0.0;  // mean product of this and the next place
    if (k + 1 < levels.size()) {
      const Moves moves = moves_of(levels[k + 1] - levels[k], scale);
      Cells before{};
      double all = 0.0;
      for (std::size_t i = 0; i < cells; ++i)
        for (std::size_t j = 0; j < cells; ++j) {
          const double one = density(moves, i, j) * after[j];
          before[i] += one;
          all += one * forward[k][i];
          together += one * forward[k][i] * place_of(i) * place_of(j);
        }
      together /= all;
      after = before;
      normalise(after);
    }
    Cells here;
    for (std::size_t i = 0; i < cells; ++i) here[i] = forward[k][i] * after[i];
    normalise(here);
    Within& p = places[k];
    for (std::size_t i = 0; i < cells; ++i) p.mean += here[i] * place_of(i);
    for (std::size_t i = 0; i < cells; ++i) p.variance += here[i] * std::pow(place_of(i) - p.mean, 2);
    if (k + 1 < levels.size()) p.autoregression = (together - p.mean * places[k + 1].mean) / p.variance;
  }
  return places;
}

}  // namespace

void unround_commands(Log& log, const Commands& steps) {
  if (steps == Commands{} || log.size() < 2) return;
  log.rounding_error.assign(log.size(), {});
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] == 0.0) continue;
    const auto value = [&](std::size_t k) -> double& { return i == 0 ? log.command[k].d : log.command[k].delta; };
    std::vector<double> levels;
    for (std::size_t k = 0; k < log.size(); ++k) levels.push_back(std::round((value(k) - value(0)) / steps[i]));
    const std::vector<Within> places = places_of(levels);
    for (std::size_t k = 0; k < log.size(); ++k) {
      // A command that was filled in from its neighbours was not rounded, and nothing tells where in its step it lay.
      const bool filled = k < log.interpolated.size() && log.interpolated[k];
      if (!filled) value(k) += places[k].mean * steps[i];
      log.rounding_error[k].variance[i] = (filled ? 1.0 / 12.0 : places[k].variance) * steps[i] * steps[i];
      log.rounding_error[k].autoregression[i] = std::clamp(places[k].autoregression, 0.0, 1.0);
    }
  }
}

}  // namespace gripline::measured
