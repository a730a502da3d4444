// A closed driving line through equally spaced samples: where it is between them, and where a car is along it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include <gripline/periodic.hpp>
#include <gripline/types.hpp>

namespace gripline::planning {

/// Two neighbouring samples and the weight of the second: value = lerp(sample[first], sample[second], weight).
struct Bracket {
  std::size_t first = 0, second = 0;
  double weight = 0;
};

/// The sample of a line that is nearest to a point; the first of several.
inline std::size_t nearest_sample(std::span<const LinePoint> samples, double x, double y) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double d2 = square(x - samples[i].x) + square(y - samples[i].y);
    if (d2 < least) {
      least = d2;
      best = i;
    }
  }
  return best;
}

/// Whether a point lies between the edges of the road beside a point of a line.
inline bool is_between_edges(const LinePoint& p, double x, double y) {
  const double n = -std::sin(p.yaw) * (x - p.x) + std::cos(p.yaw) * (y - p.y);
  return n <= p.left && n >= -p.right;
}

/// The sample of a closed line at which a car that faces `yaw` is, given the one that is nearest to it. Where a road
/// passes over itself, at 30 degrees or more, that may be of the other pass: a car that faces away from it is on the
/// stretch that runs its way, of those between whose edges it is.
inline std::size_t sample_facing(std::span<const LinePoint> samples, std::size_t nearest, double x, double y,
                                 double yaw) {
  constexpr double along = std::numbers::pi / 12.0;
  const auto askew = [&](std::size_t i) {
    return std::abs(std::remainder(yaw - samples[i].yaw, 2.0 * std::numbers::pi));
  };
  const auto distance2 = [&](std::size_t i) { return square(x - samples[i].x) + square(y - samples[i].y); };
  const std::size_t count = samples.size();
  std::size_t best = nearest;
  if (askew(nearest) <= along) return nearest;
  for (std::size_t i = 0; i < count; ++i) {
    const double here = distance2(i);
    if (distance2(i > 0 ? i - 1 : count - 1) < here || distance2(i + 1 < count ? i + 1 : 0) < here) continue;
    if (askew(i) < askew(best) && is_between_edges(samples[i], x, y)) best = i;
  }
  return best;
}

class ClosedLine {
 public:
  /// Samples equally spaced, the first not repeated; throws std::invalid_argument when there are fewer than eight.
  explicit ClosedLine(std::vector<LinePoint> samples) : samples_(std::move(samples)) {
    if (samples_.size() < 8) throw std::invalid_argument("a driving line needs at least 8 samples");
    spacing_ = (samples_.back().s - samples_.front().s) / static_cast<double>(samples_.size() - 1);
    length_ = spacing_ * static_cast<double>(samples_.size());
    if (!(spacing_ > 0.0)) throw std::invalid_argument("a driving line's samples must advance along it");
  }

  std::span<const LinePoint> samples() const { return samples_; }
  std::size_t size() const { return samples_.size(); }
  double length() const { return length_; }
  double spacing() const { return spacing_; }

  /// The samples on either side of station s [m], which may be laps away.
  Bracket bracket(double s) const {
    const double position = wrap_periodic(s, length_) / spacing_;
    const std::size_t i = std::min(static_cast<std::size_t>(position), samples_.size() - 1);
    return {i, next(i), position - static_cast<double>(i)};
  }

  /// Position by cubic Hermite interpolation between samples and their tangents, heading (unwrapped to within pi of
  /// the sample before it) of that cubic, the rest linear. `station` is the caller's to interpolate: it wraps.
  LinePoint at(double s) const {
    const Bracket b = bracket(s);
    const LinePoint& p = samples_[b.first];
    const LinePoint& q = samples_[b.second];
    LinePoint r = p;
    const Shape shape = hermite(p, q, b.weight);
    r.s = wrap_periodic(s, length_);
    r.x = shape.x;
    r.y = shape.y;
    r.yaw = p.yaw + std::remainder(std::atan2(shape.dy, shape.dx) - p.yaw, 2.0 * std::numbers::pi);
    const auto mix = [&](double from, double to) { return from + (to - from) * b.weight; };
    r.kappa = mix(p.kappa, q.kappa);
    r.left = mix(p.left, q.left);
    r.right = mix(p.right, q.right);
    r.grade = mix(p.grade, q.grade);
    r.bank = mix(p.bank, q.bank);
    return r;
  }

  struct Foot {
    double s = 0;         // of the nearest point, in [0, length)
    double distance = 0;  // to it [m]; of a search that has not settled, to the point before its last step
  };
  /// The nearest point of the whole line.
  Foot project(double x, double y) const { return refine(nearest_sample(samples_, x, y), x, y); }
  /// The same for a car that faces `yaw`: see sample_facing.
  Foot project_facing(double x, double y, double yaw) const {
    return refine(sample_facing(samples_, nearest_sample(samples_, x, y), x, y, yaw), x, y);
  }
  /// The nearest point that is reached from `hint` by always coming closer: it does not jump to a neighbouring stretch.
  Foot project(double x, double y, double hint) const {
    std::size_t i = bracket(hint).first;
    double d2 = distance2(i, x, y);
    for (std::size_t moves = 0; moves < samples_.size(); ++moves) {
      const double ahead = distance2(next(i), x, y);
      const double behind = distance2(previous(i), x, y);
      if (ahead >= d2 && behind >= d2) break;
      i = ahead < behind ? next(i) : previous(i);
      d2 = std::min(ahead, behind);
    }
    return refine(i, x, y);
  }

 private:
  struct Shape {
    double x = 0, y = 0, dx = 0, dy = 0;  // the point and its derivative by the weight
  };
  std::size_t next(std::size_t i) const { return i + 1 < samples_.size() ? i + 1 : 0; }
  std::size_t previous(std::size_t i) const { return i > 0 ? i - 1 : samples_.size() - 1; }
  double distance2(std::size_t i, double x, double y) const {
    return square(x - samples_[i].x) + square(y - samples_[i].y);
  }
  Shape hermite(const LinePoint& p, const LinePoint& q, double u) const {
    const double h00 = (1 + 2 * u) * (1 - u) * (1 - u), h01 = u * u * (3 - 2 * u);
    const double h10 = u * (1 - u) * (1 - u), h11 = u * u * (u - 1);
    const double g00 = 6 * u * (u - 1), g01 = -g00;
    const double g10 = (1 - u) * (1 - 3 * u), g11 = u * (3 * u - 2);
    const double px = spacing_ * std::cos(p.yaw), py = spacing_ * std::sin(p.yaw);
    const double qx = spacing_ * std::cos(q.yaw), qy = spacing_ * std::sin(q.yaw);
    return {h00 * p.x + h01 * q.x + h10 * px + h11 * qx, h00 * p.y + h01 * q.y + h10 * py + h11 * qy,
            g00 * p.x + g01 * q.x + g10 * px + g11 * qx, g00 * p.y + g01 * q.y + g10 * py + g11 * qy};
  }
  /// Foot of the perpendicular on the two cubics beside sample i: (p - point) . p' = 0 by Gauss-Newton steps. The
  /// distance is that before the last step, which hardly moves the foot.
  Foot refine(std::size_t i, double x, double y) const {
    double position = static_cast<double>(i);
    double distance = std::sqrt(distance2(i, x, y));
    for (int iteration = 0; iteration < 6; ++iteration) {
      const Bracket b = bracket(position * spacing_);
      const Shape p = hermite(samples_[b.first], samples_[b.second], b.weight);
      distance = std::hypot(x - p.x, y - p.y);
      const double move = ((x - p.x) * p.dx + (y - p.y) * p.dy) / (p.dx * p.dx + p.dy * p.dy);
      position = std::clamp(position + move, static_cast<double>(i) - 1.0, static_cast<double>(i) + 1.0);
    }
    return {wrap_periodic(position * spacing_, length_), distance};
  }

  std::vector<LinePoint> samples_;
  double spacing_ = 0, length_ = 0;
};

}  // namespace gripline::planning
