#include "diagnose/inference/error_change.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "diagnose/thresholds.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

double relative_change(double with, double without) { return without > 0.0 ? std::sqrt(with / without) - 1.0 : 0.0; }

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
  std::vector<double> a, b;  // squares of each block
  for (std::size_t i = 0; i < std::min(with.square.size(), without.square.size()); ++i) {
    if (i % thresholds::rollout_block == 0) {
      a.push_back(0.0);
      b.push_back(0.0);
    }
    a.back() += with.square[i];
    b.back() += without.square[i];
  }
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
  return out;
}

}  // namespace gripline::diagnose
