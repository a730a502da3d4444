#include "planners/time_optimal/base_line.hpp"

#include <cmath>
#include <numbers>

namespace gripline::time_optimal {

using namespace planning;

namespace {

/// How far one can go along a normal of the base line before the margin to an edge is used up, towards `side` (+1
/// left). Small steps, then bisection. Never nearer than a fifth of the radius to the centre of curvature.
double reach(const Course& course, const LinePoint& p, double station, double side, double margin) {
  const double nx = -std::sin(p.yaw) * side, ny = std::cos(p.yaw) * side;
  const double curvature = p.kappa * side;
  const double most = std::min(2.0 * (p.left + p.right), curvature > 1e-9 ? 0.8 / curvature : 1e9);
  double hint = station;
  const auto room = [&](double way) {
    const CoursePoint c = course.locate(p.x + nx * way, p.y + ny * way, hint);
    hint = c.s;
    return std::min(c.left - c.n, c.right + c.n) - margin;
  };
  if (room(0.0) <= 0.0) return 0.0;
  const double step = 0.02 * (p.left + p.right);
  double lo = 0.0, hi = step;
  while (hi < most && room(hi) > 0.0) {
    lo = hi;
    hi += step;
  }
  if (hi >= most) return lo;
  for (int i = 0; i < 40; ++i) (room(0.5 * (lo + hi)) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
  return lo;
}

/// Stations at equal shares of half way, half time.
std::vector<double> stations(const ClosedLine& base, const std::vector<double>& speed, std::size_t count) {
  const std::size_t n = base.size();
  double time = 0;
  for (const double v : speed) time += base.spacing() / v;
  std::vector<double> covered(n + 1, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    covered[i + 1] = covered[i] + 0.5 / static_cast<double>(n) + 0.5 * base.spacing() / speed[i] / time;
  std::vector<double> s(count);
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double share = covered[n] * static_cast<double>(k) / static_cast<double>(count);
    while (covered[i + 1] <= share) ++i;
    s[k] = base.spacing() * (static_cast<double>(i) + (share - covered[i]) / (covered[i + 1] - covered[i]));
  }
  return s;
}

}  // namespace

LapNodes place_nodes(const ClosedLine& base, const std::vector<double>& speed, const Course& course, double margin,
                     std::size_t count) {
  LapNodes nodes;
  nodes.s = stations(base, speed, count);
  for (std::size_t k = 0; k < count; ++k) {
    const double s = nodes.s[k], end = k + 1 < count ? nodes.s[k + 1] : base.length();
    const LinePoint p = base.at(s), q = base.at(end), m = base.at(0.5 * (s + end));
    const auto room = [&](const LinePoint& from, std::vector<double>& lo, std::vector<double>& hi) {
      const double station = base.samples()[base.bracket(from.s).first].station;
      hi.push_back(reach(course, from, station, 1.0, margin));
      lo.push_back(-reach(course, from, station, -1.0, margin));
    };
    room(p, nodes.n_lo, nodes.n_hi);
    room(m, nodes.mid_lo, nodes.mid_hi);
    nodes.ds.push_back(end - s);
    const double turned = std::remainder(q.yaw - p.yaw, 2.0 * std::numbers::pi);
    // Meusnier: in a turn whose bank turns with the road, the surface is curved along the road by kappa sin(bank) too.
    const double road = course.at(base.samples()[base.bracket(m.s).first].station).kappa;
    const double curve = (q.grade - p.grade) / (end - s) + road * std::sin(m.bank);
    nodes.places.push_back({turned / (end - s), m.grade, m.bank, curve});
  }
  return nodes;
}

}  // namespace gripline::time_optimal
