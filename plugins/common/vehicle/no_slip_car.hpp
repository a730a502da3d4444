// What the car models without tyres share: parameters, drive train, inertia.
//
//   Fd = (Cm1 - Cm2 vx) d,  for d < 0 with Cb > 0 instead Cb d;   Fres = Cr0 + Cd vx^2
//
// or, where an engine's map was measured (v_1 above 0.1 m/s): between closed(vx) at closed and full(vx) at full throttle,
//
//   Fd = (full(vx) - closed(vx)) d,   Fres = Cr0 + Cd vx^2 - closed(vx)
//
// both linear between the six speeds 0, v_1 ... v_5 and level beyond. Gears show as steps between two of the speeds;
// which gear is engaged inside such a step is not known.
//
// The paper's e-kinematic model leaves resistance out (it is learned), so Cr0 and Cd default to 0; the parameters exist
// for whoever knows them. yaw_gain = 1 is the formula; the published code multiplies the yaw acceleration by L where it
// should divide, which is yaw_gain = L^2: the observed yaw rate then holds over the horizon. That slip matters: near the
// limit a car turns far less than a rolling one, and a controller that believes the formula swings from edge to edge
// (framework/doc/models.md). Tyres that do not slip hold the car on a bank: no model here is pulled sideways by one.
#pragma once

#include <array>

#include <gripline/plugin.hpp>

namespace gripline {

template <class T>
struct NoSlipParams {
  T m = T(0.041), Iz = T(27.8e-6), lf = T(0.029), lr = T(0.033);
  T Cm1 = T(0.287), Cm2 = T(0.0545), Cb = T(0), Cr0 = T(0), Cd = T(0), yaw_gain = T(1);
  T v_1 = T(0), v_2 = T(0), v_3 = T(0), v_4 = T(0), v_5 = T(0);
  T full_0 = T(0), full_1 = T(0), full_2 = T(0), full_3 = T(0), full_4 = T(0), full_5 = T(0);
  T closed_0 = T(0), closed_1 = T(0), closed_2 = T(0), closed_3 = T(0), closed_4 = T(0), closed_5 = T(0);
};

inline constexpr double least_map_speed = 0.1;  // [m/s]

/// Declarations of the engine's map.
constexpr auto drive_map_parameters() {
  using P = NoSlipParams<double>;
  constexpr auto speed = [](const char* name, double P::*member, const char* doc) {
    return param(name, member, "m/s", {0, 1e3}, doc);
  };
  constexpr auto full = [](const char* name, double P::*member, const char* doc) {
    return param(name, member, "N", {0, 1e7}, doc);
  };
  constexpr auto closed = [](const char* name, double P::*member, const char* doc) {
    return param(name, member, "N", {-1e7, 0}, doc);
  };
  return std::tuple{speed("v_1", &P::v_1, "first speed of the engine's map; 0: no map, Cm1 and Cm2 hold"),
                    speed("v_2", &P::v_2, "second speed of the map, above v_1"),
                    speed("v_3", &P::v_3, "third speed of the map, above v_2"),
                    speed("v_4", &P::v_4, "fourth speed of the map, above v_3"),
                    speed("v_5", &P::v_5, "fifth speed of the map, above v_4"),
                    full("full_0", &P::full_0, "drive force at full throttle at rest"),
                    full("full_1", &P::full_1, "the same at v_1"),
                    full("full_2", &P::full_2, "the same at v_2"),
                    full("full_3", &P::full_3, "the same at v_3"),
                    full("full_4", &P::full_4, "the same at v_4"),
                    full("full_5", &P::full_5, "the same from v_5 on"),
                    closed("closed_0", &P::closed_0, "force at closed throttle at rest: the engine brakes"),
                    closed("closed_1", &P::closed_1, "the same at v_1"),
                    closed("closed_2", &P::closed_2, "the same at v_2"),
                    closed("closed_3", &P::closed_3, "the same at v_3"),
                    closed("closed_4", &P::closed_4, "the same at v_4"),
                    closed("closed_5", &P::closed_5, "the same from v_5 on")};
}

/// Where between the speeds of the map a speed lies.
template <class T>
struct MapPlace {
  std::size_t lower;
  T share;
  T of(const std::array<const T*, 6>& values) const {
    return *values[lower] + (*values[lower + 1] - *values[lower]) * share;
  }
};
template <class T>
MapPlace<T> map_place(const T& vx, const NoSlipParams<T>& k) {
  const T* const above[] = {&k.v_1, &k.v_2, &k.v_3, &k.v_4, &k.v_5};
  T from(0);
  for (std::size_t i = 0; i < 5; ++i) {
    const T& to = *above[i];
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
            param("Cm1", &P::Cm1, "N", {0, 1e7}, "drive force at standstill and full throttle").fit(0.287, 0.287, 0.1),
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
    p.q.brake = k.Cb > T(0) ? k.Cb : k.Cm1 - k.Cm2 * p.q.vx;
    p.q.rolling = k.Cr0;
    p.q.drag = k.Cd;
    if (!(k.v_1 > T(least_map_speed))) return;
    const MapPlace<T> place = map_place(p.q.vx, k);
    const T closed = place.of({&k.closed_0, &k.closed_1, &k.closed_2, &k.closed_3, &k.closed_4, &k.closed_5});
    p.q.motor = place.of({&k.full_0, &k.full_1, &k.full_2, &k.full_3, &k.full_4, &k.full_5}) - closed;
    p.q.emf = T(0);
    p.q.rolling -= closed;
  }

  template <class T>
  void load(Point<T>& p, const NoSlipParams<T>& k) const {
    p.q.drive_force = gripline::drive_force(p.q);
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
    const T drive_rate = (q.drive_force - q.rolling - q.drag * square(q.vx)) / q.m;
    static_cast<const D&>(*this).motion(q, drive_rate);
    q.aw *= k.yaw_gain;
    q.grade = T(p.at.grade);
    q.bank = T(0);
  }
};

}  // namespace gripline
