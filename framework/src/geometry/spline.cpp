#include "geometry/spline.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace gripline {
namespace {

/// Solves the cyclic system lower_i m_{i-1} + diagonal_i m_i + upper_i m_{i+1} = rhs_i in place (Sherman-Morrison
/// around the Thomas algorithm, Numerical Recipes section 2.7).
void solve_cyclic_tridiagonal(std::vector<double>& lower, std::vector<double>& diagonal, std::vector<double>& upper,
                              std::vector<double>& rhs) {
  const std::size_t n = rhs.size();
  const double corner_top = lower.front(), corner_bottom = upper.back();
  const double gamma = -diagonal.front();
  diagonal.front() -= gamma;
  diagonal.back() -= corner_top * corner_bottom / gamma;
  std::vector<double> correction(n, 0.0);
  correction.front() = gamma;
  correction.back() = corner_bottom;
  for (std::size_t i = 1; i < n; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    rhs[i] -= factor * rhs[i - 1];
    correction[i] -= factor * correction[i - 1];
  }
  rhs[n - 1] /= diagonal[n - 1];
  correction[n - 1] /= diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) {
    rhs[i] = (rhs[i] - upper[i] * rhs[i + 1]) / diagonal[i];
    correction[i] = (correction[i] - upper[i] * correction[i + 1]) / diagonal[i];
  }
  const double ratio = corner_top / gamma;
  const double scale = (rhs.front() + ratio * rhs.back()) / (1.0 + correction.front() + ratio * correction.back());
  for (std::size_t i = 0; i < n; ++i) rhs[i] -= scale * correction[i];
}

// Five-point Gauss-Legendre rule on [0, 1].
constexpr std::array<double, 5> nodes{0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842, 0.953089922969332};
constexpr std::array<double, 5> weights{0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683,
                                        0.118463442528095};

}  // namespace

std::vector<double> periodic_spline_slopes(std::span<const double> values, std::span<const double> widths) {
  const std::size_t n = values.size();
  if (n < 3 || widths.size() != n) throw GeometryError("a periodic spline needs at least three knots");
  std::vector<double> lower(n), diagonal(n), upper(n), slopes(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i == 0 ? n - 1 : i - 1;
    const std::size_t after = i + 1 == n ? 0 : i + 1;
    const double h0 = widths[before], h1 = widths[i];
    lower[i] = 1.0 / h0;
    diagonal[i] = 2.0 * (1.0 / h0 + 1.0 / h1);
    upper[i] = 1.0 / h1;
    slopes[i] = 3.0 * ((values[i] - values[before]) / (h0 * h0) + (values[after] - values[i]) / (h1 * h1));
  }
  solve_cyclic_tridiagonal(lower, diagonal, upper, slopes);
  return slopes;
}

SplinePath::SplinePath(std::span<const PlanePoint> points) {
  const std::size_t n = points.size();
  if (n < 4) throw GeometryError("a closed line needs at least 4 points, found " + std::to_string(n));
  std::vector<double> x(n), y(n), width(n);
  for (std::size_t i = 0; i < n; ++i) {
    const PlanePoint& next = points[i + 1 == n ? 0 : i + 1];
    x[i] = points[i].x;
    y[i] = points[i].y;
    width[i] = distance(points[i], next);
    if (!std::isfinite(width[i])) throw GeometryError("point " + std::to_string(i + 1) + " is not a finite number");
    if (width[i] == 0.0) {
      throw GeometryError("points " + std::to_string(i + 1) + " and " + std::to_string(i + 1 == n ? 1 : i + 2) +
                          " are the same");
    }
  }
  const std::vector<double> slope_x = periodic_spline_slopes(x, width), slope_y = periodic_spline_slopes(y, width);
  const auto cubic = [](double v0, double v1, double m0, double m1, double h) {
    const double rise = (v1 - v0) / h;
    return Cubic{v0, m0, (3.0 * rise - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * rise) / (h * h)};
  };
  pieces_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = i + 1 == n ? 0 : i + 1;
    Piece& piece = pieces_[i];
    piece.x = cubic(x[i], x[j], slope_x[i], slope_x[j], width[i]);
    piece.y = cubic(y[i], y[j], slope_y[i], slope_y[j], width[i]);
    piece.width = width[i];
    piece.s = length_;
    measure(piece);
    length_ += piece.length;
    longest_piece_ = std::max(longest_piece_, piece.length);
  }
  bucket_.resize(n);
  std::size_t i = 0;
  for (std::size_t b = 0; b < n; ++b) {
    const double s = length_ * static_cast<double>(b) / static_cast<double>(n);
    while (i + 1 < n && pieces_[i + 1].s <= s) ++i;
    bucket_[b] = i;
  }
}

std::vector<double> SplinePath::knot_stations() const {
  std::vector<double> stations;
  for (const Piece& piece : pieces_) stations.push_back(piece.s);
  return stations;
}

double SplinePath::arc_length(const Piece& piece, double t) {
  const double panel = t / piece.panels;
  double sum = 0.0;
  for (int k = 0; k < piece.panels; ++k) {
    for (std::size_t q = 0; q < nodes.size(); ++q) {
      const double at = k * panel + panel * nodes[q];
      const double dx = piece.x.slope(at), dy = piece.y.slope(at);
      sum += weights[q] * std::sqrt(dx * dx + dy * dy);
    }
  }
  return sum * panel;
}

/// On a sound line |r'(t)| stays near 1 and one panel is exact; where noise folds the line it falls to almost 0.
void SplinePath::measure(Piece& piece) {
  constexpr int most = 64;
  constexpr double settled = 1e-6;
  piece.length = arc_length(piece, piece.width);
  for (int panels = 2; panels <= most; panels *= 2) {
    Piece finer = piece;
    finer.panels = panels;
    finer.length = arc_length(finer, finer.width);
    if (std::abs(finer.length - piece.length) < settled * finer.length) return;
    piece = finer;
  }
}

/// Inverse of arc_length: Newton's method from the proportional guess, which reaches rounding error in three steps
/// where |r'(t)| stays near 1. At a fold it may be almost 0: then a step that leaves the bracket is a bisection.
double SplinePath::parameter(const Piece& piece, double along) {
  double low = 0.0, high = piece.width, t = piece.width * along / piece.length;
  for (int k = 0; k < 60; ++k) {
    const double speed = std::hypot(piece.x.slope(t), piece.y.slope(t)), missing = along - arc_length(piece, t);
    (missing > 0.0 ? low : high) = t;
    double next = t + missing / speed;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double step = std::abs(next - t);
    t = next;
    if (step < (k < 2 ? 1e-13 : 1e-8) * piece.width) break;
  }
  return t;
}

std::size_t SplinePath::piece_index(double s) const {
  const auto share = static_cast<std::size_t>(s / length_ * static_cast<double>(bucket_.size()));
  std::size_t i = bucket_[std::min(share, bucket_.size() - 1)];
  while (i + 1 < pieces_.size() && pieces_[i + 1].s <= s) ++i;
  return i;
}

CurvePoint SplinePath::point(const Piece& piece, double t) const {
  const double dx = piece.x.slope(t), dy = piece.y.slope(t);
  const double speed2 = dx * dx + dy * dy;
  CurvePoint point;
  point.x = piece.x.value(t);
  point.y = piece.y.value(t);
  point.yaw = std::atan2(dy, dx);
  point.kappa = (dx * piece.y.bend(t) - dy * piece.x.bend(t)) / (speed2 * std::sqrt(speed2));
  return point;
}

CurvePoint SplinePath::at(double s) const {
  s = wrap_periodic(s, length_);
  const Piece& piece = pieces_[piece_index(s)];
  CurvePoint result = point(piece, parameter(piece, s - piece.s));
  result.s = s;
  return result;
}

double SplinePath::knot_distance2(std::size_t i, double x, double y) const {
  const double dx = pieces_[i].x.a - x, dy = pieces_[i].y.a - y;
  return dx * dx + dy * dy;
}

/// The foot next to a knot that is nearer than both of its neighbours.
CurveLocation SplinePath::refine(std::size_t knot, double x, double y) const {
  const std::size_t before = knot == 0 ? pieces_.size() - 1 : knot - 1;
  const Piece& start = pieces_[knot];
  const bool ahead = (start.x.a - x) * start.x.b + (start.y.a - y) * start.y.b < 0.0;
  const Piece& piece = ahead ? start : pieces_[before];
  return foot(piece, 0.0, piece.width, ahead ? 0.0 : piece.width, x, y);
}

/// The foot between two parameters of a piece, from t on: safeguarded Newton on (r(t) - p) . r'(t) = 0.
CurveLocation SplinePath::foot(const Piece& piece, double low, double high, double t, double x, double y) const {
  for (int k = 0; k < 60; ++k) {
    const double rx = piece.x.value(t) - x, ry = piece.y.value(t) - y;
    const double dx = piece.x.slope(t), dy = piece.y.slope(t);
    const double slope = rx * dx + ry * dy;
    (slope < 0.0 ? low : high) = t;
    const double bend = dx * dx + dy * dy + rx * piece.x.bend(t) + ry * piece.y.bend(t);
    double next = bend > 0.0 ? t - slope / bend : 0.5 * (low + high);
    if (next < low || next > high) next = 0.5 * (low + high);
    const double step = std::abs(next - t);
    t = next;
    if (step <= 1e-14 * piece.width) break;
  }
  const CurvePoint foot = point(piece, t);
  const double dx = x - foot.x, dy = y - foot.y;
  const double side = std::cos(foot.yaw) * dy - std::sin(foot.yaw) * dx;
  return {wrap_periodic(piece.s + arc_length(piece, t), length_), std::copysign(std::hypot(dx, dy), side), foot.yaw,
          foot.kappa};
}

/// Whether some point of piece i may be nearer to (x, y): its ways to both knots add up to no more than its length.
bool SplinePath::may_be_nearer(std::size_t i, double x, double y, double than) const {
  const double length = pieces_[i].length, limit = than - 1e-9 * length;
  const double here = knot_distance2(i, x, y), next = knot_distance2(i + 1 == pieces_.size() ? 0 : i + 1, x, y);
  // Most pieces are told from squares, without roots. The answer is the same: the share is far more than rounding, and
  // nothing cancels in `far`, since `limit` is at least -1e-9 lengths.
  const double far = limit + 0.5 * length, far2 = (1.0 + 1e-12) * (far * far);
  if (here >= far2 && next >= far2) return false;
  return 0.5 * (std::sqrt(here) + std::sqrt(next) - length) < limit;
}

/// The nearest point of one piece, wherever it is on it.
CurveLocation SplinePath::nearest_on(std::size_t i, double x, double y) const {
  constexpr int shares = 8;
  const Piece& piece = pieces_[i];
  double nearest = INFINITY;
  int best = 0;
  for (int k = 0; k <= shares; ++k) {
    const double t = piece.width * k / shares, dx = piece.x.value(t) - x, dy = piece.y.value(t) - y;
    if (dx * dx + dy * dy >= nearest) continue;
    nearest = dx * dx + dy * dy;
    best = k;
  }
  const double step = piece.width / shares;
  return foot(piece, step * std::max(0, best - 1), step * std::min(shares, best + 1), step * best, x, y);
}

CurveLocation SplinePath::locate(double x, double y) const {
  const std::size_t n = pieces_.size();
  double nearest = INFINITY;
  for (std::size_t i = 0; i < n; ++i) nearest = std::min(nearest, knot_distance2(i, x, y));
  // A foot lies at most half the longest piece from its knot, so only knots this near can own the nearest foot.
  const double reach = std::sqrt(nearest) + 0.5 * longest_piece_;
  CurveLocation best{0.0, INFINITY, 0.0, 0.0};
  double before = knot_distance2(n - 1, x, y), here = knot_distance2(0, x, y);
  const double first = here;
  for (std::size_t i = 0; i < n; ++i) {
    const double after = i + 1 == n ? first : knot_distance2(i + 1, x, y);
    if (here <= before && here <= after && here <= reach * reach) {
      const CurveLocation place = refine(i, x, y);
      if (std::abs(place.n) < std::abs(best.n)) best = place;
    }
    before = here;
    here = after;
  }
  // A piece much longer than its neighbours may pass nearer than any knot says.
  for (std::size_t i = 0; i < n; ++i) {
    if (!may_be_nearer(i, x, y, std::abs(best.n))) continue;
    const CurveLocation place = nearest_on(i, x, y);
    if (std::abs(place.n) < std::abs(best.n) - 1e-9 * pieces_[i].length) best = place;
  }
  return best;
}

CurveLocation SplinePath::locate(double x, double y, double hint_s) const {
  const std::size_t n = pieces_.size(), first = piece_index(wrap_periodic(hint_s, length_));
  std::size_t i = first;
  double here = knot_distance2(i, x, y);
  for (int direction : {1, -1}) {
    for (std::size_t steps = 0; steps < n; ++steps) {
      const std::size_t next = direction > 0 ? (i + 1 == n ? 0 : i + 1) : (i == 0 ? n - 1 : i - 1);
      const double there = knot_distance2(next, x, y);
      if (there >= here) break;
      i = next;
      here = there;
    }
  }
  const CurveLocation found = refine(i, x, y);
  // The knots may lead away from the foot on the hint's own piece, where that is long.
  const bool near_it = i == first || i == (first + 1 == n ? 0 : first + 1);
  if (near_it || !may_be_nearer(first, x, y, std::abs(found.n))) return found;
  const CurveLocation own = nearest_on(first, x, y);
  return std::abs(own.n) < std::abs(found.n) ? own : found;
}

}  // namespace gripline
