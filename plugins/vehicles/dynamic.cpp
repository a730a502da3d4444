// Planar single-track car with Pacejka axles: the published plant, and the nominal model of diagnose's blind cases.
//
//   vx'    = (Fd - Fres - Ff sin(delta)) / m + vy omega - g sin(grade)
//   vy'    = (Fr + Ff cos(delta)) / m - vx omega + g sin(bank)
//   omega' = (Ff lf cos(delta) - Fr lr) / Iz
//   Fd     = (Cm1 - Cm2 vx) d,  for d < 0 with Cb > 0 instead Cb d;   Fres = Cr0 + Cd vx^2
//   af     = delta - atan2(omega lf + vy, |vx|),   ar = atan2(omega lr - vy, |vx|)
//   Ff     = N Df sin(Cf atan(Bf af)),   Fr = N Dr sin(Cr atan(Br ar))
//
// with the load N of a slope over that on a flat road (common/vehicle/slope_load.hpp), else as published, for a car that
// drives forward. For one that stands or rolls backwards common/vehicle/standstill.hpp
// has Fd, Fres and af: brakes and resistance oppose the motion and hold, and delta counts with the sign of vx. The
// published plant's af has delta as it is there: its front tyres then push a reversing or standing car.
//
// Sources: Kalaria, Lin, Dolan, the dynamic model of their simulated car, with the signs of the slope terms for ISO
// axes; Liniger, Domahidi, Morari (2015) for the 1:43 car. The tyres that parameters default to are generic, of
// friction 1 (LLA-MPC's prior), and resistance is zero: what is true of a world's car stands in the world, so that a
// stack whose nominal model this is knows none of them unless they are stated.
#include <gripline/plugin.hpp>

#include "common/vehicle/slope_load.hpp"
#include "common/vehicle/standstill.hpp"

namespace {

using gripline::Point;
using std::atan;
using std::sin;

class Dynamic final : public gripline::AutoDiffVehicle<Dynamic> {
 public:
  template <class T>
  struct Params {
    T m = T(0.041), Iz = T(27.8e-6), lf = T(0.029), lr = T(0.033);
    T Bf = T(4), Cf = T(1.4), Df = T(0.21), Br = T(4), Cr = T(1.4), Dr = T(0.19);
    T Cm1 = T(0.287), Cm2 = T(0.0545), Cb = T(0), Cr0 = T(0), Cd = T(0);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    using gripline::param;
    return std::tuple{
        param("m", &P::m, "kg", {1e-6, 1e6}, "mass"),
        param("Iz", &P::Iz, "kg m2", {1e-12, 1e9}, "yaw inertia"),
        param("lf", &P::lf, "m", {1e-4, 100}, "centre of gravity to front axle"),
        param("lr", &P::lr, "m", {1e-4, 100}, "centre of gravity to rear axle"),
        param("Bf", &P::Bf, "1/rad", {0, 1e3}, "front stiffness factor"),
        param("Cf", &P::Cf, "1", {0, 10}, "front shape factor"),
        param("Df", &P::Df, "N", {0, 1e7}, "front peak lateral force"),
        param("Br", &P::Br, "1/rad", {0, 1e3}, "rear stiffness factor"),
        param("Cr", &P::Cr, "1", {0, 10}, "rear shape factor"),
        param("Dr", &P::Dr, "N", {0, 1e7}, "rear peak lateral force"),
        param("Cm1", &P::Cm1, "N", {0, 1e7}, "drive force at standstill and full throttle"),
        param("Cm2", &P::Cm2, "N s/m", {0, 1e6}, "loss of drive force with speed"),
        param("Cb", &P::Cb, "N", {0, 1e7}, "brake force at d = -1; 0: the motor brakes, (Cm1 - Cm2 vx) d"),
        param("Cr0", &P::Cr0, "N", {0, 1e6}, "rolling resistance"),
        param("Cd", &P::Cd, "N s2/m2", {0, 1e5}, "drag: force over speed squared")};
  }

  template <class T>
  void drive(Point<T>& p, const Params<T>& k) const {
    p.q.motor = k.Cm1;
    p.q.emf = k.Cm2;
    // A motor that brakes is a brake: effects on the drive find its force made, those on brakes change it.
    p.q.brake = k.Cb > T(0) ? k.Cb : gripline::vehicle::motor_brake(k.Cm1, k.Cm2, p.q.vx);
    p.q.rolling = k.Cr0;
    p.q.drag = k.Cd;
  }

  template <class T>
  void load(Point<T>& p, const Params<T>& k) const {
    p.q.drive_force = gripline::vehicle::drive_force(p.q, k.m, p.at.grade);
    p.q.m = k.m;
    p.q.Iz = k.Iz;
    p.q.lf = k.lf;
    p.q.lr = k.lr;
    p.q.load_front = p.q.load_rear = gripline::vehicle::slope_load(p.at, p.q.vx);
  }

  template <class T>
  void tyre(Point<T>& p, const Params<T>& k) const {
    auto& q = p.q;
    gripline::vehicle::fill_slips(q);
    q.peak_front = k.Df * q.load_front;
    q.peak_rear = k.Dr * q.load_rear;
    q.stiff_front = k.Bf;
    q.stiff_rear = k.Br;
  }

  template <class T>
  void force(Point<T>& p, const Params<T>& k) const {
    auto& q = p.q;
    q.force_front = q.peak_front * sin(k.Cf * atan(q.stiff_front * q.slip_front));
    q.force_rear = q.peak_rear * sin(k.Cr * atan(q.stiff_rear * q.slip_rear));
  }

  template <class T>
  void body(Point<T>& p, const Params<T>&) const {
    auto& q = p.q;
    const auto [sine, cosine] = gripline::sine_cosine(q.delta);
    // Brakes hold the mass that there is, which effects may have changed.
    if (q.d < T(0)) q.drive_force = gripline::vehicle::drive_force(q, q.m, p.at.grade);
    const T resistance = gripline::vehicle::resistance(q);
    q.ax = (q.drive_force - resistance - q.force_front * sine) / q.m + q.vy * q.omega;
    q.ay = (q.force_rear + q.force_front * cosine) / q.m - q.vx * q.omega;
    q.aw = (q.force_front * q.lf * cosine - q.force_rear * q.lr) / q.Iz;
    q.grade = T(p.at.grade);
    q.bank = T(p.at.bank);
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<Dynamic>("dynamic", "1.0", "single-track car with Pacejka axles, grade and bank"))
