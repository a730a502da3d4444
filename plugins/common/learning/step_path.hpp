// What one control step says of tyre forces and resistance: the car's equations of motion integrated over the step.
//
//   m  (dvx/dt - mean(vy omega)) - straight drive  = -mean(Ff) sin(delta) - (Cr0 + Cd mean(vx^2))
//   m  (dvy/dt + mean(vx omega)) - m g sin(bank)   =  mean(Ff) cos(delta) + mean(Fr)
//   Iz  domega/dt                                  =  mean(Ff) lf cos(delta) - mean(Fr) lr
//
// with slips as the published plant has them (plugins/vehicles/dynamic.cpp). At 20 ms the slips of the 1:43 car change
// by a third of their range within a step, so forces taken at its first instant would be biased: the means are
// Simpson's rule over start, middle and end, the middle by the cubic through both ends with the slopes the present
// model gives. Forces are curves over slip times the axle loads of the nominal model (1 without effects on loads), less
// what drive and brakes leave of the friction ellipse. The steering angle is held over the step (zoh), at what the
// nominal model says acts in its middle. The straight drive, (Fd - Fres) / m of the nominal model
// with its effects, is asked of the model itself at zero slip, so that every nominal model and effect is accounted for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include <gripline/plugin.hpp>

namespace gripline {

inline constexpr int path_points = 3;
inline constexpr std::array<double, path_points> path_weights = {1.0 / 6, 4.0 / 6, 1.0 / 6};

/// Velocities in the car's axes.
struct Motion {
  double vx = 0, vy = 0, omega = 0;
};

struct Slips {
  double front = 0, rear = 0;
};

/// Slip angles [rad]; below v_min the forward speed is held, so that they stay smooth at standstill.
template <class T>
T front_slip(const T& vx, const T& vy, const T& omega, const T& delta, const T& lf, double v_min) {
  using std::abs, std::atan2, std::max;
  return delta - atan2(omega * lf + vy, max(T(abs(vx)), T(v_min)));
}
template <class T>
T rear_slip(const T& vx, const T& vy, const T& omega, const T& lr, double v_min) {
  using std::abs, std::atan2, std::max;
  return atan2(omega * lr - vy, max(T(abs(vx)), T(v_min)));
}

inline Slips slips(const Motion& x, double delta, const Car& car) {
  return {front_slip(x.vx, x.vy, x.omega, delta, car.lf, car.v_min), rear_slip(x.vx, x.vy, x.omega, car.lr, car.v_min)};
}

/// Side force beside drive and brakes: an axle that gives Fx keeps sqrt(1 - (Fx / (ratio Fy_max))^2) of its side force
/// (the friction ellipse; Pacejka, Tyre and Vehicle Dynamics, 1.3). Fx is the axle's share of the drive or brake force.
struct Ellipse {
  double ratio = 0;  // largest Fx over largest Fy; 0: forces do not share friction
  double drive_front = 0, brake_front = 0;

  template <class T>
  T left(Axle axle, const T& drive_force, const T& load, double peak) const {
    using std::max, std::sqrt;
    if (!(ratio > 0.0)) return T(1);
    const double front = drive_force < T(0) ? brake_front : drive_front;
    const T used = drive_force * (axle == Axle::front ? front : 1.0 - front) / (load * (ratio * peak));
    return sqrt(max(T(1) - used * used, T(least)));
  }
  static constexpr double least = 0.04;  // of the square: wheels are kept from locking and spinning
};

/// Declarations of an estimator's members ellipse, drive_front, brake_front.
template <class P>
constexpr auto ellipse_parameters() {
  return std::tuple{
      param("ellipse", &P::ellipse, "1", {0, 5},
            "largest drive or brake force over largest side force of a tyre; 0: they do not share friction"),
      param("drive_front", &P::drive_front, "1", {0, 1}, "front share of the drive force"),
      param("brake_front", &P::brake_front, "1", {0, 1}, "front share of the brake force")};
}

/// Largest side forces of the axles at static load, as believed [N].
struct Peaks {
  double front = 1, rear = 1;
};

/// Resistance force Cr0 + Cd vx^2 beside the nominal model's own [N, N s2/m2].
struct Resistance {
  double Cr0 = 0, Cd = 0;
};

/// Rates of a car with known axle forces.
inline Motion motion_rates(const Motion& x, double delta, double straight, double bank_rate, double force_front,
                           double force_rear, const Resistance& resistance, const Car& car) {
  const double sine = std::sin(delta), cosine = std::cos(delta);
  const double loss = resistance.Cr0 + resistance.Cd * x.vx * x.vx;
  return {straight - (loss + force_front * sine) / car.m + x.vy * x.omega,
          bank_rate + (force_rear + force_front * cosine) / car.m - x.vx * x.omega,
          (force_front * car.lf * cosine - force_rear * car.lr) / car.Iz};
}

/// One step, ready for regression. Forces [N]: drive_loss is the left side of the first equation, side of the second;
/// moment [N m] of the third. slip[i] and speed[i] are at start, middle and end.
struct StepPath {
  std::array<Slips, path_points> slip;
  std::array<double, path_points> speed;
  double sine = 0, cosine = 1;
  double drive_loss = 0, side = 0, moment = 0;
  double load_front = 1, load_rear = 1;  // of the axles, relative to the static ones: forces are these times the curves

  double mean_square_speed() const {
    double sum = 0;
    for (int i = 0; i < path_points; ++i) sum += path_weights[i] * speed[i] * speed[i];
    return sum;
  }
};

/// What the nominal model does with no slip at all: drive less resistance, slope and wind included, as rates.
class StraightDrive {
 public:
  /// The nominal model outlives this. Throws when there is none, or when commands move within a step: a step's equations
  /// would be taken at the wrong steering angle.
  explicit StraightDrive(const PluginContext& context) : nominal_(context.nominal) {
    if (nominal_ == nullptr) throw std::runtime_error("needs a nominal model to learn what it misses");
    if (context.hold != Hold::zoh) throw std::runtime_error("learns from held commands only: input_hold \"zoh\"");
    const Car& car = context.car;
    // A model with tyres answers a side slip with a side force, one without does not.
    const double v = std::max(car.v_ref, 2 * car.v_min);
    State sliding;
    sliding.vx = v;
    State rolling = sliding;
    sliding.vy = 0.1 * v;
    const Place flat;
    has_tyres_ = std::abs(nominal_->rates(sliding, {}, flat).vy - nominal_->rates(rolling, {}, flat).vy) > 1e-9 * v;
  }

  bool model_has_tyres() const { return has_tyres_; }

  struct Rates {
    double forward = 0, side = 0;
    double load_front = 1, load_rear = 1;
    double drive_force = 0;
    /// Loads become what they are worth to the side beside drive and brakes.
    Rates beside(const Ellipse& ellipse, const Peaks& peaks) const {
      Rates r = *this;
      r.load_front *= ellipse.left(Axle::front, drive_force, load_front, peaks.front);
      r.load_rear *= ellipse.left(Axle::rear, drive_force, load_rear, peaks.rear);
      return r;
    }
  };
  Rates at(double vx, double d, const Place& place) const {
    State straight;
    straight.vx = vx;
    const Prediction::Rates rates = nominal_->rates(straight, {d, 0.0}, place);
    // Models without tyres leave the bank out: their wheels hold the car.
    return {rates.vx, has_tyres_ ? rates.vy : rates.vy + gravity * std::sin(place.bank), rates.load_front,
            rates.load_rear, rates.drive_force};
  }

 private:
  Prediction* nominal_;
  bool has_tyres_ = false;
};

/// Start, middle and end of a step.
using Path = std::array<Motion, path_points>;

/// The equations of motion along a given path; the rates are differences of the readings.
inline StepPath equations_along(const Path& points, const Sample& k, const Car& car,
                                const StraightDrive::Rates& straight) {
  const double delta = k.x_next.delta - k.delta_behind;
  StepPath path;
  path.sine = std::sin(delta);
  path.cosine = std::cos(delta);
  double vy_omega = 0, vx_omega = 0;
  for (int i = 0; i < path_points; ++i) {
    path.slip[i] = slips(points[i], delta, car);
    path.speed[i] = points[i].vx;
    vy_omega += path_weights[i] * points[i].vy * points[i].omega;
    vx_omega += path_weights[i] * points[i].vx * points[i].omega;
  }
  path.load_front = straight.load_front;
  path.load_rear = straight.load_rear;
  path.drive_loss = car.m * ((k.x_next.vx - k.x.vx) / k.dt - straight.forward - vy_omega);
  path.side = car.m * ((k.x_next.vy - k.x.vy) / k.dt - straight.side + vx_omega);
  path.moment = car.Iz * (k.x_next.omega - k.x.omega) / k.dt;
  return path;
}

/// Path through both readings of a step. `force(Axle, slip)` is the present model of the tyres; with `use_model` false
/// (nothing learned yet) the middle is the mean of both ends.
template <class Force>
StepPath step_path(const Sample& k, const Car& car, const StraightDrive& drive, const Resistance& resistance,
                   const Ellipse& ellipse, const Peaks& peaks, bool use_model, const Force& force) {
  const double delta = k.x_next.delta - k.delta_behind;
  const Motion begin = {k.x.vx, k.x.vy, k.x.omega};
  const Motion end = {k.x_next.vx, k.x_next.vy, k.x_next.omega};
  const auto drive_begin = drive.at(begin.vx, k.u.d - k.d_behind, k.at).beside(ellipse, peaks);
  const auto drive_end = drive.at(end.vx, k.u.d - k.d_behind, k.at_next).beside(ellipse, peaks);
  Motion middle = {0.5 * (begin.vx + end.vx), 0.5 * (begin.vy + end.vy), 0.5 * (begin.omega + end.omega)};
  if (use_model) {
    const auto rates = [&](const Motion& x, const StraightDrive::Rates& straight) {
      const Slips s = slips(x, delta, car);
      return motion_rates(x, delta, straight.forward, straight.side, straight.load_front * force(Axle::front, s.front),
                          straight.load_rear * force(Axle::rear, s.rear), resistance, car);
    };
    const Motion a = rates(begin, drive_begin), b = rates(end, drive_end);
    middle.vx += k.dt / 8 * (a.vx - b.vx);
    middle.vy += k.dt / 8 * (a.vy - b.vy);
    middle.omega += k.dt / 8 * (a.omega - b.omega);
  }
  return equations_along(
      {begin, middle, end}, k, car,
      {0.5 * (drive_begin.forward + drive_end.forward), 0.5 * (drive_begin.side + drive_end.side),
       0.5 * (drive_begin.load_front + drive_end.load_front), 0.5 * (drive_begin.load_rear + drive_end.load_rear)});
}

/// Path that the present model predicts from `begin` on, an estimate of the state freed of noise: slips from noisy
/// readings would make every tyre look softer than it is, most of all at speed, where slips are small. Two classical
/// Runge-Kutta steps.
template <class Force>
StepPath predicted_path(const Motion& begin, const Sample& k, const Car& car, const StraightDrive& drive,
                        const Resistance& resistance, const Ellipse& ellipse, const Peaks& peaks, const Force& force) {
  const double delta = k.x_next.delta - k.delta_behind;
  const auto straight = drive.at(0.5 * (k.x.vx + k.x_next.vx), k.u.d - k.d_behind, k.at).beside(ellipse, peaks);
  const auto rates = [&](const Motion& x) {
    const Slips s = slips(x, delta, car);
    return motion_rates(x, delta, straight.forward, straight.side, straight.load_front * force(Axle::front, s.front),
                        straight.load_rear * force(Axle::rear, s.rear), resistance, car);
  };
  const auto moved = [](const Motion& x, const Motion& rate, double by) -> Motion {
    return {x.vx + by * rate.vx, x.vy + by * rate.vy, x.omega + by * rate.omega};
  };
  const double h = 0.5 * k.dt;
  Path points = {begin, begin, begin};
  for (int i = 1; i < path_points; ++i) {
    const Motion& x = points[i - 1];
    const Motion k1 = rates(x), k2 = rates(moved(x, k1, h / 2)), k3 = rates(moved(x, k2, h / 2)),
                 k4 = rates(moved(x, k3, h));
    points[i] = moved(moved(moved(moved(x, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
  }
  return equations_along(points, k, car, straight);
}

}  // namespace gripline
