#include "geometry/arc_path.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "util/numbers.hpp"

namespace gripline {
namespace {

void check_closure(const Pose& origin, const Pose& end, double closure) {
  const double gap = std::hypot(end.x - origin.x, end.y - origin.y);
  const double kink = std::abs(wrap_angle(end.yaw - origin.yaw));
  constexpr double degrees = 180.0 / std::numbers::pi;
  if (!(kink <= closure)) {
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
    if (piece.kappa == 0.0) {
      at.x += piece.length * piece.cos_yaw;
      at.y += piece.length * piece.sin_yaw;
    } else {
      piece.centre_x = at.x - piece.sin_yaw / piece.kappa;
      piece.centre_y = at.y + piece.cos_yaw / piece.kappa;
      at.yaw += segment.turn;
      at.x = piece.centre_x + std::sin(at.yaw) / piece.kappa;
      at.y = piece.centre_y - std::cos(at.yaw) / piece.kappa;
    }
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

CurvePoint ArcPath::at(double s) const {
  s = wrap_periodic(s, length_);
  const Piece& piece = piece_at(s);
  const double along = s - piece.s;
  CurvePoint point{s, 0.0, 0.0, 0.0, piece.kappa};
  if (piece.kappa == 0.0) {
    point.x = piece.x + along * piece.cos_yaw;
    point.y = piece.y + along * piece.sin_yaw;
    point.yaw = wrap_angle(piece.yaw);
  } else {
    const double yaw = piece.yaw + along * piece.kappa;
    point.x = piece.centre_x + std::sin(yaw) / piece.kappa;
    point.y = piece.centre_y - std::cos(yaw) / piece.kappa;
    point.yaw = wrap_angle(yaw);
  }
  return point;
}

/// Distance along the piece, prolonged beyond both ends, of the foot of (x, y). An arc's foot is taken within half a
/// circle to both sides of its middle.
double ArcPath::foot(const Piece& piece, double x, double y) {
  if (piece.kappa == 0.0) return (x - piece.x) * piece.cos_yaw + (y - piece.y) * piece.sin_yaw;
  const double sign = piece.kappa > 0.0 ? 1.0 : -1.0;
  // Heading of the tangent at the polar angle of (x, y) around the centre.
  const double yaw = std::atan2(sign * (x - piece.centre_x), -sign * (y - piece.centre_y));
  const double half = 0.5 * piece.length * piece.kappa;
  return 0.5 * piece.length + wrap_angle(yaw - piece.yaw - half) / piece.kappa;
}

CurveLocation ArcPath::describe(const Piece& piece, double along, double x, double y) const {
  CurveLocation place;
  place.s = wrap_periodic(piece.s + along, length_);
  place.kappa = piece.kappa;
  double base_x = 0.0, base_y = 0.0, yaw = piece.yaw;
  if (piece.kappa == 0.0) {
    base_x = piece.x + along * piece.cos_yaw;
    base_y = piece.y + along * piece.sin_yaw;
  } else {
    yaw += along * piece.kappa;
    base_x = piece.centre_x + std::sin(yaw) / piece.kappa;
    base_y = piece.centre_y - std::cos(yaw) / piece.kappa;
  }
  const double dx = x - base_x, dy = y - base_y;
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
    double distance = 0.0;
    if (piece.kappa == 0.0) {
      distance = std::hypot(x - piece.x - along * piece.cos_yaw, y - piece.y - along * piece.sin_yaw);
    } else {
      const double yaw = piece.yaw + along * piece.kappa;
      distance = std::hypot(x - piece.centre_x - std::sin(yaw) / piece.kappa,
                            y - piece.centre_y + std::cos(yaw) / piece.kappa);
    }
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
