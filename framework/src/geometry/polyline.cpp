#include "geometry/polyline.hpp"

#include <algorithm>
#include <string>

namespace gripline {

std::vector<double> chord_lengths(std::span<const PlanePoint> points) {
  std::vector<double> lengths(points.size());
  for (std::size_t i = 0; i < lengths.size(); ++i)
    lengths[i] = distance(points[i], points[i + 1 == lengths.size() ? 0 : i + 1]);
  return lengths;
}

ClosedPolyline::ClosedPolyline(std::vector<PlanePoint> points) : points_(std::move(points)) {
  if (points_.size() > 1 && points_.front().x == points_.back().x && points_.front().y == points_.back().y)
    points_.pop_back();
  if (points_.size() < 3)
    throw GeometryError("a closed line needs at least 3 points, found " + std::to_string(points_.size()));
  stations_.reserve(points_.size());
  for (const double chord : chord_lengths(points_)) {
    stations_.push_back(length_);
    length_ += chord;
  }
}

ClosedPolyline::Foot ClosedPolyline::foot(std::size_t chord, double x, double y) const {
  const PlanePoint& from = points_[chord];
  const PlanePoint& to = points_[chord + 1 == points_.size() ? 0 : chord + 1];
  const double ex = to.x - from.x, ey = to.y - from.y;
  const double square = ex * ex + ey * ey;
  const double share = square > 0.0 ? std::clamp(((x - from.x) * ex + (y - from.y) * ey) / square, 0.0, 1.0) : 0.0;
  const double dx = x - from.x - share * ex, dy = y - from.y - share * ey;
  return {dx * dx + dy * dy, stations_[chord] + share * std::sqrt(square)};
}

double ClosedPolyline::nearest_station(double x, double y) const {
  Foot best = foot(0, x, y);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Foot other = foot(i, x, y);
    if (other.distance2 < best.distance2) best = other;
  }
  return wrap_periodic(best.station, length_);
}

double ClosedPolyline::nearest_station(double x, double y, std::size_t near) const {
  constexpr std::size_t beyond = 3;
  const std::size_t n = points_.size();
  Foot best = foot(near, x, y);
  for (const bool forward : {true, false}) {
    std::size_t chord = near, without_gain = 0;
    for (std::size_t k = 1; k < n && without_gain < beyond; ++k) {
      chord = forward ? (chord + 1 == n ? 0 : chord + 1) : (chord == 0 ? n - 1 : chord - 1);
      const Foot other = foot(chord, x, y);
      if (other.distance2 < best.distance2) {
        best = other;
        without_gain = 0;
      } else {
        ++without_gain;
      }
    }
  }
  return wrap_periodic(best.station, length_);
}

double ClosedPolyline::nearest_station(double x, double y, double around, double reach) const {
  if (!(2.0 * reach < length_)) return nearest_station(x, y);
  const std::size_t n = points_.size(), last = chord_at(wrap_periodic(around + reach, length_));
  std::size_t chord = chord_at(wrap_periodic(around - reach, length_));
  Foot best = foot(chord, x, y);
  while (chord != last) {
    chord = chord + 1 == n ? 0 : chord + 1;
    const Foot other = foot(chord, x, y);
    if (other.distance2 < best.distance2) best = other;
  }
  return wrap_periodic(best.station, length_);
}

/// The chord with a station in [0, length).
std::size_t ClosedPolyline::chord_at(double station) const {
  return static_cast<std::size_t>(std::upper_bound(stations_.begin(), stations_.end(), station) - stations_.begin()) -
         1;
}

double ClosedPolyline::as_fraction(double station) const {
  const double f = station / length_;
  return f < 1.0 ? f : 0.0;
}

PlanePoint ClosedPolyline::at(double s) const {
  s = wrap_periodic(s, length_);
  const std::size_t i = chord_at(s);
  const bool last = i + 1 == points_.size();
  const double width = (last ? length_ : stations_[i + 1]) - stations_[i];
  const double share = width > 0.0 ? (s - stations_[i]) / width : 0.0;
  const PlanePoint& from = points_[i];
  const PlanePoint& to = points_[last ? 0 : i + 1];
  return {from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
}

}  // namespace gripline
