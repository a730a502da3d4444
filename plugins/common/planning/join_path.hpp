// The path from the car to the line it is to drive: references that begin at the car's place and heading.
//
//   n(s) = h00(s / Ln) n0 + Ls h10(s / Ls) n0',   h00 and h10 quintic: n' = n'' = 0 where the car is on the line
//
// with the offset n0 and the slope n0' = tan(heading error) of the car. Ln and Ls are the least for which the added
// curvature stays within a share of the friction at the speed driven, a larger one for a car beside the road, and
// within the steering's limit. A controller that is given a line metres away steers as hard as its model allows; with
// this path it need not.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <gripline/interfaces.hpp>

namespace gripline::planning {

class JoinPath {
 public:
  /// `line_length`: of the closed line whose stations the references carry [m]. `reach`: share of the friction with
  /// which the controller is left to take the car back to the line within its horizon, to one side and to the other.
  JoinPath(const Car& car, double line_length, double reach = 0.4)
      : reach_(reach),
        width_(car.width),
        slow_(2.0 * std::sqrt(gravity * (car.lf + car.lr))),
        steep_(0.9 * std::tan(car.delta_max) / (car.lf + car.lr)),
        v_min_(car.v_min),
        length_(line_length) {}

  /// Once per step, before references are sampled: `foot` is the point of the line beside the car, `mu` the friction
  /// assumed by plans, `horizon` the time that the controller looks ahead [s].
  void update(const Observation& now, const RefPoint& foot, double mu, double horizon) {
    horizon_ = horizon;
    friction_ = std::max(mu, 0.05) * gravity;
    const Pose2 car = pose(now.x, foot);
    if (active_) active_ = ahead(foot.s) < whole_way();
    if (far(car, active_ ? at(ahead(foot.s)) : Offset{}, now.x)) begin(car, foot, now.x);
  }
  /// What joining allows at a station of the line [m/s]; infinite where the car is to be on it.
  double speed(double s) const {
    const double way = ahead(s);
    if (!active_ || way >= whole_way()) return std::numeric_limits<double>::infinity();
    const Offset o = at(way);
    return std::sqrt(hard_share * friction_ * (1.0 + o.slope * o.slope) / std::max(std::abs(o.bend), 1e-9));
  }
  /// Metres of the way per metre of a line of this curvature: a reference that moves at v advances by v / stretch along
  /// the line. 1 where the car is to be on it.
  double stretch(double s, double kappa) const {
    const double way = ahead(s);
    if (!active_ || way >= whole_way()) return 1.0;
    const Offset o = at(way);
    return std::hypot(std::max(least_stretch, 1.0 - o.n * kappa), o.slope);
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
  struct Pose2 {
    double n = 0, angle = 0;  // from the line, to the left; of the car's course against the line's heading
  };
  struct Offset {
    double n = 0, slope = 0, bend = 0;  // n, dn/ds, d2n/ds2
  };
  // Shares of the friction for the path, beside what the line itself needs: where there is room, and near an edge.
  static constexpr double easy_share = 0.3, hard_share = 0.6;
  static constexpr double least_stretch = 0.2;   // of a way on the inside of a turn
  static constexpr double room_share = 0.6;      // of the way to the edge
  static constexpr double far_angle = 0.5;       // [rad]
  static constexpr double steepest_angle = 1.0;  // of the path against the line [rad]

  /// The course where the car moves, sideways too; the heading where it hardly does, or rolls back.
  Pose2 pose(const State& x, const RefPoint& foot) const {
    const double sine = std::sin(foot.yaw), cosine = std::cos(foot.yaw);
    const bool moves = x.vx > 0.0 && std::hypot(x.vx, x.vy) > 2 * v_min_;
    const double course = x.yaw + (moves ? std::atan2(x.vy, x.vx) : 0.0);
    return {-sine * (x.x - foot.x) + cosine * (x.y - foot.y),
            std::remainder(course - foot.yaw, 2.0 * std::numbers::pi)};
  }
  bool far(const Pose2& car, const Offset& from, const State& x) const {
    // What the controller takes back within its horizon is not far: offsets of a T^2 / 4, turns of a T / (4 v).
    const double reach = 0.25 * reach_ * friction_ * horizon_;  // [m/s]
    const double near = std::max(1.5 * width_, reach * horizon_);
    const double turned = std::abs(car.angle - std::atan(from.slope)), v = std::hypot(x.vx, x.vy);
    return std::abs(car.n - from.n) > near || (v > 0.5 * slow_ && turned > std::max(far_angle, reach / v));
  }
  static bool is_beside_road(double n, const RefPoint& foot) { return n > foot.left || -n > foot.right; }
  double ahead(double s) const { return std::max(0.0, std::remainder(s - begin_, length_)); }

  void begin(const Pose2& car, const RefPoint& foot, const State& x) {
    const double v = std::max(std::hypot(x.vx, x.vy), slow_);
    const double share = is_beside_road(car.n, foot) ? hard_share : easy_share;
    const double bend = std::min(share * friction_ / (v * v), steep_);  // curvature that may be added [1/m]
    begin_ = foot.s;
    n_ = car.n;
    slope_ = std::tan(std::clamp(car.angle, -steepest_angle, steepest_angle));
    // Largest second derivatives: 10 / sqrt(3) n0 / Ln^2, and less than 4 n0' / Ls. Where the road is too narrow for
    // that, the turn is sharper and driven more slowly.
    const double steep = std::max(std::abs(slope_), 1e-9);
    const double room = slope_ > 0 ? foot.left : foot.right;  // from the line, on the side that the slope leads to
    const auto way = [&](double curvature) { return std::sqrt(5.8 * std::abs(n_) / curvature); };
    const auto turn = [&](double longest) {
      const double sharpest = 4.0 * steep / steep_;
      return std::clamp(4.0 * steep / bend, sharpest, std::max(sharpest, longest));
    };
    if (n_ * slope_ >= 0) {  // away from the line: the slope leads 0.21 Ls n0' further
      way_slope_ = turn(room_share * std::max(room - std::abs(n_), 0.5 * width_) / (0.21 * steep));
      way_n_ = std::max(way(bend), way_slope_);
    } else {  // towards the line, which is crossed where L n0' > 2.5 n0
      const double longest = (2.5 * std::abs(n_) + 2.0 * std::max(room, 0.0)) / steep;
      way_n_ = way_slope_ = std::max(std::min(std::max(way(bend), turn(longest)), longest), way(steep_));
    }
    way_slope_ = std::min(way_slope_, 0.4 * length_);
    way_n_ = std::min(std::max(way_n_, 1e-6), 0.4 * length_);
    active_ = true;
  }
  double whole_way() const { return std::max(way_n_, way_slope_); }

  Offset at(double s) const {
    const Offset n = from_offset(std::min(s / way_n_, 1.0)), slope = from_slope(std::min(s / way_slope_, 1.0));
    return {n_ * n.n + way_slope_ * slope_ * slope.n, n_ / way_n_ * n.slope + slope_ * slope.slope,
            n_ / (way_n_ * way_n_) * n.bend + slope_ / way_slope_ * slope.bend};
  }
  /// h00 = 1 - 10 u^3 + 15 u^4 - 6 u^5 with its derivatives.
  static Offset from_offset(double u) {
    const double left = 1.0 - u;
    return {left * left * left * (1.0 + 3.0 * u + 6.0 * u * u), -30.0 * u * u * left * left,
            -60.0 * u * left * (1.0 - 2.0 * u)};
  }
  /// h10 = u - 6 u^3 + 8 u^4 - 3 u^5 with its derivatives.
  static Offset from_slope(double u) {
    const double u2 = u * u, u3 = u2 * u;
    return {u - 6.0 * u3 + 8.0 * u3 * u - 3.0 * u3 * u2, 1.0 - 18.0 * u2 + 32.0 * u3 - 15.0 * u2 * u2,
            -36.0 * u + 96.0 * u2 - 60.0 * u3};
  }

  /// The room that is stated beside the way, `to_edge` from an edge of the road. A car that stands outside of it may
  /// have to go further out to turn back, which a controller weighs as leaving the road: so a way outside of an edge
  /// has as much room beyond it as it is off, up to the car's width.
  double stated_room(double to_edge) const { return std::max(to_edge, std::min(-to_edge, width_)); }

  void move(RefPoint& r) const {
    const double way = ahead(r.s);
    if (way >= whole_way()) return;
    const Offset o = at(way);
    r.x -= std::sin(r.yaw) * o.n;
    r.y += std::cos(r.yaw) * o.n;
    r.yaw += std::atan2(o.slope, std::max(least_stretch, 1.0 - o.n * r.kappa));
    r.kappa += o.bend;
    r.left = stated_room(r.left - o.n);
    r.right = stated_room(r.right + o.n);
    r.at.n += o.n;
  }

  double reach_, width_, slow_, steep_, v_min_, length_;
  bool active_ = false;
  double friction_ = 1, horizon_ = 0;  // [m/s2, s]
  double begin_ = 0, way_n_ = 1, way_slope_ = 1, n_ = 0, slope_ = 0;
};

}  // namespace gripline::planning
