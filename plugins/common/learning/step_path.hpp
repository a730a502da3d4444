// What one control step says of tyre forces and resistance: the car's equations of motion (single_track.hpp) integrated
// over the step.
//
//   m  (dvx/dt - mean(vy omega)) - straight drive  = -mean(Ff) sin(delta) - (Cr0 + Cd mean(vx^2))
//   m  (dvy/dt + mean(vx omega)) - m g sin(bank)   =  mean(Ff) cos(delta) + mean(Fr)
//   Iz  domega/dt                                  =  mean(Ff) lf cos(delta) - mean(Fr) lr + moment of the drive force
//
// At 20 ms the slips of the 1:43 car change by a third of their range within a step, so forces taken at its first
// instant would be biased: the means are Simpson's rule over start, middle and end, the middle by the cubic through
// both ends with the slopes the present model gives. Forces are curves over slip times the axle loads of the nominal
// model (1 without effects on loads), less what drive and brakes leave of the friction ellipse. The steering angle is
// held over the step (zoh), at what the nominal model says acts in its middle. The straight drive is (Fd - Fres) / m of
// the nominal model with its effects.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <gripline/plugin.hpp>

#include "common/learning/single_track.hpp"
#include "common/learning/straight_drive.hpp"
#include "common/learning/tyre_correction.hpp"

namespace gripline::learning {

inline constexpr int path_points = 3;
inline constexpr std::array<double, path_points> path_weights = {1.0 / 6, 4.0 / 6, 1.0 / 6};  // Simpson's rule

/// One step, ready for regression. Forces [N]: `drive_loss` is the left side of the first equation, `side` of the
/// second; `moment` [N m] of the third. slip[i] and speed[i] [m/s] are at start, middle and end.
struct StepPath {
  std::array<Slips, path_points> slip;
  std::array<double, path_points> speed;
  double sine = 0, cosine = 1;  // of the steering angle
  double drive_loss = 0, side = 0, moment = 0;
  double drive_force = 0;                // of the nominal model, in drive_loss already [N]
  double load_front = 1, load_rear = 1;  // of the axles, relative to the static ones: forces are these times the curves

  double mean_square_speed() const {
    double sum = 0;
    for (int i = 0; i < path_points; ++i) sum += path_weights[i] * speed[i] * speed[i];
    return sum;
  }
};

/// Velocities at start, middle and end of a step.
using VelocityPath = std::array<BodyVelocity, path_points>;

/// The equations of motion along a given path; the rates are differences of the readings.
inline StepPath equations_along(const VelocityPath& points, const Sample& k, const Car& car,
                                const StraightDrive::Rates& straight) {
  const double delta = k.x_next.delta - k.delta_lag;
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
  path.drive_force = straight.drive_force;
  path.moment = car.Iz * (k.x_next.omega - k.x.omega) / k.dt;
  return path;
}

/// The car as it is believed to be: the nominal model's straight drive, and what is learned beside it. `force(Axle,
/// slip)` is the present model of the tyres at static load [N].
template <class Force>
struct LearnedCar {
  const Car& car;
  const StraightDrive& drive;
  const CorrectionTerms& terms;
  Force force;

  /// The nominal model's rates without slip, with what drive and brakes leave of its loads for side forces.
  StraightDrive::Rates straight(double vx, double d, const Place& at) const {
    return drive.at(vx, d, at).reduced_by(terms.ellipse, terms.peaks, terms.gains);
  }
  /// Likewise, with the loads of a road that presses `road` times as much as a flat one (road_load()).
  StraightDrive::Rates straight(double vx, double d, const Place& at, double road) const {
    return drive.at(vx, d, at).on_road(road).reduced_by(terms.ellipse, terms.peaks, terms.gains);
  }
  BodyVelocity rates(const BodyVelocity& x, double delta, const StraightDrive::Rates& straight) const {
    const Slips s = slips(x, delta, car);
    const AxleForces forces = {straight.load_front * force(Axle::front, s.front),
                               straight.load_rear * force(Axle::rear, s.rear)};
    const double missing = terms.gains.missing(straight.drive_force);
    BodyVelocity rates = body_rates(x, delta, straight.forward + missing / car.m, straight.side, forces,
                                    terms.resistance.Cr0 + terms.resistance.Cd * x.vx * x.vx, car);
    const double side_force = forces.front * std::cos(delta) + forces.rear;
    rates.omega += terms.gains.turning_moment(straight.drive_force + missing, side_force, car.m) / car.Iz;
    return rates;
  }
};
template <class Force>
LearnedCar(const Car&, const StraightDrive&, const CorrectionTerms&, Force) -> LearnedCar<Force>;

/// Path through both readings of a step. With `use_model` false (nothing learned yet) the middle is the mean of both
/// ends. It has the nominal model's loads, not road_load(): `elm` and `mhe`, which learn along it, take a crest for less
/// friction. `elm` is the published method, and `mhe` is compared with it on the same equations; only predicted_path()
/// has road_load(), for `elm_rls`.
template <class Force>
StepPath step_path(const Sample& k, const LearnedCar<Force>& learned, bool use_model) {
  const double delta = k.x_next.delta - k.delta_lag, d = k.u.d - k.d_lag;
  const BodyVelocity begin = {k.x.vx, k.x.vy, k.x.omega};
  const BodyVelocity end = {k.x_next.vx, k.x_next.vy, k.x_next.omega};
  const StraightDrive::Rates at_begin = learned.straight(begin.vx, d, k.at);
  const StraightDrive::Rates at_end = learned.straight(end.vx, d, k.at_next);
  BodyVelocity middle = {0.5 * (begin.vx + end.vx), 0.5 * (begin.vy + end.vy), 0.5 * (begin.omega + end.omega)};
  if (use_model) {
    const BodyVelocity a = learned.rates(begin, delta, at_begin), b = learned.rates(end, delta, at_end);
    middle.vx += k.dt / 8 * (a.vx - b.vx);
    middle.vy += k.dt / 8 * (a.vy - b.vy);
    middle.omega += k.dt / 8 * (a.omega - b.omega);
  }
  const auto mean = [](double a, double b) { return 0.5 * (a + b); };
  return equations_along({begin, middle, end}, k, learned.car,
                         {mean(at_begin.forward, at_end.forward), mean(at_begin.side, at_end.side),
                          mean(at_begin.load_front, at_end.load_front), mean(at_begin.load_rear, at_end.load_rear),
                          mean(at_begin.drive_force, at_end.drive_force)});
}

/// What the road presses on the axles in a step, over their load on a flat one: sqrt(1 - sin(grade)^2 - sin(bank)^2)
/// plus vx^2 / g times the curvature of its surface along the car's way, change of the grade per metre and
/// kappa sin(bank) (Meusnier). Where the grade falls by 0.04 in 100 m, a crest takes 3 % off at 28 m/s; left out,
/// that would pass for less friction, which is extrapolated from slips of half the peak's.
inline double road_load(const Sample& k) {
  const Place &from = k.at, &to = k.at_next;
  const double grade = std::sin(from.grade), bank = std::sin(from.bank), way = k.x.vx * k.dt;
  const double turned = from.direction * from.kappa * bank;
  const double curve = way > 0.1 * gravity * k.dt * k.dt ? (to.grade - from.grade) / way + turned : 0.0;
  const double load = std::sqrt(std::max(0.0, 1.0 - grade * grade - bank * bank)) + curve * k.x.vx * k.x.vx / gravity;
  return std::clamp(load, 0.5, 2.0);
}

/// Path that the present model predicts from `begin` on, an estimate of the state freed of noise: slips from noisy
/// readings would make every tyre look softer than it is, most of all at speed, where slips are small.
/// Two classical Runge-Kutta steps, on a road that presses by road_load(): what is learned is tyres on a flat one.
/// correct_body(), which predicts with it, knows no crests.
template <class Force>
StepPath predicted_path(const BodyVelocity& begin, const Sample& k, const LearnedCar<Force>& learned) {
  const double delta = k.x_next.delta - k.delta_lag;
  const auto straight = learned.straight(0.5 * (k.x.vx + k.x_next.vx), k.u.d - k.d_lag, k.at, road_load(k));
  const auto rates = [&](const BodyVelocity& x) { return learned.rates(x, delta, straight); };
  const double h = 0.5 * k.dt;
  const BodyVelocity middle = runge_kutta_step(begin, h, rates);
  return equations_along({begin, middle, runge_kutta_step(middle, h, rates)}, k, learned.car, straight);
}

}  // namespace gripline::learning
