#include "measured/estimates/timing_slip.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;

double median_deviation(const Values& values, double centre) {
  Values off;
  for (const double v : values) off.push_back(std::abs(v - centre));
  return median(std::move(off));
}

/// The shift that nearly all values share: the smaller shift of two quantiles, so that a mixture of shifted and other
/// values has none.
double shift_of_all(const Values& values, double centre) {
  const double low = lower_quantile(values, 0.25) - centre, high = lower_quantile(values, 0.75) - centre;
  if (low * high <= 0.0) return 0.0;
  return std::abs(low) < std::abs(high) ? low : high;
}

/// The largest speed along the car [m/s], but for readings that are far from what is exceeded in 2 % of the rows: wrong
/// ones.
double fastest_of(const Session& s) {
  constexpr double far = 2.0;  // times that
  Values speeds;
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (!std::isnan(s.at(i, Channel::vx))) speeds.push_back(std::abs(s.at(i, Channel::vx)));
  const double most = far * lower_quantile(speeds, 0.98, 0.0);
  double fastest = 0.0;
  for (const double v : speeds)
    if (v <= most) fastest = std::max(fastest, v);
  return fastest;
}

}  // namespace

std::optional<TimingSlip> timing_slip(const Session& s, double row_step) {
  if (!s.has[Channel::x] || !s.has[Channel::vx]) return std::nullopt;
  Values when, lost;
  const double fastest = fastest_of(s);
  for (std::size_t i = 1; i < s.rows(); ++i) {
    const double dt = s.t[i] - s.t[i - 1], v = 0.5 * (s.at(i, Channel::vx) + s.at(i - 1, Channel::vx));
    const double way =
        std::hypot(s.at(i, Channel::x) - s.at(i - 1, Channel::x), s.at(i, Channel::y) - s.at(i - 1, Channel::y));
    if (dt > 1.5 * row_step || !(std::abs(v) > 0.3 * fastest) || !std::isfinite(way)) continue;
    when.push_back(s.t[i]);
    lost.push_back(way / std::abs(v) - dt);
  }
  if (when.size() < 200) return std::nullopt;
  const double centre = median(lost), spread = median_deviation(lost, centre) / 0.6745;
  if (!(spread > 0.0)) return std::nullopt;
  TimingSlip best;
  for (const double period : {0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0}) {
    const auto bins = static_cast<std::size_t>(std::round(period / row_step));
    if (bins < 4 || when.size() < 10 * bins) continue;
    std::vector<Values> by_phase(bins);
    for (std::size_t i = 0; i < when.size(); ++i) {
      const double phase = when[i] / period - std::floor(when[i] / period);
      by_phase[static_cast<std::size_t>(std::round(phase * static_cast<double>(bins))) % bins].push_back(lost[i]);
    }
    for (std::size_t b = 0; b < bins; ++b) {
      if (by_phase[b].size() < 10) continue;
      const double off = shift_of_all(by_phase[b], centre);
      const double score = std::abs(off) / (1.25 * spread) * std::sqrt(static_cast<double>(by_phase[b].size()));
      // A multiple of the true period splits the same rows among more phases and scores less; a part of it mixes others
      // in, or has the same rows where it is no multiple of a row.
      if (score > 0.0 && score >= 0.999 * best.score) best = {period, static_cast<double>(b) * row_step, off, score};
    }
  }
  if (best.score < 8.0 || std::abs(best.travel) < 1e-3) return std::nullopt;
  return best;
}

}  // namespace gripline::measured
