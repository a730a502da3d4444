// How fast the full-size plant can lap in a quasi-steady state: the truth, for tests only.
//
// On a given line the car is at every point in the steady state of its own loads and tyres (plants/double_track):
//   loads with downforce, curvature of the road in height and both transfers;
//   a wheel with longitudinal force Fx keeps  f mu_y Fz sqrt(1 - (Fx / (f mu_x Fz))^2)  across (its ellipse);
//   both axles hold their share of the lateral force, m a lr / L in front and m a lf / L behind.
// Corner speeds first, then a forward and a backward pass (Velenis, Tsiotras 2005). Slip losses in turns, gear changes
// and transients are left out, so the lap is a little faster than the car can.
#pragma once

#include <vector>

#include "geometry/course_adapter.hpp"
#include "plants/double_track/car.hpp"

namespace gripline::testing_support {

class FullSizeLimit {
 public:
  FullSizeLimit(const double_track::Params& p, double factor)
      : p_(p),
        f_(factor),
        car_(p),
        engine_(Table{double_track::default_engine.data(), 9, 3}),
        gears_(Table{double_track::default_gears.data(), 6, 4}) {}

  /// What the road asks at a point: normal acceleration and the slope's pull.
  struct Road {
    double curve = 0;  // of the road's surface along the car [1/m]: d grade/ds and, in a banked turn, kappa sin(bank)
    double grade = 0, bank = 0;
  };

  /// Whether the tyres hold lateral acceleration a >= 0 and all longitudinal tyre force Fx at speed v.
  bool holds(double v, double a, double Fx, const Road& road) const {
    using double_track::Tyre;
    const double L = p_.lf + p_.lr;
    const double weight = p_.m * (gravity * std::cos(road.grade) * std::cos(road.bank) + v * v * road.curve);
    const double down = p_.downforce_front + p_.downforce_rear;
    const double front = weight * p_.lr / L + p_.downforce_front * v * v - Fx * p_.h / L;
    const double rear = weight + down * v * v - front;
    if (front <= 0.0 || rear <= 0.0) return false;
    const double need[2] = {p_.m * a * p_.lr / L, p_.m * a * p_.lf / L};
    const double elastic = (p_.h - p_.roll_centre_front) * need[0] + (p_.h - p_.roll_centre_rear) * need[1];
    const double transfer[2] = {(p_.roll_centre_front * need[0] + p_.roll_front * elastic) / p_.track_front,
                                (p_.roll_centre_rear * need[1] + (1.0 - p_.roll_front) * elastic) / p_.track_rear};
    const double share = Fx >= 0.0 ? p_.drive_front : p_.brake_bias;
    for (const int axle : {0, 1}) {
      const double load = axle == 0 ? front : rear;
      const double along = 0.5 * Fx * (axle == 0 ? share : 1.0 - share);
      const double moved = std::min(transfer[axle], 0.5 * load);
      double across = 0.0;
      for (const double Fz : {0.5 * load - moved, 0.5 * load + moved}) {
        const Tyre& tyre = car_.tyre(axle == 0 ? Axle::front : Axle::rear);
        const double x = f_ * tyre.mu(p_.mu_x, Fz) * Fz;
        const double y = f_ * tyre.mu(p_.mu_y, Fz) * Fz;
        if (std::abs(along) < x) across += y * std::sqrt(1.0 - square(along / x));
      }
      if (across < need[axle] || (across == 0.0 && Fx != 0.0)) return false;
    }
    return true;
  }

  /// Largest value in [0, top] for which a condition that holds at 0 still holds.
  template <class Holds>
  static double largest(double top, const Holds& holds) {
    double lo = 0.0;
    double hi = top;
    for (int i = 0; i < 40; ++i) (holds(0.5 * (lo + hi)) ? lo : hi) = 0.5 * (lo + hi);
    return lo;
  }

  double resistance(double v) const {
    return p_.drag * v * v + p_.rolling * (p_.m * gravity + (p_.downforce_front + p_.downforce_rear) * v * v);
  }
  /// The engine's largest force at a speed, in the best gear its map allows.
  double engine(double v) const {
    const double ratio = gears_.ratio(gears_.at(v)) * p_.final_drive;
    return engine_.torque(1.0, v / p_.radius * ratio) * ratio / p_.radius;
  }
  double effective_mass() const { return p_.m + 4.0 * p_.wheel_inertia / square(p_.radius); }

  /// Flying lap [s] on a closed line.
  double lap(std::span<const LinePoint> line, const Track& track) const {
    const std::size_t n = line.size();
    const double ds = line[1].s - line[0].s;
    std::vector<double> bend(n);
    for (std::size_t i = 0; i < n; ++i) bend[i] = track.at(track.locate(line[i].x, line[i].y).s).kappa;
    const auto road = [&](std::size_t i) {
      const LinePoint& a = line[(i + n - 1) % n];
      const LinePoint& b = line[(i + 1) % n];
      return Road{(b.grade - a.grade) / (2.0 * ds) + bend[i] * std::sin(line[i].bank), line[i].grade, line[i].bank};
    };
    const auto across = [&](double v, std::size_t i) {
      return std::abs(v * v * line[i].kappa - gravity * std::sin(line[i].bank));
    };
    std::vector<double> v(n);
    for (std::size_t i = 0; i < n; ++i)
      v[i] = largest(95.0, [&](double u) { return holds(u, across(u, i), resistance(u), road(i)); });
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const std::size_t i = k % n;
      const double Fx = largest(engine(v[i]), [&](double F) { return holds(v[i], across(v[i], i), F, road(i)); });
      const double a = (Fx - resistance(v[i]) - p_.m * gravity * std::sin(line[i].grade)) / effective_mass();
      v[(i + 1) % n] = std::min(v[(i + 1) % n], std::sqrt(std::max(1.0, v[i] * v[i] + 2.0 * a * ds)));
    }
    for (std::size_t k = 2 * n; k > 0; --k) {
      const std::size_t i = k % n;
      const std::size_t before = (i + n - 1) % n;
      const double brake =
          largest(p_.brake_torque / p_.radius, [&](double F) { return holds(v[i], across(v[i], i), -F, road(i)); });
      const double a = (brake + resistance(v[i]) + p_.m * gravity * std::sin(line[i].grade)) / effective_mass();
      v[before] = std::min(v[before], std::sqrt(v[i] * v[i] + 2.0 * std::max(0.0, a) * ds));
    }
    double time = 0.0;
    for (std::size_t i = 0; i < n; ++i) time += 2.0 * ds / (v[i] + v[(i + 1) % n]);
    return time;
  }

 private:
  double_track::Params p_;
  double f_;
  double_track::DoubleTrackCar car_;
  double_track::Engine engine_;
  double_track::GearMap gears_;
};

/// The line of least curvature on which the centre of gravity just stays inside.
inline std::vector<LinePoint> line_of_the_centre_of_gravity(const Track& track, const Car& car) {
  Car point = car;
  point.width = 0.0;
  const TrackCourse course(track, point);
  std::vector<LinePoint> line(static_cast<std::size_t>(track.length()));
  course.minimum_curvature({0.0, 0.0}, line);
  return line;
}

}  // namespace gripline::testing_support
