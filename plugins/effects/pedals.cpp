// What real cars have between a command in a log and a force or an angle.
//
// Stage::command
//   throttle_delay      d(t) = d_cmd(t - T)
//   steer_delay         delta(t) = delta_cmd(t - T)
//   throttle_dead_zone  d = max(d_in - z, 0) / (1 - z) for d_in > 0; brakes (d_in < 0) unchanged
//   throttle_curve      d = d_in^p for d_in > 0
//   steer_map           delta = g delta_in + a delta_in^2 + c delta_in^3
//   steer_rate_limit    delta' = R tanh((delta_in - delta) / (tau R)): a servo that follows small moves with the lag
//                       tau and turns at most at R (data sheets: seconds per 60 degrees; the bound on steering velocity
//                       of Althoff and Wuersching, CommonRoad: Vehicle Models, 2020)
// Stage::drive
//   power_limit         M = motor - emf vx becomes M / (1 + (M vx / P)^4)^(1/4): at most P / vx at full throttle
// Stage::body
//   cornering_drag      vx' -= k (vx omega)^2 sign(vx): tyres that corner take speed beyond what the steered axle does
//   turning_drag        vx' -= k |omega| sign(vx), rising from 0 at rest to its full size at 0.02 m/s: wheels that a
//                       common axle turns alike scrub where paths differ
//
// Delays come first, then dead zone and curve or map, then the servo. The exponent 4 of power_limit is a choice: it
// keeps the corner within 16 % of the two straight laws, and differentiable.
#include <gripline/plugin.hpp>

#include "common/vehicle/standstill.hpp"

namespace {

using gripline::max;
using gripline::param;
using gripline::Point;
using gripline::sqrt;
using gripline::square;
using gripline::Stage;
using gripline::tanh;
using std::max;
using std::sqrt;
using std::tanh;

template <class T>
struct Late {
  T delay = T(0);
};

template <class D>
class OneDelay : public gripline::AutoDiffEffect<D> {
 public:
  template <class T>
  using Params = Late<T>;
  static constexpr auto parameters() { return std::tuple{param("T", &Late<double>::delay, "s", {0, 1}, "delay")}; }
  Stage stage() const noexcept override { return Stage::command; }
  double look_back(std::span<const double> params) const noexcept override { return params[0]; }
};

class ThrottleDelay final : public OneDelay<ThrottleDelay> {
 public:
  template <class T>
  void act(Point<T>& p, const Late<T>& k) const {
    if (p.history == nullptr) return;
    p.q.d = p.history->at(k.delay).d;
  }
};

class SteerDelay final : public OneDelay<SteerDelay> {
 public:
  template <class T>
  void act(Point<T>& p, const Late<T>& k) const {
    if (p.history == nullptr) return;
    const auto then = p.history->at(k.delay);
    p.q.delta = then.delta;
    p.q.delta_rate = then.delta_rate;
  }
};

class ThrottleDeadZone final : public gripline::AutoDiffEffect<ThrottleDeadZone> {
 public:
  template <class T>
  struct Params {
    T z = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("z", &Params<double>::z, "1", {0, 0.9}, "width of the dead zone")};
  }
  Stage stage() const noexcept override { return Stage::command; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    if (p.q.d > T(0)) p.q.d = max(T(0), p.q.d - k.z) / (T(1) - k.z);
  }
};

class ThrottleCurve final : public gripline::AutoDiffEffect<ThrottleCurve> {
 public:
  template <class T>
  struct Params {
    T p = T(1);
  };
  static constexpr auto parameters() {
    return std::tuple{param("p", &Params<double>::p, "1", {0.2, 4}, "exponent of the pedal")};
  }
  Stage stage() const noexcept override { return Stage::command; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    using gripline::exp;
    using gripline::log;
    using std::exp;
    using std::log;
    constexpr double closed = 1e-6;
    if (p.q.d > T(closed)) p.q.d = exp(k.p * log(p.q.d));
  }
};

class SteerMap final : public gripline::AutoDiffEffect<SteerMap> {
 public:
  template <class T>
  struct Params {
    T g = T(1), a = T(0), c = T(0);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("g", &P::g, "1", {0.02, 20}, "wheel angle per command, straight ahead"),
                      param("a", &P::a, "1/rad", {-10, 10}, "asymmetry between left and right"),
                      param("c", &P::c, "1/rad2", {-50, 50}, "progression towards full lock")};
  }
  Stage stage() const noexcept override { return Stage::command; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T in = p.q.delta;
    p.q.delta = in * (k.g + in * (k.a + in * k.c));
    p.q.delta_rate *= k.g + in * (k.a * 2.0 + in * k.c * 3.0);
  }
};

class SteerRateLimit final : public gripline::AutoDiffEffect<SteerRateLimit> {
 public:
  template <class T>
  struct Params {
    T R = T(6), tau = T(0.02);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("R", &P::R, "rad/s", {0.01, 1000}, "largest rate of the wheels' angle"),
                      param("tau", &P::tau, "s", {0.002, 5}, "time constant of small moves")};
  }
  Stage stage() const noexcept override { return Stage::command; }
  int memory() const noexcept override { return 1; }
  void initial(const Point<double>& p, const Params<double>&, std::span<double> memory) const { memory[0] = p.q.delta; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T rate = k.R * tanh((p.q.delta - p.memory[0]) / (k.tau * k.R));
    p.memory_rate[0] = rate;
    p.q.delta = p.memory[0];
    p.q.delta_rate = rate;
  }
};

class PowerLimit final : public gripline::AutoDiffEffect<PowerLimit> {
 public:
  template <class T>
  struct Params {
    T P = T(1e6);
  };
  static constexpr auto parameters() {
    return std::tuple{param("P", &Params<double>::P, "W", {1e-3, 1e8}, "most power at the wheels, full throttle")};
  }
  Stage stage() const noexcept override { return Stage::drive; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T most = p.q.motor - p.q.emf * p.q.vx;
    if (!(most > T(0)) || !(p.q.vx > T(0))) return;
    const T fourth = square(square(most * p.q.vx / k.P));
    p.q.motor = most / sqrt(sqrt(T(1) + fourth));
    p.q.emf = T(0);
  }
};

class CorneringDrag final : public gripline::AutoDiffEffect<CorneringDrag> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "s2/m", {-1, 1}, "deceleration over lateral acceleration squared")};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T drag = k.k * square(p.q.vx * p.q.omega);
    p.q.ax -= p.q.vx < T(0) ? -drag : drag;
  }
};

class TurningDrag final : public gripline::AutoDiffEffect<TurningDrag> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "m/s", {-10, 10}, "deceleration over yaw rate")};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T drag = p.q.omega > T(0) ? k.k * p.q.omega : k.k * -p.q.omega;
    p.q.ax -= drag * gripline::vehicle::direction(p.q.vx);
  }
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<ThrottleDelay>("throttle_delay", "1.0", "delay of the throttle").precedence(12),
    gripline::describe<SteerDelay>("steer_delay", "1.0", "delay of the steering").precedence(13),
    gripline::describe<ThrottleDeadZone>("throttle_dead_zone", "1.0", "dead zone of the throttle").precedence(15),
    gripline::describe<ThrottleCurve>("throttle_curve", "1.0", "nonlinear throttle map: a power law").precedence(16),
    gripline::describe<SteerMap>("steer_map", "1.0", "nonlinear steering map: a cubic").precedence(17),
    gripline::describe<SteerRateLimit>("steer_rate_limit", "1.0", "rate limit and lag of the steering actuator")
        .precedence(22),
    gripline::describe<PowerLimit>("power_limit", "1.0", "power limit of the drive").precedence(30),
    gripline::describe<CorneringDrag>("cornering_drag", "1.0", "drag that grows with lateral acceleration squared")
        .precedence(18),
    gripline::describe<TurningDrag>("turning_drag", "1.0", "drag that grows with the yaw rate").precedence(19))
