#include "diagnose/inference/spectral_line.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnose/inference/bases.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

/// Periodogram of one smoothed unknown acceleration up to thresholds::line_highest, and below Nyquist's frequency.
std::vector<double> periodogram(const Likelihood& l, std::size_t states, std::size_t channel, double dt) {
  const std::size_t n = l.smoothed.size() / states;
  std::vector<double> acceleration(n);
  for (std::size_t k = 0; k < n; ++k) acceleration[k] = l.smoothed[k * states + states - noise_states + channel];
  return tapered_periodogram(acceleration,
                             static_cast<std::size_t>(thresholds::line_highest * dt * static_cast<double>(n)));
}

/// The line that stands out most of a spectrum: frequency [Hz] and -log of the probability that it does so by chance.
struct Line {
  double frequency = 0, minus_log_p = 0;
};
Line strongest_line(const std::vector<double>& power, double seconds) {
  constexpr std::ptrdiff_t reach = thresholds::line_background, own = thresholds::line_width;
  Line line;
  const auto bins = static_cast<std::ptrdiff_t>(power.size());
  std::vector<double> around;
  for (std::ptrdiff_t j = 0; bins >= 3 * reach && j < bins; ++j) {
    around.clear();
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, j - reach); i <= std::min(bins - 1, j + reach); ++i)
      if (std::abs(i - j) >= own) around.push_back(power[static_cast<std::size_t>(i)]);
    const double middle = upper_median(around);
    // Ordinates scatter exponentially about a smooth spectrum; the median of an exponential is log 2 of its mean.
    const double minus_log_p = middle > 0.0 ? std::numbers::ln2 * power[static_cast<std::size_t>(j)] / middle : 0.0;
    if (minus_log_p > line.minus_log_p) line = {static_cast<double>(j + 1) / seconds, minus_log_p};
  }
  return line;
}

/// The strongest line of all accelerations of all traces, and the number of ordinates it was chosen from.
struct Chosen {
  Line line;
  double among = 0;
};
Chosen choose_line(const Fit& fitted, std::span<const Linearised> along) {
  Chosen chosen;
  for (const auto& [lm, own, work] : along) {
    FilterOptions options;
    options.smooth = true;
    const Likelihood l = filter(lm, fitted.noise, options);
    for (std::size_t c = 0; c < noise_states; ++c) {
      const std::vector<double> power = periodogram(l, lm.states, c, lm.dt);
      chosen.among += static_cast<double>(power.size());
      const Line line = strongest_line(power, static_cast<double>(lm.n) * lm.dt);
      if (line.minus_log_p > chosen.line.minus_log_p) chosen.line = line;
    }
  }
  return chosen;
}

}  // namespace

std::vector<double> tapered_periodogram(std::span<const double> values, std::size_t ordinates) {
  using Eigen::ArrayXd;
  constexpr double pi = std::numbers::pi;
  const std::size_t n = values.size();
  const auto bins = static_cast<Eigen::Index>(std::min(ordinates, (std::max<std::size_t>(n, 1) - 1) / 2));
  // Goertzel's recurrence s[k] = y[k] + 2 cos(w) s[k - 1] - s[k - 2] in the form of Reinsch, by the differences d of s,
  // which loses no digits at low frequencies. Those above a quarter of the sampling rate are as low of every second
  // value turned round.
  const auto low = std::min(bins, static_cast<Eigen::Index>(n / 4));
  ArrayXd curvature(bins), s = ArrayXd::Zero(bins), d = ArrayXd::Zero(bins);  // curvature: 4 sin(w / 2)^2
  for (Eigen::Index j = 0; j < bins; ++j) {
    const double half = pi * static_cast<double>(j + 1) / static_cast<double>(n);
    curvature[j] = 4.0 * std::pow(j < low ? std::sin(half) : std::cos(half), 2);
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double taper = 0.5 - 0.5 * std::cos(2.0 * pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n));
    const double y = taper * values[k];
    d.head(low) += y;
    d.tail(bins - low) += k % 2 == 0 ? y : -y;
    d -= curvature * s;
    s += d;
  }
  const ArrayXd power = d.square() + curvature * s * (s - d);
  return {power.begin(), power.end()};
}

ResidualTest test_spectral_line(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  ResidualTest test;
  test.where = Where::time;
  test.quantity = "frequency";
  const Chosen chosen = choose_line(fitted, along);
  if (chosen.among == 0.0 || chosen.line.minus_log_p < std::log(chosen.among) + thresholds::line_margin) return test;
  const ScoreSystem system =
      basis_system(problem, fitted, along, [&](const Trace& trace) { return wave(trace, chosen.line.frequency); });
  const ScoreTest s = score_test(system.normal.N, system.normal.g, system.own_params);
  test.gain = s.gain;
  test.dof = s.dof;
  test.from = test.to = chosen.line.frequency;
  // Strong process noise has lines of its own, among which the frequency was chosen.
  const double share =
      has_strong_process_noise(problem, fitted.noise) ? thresholds::line_share_process_noise : thresholds::line_share;
  test.statistic = share * (s.gain - 0.5 * static_cast<double>(s.dof) - std::log(chosen.among));
  return test;
}

}  // namespace gripline::diagnose
