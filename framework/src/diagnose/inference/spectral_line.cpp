#include "diagnose/inference/spectral_line.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnose/inference/bases.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

/// Periodogram of one smoothed unknown acceleration, with von Hann's taper against leakage: ordinates at multiples of 1
/// / T up to thresholds::line_highest.
std::vector<double> periodogram(const Likelihood& l, std::size_t states, std::size_t channel, double dt) {
  const std::size_t n = l.smoothed.size() / states;
  const auto bins = static_cast<std::size_t>(thresholds::line_highest * dt * static_cast<double>(n));
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
