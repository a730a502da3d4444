// Accelerations of the nominal model without slip: drive less resistance, slope and wind included. They are evaluated
// by the model itself, so that every nominal model and effect is accounted for.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gripline/plugin.hpp>

#include "common/learning/friction_ellipse.hpp"

namespace gripline::learning {

/// By how much of itself the drive and the brake force exceed what the nominal model says, and the arm [m] at which
/// drive turns the car.
struct DriveGains {
  double drive = 0, brake = 0;
  double arm = 0;

  /// What is missing of a nominal force [N].
  template <class T>
  T missing(const T& force) const {
    return (force < T(0) ? brake : drive) * force;
  }

  /// Moment [N m] with which a drive force [N] turns the car further into the turn in which it has this side force [N].
  /// Wheels on the outside carry more: where traction control or a locking differential lets them push more, by as much
  /// as they carry more, the arm is the height of the centre of gravity; where left and right push alike it is 0.
  /// Turned front wheels that drive add to it.
  template <class T, class Mass>
  T turning_moment(const T& drive_force, const T& side_force, const Mass& mass) const {
    if (!(drive_force > T(0))) return T(0);
    return arm / (mass * gravity) * drive_force * side_force;
  }
};

class StraightDrive {
 public:
  /// The nominal model outlives this. Throws when there is none, when it has no loads, or when commands move within a
  /// step: a step's equations would be taken at the wrong steering angle.
  explicit StraightDrive(const PluginContext& context) : nominal_(context.nominal), car_(context.car) {
    if (nominal_ == nullptr) throw std::runtime_error("needs a nominal model to learn what it misses");
    if (context.hold != Hold::zoh) throw std::runtime_error("learns from held commands only: input_hold \"zoh\"");
    const Car& car = context.car;
    // Tyres answer a side slip with a side force, and that of turned wheels slows the car: what correct_body() takes
    // off. Side speed alone would not tell: without tyres it may fade by itself (effect yaw_response).
    const double v = std::max(car.v_ref, 2 * car.v_min);
    State sliding;
    sliding.vx = v;
    sliding.delta = 0.1;
    State rolling = sliding;
    sliding.vy = 0.1 * v;
    const Place flat;
    if (!(nominal_->rates(rolling, {}, flat).load_front > 0.0))
      throw std::runtime_error("needs a nominal model with a mass and axle loads (Stage::load)");
    has_tyres_ = std::abs(nominal_->rates(sliding, {}, flat).vx - nominal_->rates(rolling, {}, flat).vx) > 1e-9 * v;
    Place banked;
    banked.bank = 0.1;
    banked.kappa = gravity / (v * v);
    has_slope_load_ = nominal_->rates(rolling, {}, banked).load_front != nominal_->rates(rolling, {}, flat).load_front;
  }

  bool model_has_tyres() const { return has_tyres_; }

  struct Rates {
    double forward = 0, side = 0;          // of vx and vy [m/s2]
    double load_front = 1, load_rear = 1;  // of the axles, relative to the static ones
    double drive_force = 0;                // Fd [N], as the nominal model says
    double slope = 1;                      // what of the loads is the road's, over those on a flat one
    /// These rates, with the loads of a road that presses on both axles by `load` times as much as a flat one.
    Rates on_road(double load) const {
      Rates r = *this;
      r.load_front *= load / slope;
      r.load_rear *= load / slope;
      r.slope = load;
      return r;
    }
    /// These rates, with each load reduced to what drive and brakes leave of it for side forces.
    Rates reduced_by(const FrictionEllipse& ellipse, const PeakForces& peaks, const DriveGains& gains) const {
      Rates r = *this;
      const double force = drive_force + gains.missing(drive_force);
      r.load_front *= ellipse.side_share(Axle::front, force, load_front, peaks.front);
      r.load_rear *= ellipse.side_share(Axle::rear, force, load_rear, peaks.rear);
      return r;
    }
  };
  /// At forward speed vx [m/s] where throttle d acts and the wheels point straight ahead.
  Rates at(double vx, double d, const Place& place) const {
    const Prediction::Rates rates = rates_where(vx, d, place);
    // Models without tyres leave the bank out: their wheels hold the car.
    return {rates.vx,          has_tyres_ ? rates.vy : rates.vy + gravity * std::sin(place.bank),
            rates.load_front,  rates.load_rear,
            rates.drive_force, slope_of_load(rates, vx, d, place)};
  }

 private:
  double slope_of_load(const Prediction::Rates& rates, double vx, double d, Place place) const {
    if (!has_slope_load_ || (place.grade == 0.0 && place.bank == 0.0)) return 1.0;
    place.grade = place.bank = 0.0;
    return rates.load_front / rates_where(vx, d, place).load_front;
  }

  /// The nominal model takes commands, of which its Stage::command may make something else: a dead zone, a curve, an
  /// offset. Where it does, the commands that make throttle d act and the wheels point straight ahead are found by
  /// bisection, in 51 evaluations of the model; what acts must rise with the command.
  Prediction::Rates rates_where(double vx, double d, const Place& place) const {
    constexpr int halvings = 50;
    State x;
    x.vx = vx;
    Prediction::Rates rates = nominal_->rates(x, {d, 0.0}, place);
    const bool as_commanded = rates.d == d && rates.delta == 0.0;
    if (as_commanded || !std::isfinite(d)) return rates;
    double least = car_.d_min, most = car_.d_max, right = -car_.delta_max, left = car_.delta_max;
    if (rates.d == d) least = most = d;
    if (rates.delta == 0.0) right = left = 0.0;
    for (int i = 0; i < halvings; ++i) {
      const double command = 0.5 * (least + most);
      x.delta = 0.5 * (right + left);
      rates = nominal_->rates(x, {command, 0.0}, place);
      (rates.d < d ? least : most) = command;
      (rates.delta < 0.0 ? right : left) = x.delta;
    }
    return rates;
  }

  Prediction* nominal_;
  Car car_;
  bool has_tyres_ = false;
  bool has_slope_load_ = false;  // whether the loads of the model are those of the slope
};

}  // namespace gripline::learning
