#include "geometry/course_adapter.hpp"

#include <cmath>

#include "geometry/racing_line.hpp"

namespace gripline {

CoursePoint TrackCourse::fill(double s, double n) const {
  const CurvePoint centre = track_.at(s);
  CoursePoint p;
  p.s = s;
  p.n = n;
  p.x = centre.x;
  p.y = centre.y;
  p.yaw = centre.yaw;
  p.kappa = centre.kappa;
  p.left = track_.half_width_left(s);
  p.right = track_.half_width_right(s);
  p.grade = track_.grade(s);
  p.bank = track_.bank(s);
  p.lap_fraction = track_.lap_fraction(centre.x - n * std::sin(centre.yaw), centre.y + n * std::cos(centre.yaw),
                                       {s, n, centre.yaw, centre.kappa});
  return p;
}

CoursePoint TrackCourse::at(double s) const { return fill(track_.wrap(s), 0.0); }

CoursePoint TrackCourse::locate(double x, double y, double hint_s) const {
  const CurveLocation found = std::isnan(hint_s) ? track_.locate(x, y) : track_.locate(x, y, hint_s);
  return fill(found.s, found.n);
}

void TrackCourse::minimum_curvature(const LineOptions& options, std::span<LinePoint> line) const {
  RacingLineOptions wanted;
  wanted.car_width = car_.width;
  wanted.margin = options.margin;
  wanted.max_curvature = options.max_curvature;
  const RacingLine found = minimum_curvature_line(track_, wanted);
  const double length = found.length();
  double hint = std::nan("");
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double s = length * static_cast<double>(i) / static_cast<double>(line.size());
    const CurvePoint on = found.curve.at(s);
    const CurveLocation place =
        std::isnan(hint) ? track_.locate(Pose{on.x, on.y, on.yaw}) : track_.locate(on.x, on.y, hint);
    hint = place.s;
    LinePoint& p = line[i];
    p.s = s;
    p.x = on.x;
    p.y = on.y;
    p.yaw = on.yaw;
    p.kappa = on.kappa;
    p.station = place.s;
    p.left = track_.half_width_left(place.s) - place.n;
    p.right = track_.half_width_right(place.s) + place.n;
    p.grade = track_.grade(place.s);
    p.bank = track_.bank(place.s);
  }
}

Place place_of(const Track& track, const CurveLocation& location, double t, double x, double y, double yaw) {
  const CurvePoint centre = track.at(location.s);
  Place place;
  place.t = t;
  place.s = location.s;
  place.n = location.n;
  place.lap_fraction = track.lap_fraction(x, y, location);
  place.yaw_line = centre.yaw;
  place.kappa = centre.kappa;
  place.direction = std::cos(yaw - centre.yaw) >= 0.0 ? 1.0 : -1.0;
  place.grade = place.direction * track.grade(location.s);
  place.bank = place.direction * track.bank(location.s);
  return place;
}

}  // namespace gripline
