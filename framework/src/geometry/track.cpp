#include "geometry/track.hpp"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <utility>

#include "geometry/place_text.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Places along a road at equal steps, fine enough to see an overlap of a fraction of the width.
struct Station {
  CurvePoint centre;
  double right = 0.0, left = 0.0;
};

/// Stations by squares of the plane.
class Squares {
 public:
  Squares(const std::vector<Station>& road, double size) : road_(road), size_(size) {
    for (std::size_t i = 0; i < road.size(); ++i) {
      const CurvePoint& at = road[i].centre;
      members_.push_back({column(at.x), column(at.y), i});
    }
    std::sort(members_.begin(), members_.end());
  }

  /// The stations nearer to a place than `reach`, which is at most the size of the squares, in no order.
  const std::vector<std::size_t>& near(double x, double y, double reach) {
    found_.clear();
    for (std::int64_t i = column(x) - 1; i <= column(x) + 1; ++i) {
      auto member = std::lower_bound(members_.begin(), members_.end(), Member{i, column(y) - 1, 0});
      for (; member != members_.end() && member->x == i && member->y <= column(y) + 1; ++member) {
        const double dx = x - road_[member->station].centre.x, dy = y - road_[member->station].centre.y;
        if (dx * dx + dy * dy < reach * reach) found_.push_back(member->station);
      }
    }
    return found_;
  }

 private:
  struct Member {
    std::int64_t x = 0, y = 0;
    std::size_t station = 0;
    auto operator<=>(const Member&) const = default;
  };
  std::int64_t column(double place) const { return static_cast<std::int64_t>(std::floor(place / size_)); }

  const std::vector<Station>& road_;
  double size_;
  std::vector<Member> members_;
  std::vector<std::size_t> found_;
};

double widest_half(const TrackShape& shape) {
  return std::max(shape.half_width_right.maximum(), shape.half_width_left.maximum());
}
double narrowest_half(const TrackShape& shape) {
  return std::min(shape.half_width_right.minimum(), shape.half_width_left.minimum());
}

/// Every `spacing` metres, or fewer where a road that is wide for its narrowest place would take too long to compare.
std::vector<Station> stations(const TrackShape& shape, double spacing) {
  constexpr double fewest = 64.0, always = 6000.0, most = 400000.0, comparisons = 1e7;
  const double length = shape.centre.length();
  const double bearable = std::clamp(std::sqrt(comparisons * length / widest_half(shape)), always, most);
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(length / spacing), fewest, bearable));
  std::vector<Station> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double s = length * static_cast<double>(i) / static_cast<double>(count);
    result[i] = {shape.centre.at(s), shape.half_width_right.at(s), shape.half_width_left.at(s)};
  }
  return result;
}

/// Height of a station above the road's first one [m].
double height_at(const TrackShape& shape, double s) {
  if (shape.grade.constant()) return s * std::tan(shape.grade.minimum());
  const int count = static_cast<int>(std::clamp(s / 0.1, 1000.0, 100000.0));
  double height = 0.0;
  for (int i = 0; i < count; ++i) height += s / count * std::tan(shape.grade.at((i + 0.5) * s / count));
  return height;
}

/// Where two straight pieces of the centre line cross, with the shares of both pieces. Ends count: rounding must not
/// lose a crossing between two pieces.
std::optional<std::pair<double, double>> intersection(const CurvePoint& a, const CurvePoint& b, const CurvePoint& c,
                                                      const CurvePoint& d) {
  const double ux = b.x - a.x, uy = b.y - a.y, vx = d.x - c.x, vy = d.y - c.y;
  const double cross = ux * vy - uy * vx, wx = c.x - a.x, wy = c.y - a.y;
  if (cross == 0.0) return std::nullopt;
  const double u = (wx * vy - wy * vx) / cross, v = (wx * uy - wy * ux) / cross;
  constexpr double rounding = 1e-9;
  const auto within = [](double share) { return share >= -rounding && share <= 1.0 + rounding; };
  if (!within(u) || !within(v)) return std::nullopt;
  return std::pair(u, v);
}

/// The crossing of two passes whose straight pieces meet at these stations.
Crossing crossing_at(const TrackShape& shape, double a, double b, double step) {
  const double length = shape.centre.length();
  const auto station = [&](double s) {
    return std::abs(wrap_difference(s, length)) < 1e-6 * step ? 0.0 : wrap_periodic(s, length);
  };
  const double first = std::min(station(a), station(b)), second = std::max(station(a), station(b));
  const CurvePoint here = shape.centre.at(first), there = shape.centre.at(second);
  const auto rounded = [&](double metres) { return std::abs(metres) < 1e-3 * step ? 0.0 : metres; };
  const double turned = std::abs(wrap_angle(here.yaw - there.yaw));
  return {first,
          second,
          rounded(0.5 * (here.x + there.x)),
          rounded(0.5 * (here.y + there.y)),
          std::min(turned, std::numbers::pi - turned),
          height_at(shape, second) - height_at(shape, first)};
}

/// Where the centre line crosses itself. Looked for only when the road overlaps: most roads need none of it.
std::vector<Crossing> find_crossings(const TrackShape& shape, const std::vector<Station>& road) {
  const std::size_t n = road.size();
  const double length = shape.centre.length(), step = length / static_cast<double>(n);
  std::vector<Crossing> found;
  const auto known = [&](const Crossing& c) {
    const auto near = [&](double s, double other) { return std::abs(wrap_difference(s - other, length)) < 0.5 * step; };
    return std::any_of(found.begin(), found.end(), [&](const Crossing& other) {
      return (near(c.first, other.first) && near(c.second, other.second)) ||
             (near(c.first, other.second) && near(c.second, other.first));
    });
  };
  Squares squares(road, 3.0 * step);
  for (std::size_t i = 0; i < n; ++i) {
    const CurvePoint &a = road[i].centre, &b = road[i + 1 == n ? 0 : i + 1].centre;
    std::vector<std::size_t> near = squares.near(a.x, a.y, 3.0 * step);
    std::sort(near.begin(), near.end());
    for (const std::size_t j : near) {
      if (j < i + 2) continue;
      const CurvePoint &c = road[j].centre, &d = road[j + 1 == n ? 0 : j + 1].centre;
      if (std::abs(a.x - c.x) > 2.0 * step || std::abs(a.y - c.y) > 2.0 * step || (i == 0 && j + 1 == n)) continue;
      const auto shares = intersection(a, b, c, d);
      if (!shares) continue;
      const Crossing one = crossing_at(shape, a.s + shares->first * step, c.s + shares->second * step, step);
      if (!known(one)) found.push_back(one);
    }
  }
  return found;
}

/// The crossings of a road that are bridges, and which overlaps they explain.
class Bridges {
 public:
  explicit Bridges(const TrackShape& shape) : shape_(&shape) {}

  /// Whether the centre line crosses itself where no bridge is.
  bool crosses(const std::vector<Station>& road) {
    if (!searched_) search(road);
    return !level_.empty() || !flat_.empty();
  }
  /// Whether stations a and b share a place because one passes over the other nearby.
  bool explain(double a, double b, const std::vector<Station>& road) {
    if (!searched_) search(road);
    const auto near = [&](double s, double at, const Crossing& c) {
      return std::abs(wrap_difference(s - at, shape_->centre.length())) <= reach(c);
    };
    return std::any_of(found_.begin(), found_.end(), [&](const Crossing& c) {
      return (near(a, c.first, c) && near(b, c.second, c)) || (near(a, c.second, c) && near(b, c.first, c));
    });
  }
  /// Way from the crossing within which the two passes overlap, and a little more [m].
  double reach(const Crossing& c) const { return 2.6 * widest_half(*shape_) / std::sin(c.angle); }
  const std::vector<Crossing>& found() const { return found_; }
  /// Crossings at an angle at which nothing says that they are bridges.
  const std::vector<Crossing>& level() const { return level_; }
  /// Crossings at too small an angle for a bridge.
  const std::vector<Crossing>& flat() const { return flat_; }
  double clearance() const { return 0.25 * (shape_->half_width_right.minimum() + shape_->half_width_left.minimum()); }

 private:
  void search(const std::vector<Station>& road) {
    constexpr double least_angle = std::numbers::pi / 6.0;
    searched_ = true;
    for (const Crossing& c : find_crossings(*shape_, road)) {
      if (c.angle < least_angle) {
        flat_.push_back(c);
        continue;
      }
      (shape_->bridges || std::abs(c.height) >= clearance() ? found_ : level_).push_back(c);
    }
  }

  const TrackShape* shape_;
  std::vector<Crossing> found_, level_, flat_;
  bool searched_ = false;
};

/// Half widths beyond those of roads, for a lap so short, may be centimetres; "" where they are not.
std::string doubt_about_widths(double length, double half_width) {
  constexpr double usual = 10.0, shortest = 10.0;  // [m], half width; lap per width
  if (half_width <= usual || length >= shortest * 2.0 * half_width) return {};
  return format("; a lap of %.4g m with widths of %.4g m: are the widths metres?", length, 2.0 * half_width);
}

/// Throws the reason why two stations share a place: a bend between them that is too sharp for the width, or a road
/// that crosses itself.
[[noreturn]] void refuse_overlap(const TrackShape& shape, const CurvePoint& here, const CurvePoint& other,
                                 double half_width, const Bridges& bridges) {
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
  if (!bridges.level().empty()) {
    const Crossing& c = bridges.level().front();
    text += format("; a bridge at %s? \"bridges\": true says so, or heights that differ by %.3g m there",
                   place_text(c.x, c.y).c_str(), bridges.clearance());
  }
  if (bridges.level().empty() && !bridges.flat().empty()) {
    const Crossing& c = bridges.flat().front();
    text += format("; a crossing at %.3g degrees, near %s, is no bridge: expected 30 or more",
                   c.angle * 180.0 / std::numbers::pi, place_text(c.x, c.y).c_str());
  }
  throw GeometryError(text + doubt_about_widths(length, half_width));
}

/// The road overlaps itself where a place on its edge lies inside the road at another station. On a sound road the
/// centre line comes no nearer to a place on the edge than that edge's own half width.
void check_overlap(const TrackShape& shape, const std::vector<Station>& road, Squares& squares, Bridges& bridges) {
  constexpr double tolerated = 0.9;  // an inner edge drawn through points may fold a little at a kink
  constexpr double pi = std::numbers::pi;
  const double narrow = narrowest_half(shape), reach = tolerated * widest_half(shape);
  const double length = shape.centre.length();
  for (const Station& here : road) {
    for (const double offset : {here.left, -here.right}) {
      const double x = here.centre.x - offset * std::sin(here.centre.yaw);
      const double y = here.centre.y + offset * std::cos(here.centre.yaw);
      std::size_t first = road.size();  // the first station that shares the place
      for (const std::size_t i : squares.near(x, y, reach)) {
        if (i > first) continue;
        const Station& other = road[i];
        const double dx = x - other.centre.x, dy = y - other.centre.y;
        const double square = dx * dx + dy * dy;
        const auto within = [&](double half_width) { return square < std::pow(tolerated * half_width, 2); };
        const bool on_left = dy * std::cos(other.centre.yaw) - dx * std::sin(other.centre.yaw) > 0.0;
        const double half_width = on_left ? other.left : other.right;
        if (!within(half_width)) continue;
        // Its own neighbourhood does not count, where one width changes into another.
        const double way = std::abs(wrap_difference(here.centre.s - other.centre.s, length));
        if (way <= 0.5 * narrow) continue;
        // Within a bend, and beside a part that is wider, the edge of a narrow part may lie less than a half width from
        // a wide part: it is inside that only if it is nearer to it than to its own centre line.
        const bool along = std::abs(wrap_angle(here.centre.yaw - other.centre.yaw)) < 0.5 * pi;
        if (way < pi * std::max(std::abs(offset), along ? half_width : 0.0) && !within(offset)) continue;
        if (!bridges.explain(here.centre.s, other.centre.s, road)) first = i;
      }
      if (first < road.size()) refuse_overlap(shape, here.centre, road[first].centre, std::abs(offset), bridges);
    }
  }
}

/// A road that comes back over itself, the same line again or the other way, has edges that keep their distance from
/// every centre line: only the centre lines meet. A sound road's centre line bends no sharper than its half width w, so
/// after 2 w of way it is 2 w sin(1) from where it was, and while it turns by 120 degrees it gets 2 w sin(60 deg) away.
void check_retrace(const TrackShape& shape, const std::vector<Station>& road, Squares& squares, Bridges& bridges) {
  constexpr double together = 0.5, turned = 2.0 / 3.0 * std::numbers::pi;
  const double length = shape.centre.length();
  for (std::size_t i = 0; i < road.size(); ++i) {
    const CurvePoint& here = road[i].centre;
    std::size_t first = road.size();
    for (const std::size_t j : squares.near(here.x, here.y, together * std::min(road[i].left, road[i].right))) {
      if (j <= i || j > first) continue;
      const CurvePoint& other = road[j].centre;
      const double width = std::min(std::min(road[i].left, road[i].right), std::min(road[j].left, road[j].right));
      const double dx = here.x - other.x, dy = here.y - other.y;
      if (dx * dx + dy * dy >= together * together * width * width) continue;
      const double way = std::abs(wrap_difference(here.s - other.s, length));
      if (way <= 2.0 * width && std::abs(wrap_angle(here.yaw - other.yaw)) < turned) continue;
      if (!bridges.explain(here.s, other.s, road)) first = j;
    }
    if (first == road.size()) continue;
    throw GeometryError(format("the road runs over itself: it is at %s at s = %.4g m and again at s = %.4g m",
                               place_text(here.x, here.y).c_str(), here.s, road[first].centre.s));
  }
}

/// Stations that lie further apart than the road is wide may miss a crossing; the pieces of the centre line between
/// them do not.
void check_thin(const TrackShape& shape, const std::vector<Station>& road, Bridges& bridges) {
  const double step = shape.centre.length() / static_cast<double>(road.size());
  if (step <= narrowest_half(shape) || !bridges.crosses(road)) return;
  const Crossing& c = bridges.level().empty() ? bridges.flat().front() : bridges.level().front();
  refuse_overlap(shape, shape.centre.at(c.first), shape.centre.at(c.second), narrowest_half(shape), bridges);
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

/// The sum of two tables that are linear between their stations is least at a station of one of them.
double narrowest_width(const TrackShape& shape) {
  const StationTable &left = shape.half_width_left, &right = shape.half_width_right;
  double narrowest = left.at(0.0) + right.at(0.0);
  for (const StationTable* table : {&left, &right})
    for (const double s : table->stations()) narrowest = std::min(narrowest, left.at(s) + right.at(s));
  return narrowest;
}

}  // namespace

Track::Track(TrackShape shape) : shape_(std::move(shape)), length_(shape_.centre.length()) {
  check_widths(shape_);
  check_units(shape_);
  const double narrow = narrowest_half(shape_);
  const std::vector<Station> road = stations(shape_, 0.25 * narrow);
  Squares squares(road, widest_half(shape_));
  Bridges bridges(shape_);
  check_overlap(shape_, road, squares, bridges);
  check_retrace(shape_, road, squares, bridges);
  check_thin(shape_, road, bridges);
  crossings_ = bridges.found();
  check_height(shape_);
  narrowest_ = narrowest_width(shape_);
  const CurvePoint first = shape_.centre.at(0.0);
  start_ = shape_.start.value_or(Pose{first.x, first.y, first.yaw});
}

CurveLocation Track::locate(const Pose& pose) const {
  CurveLocation best = locate(pose.x, pose.y);
  const auto askew = [&](const CurveLocation& at) { return std::abs(wrap_angle(pose.yaw - at.yaw)); };
  for (const Crossing& c : crossings_)
    for (const double s : {c.first, c.second}) {
      const CurveLocation other = locate(pose.x, pose.y, s);
      if (inside(other) && askew(other) < askew(best)) best = other;
    }
  return best;
}

double Track::beyond_edge(const CurveLocation& place) const {
  return place.n >= 0.0 ? place.n - half_width_left(place.s) : -place.n - half_width_right(place.s);
}

Track::Slope Track::slope(const CurveLocation& place, double yaw) const {
  const double cosine = std::cos(yaw - place.yaw), sine = std::sin(yaw - place.yaw);
  const double up = std::sin(shape_.grade.at(place.s)), across = std::sin(shape_.bank.at(place.s));
  const auto angle = [](double part) { return std::asin(std::clamp(part, -1.0, 1.0)); };
  return {angle(up * cosine - across * sine), angle(up * sine + across * cosine)};
}

double Track::wall_clearance(const CurveLocation& place) const {
  return (place.n >= 0.0 ? shape_.wall_left : shape_.wall_right).at(place.s) - beyond_edge(place);
}

double Track::lap_fraction(double x, double y, const CurveLocation& place) const {
  const SplinePath* spline = shape_.centre.spline();
  if (shape_.points && spline != nullptr) return shape_.points->fraction(x, y, spline->knot_before(place.s));
  const double f = place.s / length_;
  return f < 1.0 ? f : 0.0;
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
