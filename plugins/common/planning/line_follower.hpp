// Reference points along a closed line, as the paper samples them: project the car, then advance by v dt.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include <gripline/interfaces.hpp>

#include "common/planning/closed_line.hpp"

namespace gripline::planning {

/// A closed line with, at each sample, where that is on the road.
class RoadLine {
 public:
  RoadLine(ClosedLine line, const Course& course) : line_(std::move(line)), road_length_(course.length()) {
    places_.reserve(line_.size());
    for (const LinePoint& p : line_.samples()) {
      const CoursePoint c = course.at(p.station);
      Place place;
      place.s = p.station;
      place.n = -std::sin(c.yaw) * (p.x - c.x) + std::cos(c.yaw) * (p.y - c.y);
      place.lap_fraction = c.lap_fraction;
      place.yaw_line = c.yaw;
      place.kappa = c.kappa;
      places_.push_back(place);
    }
  }

  const ClosedLine& line() const { return line_; }

  /// The reference at a station of the line; v and the place's time and direction are left to the caller. The heading
  /// is the one nearest to `yaw_near`.
  RefPoint at(double s, double yaw_near) const {
    const LinePoint p = line_.at(s);
    RefPoint r;
    r.s = p.s;
    r.x = p.x;
    r.y = p.y;
    r.yaw = yaw_near + std::remainder(p.yaw - yaw_near, 2.0 * std::numbers::pi);
    r.kappa = p.kappa;
    r.left = p.left;
    r.right = p.right;
    const Bracket b = line_.bracket(s);
    const Place &from = places_[b.first], &to = places_[b.second];
    const auto mix = [&](double u, double v) { return u + (v - u) * b.weight; };
    const auto around = [&](double u, double v, double period) { return u + std::remainder(v - u, period) * b.weight; };
    r.at.s = wrap_periodic(around(from.s, to.s, road_length_), road_length_);
    r.at.n = mix(from.n, to.n);
    r.at.lap_fraction = wrap_periodic(around(from.lap_fraction, to.lap_fraction, 1.0), 1.0);
    r.at.yaw_line = around(from.yaw_line, to.yaw_line, 2.0 * std::numbers::pi);
    r.at.kappa = mix(from.kappa, to.kappa);
    r.at.grade = p.grade;
    r.at.bank = p.bank;
    return r;
  }

 private:
  ClosedLine line_;
  std::vector<Place> places_;
  double road_length_ = 0;
};

/// Remembers where the car was on the line, so that the projection moves continuously.
class LineFollower {
 public:
  /// Station of the foot on the line of a car that faces `yaw`, searched near the last one. A car further from it than
  /// the road is wide, or whose foot jumped by twice that, is on another stretch if it is between the edges there; a
  /// car that left the road stays beside the stretch where it did, however near others are.
  double locate(const ClosedLine& line, double x, double y, double yaw) {
    if (std::isnan(hint_)) return hint_ = line.project_facing(x, y, yaw).s;
    const ClosedLine::Foot foot = line.project(x, y, hint_);
    const LinePoint p = line.at(foot.s);
    const double width = p.left + p.right, jump = std::remainder(foot.s - hint_, line.length());
    if (foot.distance > width || std::abs(jump) > 2.0 * width) {
      const ClosedLine::Foot other = line.project(x, y);
      if (is_between_edges(line.at(other.s), x, y)) return hint_ = other.s;
    }
    return hint_ = foot.s;
  }
  /// To be called after a change of line: a station of the old one is not a hint.
  void forget() { hint_ = std::numeric_limits<double>::quiet_NaN(); }

 private:
  double hint_ = std::numeric_limits<double>::quiet_NaN();
};

/// Fills the horizon from the car's foot on: the first advance is with the car's own speed, as in the paper, the others
/// with the planned one. `speed(s)` is the planned speed at a station of the line; `reach(v)` the acceleration by which
/// references may gain speed, infinite if they need not start from what the car drives now.
template <class Speed, class Reach>
void sample_horizon(const RoadLine& road, double s, const Observation& now, double dt, const Speed& speed,
                    const Reach& reach, std::span<RefPoint> horizon) {
  double yaw = now.x.yaw;
  double v = std::max(now.x.vx, 0.01);
  for (std::size_t k = 0; k < horizon.size(); ++k) {
    RefPoint& r = horizon[k];
    r = road.at(s, yaw);
    r.at.t = now.t + static_cast<double>(k) * dt;
    r.at.direction = now.at.direction;
    r.v = speed(s);
    if (k > 0) {
      const double gain = reach(v);
      if (gain < std::numeric_limits<double>::infinity()) r.v = std::min(r.v, v + gain * dt);
      v = r.v;
    }
    s += v * dt;
    yaw = r.yaw;
  }
}

}  // namespace gripline::planning
