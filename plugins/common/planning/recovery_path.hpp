// The path back to the line for a car that faces across the road or backwards, is further off than the road is wide,
// stands beside it, or stands askew on it.
//
// A fast car is first slowed down along its course. Then it drives the arcs and the straight line of dubins.hpp to a
// place of the line nearby, on the radius that the steering allows with a reserve, at the speed that friction allows on
// it. Of all places and paths the one is chosen that loses least distance and leaves the road least. JoinPath removes
// the offset that is left at the end.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <gripline/interfaces.hpp>
#include <gripline/periodic.hpp>

#include "common/planning/closed_line.hpp"
#include "common/planning/dubins.hpp"

namespace gripline::planning {

class RecoveryPath {
 public:
  /// `line`: what the stations of references count along; it must outlive the path.
  RecoveryPath(const Car& car, const ClosedLine& line)
      : line_(line), radius_((car.lf + car.lr) / (steering_share * std::tan(car.delta_max))), width_(car.width) {}
  RecoveryPath(const RecoveryPath&) = delete;
  RecoveryPath& operator=(const RecoveryPath&) = delete;

  /// Once per step: whether the car is on its way back. `foot` is the station of the line beside the car, `mu` the
  /// friction that plans rest on, `reference(s)` the reference at a station of the line.
  template <class Reference>
  bool update(const Observation& now, double foot, double mu, const Reference& reference) {
    friction_ = std::max(mu, least_mu) * gravity;
    const State& x = now.x;
    const double v = std::hypot(x.vx, x.vy);
    if (!active_) {
      if (!lost(x, foot, reference(foot))) return false;
      active_ = slowing_ = true;
    }
    if (slowing_) {
      slowing_ = too_fast(v);
      if (!slowing_) begin(x, foot, reference);
      return true;
    }
    follow(x);
    if (driven_ >= path_.length() - arrived_before * radius_ && std::abs(heading_error(x)) < arrived_angle) {
      active_ = false;
    } else if (const double off = distance(x, driven_);
               off > off_path_distance * radius_ || std::abs(heading_error(x)) > off_path_angle) {
      if (too_fast(v))
        slowing_ = true;
      else
        begin(x, foot, reference);
    }
    return active_;
  }
  bool active() const { return active_; }

  /// References from the car on. `line_speed(s)` is the planned speed at a station of the line, `reach(v)` the
  /// acceleration by which references may gain speed.
  template <class Reference, class Speed, class Reach>
  void fill(const Observation& now, double dt, const Reference& reference, const Speed& line_speed, const Reach& reach,
            std::span<RefPoint> horizon) const {
    if (slowing_) {
      fill_slowing(now, dt, horizon);
      return;
    }
    double v = std::max(now.x.vx, least_speed), way = driven_, yaw = now.x.yaw;
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      RefPoint& r = horizon[k];
      const double beyond = way - path_.length(), s = wrap_periodic(target_ + beyond, line_.length());
      r = beyond >= 0.0 ? reference(s) : on_path(way, s, now);
      r.at.t = now.t + static_cast<double>(k) * dt;
      r.at.direction = now.at.direction;
      r.yaw = yaw = yaw + std::remainder(r.yaw - yaw, 2.0 * std::numbers::pi);
      if (k > 0) v = std::min({v + reach(v) * dt, beyond >= 0.0 ? line_speed(s) : speed(), speed() + gain(beyond)});
      r.v = v;
      way += v * dt;
    }
  }

 private:
  // What a way is driven with; the rest of lock and friction is left to the controller, which keeps the car on it.
  static constexpr double steering_share = 0.85;                       // of full lock, for the radius of the arcs
  static constexpr double friction_share = 0.35;                       // of the friction, in the arcs
  static constexpr double braking_share = 0.6;                         // of the friction, where the car is slowed down
  static constexpr double standing_share = 0.3, too_fast_share = 1.5;  // of the speed in the arcs
  static constexpr double least_mu = 0.05;     // that is reckoned with: at none the car would stop
  static constexpr double least_speed = 0.01;  // [m/s] of references, also of a car that stands

  // When a car is lost.
  static constexpr double lost_angle = 1.5;       // [rad] between car and line: lines cross roads at up to 1.4
  static constexpr double askew_angle = 0.3;      // [rad] between a standing car and the line, and
  static constexpr double room_for_a_turn = 2.5;  // the least room over what the turn takes at the radius of the arcs
  static constexpr double lost_off = 1.5;         // of the road's width, from the reference: not on this road
  // Nearer to the line, but inside its bend: by this share of the road's width, and of the way to the bend's centre,
  // where places of the line far apart are equally near.
  static constexpr double inside_off = 0.5, inside_bend = 0.7;

  // When a car has arrived, before the end of its way, or is so far off it that it begins another.
  static constexpr double off_path_distance = 0.5;                                      // of the radius, beside the way
  static constexpr double off_path_angle = 1.2;                                         // [rad] between car and way
  static constexpr double arrived_before = 0.25, arrived_angle = 0.5 * off_path_angle;  // of the radius; [rad]

  // Where on the line ways may lead to: so many radii behind and ahead of the car, a few of its turning circles; for a
  // car that is far off further ahead, by so many times its distance from the line; but no more than a share of the
  // lap, since places beyond are nearer the other way round.
  static constexpr int places = 48;
  static constexpr double behind = 4.0, ahead_least = 12.0, ahead_per_off = 2.0;
  static constexpr double behind_share = 0.1, ahead_share = 0.4;
  // Which is chosen.
  static constexpr double gained = 0.9;        // of a metre of way, for each that it ends further along the line
  static constexpr double beside_cost = 2.0;   // of a metre that is driven the car's width beside the road [m]
  static constexpr double beside_step = 0.25;  // of the radius, between places that are looked at for it
  static constexpr double free_room = 1e3;     // [m] that references state where no edge is to hold the car back

  // Newton's steps to the place of the way beside the car, and how long they are at most, over the radius: along a
  // tangent, which an arc leaves.
  static constexpr int foot_steps = 4;
  static constexpr double longest_foot_step = 0.25;

  /// In the arcs [m/s].
  double speed() const { return std::sqrt(friction_share * friction_ * radius_); }
  /// Whether the car is slowed down before it drives arcs.
  bool too_fast(double v) const { return v > too_fast_share * speed(); }
  /// How much faster than in the arcs a reference may be `beyond` metres after the end of the path [m/s].
  double gain(double beyond) const {
    return std::max(0.0,
                    std::sqrt(square(speed()) + 2.0 * braking_share * friction_ * std::max(beyond, 0.0)) - speed());
  }

  /// `planned`: the reference beside the car. It may be planned to slide, and to be anywhere on the road.
  bool lost(const State& x, double foot, const RefPoint& planned) const {
    const LinePoint p = line_.at(foot);
    const double width = p.left + p.right, off = std::hypot(x.x - planned.x, x.y - planned.y);
    const double across = -std::sin(p.yaw) * (x.x - p.x) + std::cos(p.yaw) * (x.y - p.y);
    // Within its horizon a controller may find that driving off along the line leads further off the road than standing
    // still does: so a car that stands beside the road counts as lost.
    const bool stands = std::hypot(x.vx, x.vy) < standing_share * speed();
    return (stands && (across > p.left || -across > p.right || short_of_room(x, p, across))) ||
           std::abs(std::remainder(x.yaw - (planned.yaw - planned.beta), 2.0 * std::numbers::pi)) > lost_angle ||
           off > lost_off * width || (off > inside_off * width && across * p.kappa > inside_bend);
  }

  /// Whether a car that drives off needs much of the room on the side that it faces to turn along the line. A
  /// controller that is shown the line at speed gains speed first, and turns too late.
  bool short_of_room(const State& x, const LinePoint& p, double across) const {
    const double turned = std::remainder(x.yaw - p.yaw, 2.0 * std::numbers::pi);
    const double room = (turned > 0.0 ? p.left - across : p.right + across) - 0.5 * width_;
    return std::abs(turned) > askew_angle && room < room_for_a_turn * radius_ * (1.0 - std::cos(turned));
  }

  template <class Reference>
  void begin(const State& x, double foot, const Reference& reference) {
    const PlanePose from{x.x, x.y, x.yaw};
    const double nearest = -std::min(behind * radius_, behind_share * line_.length());
    const double farthest =
        std::min(ahead_least * radius_ + ahead_per_off * distance_to_line(x, foot), ahead_share * line_.length());
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= places; ++i) {
      const double ahead = std::lerp(nearest, farthest, static_cast<double>(i) / places);
      const double s = wrap_periodic(foot + ahead, line_.length());
      const RefPoint r = reference(s);
      for (int kind = 0; kind < DubinsPath::kinds; ++kind) {
        const auto path = DubinsPath::between(from, {r.x, r.y, r.yaw}, radius_, kind);
        if (!path) continue;
        const double longer = path->length() - gained * ahead;
        if (longer >= least) continue;
        const double cost = longer + beside(*path, foot, least - longer);
        if (cost >= least) continue;
        least = cost;
        path_ = *path;
        target_ = s;
      }
    }
    driven_ = 0.0;
  }
  /// What the parts of a path beside the road cost, by the square of how far they are beside it [m]; the sum ends where
  /// it exceeds `most`.
  double beside(const DubinsPath& path, double foot, double most) const {
    const double step = beside_step * radius_;
    double sum = 0.0, hint = foot;
    for (double way = step; way < path.length() && sum < most; way += step) {
      const PathPoint p = path.at(way);
      hint = line_.project(p.x, p.y, hint).s;
      const LinePoint q = line_.at(hint);
      const double n = -std::sin(q.yaw) * (p.x - q.x) + std::cos(q.yaw) * (p.y - q.y);
      const double off = std::max({n - q.left + 0.5 * width_, -n - q.right + 0.5 * width_, 0.0});
      sum += beside_cost * square(off / width_) * step;
    }
    return sum;
  }
  double distance_to_line(const State& x, double foot) const {
    const LinePoint p = line_.at(foot);
    return std::hypot(x.x - p.x, x.y - p.y);
  }

  double distance(const State& x, double way) const {
    const PathPoint p = path_.at(way);
    return std::hypot(x.x - p.x, x.y - p.y);
  }
  double heading_error(const State& x) const {
    return std::remainder(x.yaw - path_.at(driven_).yaw, 2.0 * std::numbers::pi);
  }
  /// The place of the way beside the car, near the last one: Newton's method with the curvature left out.
  void follow(const State& x) {
    for (int i = 0; i < foot_steps; ++i) {
      const PathPoint p = path_.at(driven_);
      const double ahead = (x.x - p.x) * std::cos(p.yaw) + (x.y - p.y) * std::sin(p.yaw);
      driven_ = std::clamp(driven_ + std::clamp(ahead, -longest_foot_step * radius_, longest_foot_step * radius_), 0.0,
                           path_.length());
    }
  }

  RefPoint on_path(double way, double s, const Observation& now) const {
    RefPoint r;
    const PathPoint p = path_.at(way);
    r.s = s;
    r.x = p.x;
    r.y = p.y;
    r.yaw = p.yaw;
    r.kappa = p.curvature;
    r.left = r.right = free_room;
    r.at = now.at;
    return r;
  }
  /// References that slow the car down along its present course, by a share of what its tyres can brake.
  void fill_slowing(const Observation& now, double dt, std::span<RefPoint> horizon) const {
    const State& x = now.x;
    const double course = x.yaw + std::atan2(x.vy, x.vx);
    const double forward = x.vx >= 0.0 ? 1.0 : -1.0;
    double v = std::hypot(x.vx, x.vy), way = 0.0;
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      RefPoint& r = horizon[k];
      r = {};
      r.x = x.x + way * std::cos(course);
      r.y = x.y + way * std::sin(course);
      r.yaw = x.yaw + std::remainder(course + (forward > 0.0 ? 0.0 : std::numbers::pi) - x.yaw, 2.0 * std::numbers::pi);
      r.v = forward * v;
      r.left = r.right = free_room;
      r.at = now.at;
      r.at.t = now.t + static_cast<double>(k) * dt;
      way += v * dt;
      v = std::max(0.0, v - braking_share * friction_ * dt);
    }
  }

  const ClosedLine& line_;
  double radius_, width_;
  double friction_ = 1;  // [m/s2]
  bool active_ = false, slowing_ = false;
  DubinsPath path_;
  double target_ = 0;  // station of the line where the way ends
  double driven_ = 0;  // of the way [m]
};

}  // namespace gripline::planning
