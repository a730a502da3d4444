#include "calibrate/forecast/baselines.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::calibrate {
namespace {

/// Mean curvature of a rolling car over the commands between two times.
double rolling_curvature(const Session& s, double from, double to, double wheelbase) {
  double sum = 0.0, count = 0.0;
  const auto first = std::lower_bound(s.t.begin(), s.t.end(), from - 1e-9);
  for (auto t = first; t != s.t.end() && *t <= to + 1e-9; ++t, count += 1.0)
    sum += std::tan(std::clamp(s.command[static_cast<std::size_t>(t - s.t.begin())].delta, -1.4, 1.4)) / wheelbase;
  return count > 0.0 ? sum / count : 0.0;
}

double steering_at(const Session& s, double time) {
  const std::size_t row = std::min(s.row_before(time), s.rows() - 1);
  return std::clamp(s.command[row].delta, -1.4, 1.4);
}

}  // namespace

std::vector<double> baseline(Baseline which, const Session& s, const Starts& starts, double wheelbase) {
  std::vector<double> out;
  for (const double start : starts.time) {
    std::array<double, channels> now{};
    for (std::size_t c = 0; c < channels; ++c) now[c] = s.interpolate(c, start);
    const double vy = std::isnan(now[4]) ? 0.0 : now[4];
    for (const double h : starts.horizons) {
      double curvature_rate = std::isnan(now[5]) ? 0.0 : now[5], side = vy, rate = now[5];
      if (which == Baseline::constant_speed) curvature_rate = side = rate = 0.0;
      if (which == Baseline::kinematic) {
        curvature_rate = now[3] * rolling_curvature(s, start, start + h, wheelbase);
        rate = now[3] * std::tan(steering_at(s, start + h)) / wheelbase;
        side = 0.0;
      }
      // Constant velocities and turn rate: along a circle.
      const double turn = curvature_rate * h;
      const double along = std::abs(turn) > 1e-6 ? std::sin(turn) / turn : 1.0;
      const double across = std::abs(turn) > 1e-6 ? (1.0 - std::cos(turn)) / turn : 0.5 * turn;
      const double ahead = h * (now[3] * along - side * across), left = h * (now[3] * across + side * along);
      const double yaw = std::isnan(now[2]) ? 0.0 : now[2];
      out.push_back(now[0] + ahead * std::cos(yaw) - left * std::sin(yaw));
      out.push_back(now[1] + ahead * std::sin(yaw) + left * std::cos(yaw));
      out.push_back(now[2] + turn);
      out.push_back(now[3]);
      out.push_back(std::isnan(now[4]) ? now[4] : side);
      out.push_back(std::isnan(now[5]) ? now[5] : rate);
    }
  }
  return out;
}

}  // namespace gripline::calibrate
