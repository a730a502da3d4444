// What the car can do, as far as a stack may know it: drive and brakes from the nominal model, cornering from a
// friction coefficient and a tyre of generic shape, steering from its stop.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gripline/interfaces.hpp>

#include "common/vehicle/axle_loads.hpp"
#include "common/vehicle/magic_formula.hpp"

namespace gripline::planning {

/// The entry of a table at or before a position, which is at least 0, the last but one at most. That one too where the
/// position is NaN: what is interpolated from there is NaN as well.
inline std::size_t entry_before(double position, std::size_t count) {
  return position < static_cast<double>(count - 2) ? static_cast<std::size_t>(position) : count - 2;
}

/// Accelerations on a straight and level road, tabled over speed [m/s2]:
/// v' = coast(v) + drive(v) at full throttle, coast(v) - brake(v) at full brake.
class DriveLimits {
 public:
  /// `rolling` [m/s2] and `drag` [1/m] are resistances that the nominal model lacks: rolling + drag v^2.
  DriveLimits(Prediction& nominal, const Car& car, double rolling, double drag) {
    const auto rate = [&](double v, double d) {
      State x;
      x.vx = v;
      return nominal.rates(x, Input{d, 0.0}, Place{}).vx;
    };
    const auto resisted = [&](double v) { return rate(v, car.d_max) - rolling - drag * v * v; };
    top_ = top_speed(resisted, car);
    step_ = top_ / static_cast<double>(count - 1);
    for (std::size_t i = 0; i < count; ++i) {
      const double v = std::max(static_cast<double>(i) * step_, car.v_min);
      const double free = rate(v, 0.0);
      rows_.push_back({free - rolling - drag * v * v, std::max(0.0, rate(v, car.d_max) - free),
                       std::max(0.0, free - rate(v, car.d_min))});
    }
  }

  double coast(double v) const { return at(v).coast; }
  double drive(double v) const { return at(v).drive; }
  double brake(double v) const { return at(v).brake; }
  /// Speed at which full throttle only just overcomes the resistances [m/s].
  double top_speed() const { return top_; }

 private:
  struct Row {
    double coast = 0, drive = 0, brake = 0;
  };
  static constexpr std::size_t count = 257;

  template <class Rate>
  static double top_speed(const Rate& rate, const Car& car) {
    const double scale = std::max(car.v_ref, 0.1);
    if (!(rate(std::max(car.v_min, 1e-3 * scale)) > 0.0))
      throw std::invalid_argument("the nominal model does not accelerate at full throttle from standstill");
    double hi = scale;
    while (rate(hi) > 0.0) {
      hi *= 1.25;
      if (hi > 50.0 * scale) return hi;  // a model without emf or resistance: the corners limit the speed
    }
    double lo = 0.0;
    for (int i = 0; i < 60; ++i) (rate(0.5 * (lo + hi)) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
    return hi;
  }
  Row at(double v) const {
    const double position = std::clamp(v / step_, 0.0, static_cast<double>(count - 1));
    const std::size_t i = entry_before(position, count);
    const double w = position - static_cast<double>(i);
    const Row &p = rows_[i], &q = rows_[i + 1];
    return {p.coast + (q.coast - p.coast) * w, p.drive + (q.drive - p.drive) * w, p.brake + (q.brake - p.brake) * w};
  }

  std::vector<Row> rows_;
  double top_ = 0, step_ = 1;
};

/// Both axles at one coefficient of friction, the static load on each. Forces are per mass of the car [m/s2].
inline vehicle::AxleTyres equal_friction(double mu, const Car& car, double B, double C) {
  const vehicle::AxleLoads peak = vehicle::axle_loads(mu * gravity, car);
  return {{B, C, peak.front}, {B, C, peak.rear}};
}

/// Largest lateral acceleration of tyres per mass with the yaw moments in balance [m/s2].
inline double lateral_limit(const vehicle::AxleTyres& tyres, const Car& car) {
  return std::min(tyres.front.D / car.lr, tyres.rear.D / car.lf) * (car.lf + car.lr);
}

/// A steady turn: the steering it needs, how much the tyres slow the car down, how the car stands.
struct SteadyTurn {
  double steering = 0;  // [rad], infinite when the tyres cannot give the force
  double drag = 0;      // [m/s2]
  double beta = 0;      // sideslip angle of the centre of gravity [rad]
};

/// Steady turn of curvature kappa >= 0 on tyres whose forces are per mass [m/s2], with lateral acceleration a >= 0 and
/// the drive force that keeps the speed:
///   Ff cos(delta) + Fr = m a cos(beta),   Ff cos(delta) lf = Fr lr,
/// slips as in the single-track model: sin(beta + slip_r) = kappa lr cos(slip_r),
/// delta = slip_f + atan((sin(beta) + kappa lf) / cos(beta)); drag = Ff sin(delta - beta) - Fr sin(beta).
inline SteadyTurn steady_turn(const Car& car, const vehicle::AxleTyres& tyres, double kappa, double a) {
  const double wheelbase = car.lf + car.lr;
  double delta = wheelbase * kappa, beta = car.lr * kappa, front = 0, rear = 0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const double balance = std::cos(delta) * car.lf / car.lr;  // Fr / Ff
    front = a * std::cos(beta) / (std::cos(delta) + balance);
    rear = balance * front;
    const double slip_front = tyres.front.slip(front), slip_rear = tyres.rear.slip(rear);
    const double sine = kappa * car.lr * std::cos(slip_rear);
    if (!std::isfinite(slip_front) || !std::isfinite(slip_rear) || !(std::abs(sine) < 1.0))
      return {std::numeric_limits<double>::infinity(), 0.0, 0.0};
    beta = std::asin(sine) - slip_rear;
    const double wanted = slip_front + std::atan((std::sin(beta) + kappa * car.lf) / std::cos(beta));
    if (!(wanted < 1.5)) return {std::numeric_limits<double>::infinity(), 0.0, 0.0};
    const double change = wanted - delta;
    delta += iteration > 3 ? change : 0.5 * change;
    if (std::abs(change) < 1e-10) break;
  }
  return {delta, front * std::sin(delta - beta) - rear * std::sin(beta), beta};
}

/// Speed limits of corners and the drag in them. Forces scale with mu and steering depends on their ratios only, so
/// that one table over curvature and one over curvature and load serve every mu. A road needs few of their entries:
/// each is computed where it is looked up first. Hence not for several threads at once, though const.
class CornerLimits {
 public:
  /// `unit`: the axles at mu = 1.
  CornerLimits(const Car& car, const vehicle::AxleTyres& unit, double top_speed)
      : car_(car),
        unit_(unit),
        lateral_(planning::lateral_limit(unit, car)),
        top_(top_speed),
        steepest_(1.2 * std::tan(car.delta_max) / (car.lf + car.lr)),
        accel_(curvatures, unknown),
        drag_(curvatures * loads, unknown) {}

  /// Largest lateral acceleration with the yaw moments in balance [m/s2].
  double lateral_limit(double mu) const { return mu * lateral_; }

  /// Largest speed at which the turn can be held steadily by tyres and steering [m/s]. `bank` as in Place. A line
  /// sharper than the car can steer at all gets the speed of a crawl: a quarter of its friction circle's.
  double speed(double mu, double kappa, double bank) const {
    const double curvature = std::abs(kappa), pull = (kappa < 0 ? -1.0 : 1.0) * gravity * std::sin(bank);
    const double force =
        mu * lookup([&](std::size_t i) { return accel(i); }, curvature / steepest_ * (curvatures - 1), curvatures);
    const double a = std::max(force, mu * lateral_ / 16.0) + pull;  // crawl: v^2 kappa is a sixteenth of mu g
    return std::min(top_, std::sqrt(std::max(a, 1e-4) / std::max(curvature, 1e-9)));
  }

  /// Deceleration by the tyres' side forces in a turn at speed v [m/s2]; that of the limit beyond it.
  double drag(double mu, double v, double kappa, double bank) const {
    const double a = (kappa < 0 ? -1.0 : 1.0) * (v * v * kappa - gravity * std::sin(bank));
    const double row = std::min(std::abs(kappa) / steepest_, 1.0) * (curvatures - 1);
    const double column = std::clamp(a / (mu * lateral_), 0.0, full_load) / full_load * (loads - 1);
    const std::size_t i = entry_before(row, curvatures);
    const auto in_row = [&](std::size_t at) {
      return lookup([&](std::size_t j) { return drag_at(at, j); }, column, loads);
    };
    const double low = in_row(i), high = in_row(i + 1);
    return mu * (low + (high - low) * (row - static_cast<double>(i)));
  }

 private:
  static constexpr std::size_t curvatures = 257, loads = 65;
  static constexpr double full_load = 0.98;  // towards the peak the slip is too sensitive to the force to be tabled

  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double curvature_at(std::size_t i) const { return steepest_ * static_cast<double>(i) / (curvatures - 1); }
  double accel(std::size_t i) const {
    if (std::isnan(accel_[i])) accel_[i] = largest_accel(curvature_at(i));
    return accel_[i];
  }
  /// Where the tyres cannot hold the turn: that of the largest load in the table at which they can.
  double drag_at(std::size_t i, std::size_t j) const {
    double& entry = drag_[i * loads + j];
    if (!std::isnan(entry)) return entry;
    const double share = full_load * static_cast<double>(j) / (loads - 1);
    const SteadyTurn turn = steady_turn(car_, unit_, curvature_at(i), share * lateral_);
    if (std::isfinite(turn.steering)) return entry = turn.drag;
    return entry = j > 0 ? drag_at(i, j - 1) : 0.0;
  }
  double largest_accel(double kappa) const {
    const auto possible = [&](double a) { return steady_turn(car_, unit_, kappa, a).steering <= car_.delta_max; };
    if (!possible(0.0)) return 0.0;
    double lo = 0.0, hi = lateral_ / std::cos(car_.delta_max);  // none can be more: Ff <= its peak
    for (int i = 0; i < 40; ++i) (possible(0.5 * (lo + hi)) ? lo : hi) = 0.5 * (lo + hi);
    return std::min(lo, lateral_);
  }
  template <class Values>
  static double lookup(const Values& values, double position, std::size_t count) {
    const double inside = std::clamp(position, 0.0, static_cast<double>(count - 1));
    const std::size_t i = entry_before(inside, count);
    const double w = inside - static_cast<double>(i);
    return values(i) * (1.0 - w) + values(i + 1) * w;
  }

  Car car_;
  vehicle::AxleTyres unit_;
  double lateral_, top_, steepest_;
  mutable std::vector<double> accel_, drag_;  // unknown until they are looked up
};

}  // namespace gripline::planning
