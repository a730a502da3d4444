#include "diagnose/real_logs/remainder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace gripline::diagnose {

using calibrate::FitLog;

namespace {

constexpr double longest_gap = 0.5;  // [s] between readings

/// What every start has of each thing; NaN where nothing tells it.
std::map<std::string, std::vector<double>> features_of(const std::vector<FitLog>& logs, double horizon) {
  std::map<std::string, std::vector<double>> features;
  for (const FitLog& log : logs)
    for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
      if (!calibrate::has_truth(log, i)) continue;
      const double t = log.starts.time[i];
      const std::size_t row = std::min(log.session->row_before(t), log.session->rows() - 1);
      const auto size = [&](std::size_t channel) {
        return std::abs(log.session->bridge(channel, t + 0.5 * horizon, INFINITY, longest_gap).value);
      };
      features["speed"].push_back(size(measured::Channel::vx));
      features["yaw rate"].push_back(size(measured::Channel::yaw_rate));
      features["throttle"].push_back(log.session->command[row].d);
      features["steering"].push_back(log.session->command[row].delta);
      features["time"].push_back(t - log.session->t.front());
    }
  return features;
}

}  // namespace

Remainder remainder_of(const std::vector<FitLog>& logs, const calibrate::ForecastErrors& errors, double horizon) {
  Remainder out;
  const std::vector<double>& square = errors.square;
  const double total = std::accumulate(square.begin(), square.end(), 0.0);
  const std::size_t third = square.size() / 3;
  if (third == 0 || !(total > 0.0)) return out;
  for (const auto& feature : features_of(logs, horizon)) {
    const std::vector<double>& value = feature.second;
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < value.size(); ++i)
      if (!std::isnan(value[i])) order.push_back(i);
    if (order.size() < value.size() - value.size() / 10) continue;  // a third of what is left is no third of the time
    const auto key = [&](std::size_t i) { return value[i]; };
    std::ranges::stable_sort(order, {}, key);
    double low = 0.0, high = 0.0;
    for (std::size_t i = 0; i < third; ++i) {
      low += square[order[i]];
      high += square[order[order.size() - 1 - i]];
    }
    const double share = std::max(low, high) / total;
    if (!(share > out.share)) continue;
    out = {feature.first, high >= low, key(high >= low ? order[order.size() - third] : order[third - 1]), share};
  }
  return out;
}

}  // namespace gripline::diagnose
