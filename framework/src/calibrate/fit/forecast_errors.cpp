#include "calibrate/fit/forecast_errors.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace gripline::calibrate {
namespace {

constexpr double farthest_error = 15.0;  // scales: an error beyond, as of a spin, counts as this one

/// The pseudo-Huber loss, as errors count in a fit.
double pseudo_huber(double z, double delta) {
  return 2.0 * delta * delta * (std::sqrt(1.0 + z * z / (delta * delta)) - 1.0);
}

}  // namespace

bool has_truth(const FitLog& log, std::size_t start) {
  const auto first = log.truth.begin() + static_cast<std::ptrdiff_t>(start * channels);
  return std::any_of(first, first + channels, [](double value) { return !std::isnan(value); });
}

ForecastErrors forecast_errors(const Forecaster& forecaster, std::span<const double> params, const Weighing& weighing,
                               const std::vector<FitLog>& judged) {
  ForecastErrors out;
  std::size_t stretch = 0;
  std::vector<FitLog> logs = judged;
  const PredictionErrors errors(forecaster, logs);
  const auto all = errors.errors(params);
  for (std::size_t l = 0; l < logs.size(); ++l) {
    double begin = -INFINITY, before = -INFINITY;
    for (std::size_t i = 0; i < logs[l].starts.time.size(); ++i) {
      if (!has_truth(logs[l], i)) continue;
      double sum = 0.0, weight = 0.0;
      for (std::size_t c = 0; c < channels; ++c) {
        if (std::isnan(logs[l].truth[i * channels + c])) continue;
        const double w = weighing.channel[c] * weighing.channel[c];
        double z = std::abs(all[l][i * channels + c]) / weighing.scale[c];
        if (!(z < farthest_error)) z = farthest_error;
        sum += w * pseudo_huber(z, weighing.huber_delta);
        weight += w;
      }
      // Starts that follow each other share a stretch, of at most the length over which a bootstrap draws blocks.
      const double now = logs[l].starts.time[i];
      if (now - before > 2.0 * judged_every || now - begin > block_length) {
        begin = now;
        ++stretch;
      }
      before = now;
      out.square.push_back(weight > 0.0 ? sum / weight : 0.0);
      out.stretch.push_back(stretch);
      out.log.push_back(l);
    }
  }
  return out;
}

double ForecastErrors::rms() const {
  const double sum = std::accumulate(square.begin(), square.end(), 0.0);
  return square.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(square.size()));
}

std::size_t ForecastErrors::stretches() const { return std::set(stretch.begin(), stretch.end()).size(); }

ForecastErrors ForecastErrors::of_log(std::size_t which) const {
  ForecastErrors out;
  for (std::size_t i = 0; i < square.size(); ++i) {
    if (log[i] != which) continue;
    out.square.push_back(square[i]);
    out.stretch.push_back(stretch[i]);
    out.log.push_back(which);
  }
  return out;
}

ForecastChange change_of(const ForecastErrors& with, const ForecastErrors& without) {
  // The logarithm of the ratio of two root mean squares, half that of A / C, moves with a stretch's sums a and c by
  // (a / A - c / C) / 2; stretches are drawn at random, so that its variance is that of their sum.
  std::map<std::size_t, std::pair<double, double>> sums;
  double all_with = 0.0, all_without = 0.0;
  for (std::size_t i = 0; i < with.square.size(); ++i) {
    auto& [a, c] = sums[with.stretch[i]];
    a += with.square[i];
    c += without.square[i];
    all_with += with.square[i];
    all_without += without.square[i];
  }
  ForecastChange out;
  if (!(all_with > 0.0) || !(all_without > 0.0)) return out;
  const double log_ratio = 0.5 * std::log(all_with / all_without);
  out.change = std::expm1(log_ratio);
  if (sums.size() < fewest_stretches) return out;
  const auto count = static_cast<double>(sums.size());
  double square = 0.0;
  for (const auto& [stretch, sum] : sums) {
    const double by = 0.5 * (sum.first / all_with - sum.second / all_without);
    square += by * by;
  }
  const double sigma = std::sqrt(square * count / (count - 1.0));
  const boost::math::students_t t(count - 1.0);
  const double half = sigma * boost::math::quantile(t, 0.975);
  out.low = std::expm1(log_ratio - half);
  out.high = std::expm1(log_ratio + half);
  out.certainty = sigma > 0.0 ? boost::math::cdf(t, -log_ratio / sigma) : log_ratio < 0.0 ? 1.0 : 0.0;
  return out;
}

}  // namespace gripline::calibrate
