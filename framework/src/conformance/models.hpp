// The kit's own vehicle models, written out here so that checking a plugin needs no other plugin: the nominal model
// that estimators and controllers are given, and the true car that Truth speaks of.
#pragma once

#include <cmath>
#include <tuple>
#include <vector>

#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>

#include "conformance/published_car.hpp"

namespace gripline::conformance {

/// Wheels roll where they point, linear in the steering angle: ax = Fd / m, ay = lr / L (delta' vx + delta ax),
/// aw = ay / lr. Resistance and tyres are what it misses.
class RollingCar final : public AutoDiffVehicle<RollingCar> {
 public:
  template <class T>
  struct Params {
    T m = T(published::car.m), Iz = T(published::car.Iz), lf = T(published::car.lf), lr = T(published::car.lr);
    T Cm1 = T(published::Cm1), Cm2 = T(published::Cm2);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("m", &P::m, "kg", {1e-6, 1e6}, "mass"),
                      param("Iz", &P::Iz, "kg m2", {1e-12, 1e9}, "yaw inertia"),
                      param("lf", &P::lf, "m", {1e-4, 100}, "centre of gravity to front axle"),
                      param("lr", &P::lr, "m", {1e-4, 100}, "centre of gravity to rear axle"),
                      param("Cm1", &P::Cm1, "N", {0, 1e7}, "drive force at rest"),
                      param("Cm2", &P::Cm2, "N s/m", {0, 1e6}, "loss of drive force with speed")};
  }
  static std::vector<double> values() {
    const Params<double> p;
    return {p.m, p.Iz, p.lf, p.lr, p.Cm1, p.Cm2};
  }

  template <class T>
  void drive(Point<T>& p, const Params<T>& k) const {
    p.q.motor = k.Cm1;
    p.q.emf = k.Cm2;
    p.q.brake = k.Cm1 - k.Cm2 * p.q.vx;
    p.q.rolling = T(0);
    p.q.drag = T(0);
  }
  template <class T>
  void load(Point<T>& p, const Params<T>& k) const {
    p.q.drive_force = drive_force(p.q);
    p.q.m = k.m;
    p.q.Iz = k.Iz;
    p.q.lf = k.lf;
    p.q.lr = k.lr;
    p.q.load_front = T(1);
    p.q.load_rear = T(1);
  }
  template <class T>
  void body(Point<T>& p, const Params<T>&) const {
    auto& q = p.q;
    q.ax = q.drive_force / q.m;
    q.ay = q.lr / (q.lf + q.lr) * (q.delta_rate * q.vx + q.delta * q.ax);
    q.aw = q.ay / q.lr;
    q.grade = T(p.at.grade);
    q.bank = T(p.at.bank);
  }
};

/// ax, ay, aw of the recorded drive's car (recorded_drive.hpp) at friction factor 1; of one that rolls backwards too,
/// whose resistance and front wheels oppose the motion.
template <class T>
void true_accelerations(Quantities<T>& q) {
  using std::abs;
  using std::atan;
  using std::cos;
  using std::sin;
  using namespace published;
  constexpr double m = car.m, Iz = car.Iz, lf = car.lf, lr = car.lr;
  const T forward = abs(q.vx);
  const T turned = steered_along_motion(q.vx, q.delta);
  const T front = Df * sin(Cf * atan(Bf * front_slip(forward, q.vy, q.omega, turned, T(lf))));
  const T rear = Dr * sin(Cr * atan(Br * rear_slip(forward, q.vy, q.omega, T(lr))));
  T resistance = Cr0 + Cd * square(q.vx);
  if (q.vx < T(0)) resistance = -resistance;
  q.ax = ((Cm1 - Cm2 * q.vx) * q.d - resistance - front * sin(q.delta)) * (1 / m) + q.vy * q.omega;
  q.ay = (rear + front * cos(q.delta)) * (1 / m) - q.vx * q.omega;
  q.aw = (front * lf * cos(q.delta) - rear * lr) * (1 / Iz);
}

}  // namespace gripline::conformance
