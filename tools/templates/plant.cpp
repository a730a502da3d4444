// A single-track car that a world may drive: change it to yours. Plants alone are given the friction of the road.
#include <algorithm>
#include <cmath>

#include <gripline/equation.hpp>
#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>

namespace {
using gripline::Axle, gripline::param, gripline::State;

class NewPlugin final : public gripline::Plant {
 public:
  struct Params {
    double mu = 0.9, C = 5, k_d = 6, k_r = 2;  // the initializers are the defaults
  };
  static constexpr auto parameters() {  // JSON key, member, unit, range, one sentence
    return std::tuple{param("mu", &Params::mu, "1", {0.01, 5}, "peak lateral force over load at factor 1"),
                      param("C", &Params::C, "1/rad", {0.1, 100}, "stiffness over peak force"),
                      param("k_d", &Params::k_d, "m/s2", {0, 100}, "acceleration at full throttle"),
                      param("k_r", &Params::k_r, "1/s", {0, 100}, "resistance over speed")};
  }
  NewPlugin(const gripline::PluginContext& context, const Params& params) : car_(context.car), k_(params) {}
  void reset(const State& x, const gripline::Ground& /*ground*/) override { x_ = x, front_ = rear_ = 0; }
  State advance(double d, double delta, double dt, const gripline::Ground& ground) override {
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / 1e-3)));  // of 1 ms: stable at rest too
    const double h = dt / steps, g = gripline::gravity, lf = car_.lf, lr = car_.lr;
    for (int i = 0; i < steps; ++i) {
      const gripline::Ground::Patch road = ground.at(x_.x, x_.y, x_.yaw);
      const double vx = x_.vx, vy = x_.vy, along = std::clamp(10.0 * vx, -1.0, 1.0);  // from -1 backwards to 1 forwards
      const double forward = std::max(std::abs(vx), 0.3), c = std::cos(x_.yaw), s = std::sin(x_.yaw);
      front_ = road.factor * tyre_force(Axle::front, gripline::front_slip(forward, vy, x_.omega, along * delta, lf));
      rear_ = road.factor * tyre_force(Axle::rear, gripline::rear_slip(forward, vy, x_.omega, lr));
      const double across = front_ * std::cos(delta), push = k_.k_d * (d < 0 ? along * d : d);  // brakes oppose motion
      x_.x += h * (vx * c - vy * s), x_.y += h * (vx * s + vy * c), x_.yaw += h * x_.omega;
      x_.vx += h * (push - k_.k_r * vx + vy * x_.omega - g * std::sin(road.grade));
      x_.vy += h * ((rear_ + across) / car_.m - vx * x_.omega + g * std::sin(road.bank));
      x_.omega += h * (lf * across - lr * rear_) / car_.Iz;
    }
    x_.delta = delta;
    return x_;
  }
  double mu(Axle) const override { return k_.mu; }
  double tyre_force(Axle axle, double slip) const override {
    const double load = car_.m * gripline::gravity / (car_.lf + car_.lr) * (axle == Axle::front ? car_.lr : car_.lf);
    return k_.mu * std::tanh(k_.C * slip) * load;
  }
  double axle_force(Axle axle) const override { return axle == Axle::front ? front_ : rear_; }

 private:
  gripline::Car car_;
  Params k_;
  State x_;
  double front_ = 0, rear_ = 0;
};

}  // namespace
GRIPLINE_EQUATIONS({"new_plugin", "vx' = k_d d - k_r vx + vy omega - g sin(grade); F = factor mu tanh(C slip) load"})
GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "single-track car in steps of a millisecond"))
