#include "geometry/track_checks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/crossings.hpp"
#include "geometry/place_text.hpp"
#include "geometry/road_stations.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Half widths beyond those of roads, for a lap so short, may be centimetres; "" where they are not.
std::string doubt_about_widths(double length, double half_width) {
  constexpr double usual = 10.0, shortest = 10.0;  // [m], half width; lap per width
  if (half_width <= usual || length >= shortest * 2.0 * half_width) return {};
  return format("; a lap of %.4g m with widths of %.4g m: are the widths metres?", length, 2.0 * half_width);
}

/// Throws the reason why two stations share a place: a bend between them that is too sharp for the width, or a road
/// that crosses itself.
[[noreturn]] void refuse_overlap(const TrackShape& shape, const CurvePoint& here, const CurvePoint& other,
                                 double half_width, const Crossings& crossings) {
  const double length = shape.centre.length();
  const double way = wrap_difference(other.s - here.s, length);
  constexpr int steps = 200;
  CurvePoint sharpest = here;
  for (int i = 0; i <= steps; ++i) {
    const CurvePoint at = shape.centre.at(here.s + way * i / steps);
    if (std::abs(at.kappa) > std::abs(sharpest.kappa)) sharpest = at;
  }
  if (std::abs(way) < 2.0 * std::numbers::pi * half_width && std::abs(sharpest.kappa) * half_width > 1.0) {
    throw GeometryError(
        format("the road bends more sharply (radius %.4g m at s = %.4g m) than its half width %.4g m allows",
               1.0 / std::abs(sharpest.kappa), sharpest.s, half_width) +
        doubt_about_widths(length, half_width));
  }
  std::string text = format(
      "the road crosses or overlaps itself: it comes to %s at s = %.4g m and at s = "
      "%.4g m",
      place_text(here.x, here.y).c_str(), std::min(here.s, other.s), std::max(here.s, other.s));
  if (!crossings.at_grade().empty()) {
    const Crossing& c = crossings.at_grade().front();
    text += format("; a bridge at %s? \"bridges\": true says so, or heights that differ by %.3g m there",
                   place_text(c.x, c.y).c_str(), crossings.clearance());
  } else if (!crossings.shallow().empty()) {
    const Crossing& c = crossings.shallow().front();
    text += format("; a crossing at %.3g degrees, near %s, is no bridge: expected 30 or more",
                   c.angle * 180.0 / std::numbers::pi, place_text(c.x, c.y).c_str());
  }
  throw GeometryError(text + doubt_about_widths(length, half_width));
}

/// Looks for places where a road overlaps itself and no bridge is. A place is refused at the first station of the road
/// that shares it.
class Overlaps {
 public:
  /// The shape must outlive it.
  explicit Overlaps(const TrackShape& shape)
      : shape_(shape),
        length_(shape.centre.length()),
        narrow_(shape.narrowest_half()),
        road_(road_stations(shape, 0.25 * narrow_)),
        squares_(road_, shape.widest_half()) {}
  Overlaps(const Overlaps&) = delete;
  Overlaps& operator=(const Overlaps&) = delete;

  void check_edges();
  void check_retrace();
  void check_thin();
  /// Those that explain the overlaps seen; none where none was.
  std::vector<Crossing> bridges() const { return crossings_ ? crossings_->bridges() : std::vector<Crossing>{}; }

 private:
  bool edge_lies_on(const RoadStation& here, double offset, const PlanePoint& edge, const RoadStation& other) const;
  bool runs_over(const RoadStation& here, const RoadStation& other) const;
  /// Looked for when the road overlaps: most roads do so nowhere.
  const Crossings& crossings() {
    if (!crossings_) crossings_.emplace(shape_, road_);
    return *crossings_;
  }

  static constexpr double tolerated_ = 0.9;  // an inner edge drawn through points may fold a little at a kink
  static constexpr double together_ = 0.5;   // of a half width: two centre lines that are one

  const TrackShape& shape_;
  double length_, narrow_;  // [m]
  std::vector<RoadStation> road_;
  StationSquares squares_;
  std::optional<Crossings> crossings_;
};

/// Whether the place on the edge `offset` [m] to the left of one station lies inside the road at another one.
bool Overlaps::edge_lies_on(const RoadStation& here, double offset, const PlanePoint& edge,
                            const RoadStation& other) const {
  constexpr double pi = std::numbers::pi;
  const double dx = edge.x - other.centre.x, dy = edge.y - other.centre.y;
  const double square = dx * dx + dy * dy;
  const auto within = [&](double half_width) { return square < std::pow(tolerated_ * half_width, 2); };
  const bool on_left = dy * std::cos(other.centre.yaw) - dx * std::sin(other.centre.yaw) > 0.0;
  const double half_width = on_left ? other.left : other.right;
  if (!within(half_width)) return false;
  // Its own neighbourhood does not count, where one width changes into another.
  const double way = std::abs(wrap_difference(here.centre.s - other.centre.s, length_));
  if (way <= 0.5 * narrow_) return false;
  // Within a bend, and beside a part that is wider, the edge of a narrow part may lie less than a half width from a
  // wide part: it is inside that only if it is nearer to it than to its own centre line.
  const bool along = std::abs(wrap_angle(here.centre.yaw - other.centre.yaw)) < 0.5 * pi;
  return way >= pi * std::max(std::abs(offset), along ? half_width : 0.0) || within(offset);
}

/// The road overlaps itself where a place on its edge lies inside the road at another station. On a sound road the
/// centre line comes no nearer to a place on the edge than that edge's own half width.
void Overlaps::check_edges() {
  const double reach = tolerated_ * shape_.widest_half();
  for (const RoadStation& here : road_) {
    for (const double offset : {here.left, -here.right}) {
      const PlanePoint edge{here.centre.x - offset * std::sin(here.centre.yaw),
                            here.centre.y + offset * std::cos(here.centre.yaw)};
      std::size_t first = road_.size();  // the first station that shares the place
      squares_.visit_near(edge.x, edge.y, reach, [&](std::size_t i) {
        if (i > first || !edge_lies_on(here, offset, edge, road_[i])) return;
        if (!crossings().bridge_explains(here.centre.s, road_[i].centre.s)) first = i;
      });
      if (first < road_.size()) refuse_overlap(shape_, here.centre, road_[first].centre, std::abs(offset), crossings());
    }
  }
}

/// Whether two stations' centre lines meet though the way between them is no bend.
bool Overlaps::runs_over(const RoadStation& here, const RoadStation& other) const {
  constexpr double turned = 2.0 / 3.0 * std::numbers::pi;
  const double width = std::min(std::min(here.left, here.right), std::min(other.left, other.right));
  const double dx = here.centre.x - other.centre.x, dy = here.centre.y - other.centre.y;
  if (dx * dx + dy * dy >= together_ * together_ * width * width) return false;
  const double way = std::abs(wrap_difference(here.centre.s - other.centre.s, length_));
  return way > 2.0 * width || std::abs(wrap_angle(here.centre.yaw - other.centre.yaw)) >= turned;
}

/// A road that comes back over itself, the same line again or the other way, has edges that keep their distance from
/// every centre line: only the centre lines meet. A sound road's centre line bends no sharper than its half width w, so
/// after 2 w of way it is 2 w sin(1) from where it was, and while it turns by 120 degrees it gets 2 w sin(60 deg) away.
void Overlaps::check_retrace() {
  for (std::size_t i = 0; i < road_.size(); ++i) {
    const RoadStation& here = road_[i];
    std::size_t first = road_.size();
    squares_.visit_near(here.centre.x, here.centre.y, together_ * std::min(here.left, here.right), [&](std::size_t j) {
      if (j <= i || j > first || !runs_over(here, road_[j])) return;
      if (!crossings().bridge_explains(here.centre.s, road_[j].centre.s)) first = j;
    });
    if (first == road_.size()) continue;
    throw GeometryError(format("the road runs over itself: it is at %s at s = %.4g m and again at s = %.4g m",
                               place_text(here.centre.x, here.centre.y).c_str(), here.centre.s, road_[first].centre.s));
  }
}

/// Stations that lie further apart than the road is wide may miss a crossing; the pieces of the centre line between
/// them do not.
void Overlaps::check_thin() {
  const double step = length_ / static_cast<double>(road_.size());
  if (step <= narrow_) return;
  if (const Crossing* c = crossings().no_bridge())
    refuse_overlap(shape_, shape_.centre.at(c->first), shape_.centre.at(c->second), narrow_, crossings());
}

/// Lengths are metres; a file in millimetres gives a road wider than any, or with widths in metres a longer one for its
/// width than any: the longest circuit ever raced, 148 km of roads in Sicily, had about 5 m. One in kilometres or
/// degrees is shorter than it is wide.
void check_units(const TrackShape& shape) {
  constexpr double widest = 100.0, longest = 4e4;  // [m], half width; lap per width
  const StationTable &right = shape.half_width_right, &left = shape.half_width_left;
  const double half = std::max(right.maximum(), left.maximum()), length = shape.centre.length();
  if (half > widest || length > longest * (right.maximum() + left.maximum()))
    throw GeometryError(
        format("a lap of %.0f m with widths of %.4g m: millimetres? Lengths are metres", length, 2.0 * half));
  const double narrow = right.minimum() + left.minimum();
  if (length < narrow)
    throw GeometryError(
        format("a lap of %.4g m with widths of %.4g m: kilometres, degrees, or widths in another unit? Lengths are "
               "metres",
               length, narrow));
}

/// The road must come back to its height: the integral of tan(grade) over a lap is zero, up to a hundredth of the
/// climb.
void check_height(const TrackShape& shape) {
  if (shape.grade.constant() && shape.grade.minimum() == 0.0) return;
  const double length = shape.centre.length();
  const int count = static_cast<int>(std::clamp(length / 0.1, 4000.0, 200000.0));
  const double step = length / count;
  double height = 0.0, climb = 0.0;
  for (int i = 0; i < count; ++i) {
    const double rise = step * std::tan(shape.grade.at((i + 0.5) * step));
    height += rise;
    climb += std::max(rise, 0.0);
  }
  if (!(std::abs(height) <= 0.01 * climb)) {
    throw GeometryError(format(
        "the grade does not close: after one lap the road is %.4g m %s than where it began (its climb is %.4g m, "
        "1 %% of that is accepted)",
        std::abs(height), height > 0.0 ? "higher" : "lower", climb));
  }
}

/// " at s = 12.3 m", where a table has a value of this size; "" if it is constant.
std::string station_text(const StationTable& table, double size) {
  for (const double s : table.stations())
    if (std::abs(table.at(s)) == std::abs(size)) return format(" at s = %.5g m", s);
  return "";
}

void check_widths(const TrackShape& shape) {
  for (const StationTable* table : {&shape.half_width_right, &shape.half_width_left}) {
    if (!(table->minimum() > 0.0) || !std::isfinite(table->maximum())) {
      throw GeometryError(format("the %s half width is %.4g m%s, expected more than 0",
                                 table == &shape.half_width_right ? "right" : "left", table->minimum(),
                                 station_text(*table, table->minimum()).c_str()));
    }
  }
  if (!(std::min(shape.wall_right.minimum(), shape.wall_left.minimum()) >= 0.0)) {
    throw GeometryError("a wall stands inside the road: its distance beyond the edge must be 0 or more");
  }
  for (const StationTable* table : {&shape.grade, &shape.bank}) {
    const double steepest = std::max(std::abs(table->minimum()), table->maximum());
    if (!(steepest < 0.8)) {
      throw GeometryError(format("the %s is %.4g rad%s, expected less than 0.8",
                                 table == &shape.grade ? "grade" : "bank", steepest,
                                 station_text(*table, steepest).c_str()));
    }
  }
}

}  // namespace

std::vector<Crossing> check_shape(const TrackShape& shape) {
  check_widths(shape);
  check_units(shape);
  Overlaps overlaps(shape);
  overlaps.check_edges();
  overlaps.check_retrace();
  overlaps.check_thin();
  check_height(shape);
  return overlaps.bridges();
}

std::string check_start(const Track& track, const Pose& start) {
  constexpr double degrees = 180.0 / std::numbers::pi;
  const CurveLocation place = track.locate(start);
  const double heading = wrap_angle(start.yaw - place.yaw);
  if (!track.inside(place)) {
    const bool left = place.n > 0.0;
    return format(
        "start %s is off the track: %.4g m %s of the centre line at s = %.4g m, where the half width is %.4g m",
        place_text(start.x, start.y).c_str(), std::abs(place.n), left ? "left" : "right", place.s,
        left ? track.half_width_left(place.s) : track.half_width_right(place.s));
  }
  if (std::abs(heading) > 0.5 * std::numbers::pi) {
    return format("start faces backwards: yaw %.4g deg, but the track runs %.4g deg there",
                  wrap_angle(start.yaw) * degrees, place.yaw * degrees);
  }
  return {};
}

std::string check_car_fits(const Track& track, double car_width) {
  if (car_width < track.narrowest()) return {};
  return format("the car is %.4g m wide, the track only %.4g m at its narrowest", car_width, track.narrowest());
}

}  // namespace gripline
