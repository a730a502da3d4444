// The equations of the double-track car.
//
//   m (vx' - vy omega) = sum Fx - D |V| vx - m g sin(grade)
//   m (vy' + vx omega) = sum Fy - D |V| vy + m g sin(bank)
//   Iz omega'          = sum (px Fy - py Fx)                                 p: the wheel's place in the car
//   I spin'            = T_drive - r Fx - T_stop sign(spin)
//   T_stop             = T_brake + f_r r Fz     dry friction: a stopped wheel stays until the torque on it exceeds this
// Loads (Milliken and Milliken, chapter 18), all transfers with lag `load_lag` so that they depend on the forces of
// a moment ago:
//   front + rear = m (g_n + vx^2 d grade/ds) + c V^2,   front's static share lr / (lf + lr)
//   longitudinal transfer   h sum Fx / (lf + lr)     from front to rear; holds at rest on a slope too
//   lateral transfer, front (z_f Fyf + k_f ((h - z_f) Fyf + (h - z_r) Fyr)) / track_front, rear alike with 1 - k_f
// g_n = g sqrt(1 - sin(grade)^2 - sin(bank)^2); d grade/ds is the difference of the grades under the two axles, along
// the car: in a turn whose bank turns with the road that is d grade/ds of the road and kappa sin(bank), the curvature
// of the surface in the car's direction (Meusnier).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "plants/double_track/drivetrain.hpp"
#include "plants/double_track/parameters.hpp"
#include "plants/double_track/tyre.hpp"

namespace gripline::double_track {

inline constexpr std::size_t wheels = 4;  // front left, front right, rear left, rear right
using PerWheel = std::array<double, wheels>;

/// Everything that is integrated.
struct Motion {
  double x = 0, y = 0, yaw = 0, vx = 0, vy = 0, omega = 0;
  double steer = 0;                               // mean angle of the front wheels [rad]
  double throttle = 0, brake = 0;                 // as they act, in [0, 1]
  double lag_x = 0, lag_front = 0, lag_rear = 0;  // tyre forces that loads follow: all Fx, Fy per axle [N]
  PerWheel spin{}, slip_x{}, slip_y{};            // [rad/s], transient slips [-]
};
inline constexpr std::size_t motion_size = sizeof(Motion) / sizeof(double);

/// What is held over one integration step.
struct Held {
  double throttle = 0, brake = 0, steer = 0;         // commands
  double ratio = 1;                                  // engine speed over mean wheel speed
  double engaged = 1;                                // share of the engine's torque that gets through
  double grade_sine = 0, bank_sine = 0, normal = 0;  // slope under the centre of gravity; g_n [m/s2]
  double curve = 0;                                  // d grade/ds [1/m]
  PerWheel factor{1, 1, 1, 1};                       // friction
  PerWheel turning{};                                // -1, 0, 1: sign of the spin at the step's start
};

/// What acts at a wheel at one instant, for validation and tests.
struct WheelLoads {
  double Fx = 0, Fy = 0, Fz = 0;     // in the wheel's axes [N]
  double Vx = 0, Vy = 0;             // of the contact point in the wheel's axes [m/s]
  double drive = 0, resistance = 0;  // torque of the engine, and against the spin (brake and rolling) [N m]
};

class DoubleTrackCar {
 public:
  /// std::invalid_argument with one line when parameters do not fit together.
  explicit DoubleTrackCar(const Params& p)
      : p_(p),
        engine_(p.engine_torque.data != nullptr ? p.engine_torque : Table{default_engine.data(), 9, 3}),
        gearbox_(GearMap(p.gears.data != nullptr ? p.gears : Table{default_gears.data(), 6, 4}), p.shift_time) {
    if (!(p.slip_end > p.slip_start))
      throw std::invalid_argument(detail::text("slip_end is %g and slip_start %g, expected slip_end above slip_start",
                                               p.slip_end, p.slip_start));
    if (p.roll_centre_front > p.h || p.roll_centre_rear > p.h)
      throw std::invalid_argument(detail::text("roll centres are at %g and %g m, expected none above h, %g m",
                                               p.roll_centre_front, p.roll_centre_rear, p.h));
    const double wheelbase = p.lf + p.lr;
    const TyreData tyre{.mu_x = p.mu_x,
                        .mu_y = p.mu_y,
                        .sensitivity = p.load_sensitivity,
                        .stiffness_x = p.stiffness_x,
                        .stiffness_load = p.stiffness_load,
                        .relaxation_x = p.relaxation_x,
                        .relaxation_y = p.relaxation_y,
                        .damping = p.contact_damping,
                        .damping_below = 2.5,
                        .x = Shape(p.C_x, p.E_x),
                        .y = Shape(p.C_y, p.E_y)};
    front_ = Tyre(tyre, p.stiffness_front, 0.5 * p.m * gravity * p.lr / wheelbase);
    rear_ = Tyre(tyre, p.stiffness_rear, 0.5 * p.m * gravity * p.lf / wheelbase);
    wheel_x_ = {p.lf, p.lf, -p.lr, -p.lr};
    wheel_y_ = {0.5 * p.track_front, -0.5 * p.track_front, 0.5 * p.track_rear, -0.5 * p.track_rear};
  }

  void reset(const State& x, const Ground& ground);
  /// Advances by dt in equal steps of at most `step`, commands held.
  void advance(double d, double delta, double dt, const Ground& ground);

  const Motion& motion() const { return z_; }
  const Params& params() const { return p_; }
  const std::array<WheelLoads, wheels>& loads() const { return loads_; }
  int gear() const { return gearbox_.gear(); }
  const Tyre& tyre(Axle axle) const { return axle == Axle::front ? front_ : rear_; }
  double axle_force(Axle axle) const {
    return axle == Axle::front ? loads_[0].Fy + loads_[1].Fy : loads_[2].Fy + loads_[3].Fy;
  }

 private:
  /// Where a wheel points, in the car's axes.
  struct Heading {
    double cosine = 1.0, sine = 0.0;
  };
  using Headings = std::array<Heading, wheels>;
  /// At a wheel [N m].
  struct Torques {
    double drive = 0, brake = 0;  // of the engine, of its brake
  };
  /// Of the tyres together, in the car's axes.
  struct ForceSum {
    double x = 0, y[2] = {0, 0};  // all along, and across per axle [N]
    double moment = 0;            // about the centre of gravity [N m]
  };
  Held hold(double d, double delta, const Ground& ground) const;
  Headings headings(double steer) const;
  PerWheel vertical(const Motion& z, const Held& held) const;
  /// Torque of the engine at an axle [N m].
  double axle_drive(const Motion& z, const Held& held, Axle axle) const;
  /// At each wheel of an axle, before slip control.
  Torques wheel_torques(const Motion& z, const Held& held, Axle axle) const;
  WheelMotion over_ground(const Motion& z, const Heading& heading, std::size_t wheel) const;
  Torques slip_controlled(Torques torques, const WheelMotion& over) const;
  /// Rates of all but spins and slips.
  void set_body_rates(const Motion& z, const Held& held, const ForceSum& force, Motion& rate) const;
  Motion rates(const Motion& z, const Held& held, double step, std::array<WheelLoads, wheels>* loads) const;
  void heun(const Held& held, double step);

  Params p_;
  Engine engine_;
  Gearbox gearbox_;
  Tyre front_, rear_;
  PerWheel wheel_x_{}, wheel_y_{};  // from the centre of gravity, forward and to the left [m]
  Motion z_;
  std::array<WheelLoads, wheels> loads_{};
};

namespace detail {

using Flat = std::array<double, motion_size>;
static_assert(sizeof(Flat) == sizeof(Motion));

/// a + h b, component by component.
inline Motion plus(const Motion& a, double h, const Motion& b) {
  Flat sum = std::bit_cast<Flat>(a);
  const Flat rate = std::bit_cast<Flat>(b);
  for (std::size_t i = 0; i < motion_size; ++i) sum[i] += h * rate[i];
  return std::bit_cast<Motion>(sum);
}

inline double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

}  // namespace detail

inline Held DoubleTrackCar::hold(double d, double delta, const Ground& ground) const {
  Held held;
  held.throttle = std::clamp(d, 0.0, 1.0);
  held.brake = std::clamp(-d, 0.0, 1.0);
  held.steer = delta;
  held.ratio = gearbox_.ratio() * p_.final_drive;
  held.engaged = gearbox_.engaged();
  const double c = std::cos(z_.yaw);
  const double s = std::sin(z_.yaw);
  const auto under = [&](double along, double left) {
    return ground.at(z_.x + c * along - s * left, z_.y + s * along + c * left, z_.yaw);
  };
  const Ground::Patch here = under(0.0, 0.0);
  held.grade_sine = std::sin(here.grade);
  held.bank_sine = std::sin(here.bank);
  held.normal =
      gravity * std::sqrt(std::max(0.0, 1.0 - held.grade_sine * held.grade_sine - held.bank_sine * held.bank_sine));
  PerWheel grade{};
  for (std::size_t i = 0; i < wheels; ++i) {
    const Ground::Patch patch = under(wheel_x_[i], wheel_y_[i]);
    held.factor[i] = patch.factor;
    grade[i] = patch.grade;
    held.turning[i] = detail::sign(z_.spin[i]);
  }
  held.curve = 0.5 * (grade[0] + grade[1] - grade[2] - grade[3]) / (p_.lf + p_.lr);
  return held;
}

// tan(left, right) = tan(steer) / (1 -+ ackermann track tan(steer) / (2 wheelbase)): the mean of their cotangents is
// the cotangent of the single-track angle.
inline DoubleTrackCar::Headings DoubleTrackCar::headings(double steer) const {
  const double tangent = std::tan(steer);
  const double spread = 0.5 * p_.ackermann * p_.track_front / (p_.lf + p_.lr) * tangent;
  Headings all;
  for (const std::size_t i : {0u, 1u}) {
    const double t = tangent / (i == 0 ? 1.0 - spread : 1.0 + spread);
    const double cosine = 1.0 / std::sqrt(1.0 + t * t);
    all[i] = {cosine, t * cosine};
  }
  return all;
}

inline PerWheel DoubleTrackCar::vertical(const Motion& z, const Held& held) const {
  const double wheelbase = p_.lf + p_.lr;
  const double V2 = z.vx * z.vx + z.vy * z.vy;
  const double weight = p_.m * std::max(0.0, held.normal + z.vx * z.vx * held.curve);
  const double total = std::max(0.0, weight + (p_.downforce_front + p_.downforce_rear) * V2);  // lift unloads
  const double front =
      std::clamp(weight * p_.lr / wheelbase + p_.downforce_front * V2 - z.lag_x * p_.h / wheelbase, 0.0, total);
  const double rear = total - front;
  const double elastic = (p_.h - p_.roll_centre_front) * z.lag_front + (p_.h - p_.roll_centre_rear) * z.lag_rear;
  const auto transfer = [](double moment, double track, double axle) {
    return std::clamp(moment / track, -0.5 * axle, 0.5 * axle);
  };
  const double f = transfer(p_.roll_centre_front * z.lag_front + p_.roll_front * elastic, p_.track_front, front);
  const double r = transfer(p_.roll_centre_rear * z.lag_rear + (1.0 - p_.roll_front) * elastic, p_.track_rear, rear);
  return {0.5 * front - f, 0.5 * front + f, 0.5 * rear - r, 0.5 * rear + r};
}

// A centre differential of fixed torque split and open differentials at the axles: the engine turns with the mean of
// the wheels, weighted by their torque.
inline double DoubleTrackCar::axle_drive(const Motion& z, const Held& held, Axle axle) const {
  const double mean =
      0.5 * (p_.drive_front * (z.spin[0] + z.spin[1]) + (1.0 - p_.drive_front) * (z.spin[2] + z.spin[3]));
  const double torque = engine_.torque(z.throttle, held.ratio * mean) * held.ratio * held.engaged;
  return torque * (axle == Axle::front ? p_.drive_front : 1.0 - p_.drive_front);
}

inline DoubleTrackCar::Torques DoubleTrackCar::wheel_torques(const Motion& z, const Held& held, Axle axle) const {
  return {0.5 * axle_drive(z, held, axle),
          0.5 * z.brake * p_.brake_torque * (axle == Axle::front ? p_.brake_bias : 1.0 - p_.brake_bias)};
}

inline WheelMotion DoubleTrackCar::over_ground(const Motion& z, const Heading& heading, std::size_t wheel) const {
  const double ux = z.vx - z.omega * wheel_y_[wheel];
  const double uy = z.vy + z.omega * wheel_x_[wheel];
  return {heading.cosine * ux + heading.sine * uy, heading.cosine * uy - heading.sine * ux, p_.radius * z.spin[wheel]};
}

inline DoubleTrackCar::Torques DoubleTrackCar::slip_controlled(Torques torques, const WheelMotion& over) const {
  const double Vt = Tyre::transport(over);
  const double slip = (over.Vr - over.Vx) / std::max(Vt, 3.0);  // [m/s] less sharp when setting off
  const double left = std::clamp((p_.slip_end - std::abs(slip)) / (p_.slip_end - p_.slip_start), 0.0, 1.0);
  const double active = std::clamp(Vt - 1.0, 0.0, 1.0);  // below 1 m/s wheels may lock, from 2 m/s on none
  // Slower than the ground, backwards too; a wheel that turns against it is braked.
  const bool locks = over.Vx < 0.0 ? slip > 0.0 && over.Vr <= 0.0 : slip < 0.0;
  if (locks) torques.brake *= 1.0 - active * (1.0 - left);
  if (slip > 0.0 && torques.drive > 0.0) torques.drive *= left;
  return torques;
}

inline Motion DoubleTrackCar::rates(const Motion& z, const Held& held, double step,
                                    std::array<WheelLoads, wheels>* loads) const {
  Motion rate;
  const PerWheel Fz = vertical(z, held);
  const Headings heading = headings(z.steer);
  const Torques torques[2] = {wheel_torques(z, held, Axle::front), wheel_torques(z, held, Axle::rear)};
  ForceSum force;
  for (std::size_t i = 0; i < wheels; ++i) {
    const std::size_t axle = i / 2;
    const WheelMotion over = over_ground(z, heading[i], i);
    const TyreForce tyre =
        (axle == 0 ? front_ : rear_).force(over, z.slip_x[i], z.slip_y[i], Fz[i], held.factor[i], step);
    rate.slip_x[i] = tyre.rate_x;
    rate.slip_y[i] = tyre.rate_y;

    const auto [drive, brake] = p_.slip_control ? slip_controlled(torques[axle], over) : torques[axle];
    const double resistance = brake + p_.rolling * p_.radius * Fz[i];
    const double free = drive - p_.radius * tyre.x;
    const double against =
        held.turning[i] != 0.0 ? held.turning[i] * resistance : std::clamp(free, -resistance, resistance);
    rate.spin[i] = (free - against) / p_.wheel_inertia;

    const double Fx = heading[i].cosine * tyre.x - heading[i].sine * tyre.y;
    const double Fy = heading[i].cosine * tyre.y + heading[i].sine * tyre.x;
    force.x += Fx;
    force.y[axle] += Fy;
    force.moment += wheel_x_[i] * Fy - wheel_y_[i] * Fx;
    if (loads != nullptr) (*loads)[i] = {tyre.x, tyre.y, Fz[i], over.Vx, over.Vy, drive, against};
  }
  set_body_rates(z, held, force, rate);
  return rate;
}

inline void DoubleTrackCar::set_body_rates(const Motion& z, const Held& held, const ForceSum& force,
                                           Motion& rate) const {
  const double speed = std::sqrt(z.vx * z.vx + z.vy * z.vy);
  rate.x = z.vx * std::cos(z.yaw) - z.vy * std::sin(z.yaw);
  rate.y = z.vx * std::sin(z.yaw) + z.vy * std::cos(z.yaw);
  rate.yaw = z.omega;
  rate.vx = (force.x - p_.drag * speed * z.vx) / p_.m - gravity * held.grade_sine + z.vy * z.omega;
  rate.vy = (force.y[0] + force.y[1] - p_.drag * speed * z.vy) / p_.m + gravity * held.bank_sine - z.vx * z.omega;
  rate.omega = force.moment / p_.Iz;
  rate.steer = std::clamp((held.steer - z.steer) / p_.steer_lag, -p_.steer_rate, p_.steer_rate);
  rate.throttle = (held.throttle - z.throttle) / p_.engine_lag;
  rate.brake = (held.brake - z.brake) / p_.brake_lag;
  rate.lag_x = (force.x - z.lag_x) / p_.load_lag;
  rate.lag_front = (force.y[0] - z.lag_front) / p_.load_lag;
  rate.lag_rear = (force.y[1] - z.lag_rear) / p_.load_lag;
}

inline void DoubleTrackCar::heun(const Held& held, double step) {
  const Motion first = rates(z_, held, step, nullptr);
  const Motion second = rates(detail::plus(z_, step, first), held, step, nullptr);
  z_ = detail::plus(detail::plus(z_, 0.5 * step, first), 0.5 * step, second);
  // dry friction stops a wheel, it does not turn it round
  for (std::size_t i = 0; i < wheels; ++i)
    if (z_.spin[i] * held.turning[i] < 0.0) z_.spin[i] = 0.0;
}

inline void DoubleTrackCar::advance(double d, double delta, double dt, const Ground& ground) {
  const int steps = std::max(1, static_cast<int>(std::ceil(dt / p_.step - 1e-9)));
  const double step = dt / steps;
  for (int i = 0; i < steps; ++i) {
    gearbox_.advance(std::max(0.0, z_.vx), step);
    heun(hold(d, delta, ground), step);
  }
  rates(z_, hold(d, delta, ground), step, &loads_);
}

inline void DoubleTrackCar::reset(const State& x, const Ground& ground) {
  z_ = {};
  z_.x = x.x;
  z_.y = x.y;
  z_.yaw = x.yaw;
  z_.vx = x.vx;
  z_.vy = x.vy;
  z_.omega = x.omega;
  z_.steer = x.delta;
  gearbox_.reset(std::max(0.0, x.vx));
  const Headings heading = headings(z_.steer);
  for (std::size_t i = 0; i < wheels; ++i) {
    const auto [cosine, sine] = heading[i];
    const double ux = z_.vx - z_.omega * wheel_y_[i];
    const double uy = z_.vy + z_.omega * wheel_x_[i];
    const double along = cosine * ux + sine * uy;
    z_.spin[i] = along / p_.radius;
    const double speed = std::hypot(ux, uy);
    z_.slip_y[i] = speed > 0.0 ? (sine * ux - cosine * uy) / speed : 0.0;
  }
  // loads follow the forces, and these the loads: settled after a few rounds
  const Held held = hold(0.0, x.delta, ground);
  for (int round = 0; round < 20; ++round) {
    const Motion rate = rates(z_, held, p_.step, &loads_);
    z_.lag_x += rate.lag_x * p_.load_lag;
    z_.lag_front += rate.lag_front * p_.load_lag;
    z_.lag_rear += rate.lag_rear * p_.load_lag;
  }
}

}  // namespace gripline::double_track
