// Random closed roads for blind cases: a circle with a few waves, 1200 points, as a track file.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "blind/sizes.hpp"

namespace gripline::blind {

/// A star-shaped line cannot cross itself; drawn again until its sharpest bend is neither too tight nor dull.
inline void write_road(const std::filesystem::path& file, int car, Random& r) {
  const bool full = car == 1;
  const double length = full ? uniform(r, 550, 1300) : uniform(r, 8, 16);
  const double sharpest = full ? uniform(r, 24, 40) : uniform(r, 0.22, 0.45), half_width = full ? 8.0 : 0.26;
  constexpr std::size_t n = 1200;
  std::vector<std::array<double, 2>> points(n);
  for (double strength = 1.0;; strength *= 0.97) {
    std::array<double, 7> a{}, phase{};
    for (std::size_t k = 2; k < a.size(); ++k) {
      a[k] = strength * normal(r) * 0.35 / static_cast<double>(k);
      phase[k] = uniform(r, 0.0, 2.0 * std::numbers::pi);
    }
    bool good = true;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / n;
      double radius = 1.0;
      for (std::size_t k = 2; k < a.size(); ++k) radius += a[k] * std::cos(static_cast<double>(k) * angle + phase[k]);
      good &= radius > 0.35;
      points[i] = {radius * std::cos(angle), radius * std::sin(angle)};
    }
    double total = 0.0;
    const auto at = [&](std::size_t i) { return points[i % n]; };
    const auto distance = [](auto p, auto q) { return std::hypot(p[0] - q[0], p[1] - q[1]); };
    for (std::size_t i = 0; i < n; ++i) total += distance(at(i), at(i + 1));
    const double scale = length / total;
    double tightest = 1e9;
    for (std::size_t i = 0; i < n; ++i) {
      const auto p = at(i), q = at(i + 10), s = at(i + 20);
      const double area = std::abs((q[0] - p[0]) * (s[1] - p[1]) - (q[1] - p[1]) * (s[0] - p[0]));
      tightest =
          std::min(tightest, scale * distance(p, q) * distance(q, s) * distance(p, s) / std::max(1e-12, 2 * area));
    }
    if (good && tightest > 1.6 * sharpest) strength *= 1.04;
    if (!good || tightest < sharpest || tightest > 1.6 * sharpest) continue;
    for (auto& p : points) p = {p[0] * scale, p[1] * scale};
    break;
  }
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  char row[120];
  for (const auto& p : points) {
    std::snprintf(row, sizeof row, "%.6f,%.6f,%g,%g\n", p[0], p[1], half_width, half_width);
    out << row;
  }
}

}  // namespace gripline::blind
