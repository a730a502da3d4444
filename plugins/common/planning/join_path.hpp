// The path from the car to the line it is to drive: references that begin at the car's place and heading.
//
// A controller that is given a line metres away steers as hard as its model allows; with this path it need not. Of ways
// (join_way.hpp) from a gentle one to one at 0.9 of full lock, the first is taken that the car can steer and slow down
// for, its width from both edges (or as near as the line) and not far further out than it is; where there is none, the
// one that comes nearest to that. The gentle one adds curvature for a share of the friction at the speed driven, a
// larger share for a car beside the road.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <gripline/interfaces.hpp>
#include <gripline/periodic.hpp>

#include "common/planning/join_way.hpp"

namespace gripline::planning {

class JoinPath {
 public:
  /// `line_length`: of the closed line whose stations the references carry [m]. `reach`: share of the friction with
  /// which the controller is left to take the car back to the line within its horizon, to one side and to the other.
  JoinPath(const Car& car, double line_length, double reach = 0.4)
      : reach_(reach),
        width_(car.width),
        slow_(2.0 * std::sqrt(gravity * (car.lf + car.lr))),
        full_lock_(std::tan(car.delta_max) / (car.lf + car.lr)),
        v_min_(car.v_min),
        length_(line_length) {}

  /// Once per step, before references are sampled: `foot` is the station of the line beside the car, `mu` the friction
  /// assumed by plans, `horizon` the time that the controller looks ahead [s], `reference(s)` the reference at a station
  /// of the line.
  template <class Reference>
  void update(const Observation& now, double foot, double mu, double horizon, const Reference& reference) {
    horizon_ = horizon;
    friction_ = std::max(mu, 0.05) * gravity;
    const RefPoint beside = reference(foot);
    const Deviation car = deviation(now.x, beside);
    if (active_) active_ = ahead(foot) < way_.length();
    if (far(car, active_ ? way_.at(ahead(foot)) : JoinWay::Offset{}, now.x))
      begin(car, beside, std::hypot(now.x.vx, now.x.vy), reference);
  }
  /// What joining allows at a station of the line [m/s]; infinite where the car is to be on it.
  double speed(double s) const {
    const double passed = ahead(s);
    if (!active_ || passed >= way_.length()) return std::numeric_limits<double>::infinity();
    const auto i = std::min(static_cast<std::size_t>(places * std::sqrt(passed / farthest_)), places - 1);
    const double weight = (passed - place(i)) / (place(i + 1) - place(i));
    return std::sqrt(std::lerp(square_speed_[i], square_speed_[i + 1], std::clamp(weight, 0.0, 1.0)));
  }
  /// Metres of the way per metre of a line of this curvature: a reference that moves at v advances by v / stretch along
  /// the line. 1 where the car is to be on it.
  double stretch(double s, double kappa) const {
    if (!active_ || ahead(s) >= way_.length()) return 1.0;
    const JoinWay::Offset o = way_.at(ahead(s));
    return std::hypot(along(o, kappa), o.slope);
  }
  /// Moves references from the line onto the path that leads to it.
  void move(std::span<RefPoint> horizon) const {
    if (active_)
      for (RefPoint& r : horizon) move(r);
  }

  bool active() const { return active_; }
  /// Drops the path: the car was driven by another one.
  void forget() { active_ = false; }

 private:
  /// Of the car from the line: to its left [m], and of the car's course from the line's heading [rad].
  struct Deviation {
    double n = 0, angle = 0;
  };
  /// A point of the line: room to both edges [m], curvature [1/m], side acceleration that the car has there [m/s2].
  struct RoadPoint {
    double left = 0, right = 0, kappa = 0, most = 0;
  };
  static constexpr std::size_t places = 48;       // of the line that ways are weighed at, after the first
  static constexpr std::size_t sharpnesses = 12;  // of ways that are weighed
  using Road = std::array<RoadPoint, places + 1>;
  // Shares of the friction: for the bends of a gentle way, and of one back from beside the road; for the bends that
  // speeds are for, beside what the line itself needs; to slow down for them.
  static constexpr double gentle_share = 0.3, back_share = 0.6, bend_share = 0.6, brake_share = 0.6;
  static constexpr double kept_share = 0.55;  // of the room beyond the car: one that goes far out returns late
  static constexpr double hard_cost = 1e3;    // of leaving the road or steering beyond full lock, over the others
  static constexpr double lock_share = 0.9;   // of full lock, for the sharpest way
  // Of its speed, what a car keeps on a way outwards that lacks something, but no less than this share of slow_: while it
  // slows down, its wheels turn.
  static constexpr double outwards_share = 0.7, crawl_share = 0.25;
  static constexpr double least_stretch = 0.2;   // of a way on the inside of a turn
  static constexpr double far_angle = 0.5;       // [rad]
  static constexpr double steepest_angle = 1.0;  // of the path against the line [rad]

  /// The course where the car moves, sideways too; the heading where it hardly does, or rolls back.
  Deviation deviation(const State& x, const RefPoint& foot) const {
    const double sine = std::sin(foot.yaw), cosine = std::cos(foot.yaw);
    const bool moves = x.vx > 0.0 && std::hypot(x.vx, x.vy) > 2 * v_min_;
    const double course = x.yaw + (moves ? std::atan2(x.vy, x.vx) : 0.0);
    return {-sine * (x.x - foot.x) + cosine * (x.y - foot.y),
            std::remainder(course - foot.yaw, 2.0 * std::numbers::pi)};
  }
  bool far(const Deviation& car, const JoinWay::Offset& from, const State& x) const {
    // What the controller takes back within its horizon is not far: offsets of a T^2 / 4, turns of a T / (4 v).
    const double reach = 0.25 * reach_ * friction_ * horizon_;  // [m/s]
    const double near = std::max(1.5 * width_, reach * horizon_);
    const double turned = std::abs(car.angle - std::atan(from.slope)), v = std::hypot(x.vx, x.vy);
    return std::abs(car.n - from.n) > near || (v > 0.5 * slow_ && turned > std::max(far_angle, reach / v));
  }
  static bool is_beside_road(double n, const RefPoint& foot) { return n > foot.left || -n > foot.right; }
  double ahead(double s) const { return std::max(0.0, std::remainder(s - begin_, length_)); }

  /// Chooses the way from a car that drives at v, beside a reference of the line.
  template <class Reference>
  void begin(const Deviation& car, const RefPoint& beside, double v, const Reference& reference) {
    begin_ = beside.s;
    const double slope = std::tan(std::clamp(car.angle, -steepest_angle, steepest_angle));
    const double share = is_beside_road(car.n, beside) ? back_share : gentle_share, sharpest = lock_share * full_lock_;
    const double gentlest = std::min(share * friction_ / square(std::max(v, slow_)), sharpest);
    const auto way_with = [&](double bend) { return JoinWay(car.n, slope, bend, 0.4 * length_); };
    farthest_ = way_with(gentlest).length();
    const Road road = road_ahead(reference);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < sharpnesses && least > 0.0; ++i) {
      const double bend = gentlest * std::pow(sharpest / gentlest, static_cast<double>(i) / (sharpnesses - 1));
      const JoinWay way = way_with(bend);
      const double cost = cost_of(way, road, v);
      if (cost >= least) continue;
      least = cost;
      way_ = way;
    }
    const double slower = std::max(outwards_share * v, crawl_share * slow_);
    set_speeds(road, least > 0.0 ? slower : std::numeric_limits<double>::infinity());
    active_ = true;
  }
  /// Metres from the begin of the way to a place that it is weighed at. They lie closer near the car, where sharp ways,
  /// which are short, have all their bends.
  double place(std::size_t i) const { return farthest_ * square(static_cast<double>(i) / places); }
  template <class Reference>
  Road road_ahead(const Reference& reference) const {
    Road road;
    for (std::size_t i = 0; i < road.size(); ++i) {
      const RefPoint r = reference(wrap_periodic(begin_ + place(i), length_));
      // A line in a banked bend is planned for more than the friction of a level one.
      road[i] = {r.left, r.right, r.kappa, std::max(friction_, std::abs(r.kappa) * square(r.v))};
    }
    return road;
  }
  /// The distance that a way is to keep from an edge, by the room between line and edge and how far the car is off on
  /// that side: the car's width, or where there is more a share of the room beyond the car; none that the line lacks.
  double margin(double room, double off) const {
    return std::min(room, std::max(width_, kept_share * (room - std::max(off, 0.0))));
  }
  /// What a way lacks on this road for a car that brakes from v: of margins to the edges, and of friction or steering in
  /// its bends. 0 for a way that lacks nothing.
  double cost_of(const JoinWay& way, const Road& road, double v) const {
    const double n0 = way.at(0).n;
    double sum = 0;
    for (std::size_t i = 0; i < road.size(); ++i) {
      const RoadPoint& p = road[i];
      const JoinWay::Offset o = way.at(place(i));
      const double too_near = std::max({0.0, o.n + margin(p.left, n0) - p.left, margin(p.right, -n0) - p.right - o.n});
      const double beside = std::max({0.0, o.n - p.left, -o.n - p.right});
      const double square_speed = std::max(0.0, square(v) - 2.0 * brake_share * friction_ * place(i));
      const double bend = std::abs(curvature(o, p.kappa));
      const double unsteerable = std::max(0.0, bend / std::max(full_lock_, std::abs(p.kappa)) - 1.0);
      const double too_fast = std::max(0.0, bend * square_speed / p.most - 1.0);
      const double stretch = place(i) - place(i > 0 ? i - 1 : 0);
      sum += stretch * (square(too_near / width_) + square(too_fast) +
                        hard_cost * (square(beside / width_) + square(unsteerable)));
    }
    return sum;
  }
  /// Speeds along the way that friction allows in its bends, and from which the car can brake to those further ahead;
  /// `outwards` at most where the way leads away from the line.
  void set_speeds(const Road& road, double outwards) {
    double after = std::numeric_limits<double>::infinity();
    for (std::size_t i = road.size(); i-- > 0;) {
      const JoinWay::Offset o = way_.at(place(i));
      const double in_bend = bend_share * friction_ * (1.0 + square(o.slope)) / std::max(std::abs(o.bend), 1e-9);
      const double in_all = road[i].most / std::max(std::abs(curvature(o, road[i].kappa)), 1e-9);
      const double stretch = i + 1 < road.size() ? place(i + 1) - place(i) : 0.0;
      const double most = o.n * o.slope > 0.0 ? square(outwards) : std::numeric_limits<double>::infinity();
      after = square_speed_[i] = std::min({in_bend, in_all, most, after + 2.0 * brake_share * friction_ * stretch});
    }
  }
  /// Metres along the way per metre of a line of this curvature, leaving out the slope.
  static double along(const JoinWay::Offset& o, double kappa) { return std::max(least_stretch, 1.0 - o.n * kappa); }
  static double curvature(const JoinWay::Offset& o, double kappa) {
    return kappa / along(o, kappa) + o.bend / (1.0 + square(o.slope));
  }

  /// The room that is stated beside the way, `to_edge` from an edge of the road. A car that stands outside of it may
  /// have to go further out to turn back, which a controller weighs as leaving the road: so a way outside of an edge
  /// has as much room beyond it as it is off, up to the car's width.
  double stated_room(double to_edge) const { return std::max(to_edge, std::min(-to_edge, width_)); }

  void move(RefPoint& r) const {
    if (ahead(r.s) >= way_.length()) return;
    const JoinWay::Offset o = way_.at(ahead(r.s));
    r.x -= std::sin(r.yaw) * o.n;
    r.y += std::cos(r.yaw) * o.n;
    r.yaw += std::atan2(o.slope, along(o, r.kappa));
    r.kappa += o.bend;
    r.left = stated_room(r.left - o.n);
    r.right = stated_room(r.right + o.n);
    r.at.n += o.n;
  }

  double reach_, width_, slow_, full_lock_, v_min_, length_;  // full_lock_: curvature [1/m]
  bool active_ = false;
  double friction_ = 1, horizon_ = 0;  // [m/s2, s]
  double begin_ = 0;                   // station
  double farthest_ = 1;                // of the places that ways are weighed at, from there [m]
  JoinWay way_;
  std::array<double, places + 1> square_speed_{};  // at the places [m2/s2]
};

}  // namespace gripline::planning
