#include "geometry/arc_path.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "util/numbers.hpp"

namespace gripline {
namespace {

void check_closure(const Pose& origin, const Pose& end, double closure) {
  const double gap = std::hypot(end.x - origin.x, end.y - origin.y);
  const double turn = std::abs(wrap_angle(end.yaw - origin.yaw));
  constexpr double degrees = 180.0 / std::numbers::pi;
  if (!(turn <= closure)) {
    throw GeometryError(
        format("the segments do not close: the last ends with heading %.6g deg, the first begins with %.6g deg",
               wrap_angle(end.yaw) * degrees, wrap_angle(origin.yaw) * degrees));
  }
  if (!(gap <= closure)) {
    throw GeometryError(
        format("the segments do not close: the last ends %.6g m from the start (%.0e m is accepted)", gap, closure));
  }
}

}  // namespace

ArcPath::ArcPath(const Pose& origin, std::span<const Segment> segments, double closure) {
  if (segments.empty()) throw GeometryError("a track needs at least one segment");
  Pose at = origin;
  pieces_.reserve(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    if (!(segment.length > 0.0) || !std::isfinite(segment.length) || !std::isfinite(segment.turn)) {
      throw GeometryError("segment " + std::to_string(i + 1) + " has no length");
    }
    Piece piece;
    piece.s = length_;
    piece.length = segment.length;
    piece.x = at.x;
    piece.y = at.y;
    piece.yaw = at.yaw;
    piece.cos_yaw = std::cos(at.yaw);
    piece.sin_yaw = std::sin(at.yaw);
    piece.kappa = segment.turn / segment.length;
    // From a centre a thousand and more lengths away, differences of places lose the digits that matter.
    piece.nearly_straight = std::abs(segment.turn) < 1e-3;
    if (piece.kappa != 0.0 && !piece.nearly_straight) {
      piece.centre_x = at.x - piece.sin_yaw / piece.kappa;
      piece.centre_y = at.y + piece.cos_yaw / piece.kappa;
    }
    const PlanePoint end = place_on(piece, piece.length, segment.turn);
    at = {end.x, end.y, at.yaw + segment.turn};
    length_ += piece.length;
    pieces_.push_back(piece);
  }
  check_closure(origin, at, closure);

  bucket_.resize(4 * pieces_.size());
  std::size_t piece = 0;
  for (std::size_t i = 0; i < bucket_.size(); ++i) {
    const double s = length_ * static_cast<double>(i) / static_cast<double>(bucket_.size());
    while (piece + 1 < pieces_.size() && pieces_[piece + 1].s <= s) ++piece;
    bucket_[i] = piece;
  }
}

const ArcPath::Piece& ArcPath::piece_at(double s) const {
  const auto share = static_cast<std::size_t>(s / length_ * static_cast<double>(bucket_.size()));
  std::size_t i = bucket_[std::min(share, bucket_.size() - 1)];
  while (i + 1 < pieces_.size() && pieces_[i + 1].s <= s) ++i;
  return pieces_[i];
}

/// Where the piece is after so many metres, having turned by `turned`.
PlanePoint ArcPath::place_on(const Piece& piece, double along, double turned) {
  if (piece.kappa == 0.0) return {piece.x + along * piece.cos_yaw, piece.y + along * piece.sin_yaw};
  if (piece.nearly_straight) {
    // The chord: it leaves at half the angle that the arc turns by.
    const double half = 0.5 * turned, chord = half == 0.0 ? along : along * std::sin(half) / half;
    return {piece.x + chord * std::cos(piece.yaw + half), piece.y + chord * std::sin(piece.yaw + half)};
  }
  const double yaw = piece.yaw + turned;
  return {piece.centre_x + std::sin(yaw) / piece.kappa, piece.centre_y - std::cos(yaw) / piece.kappa};
}

CurvePoint ArcPath::at(double s) const {
  s = wrap_periodic(s, length_);
  const Piece& piece = piece_at(s);
  const double along = s - piece.s;
  const PlanePoint place = place_on(piece, along, along * piece.kappa);
  return {s, place.x, place.y, wrap_angle(piece.yaw + along * piece.kappa), piece.kappa};
}

/// Distance along the piece, prolonged beyond both ends, of the foot of (x, y). An arc's foot is taken within half a
/// circle to both sides of its middle.
double ArcPath::foot(const Piece& piece, double x, double y) {
  const double ahead = (x - piece.x) * piece.cos_yaw + (y - piece.y) * piece.sin_yaw;
  if (piece.kappa == 0.0) return ahead;
  const double half = 0.5 * piece.length * piece.kappa;
  if (piece.nearly_straight) {
    const double left = (y - piece.y) * piece.cos_yaw - (x - piece.x) * piece.sin_yaw;
    const double turned = std::atan2(piece.kappa * ahead, 1.0 - piece.kappa * left);
    return 0.5 * piece.length + wrap_angle(turned - half) / piece.kappa;
  }
  const double sign = piece.kappa > 0.0 ? 1.0 : -1.0;
  // Heading of the tangent at the polar angle of (x, y) around the centre.
  const double yaw = std::atan2(sign * (x - piece.centre_x), -sign * (y - piece.centre_y));
  return 0.5 * piece.length + wrap_angle(yaw - piece.yaw - half) / piece.kappa;
}

CurveLocation ArcPath::describe(const Piece& piece, double along, double x, double y) const {
  CurveLocation place;
  place.s = wrap_periodic(piece.s + along, length_);
  place.kappa = piece.kappa;
  const PlanePoint base = place_on(piece, along, along * piece.kappa);
  const double yaw = piece.yaw + along * piece.kappa;
  const double dx = x - base.x, dy = y - base.y;
  const double side = std::cos(yaw) * dy - std::sin(yaw) * dx;
  place.n = std::copysign(std::hypot(dx, dy), side);
  place.yaw = wrap_angle(yaw);
  return place;
}

CurveLocation ArcPath::locate(double x, double y) const {
  const Piece* best = &pieces_.front();
  double best_along = 0.0, best_distance = INFINITY;
  for (const Piece& piece : pieces_) {
    const double along = std::clamp(foot(piece, x, y), 0.0, piece.length);
    const double distance = gripline::distance(place_on(piece, along, along * piece.kappa), {x, y});
    if (distance < best_distance) {
      best = &piece;
      best_along = along;
      best_distance = distance;
    }
  }
  return describe(*best, best_along, x, y);
}

CurveLocation ArcPath::locate(double x, double y, double hint_s) const {
  std::size_t i = static_cast<std::size_t>(&piece_at(wrap_periodic(hint_s, length_)) - pieces_.data());
  int direction = 0;
  for (std::size_t steps = 0; steps < pieces_.size(); ++steps) {
    const Piece& piece = pieces_[i];
    const double along = foot(piece, x, y);
    if (along > piece.length && direction >= 0) {
      direction = 1;
      i = i + 1 == pieces_.size() ? 0 : i + 1;
    } else if (along < 0.0 && direction <= 0) {
      direction = -1;
      i = i == 0 ? pieces_.size() - 1 : i - 1;
    } else {
      // Inside, or at a joint that is nearest from both of its sides.
      return describe(piece, std::clamp(along, 0.0, piece.length), x, y);
    }
  }
  return locate(x, y);
}

}  // namespace gripline
