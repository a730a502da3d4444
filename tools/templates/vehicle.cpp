// A single-track car whose tyres give a force in proportion to slip, up to their peak: change it to yours.
#include <gripline/equation.hpp>
#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>

namespace {

class NewPlugin final : public gripline::AutoDiffVehicle<NewPlugin> {
 public:
  template <class T>
  struct Params {  // filled by position: in the order of parameters()
    T m = T(0.041), Iz = T(27.8e-6), lf = T(0.029), lr = T(0.033), Cm1 = T(0.287), Cm2 = T(0.0545), mu = T(0.8),
      C = T(5);
  };
  static constexpr auto parameters() {  // key, member, unit, range, one sentence; a car's file gives those it knows
    using P = Params<double>;
    return std::tuple{gripline::param("m", &P::m, "kg", {1e-6, 1e6}, "mass"),
                      gripline::param("Iz", &P::Iz, "kg m2", {1e-12, 1e9}, "yaw inertia"),
                      gripline::param("lf", &P::lf, "m", {1e-4, 100}, "front axle to centre of gravity"),
                      gripline::param("lr", &P::lr, "m", {1e-4, 100}, "rear axle to centre of gravity"),
                      gripline::param("Cm1", &P::Cm1, "N", {0, 1e7}, "drive force at rest and full throttle"),
                      gripline::param("Cm2", &P::Cm2, "N s/m", {0, 1e6}, "loss of drive force with speed"),
                      gripline::param("mu", &P::mu, "1", {0.01, 5}, "peak lateral force over load"),
                      gripline::param("C", &P::C, "1/rad", {0.1, 1e3}, "stiffness over peak force")};
  }
  explicit NewPlugin(const gripline::PluginContext& context) : v_min_(gripline::max(0.3, context.car.v_min)) {}

  template <class T>  // stage by stage, so that effects can act in between: drive, load, tyre, force, body
  void load(gripline::Point<T>& p, const Params<T>& k) const {
    const T motor = (k.Cm1 - k.Cm2 * p.q.vx) * p.q.d;
    p.q.drive_force = p.q.d < T(0) ? along(p.q.vx) * motor : motor;  // brakes oppose the motion
    p.q.m = k.m, p.q.Iz = k.Iz, p.q.lf = k.lf, p.q.lr = k.lr, p.q.load_front = p.q.load_rear = T(1);
  }
  template <class T>
  void body(gripline::Point<T>& p, const Params<T>& k) const {
    using std::abs, std::cos, std::sin, std::tanh, gripline::max;  // found for T that carries derivatives too
    auto& q = p.q;
    const T forward = max(abs(q.vx), T(v_min_));  // held below: derivatives stay finite at standstill
    const T grip = k.mu * gripline::gravity * q.m / (q.lf + q.lr);
    const T front = grip * q.lr * tanh(k.C * gripline::front_slip(forward, q.vy, q.omega, along(q.vx) * q.delta, q.lf));
    const T rear = grip * q.lf * tanh(k.C * gripline::rear_slip(forward, q.vy, q.omega, q.lr));
    q.ax = (q.drive_force - front * sin(q.delta)) / q.m + q.vy * q.omega;
    q.ay = (rear + front * cos(q.delta)) / q.m - q.vx * q.omega;
    q.aw = (q.lf * front * cos(q.delta) - q.lr * rear) / q.Iz;
    q.grade = T(p.at.grade), q.bank = T(p.at.bank);
  }

 private:
  /// From -1 backwards to 1 forwards; between them, at rest, neither brakes nor turned wheels push.
  static auto along(const auto& vx) { return gripline::clamp_value(10.0 * vx, -1.0, 1.0); }
  double v_min_;
};

}  // namespace

GRIPLINE_EQUATIONS({"new_plugin",
                    "vx' = (Fd - Ff sin(delta)) / m + vy omega; vy' = (Fr + Ff cos(delta)) / m - vx omega; "
                    "omega' = (lf Ff cos(delta) - lr Fr) / Iz; F = mu tanh(C slip) load"})
GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "single-track car, tyres that saturate"))
