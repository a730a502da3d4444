// Effects of Stage::body: accelerations and slopes (framework/doc/effects.md; u = vx / v_ref, L = lf + lr).
//
//   aero_drag     vx' -= a u |u|
//   rolling_res   vx' -= a sign(vx), rising from 0 at rest to its full size at 0.02 m/s
//   diff_yaw      omega' -= k omega
//   torque_vec    omega' += k (Fd / m) / L (delta / 0.2 rad)
//   wind          rx = vx - (wx cos yaw + wy sin yaw),  ry = vy - (-wx sin yaw + wy cos yaw);
//                 vx' -= Cd (rx |rx| - vx |vx|) / m,  vy' -= 2.5 Cd (ry hypot(rx, ry) - vy hypot(vx, vy)) / m
//   plane_tilt    grade += tx cos yaw + ty sin yaw,  bank += tx sin yaw - ty cos yaw
//   yaw_response  omega* = w / sqrt(1 + (w vx / (mu g))^2),  w = vx delta / L;
//                 omega' = (omega* - omega) / tau,  vy' = (lr omega* - vy) / tau: in place of the model's own
//   grade, bank   slope += direction sum_i c_i B(10 f - i), i = 0..9 periodic, f the lap fraction, B the
//                 cubic B-spline; grade leaves out the mean of its c_i: a closed lap comes back to its height
#include <gripline/plugin.hpp>

#include "common/vehicle/standstill.hpp"

namespace {

using gripline::hypot;
using gripline::param;
using gripline::Point;
using gripline::square;
using gripline::Stage;
using std::abs;
using std::hypot;

template <class T>
struct Strength {
  T a = T(0);
};
template <class T>
struct Factor {
  T k = T(0);
};

class AeroDrag final : public gripline::AutoDiffEffect<AeroDrag> {
 public:
  template <class T>
  using Params = Strength<T>;
  static constexpr auto parameters() {
    return std::tuple{param("a", &Params<double>::a, "m/s2", {-50, 50}, "deceleration at v_ref").fit(0, 0.05, 0.1)};
  }
  explicit AeroDrag(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T u = p.q.vx / v_ref_;
    p.q.ax -= k.a * (u * abs(u));
  }

 private:
  double v_ref_;
};

class RollingRes final : public gripline::AutoDiffEffect<RollingRes> {
 public:
  template <class T>
  using Params = Strength<T>;
  static constexpr auto parameters() {
    return std::tuple{param("a", &Params<double>::a, "m/s2", {-50, 50}, "deceleration").fit(0, 0.05, 0.1)};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    // Against the motion, and nothing at rest: rest stays at rest.
    p.q.ax -= k.a * gripline::vehicle::direction(p.q.vx);
  }
};

class DiffYaw final : public gripline::AutoDiffEffect<DiffYaw> {
 public:
  template <class T>
  using Params = Factor<T>;
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1/s", {-50, 200}, "damping of the yaw rate").fit(0, 0.1, 0.3)};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.aw -= k.k * p.q.omega;
  }
};

class TorqueVec final : public gripline::AutoDiffEffect<TorqueVec> {
 public:
  template <class T>
  using Params = Factor<T>;
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-20, 20}, "yaw moment from drive force while steering").fit(0, 0.1, 0.2)};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.aw += k.k * (p.q.drive_force / p.q.m) / (p.q.lf + p.q.lr) * (p.q.delta / 0.2);
  }
};

class Wind final : public gripline::AutoDiffEffect<Wind> {
 public:
  template <class T>
  struct Params {
    T wx = T(0), wy = T(0);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("wx", &P::wx, "m/s", {-80, 80}, "wind towards +x").fit(0, 2, 4),
                      param("wy", &P::wy, "m/s", {-80, 80}, "wind towards +y").fit(0, 2, 4)};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const auto [sine, cosine] = gripline::sine_cosine(p.q.yaw);
    const T rx = p.q.vx - (k.wx * cosine + k.wy * sine);
    const T ry = p.q.vy - (k.wy * cosine - k.wx * sine);
    p.q.ax -= p.q.drag * (rx * abs(rx) - p.q.vx * abs(p.q.vx)) / p.q.m;
    p.q.ay -= p.q.drag * 2.5 * (ry * hypot(rx, ry) - p.q.vy * hypot(p.q.vx, p.q.vy)) / p.q.m;
  }
};

class PlaneTilt final : public gripline::AutoDiffEffect<PlaneTilt> {
 public:
  template <class T>
  struct Params {
    T tx = T(0), ty = T(0);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("tx", &P::tx, "rad", {-0.5, 0.5}, "rise of the ground towards +x").fit(0, 0.005, 0.01),
                      param("ty", &P::ty, "rad", {-0.5, 0.5}, "rise of the ground towards +y").fit(0, 0.005, 0.01)};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const auto [sine, cosine] = gripline::sine_cosine(p.q.yaw);
    p.q.grade += k.tx * cosine + k.ty * sine;
    p.q.bank += k.tx * sine - k.ty * cosine;
  }
};

/// Ten coefficients of a periodic slope profile over the lap.
template <class D>
class LapSlope : public gripline::AutoDiffEffect<D> {
 public:
  template <class T>
  struct Params {
    std::array<T, 10> c = {};
  };
  static constexpr auto parameters() {
    return std::tuple{param({"c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8", "c9"}, &Params<double>::c, "rad",
                            {-0.5, 0.5}, "slope near that tenth of the lap")
                          .fit(0, 0.005, 0.01)};
  }
  Stage stage() const noexcept override { return Stage::body; }

 protected:
  /// sum_i c_i B(10 f - i) with B as the mean-free or plain spline.
  template <class T>
  static T slope(double f, const Params<T>& k, bool mean_free) {
    T sum(0);
    const double mean = mean_free ? 0.1 : 0.0;  // the ten B sum to 1 everywhere
    for (int i = 0; i < 10; ++i) sum += k.c[static_cast<std::size_t>(i)] * (basis(10.0 * f - i) - mean);
    return sum;
  }

 private:
  static double basis(double x) {
    const double z = std::abs(x - 10.0 * std::round(x / 10.0));
    if (z < 1.0) return (4.0 - 6.0 * z * z + 3.0 * z * z * z) / 6.0;
    if (z < 2.0) return (2.0 - z) * (2.0 - z) * (2.0 - z) / 6.0;
    return 0.0;
  }
};

class Grade final : public LapSlope<Grade> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.grade += slope(p.at.lap_fraction, k, true) * p.at.direction;
  }
};

class Bank final : public LapSlope<Bank> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.bank += slope(p.at.lap_fraction, k, false) * p.at.direction;
  }
};

/// For cars without slip, which turn by any steering angle at any speed, and at once.
class YawResponse final : public gripline::AutoDiffEffect<YawResponse> {
 public:
  template <class T>
  struct Params {
    T tau = T(0.12), mu = T(1);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("tau", &P::tau, "s", {0.01, 5}, "time constant of the yaw rate"),
                      param("mu", &P::mu, "1", {0.05, 5}, "friction that bounds lateral acceleration")};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    using std::sqrt;
    auto& q = p.q;
    const T no_slip = q.vx * q.delta / (q.lf + q.lr);
    const T omega = no_slip / sqrt(1.0 + square(no_slip * q.vx / (k.mu * gripline::gravity)));
    q.aw = (omega - q.omega) / k.tau;
    q.ay = (q.lr * omega - q.vy) / k.tau;
  }
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<AeroDrag>("aero_drag", "1.0", "drag that grows with speed squared")
        .advice("coast down from top speed to half of it on a level straight; "
                "drive the same lap in the other direction, and coast down once; "
                "full throttle from a quarter of top speed to top speed")
        .precedence(10),
    gripline::describe<RollingRes>("rolling_res", "1.0", "rolling resistance: a constant deceleration")
        .advice("coast down from top speed to half of it on a level straight; "
                "drive the same lap in the other direction, and coast down once")
        .precedence(11),
    gripline::describe<DiffYaw>("diff_yaw", "1.0", "yaw damping, as of a locked differential")
        .advice("power on and lift off in a steady corner, then brake in a turn")
        .precedence(12),
    gripline::describe<TorqueVec>("torque_vec", "1.0", "torque vectoring: a yaw moment from drive force and steering")
        .advice("power on and lift off in a steady corner, then brake in a turn")
        .precedence(13),
    gripline::describe<Wind>("wind", "1.0", "steady wind")
        .advice("drive the same lap in the other direction")
        .precedence(14),
    gripline::describe<PlaneTilt>("plane_tilt", "1.0", "constant tilt of the ground plane")
        .advice("drive the same lap in the other direction")
        .precedence(15),
    gripline::describe<Grade>("grade", "1.0", "slope along the lap")
        .advice("drive the same lap in the other direction, and coast down once; "
                "drive the same lap in the other direction; "
                "the same place at two speeds, for three laps or more")
        .precedence(16),
    gripline::describe<Bank>("bank", "1.0", "slope across the lap")
        .advice("drive the same lap in the other direction; "
                "the same place at two speeds, for three laps or more")
        .precedence(17),
    gripline::describe<YawResponse>("yaw_response", "1.0",
                                    "a car without slip turns with a delay, and no more than its tyres bear"))
