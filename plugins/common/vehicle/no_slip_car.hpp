// What the car models without tyres share: parameters, drive train, inertia.
//
//   Fd = (Cm1 - Cm2 vx) d,  for d < 0 with Cb > 0 instead Cb d;   Fres = Cr0 + Cd vx^2
//
// or, where an engine's map was measured (v_1 above 0.1 m/s), between closed(vx) without and full(vx) at full throttle,
//
//   Fd = (full(vx) - closed(vx)) d,   Fres = Cr0 + Cd vx^2 - closed(vx)
//
// both linear between the six speeds 0, v_1 ... v_5 and level beyond. Gears show as steps between two of the speeds;
// which gear is engaged inside such a step is not known. Of a car that stands or rolls backwards Fd and Fres are those
// of standstill.hpp: brakes and resistance oppose the motion and hold.
//
// The paper's e-kinematic model leaves resistance out (it is learned), so Cr0 and Cd default to 0; the parameters exist
// for stacks that are given them. yaw_gain = 1 is the formula; the published code multiplies the yaw acceleration by L
// where it should divide, which is yaw_gain = L^2: the observed yaw rate then holds over the horizon. Near the limit a
// car turns far less than one without slip, and a controller on the formula oscillates between the edges
// (framework/doc/models.md). Without slip a bank moves no car sideways: no model here has a term for it. A grade
// changes vx alone: side speed and yaw rate of a steered car that drives forward do not follow it.
#pragma once

#include <array>

#include <gripline/plugin.hpp>

#include "common/vehicle/standstill.hpp"

namespace gripline {

template <class T>
struct NoSlipParams {
  T m = T(0.041), Iz = T(27.8e-6), lf = T(0.029), lr = T(0.033);
  T Cm1 = T(0.287), Cm2 = T(0.0545), Cb = T(0), Cr0 = T(0), Cd = T(0), yaw_gain = T(1);
  std::array<T, 5> v = {};                  // speeds of the engine's map above 0, v_1 first [m/s]
  std::array<T, 6> full = {}, closed = {};  // its forces at rest and at those speeds [N]
};

inline constexpr double least_map_speed = 0.1;  // [m/s]

/// Declarations of the engine's map.
constexpr auto drive_map_parameters() {
  using P = NoSlipParams<double>;
  return std::tuple{param({"v_1", "v_2", "v_3", "v_4", "v_5"}, &P::v, "m/s", {0, 1e3},
                          "speeds of the engine's map, rising; v_1 = 0: no map, Cm1 and Cm2 hold"),
                    param({"full_0", "full_1", "full_2", "full_3", "full_4", "full_5"}, &P::full, "N", {0, 1e7},
                          "drive force at full throttle: at rest, at v_1 to v_4, from v_5 on"),
                    param({"closed_0", "closed_1", "closed_2", "closed_3", "closed_4", "closed_5"}, &P::closed, "N",
                          {-1e7, 0}, "force at closed throttle at the same speeds: the engine brakes")};
}

/// Where between the speeds of the map a speed lies.
template <class T>
struct MapPlace {
  std::size_t lower;
  T share;
  T of(const std::array<T, 6>& values) const { return values[lower] + (values[lower + 1] - values[lower]) * share; }
};
template <class T>
MapPlace<T> map_place(const T& vx, const NoSlipParams<T>& k) {
  T from(0);
  for (std::size_t i = 0; i < 5; ++i) {
    const T& to = k.v[i];
    if (vx < to && vx > from) return {i, (vx - from) / (to - from)};
    if (!(vx > from)) return {i, T(0)};
    from = to;
  }
  return {4, T(1)};
}

/// Base of a model with the stages command, drive, load and body. D supplies
/// `motion(Quantities<T>&, const T& drive_rate)`, which fills ax, ay, aw from drive_rate = (Fd - Fres) / m.
template <class D>
class NoSlipCar : public AutoDiffVehicle<D> {
 public:
  template <class T>
  using Params = NoSlipParams<T>;

  static constexpr auto parameters() {
    using P = NoSlipParams<double>;
    return std::tuple_cat(
        std::tuple{
            param("m", &P::m, "kg", {1e-6, 1e6}, "mass"), param("Iz", &P::Iz, "kg m2", {1e-12, 1e9}, "yaw inertia"),
            param("lf", &P::lf, "m", {1e-4, 100}, "centre of gravity to front axle"),
            param("lr", &P::lr, "m", {1e-4, 100}, "centre of gravity to rear axle"),
            param("Cm1", &P::Cm1, "N", {0, 1e7}, "drive force at standstill and full throttle"),
            param("Cm2", &P::Cm2, "N s/m", {0, 1e6}, "loss of drive force with speed"),
            param("Cb", &P::Cb, "N", {0, 1e7}, "brake force at d = -1; 0: the motor brakes, (Cm1 - Cm2 vx) d"),
            param("Cr0", &P::Cr0, "N", {0, 1e6}, "rolling resistance; the paper's e-kinematic model has none"),
            param("Cd", &P::Cd, "N s2/m2", {0, 1e5}, "drag: force over speed squared; none in the paper"),
            param("yaw_gain", &P::yaw_gain, "1", {0, 10},
                  "factor on the yaw acceleration; 1 is the formula, L^2 (0.003844 for the 1:43 car) the published "
                  "code")},
        drive_map_parameters());
  }

  template <class T>
  void drive(Point<T>& p, const NoSlipParams<T>& k) const {
    p.q.motor = k.Cm1;
    p.q.emf = k.Cm2;
    // A motor that brakes is a brake: effects on the drive find its force made, those on brakes change it.
    p.q.brake = k.Cb > T(0) ? k.Cb : vehicle::motor_brake(k.Cm1, k.Cm2, p.q.vx);
    p.q.rolling = k.Cr0;
    p.q.drag = k.Cd;
    if (!(k.v[0] > T(least_map_speed))) return;
    const MapPlace<T> place = map_place(p.q.vx, k);
    const T closed = place.of(k.closed);
    p.q.motor = place.of(k.full) - closed;
    p.q.emf = T(0);
    p.q.rolling -= closed;
  }

  template <class T>
  void load(Point<T>& p, const NoSlipParams<T>& k) const {
    p.q.drive_force = vehicle::drive_force(p.q, k.m, p.at.grade);
    p.q.m = k.m;
    p.q.Iz = k.Iz;
    p.q.lf = k.lf;
    p.q.lr = k.lr;
    p.q.load_front = T(1);
    p.q.load_rear = T(1);
  }

  template <class T>
  void body(Point<T>& p, const NoSlipParams<T>& k) const {
    auto& q = p.q;
    // Brakes hold the mass that there is, which effects may have changed.
    if (q.d < T(0)) q.drive_force = vehicle::drive_force(q, q.m, p.at.grade);
    if (q.vx < T(vehicle::crawl_speed)) return stand(p, k);
    const T drive_rate = (q.drive_force - q.rolling - q.drag * square(q.vx)) / q.m;
    static_cast<const D&>(*this).motion(q, drive_rate);
    q.aw *= k.yaw_gain;
    q.grade = T(p.at.grade);
    q.bank = T(0);
  }

 private:
  /// body() of a car that stands or rolls backwards. The slope counts among what moves it, the less the faster it goes
  /// forwards: a steered car that brakes hold on a slope must not turn by the force that holds it. Not inline: GCC 12
  /// fuses products with sums where it vectorises both calls of `motion`, whatever -ffp-contract says, and the car that
  /// drives forward would differ in the last digit.
  template <class T>
  [[gnu::noinline]] void stand(Point<T>& p, const NoSlipParams<T>& k) const {
    auto& q = p.q;
    const T share = q.vx > T(0) ? T(1) - vehicle::direction(q.vx) : T(1);
    const T slope = share * (gravity * std::sin(p.at.grade));
    static_cast<const D&>(*this).motion(q, (q.drive_force - vehicle::resistance(q)) / q.m - slope);
    q.ax += slope;  // the host subtracts it for every model
    q.aw *= k.yaw_gain;
    q.grade = T(p.at.grade);
    q.bank = T(0);
  }
};

}  // namespace gripline
