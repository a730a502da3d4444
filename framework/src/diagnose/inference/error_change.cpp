#include "diagnose/inference/error_change.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <span>

#include "diagnose/thresholds.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

double relative_change(double with, double without) { return without > 0.0 ? std::sqrt(with / without) - 1.0 : 0.0; }

/// Sums of the squares of every `block` starts; the last block may hold fewer.
std::vector<double> block_sums(std::span<const double> square, std::size_t block) {
  std::vector<double> sums((square.size() + block - 1) / block, 0.0);
  for (std::size_t i = 0; i < square.size(); ++i) sums[i / block] += square[i];
  return sums;
}

/// Resampled intervals of n blocks are too narrow: by the root of (n - 1) / n, and as a normal's are beside Student's.
void widen(ErrorChange& to, std::size_t blocks) {
  if (!(to.change > -1.0)) return;
  const auto n = static_cast<double>(blocks);
  const double t = boost::math::quantile(boost::math::students_t(n - 1.0), 0.975);
  const double by = std::sqrt(n / (n - 1.0)) * t / normal_95;
  const auto away = [&](double end) { return (1.0 + to.change) * std::pow((1.0 + end) / (1.0 + to.change), by) - 1.0; };
  to.low = away(to.low);
  to.high = away(to.high);
}

}  // namespace

double StartErrors::rms() const {
  const double count = std::accumulate(readings.begin(), readings.end(), 0.0);
  return count > 0.0 ? std::sqrt(std::accumulate(square.begin(), square.end(), 0.0) / count) : 0.0;
}

std::string_view ErrorChange::in_words() const { return helps() ? "helps" : harms() ? "harms" : "cannot tell"; }

ErrorChange compare(const StartErrors& with, const StartErrors& without) {
  ErrorChange out;
  const double all = without.rms();
  out.change = all > 0.0 ? with.rms() / all - 1.0 : 0.0;
  const std::size_t starts = std::min(with.square.size(), without.square.size());
  const bool many = starts > (thresholds::fewest_rollout_blocks - 1) * thresholds::rollout_block;
  const std::size_t block = many ? thresholds::rollout_block : thresholds::short_rollout_block;
  const std::vector<double> a = block_sums(std::span(with.square).first(starts), block);
  const std::vector<double> b = block_sums(std::span(without.square).first(starts), block);
  if (a.size() < thresholds::fewest_rollout_blocks) return out;
  std::mt19937_64 random(20260101);
  std::uniform_int_distribution<std::size_t> any(0, a.size() - 1);
  std::vector<double> changes;
  for (int draw = 0; draw < thresholds::bootstrap_draws; ++draw) {
    double sum_a = 0.0, sum_b = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const std::size_t at = any(random);
      sum_a += a[at];
      sum_b += b[at];
    }
    changes.push_back(relative_change(sum_a, sum_b));
  }
  out.low = lower_quantile(changes, 0.025);
  out.high = lower_quantile(changes, 0.975);
  widen(out, a.size());
  return out;
}

}  // namespace gripline::diagnose
