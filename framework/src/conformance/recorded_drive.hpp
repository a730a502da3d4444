// The published 1:43 car, driven: the true equations, a driver of bends and what a stack sees of every step. Estimators
// are asked to learn from it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "car/corrected_model.hpp"
#include "conformance/published_car.hpp"

namespace gripline::conformance {

inline constexpr double dt = 0.02;  // [s]

inline Car small_car() { return published::car; }

/// The published 1:43 car, by the equations of the paper, which are those of a car that drives forward: backwards its
/// front wheels and its resistance would push it. Friction multiplies both axles' peaks.
struct TrueCar {
  Car car = small_car();
  double Bf = published::Bf, Cf = published::Cf, Df = published::Df;
  double Br = published::Br, Cr = published::Cr, Dr = published::Dr;
  double Cm1 = published::Cm1, Cm2 = published::Cm2, Cr0 = published::Cr0, Cd = published::Cd;
  double factor = 1.0;
  double arm = 0.0;  // [m] at which drive turns the car, under a side force as large as its weight

  double force(Axle axle, double slip) const {
    return axle == Axle::front ? factor * Df * std::sin(Cf * std::atan(Bf * slip))
                               : factor * Dr * std::sin(Cr * std::atan(Br * slip));
  }
  double mu() const { return factor * (Df + Dr) / (car.m * gravity); }

  double front_slip(const State& x) const { return x.delta - std::atan2(x.omega * car.lf + x.vy, std::abs(x.vx)); }
  double rear_slip(const State& x) const { return std::atan2(x.omega * car.lr - x.vy, std::abs(x.vx)); }

  /// x.delta is the angle that acts.
  State rates(const State& x, double d, double grade = 0, double bank = 0) const {
    const double ff = force(Axle::front, front_slip(x)), fr = force(Axle::rear, rear_slip(x));
    State r;
    r.x = x.vx * std::cos(x.yaw) - x.vy * std::sin(x.yaw);
    r.y = x.vx * std::sin(x.yaw) + x.vy * std::cos(x.yaw);
    r.yaw = x.omega;
    const double drive = (Cm1 - Cm2 * x.vx) * d;
    r.vx =
        (drive - Cr0 - Cd * x.vx * x.vx - ff * std::sin(x.delta)) / car.m + x.vy * x.omega - gravity * std::sin(grade);
    r.vy = (fr + ff * std::cos(x.delta)) / car.m - x.vx * x.omega + gravity * std::sin(bank);
    const double moment = arm * std::max(0.0, drive) * (fr + ff * std::cos(x.delta)) / (car.m * gravity);
    r.omega = (ff * car.lf * std::cos(x.delta) - fr * car.lr + moment) / car.Iz;
    return r;
  }

  /// One control step, steering held: twenty classical Runge-Kutta steps.
  State step(State x, const Input& u, double grade = 0, double bank = 0) const {
    x.delta += u.ddelta * dt;
    const double h = dt / 20;
    const auto moved = [](State a, const State& r, double by) {
      a.x += by * r.x;
      a.y += by * r.y;
      a.yaw += by * r.yaw;
      a.vx += by * r.vx;
      a.vy += by * r.vy;
      a.omega += by * r.omega;
      return a;
    };
    for (int i = 0; i < 20; ++i) {
      const State k1 = rates(x, u.d, grade, bank);
      const State k2 = rates(moved(x, k1, h / 2), u.d, grade, bank);
      const State k3 = rates(moved(x, k2, h / 2), u.d, grade, bank);
      const State k4 = rates(moved(x, k3, h), u.d, grade, bank);
      x = moved(moved(moved(moved(x, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
    }
    return x;
  }
};

/// Algorithm 1, line 4: one step as the stack sees it.
inline Sample make_sample(CorrectedModel& nominal, std::int64_t step, const State& x, const Input& u,
                          const State& x_next, const Place& at = {}) {
  Sample k;
  k.t = static_cast<double>(step) * dt;
  k.dt = dt;
  k.step = step;
  k.x = x;
  k.u = u;
  k.at = k.at_next = at;
  k.x_next = x_next;
  const State predicted = nominal.advance(x, u, at);
  k.e_vx = (x_next.vx - predicted.vx) / dt;
  k.e_vy = (x_next.vy - predicted.vy) / dt;
  k.e_omega = (x_next.omega - predicted.omega) / dt;
  return k;
}

/// A driver of bends: every 0.3 to 0.8 s another curvature, the speed it allows at 85 % of the friction; seeded.
class BendDriver {
 public:
  explicit BendDriver(unsigned seed) : state_(seed * 2654435761u + 1u) {}
  Input drive(const State& x, const TrueCar& truth) {
    if (left_-- <= 0) {
      left_ = 15 + static_cast<int>(25 * random());
      const double sharpest = 4.5;
      curvature_ = (random() < 0.2 ? 0.1 : 1.0) * sharpest * (2 * random() - 1);
      if (std::abs(curvature_) < 0.3) curvature_ = 0;
    }
    const Car& car = truth.car;
    const double speed = std::min(2.8, std::sqrt(0.95 * truth.mu() * gravity / std::max(0.05, std::abs(curvature_))));
    const double wanted = std::atan((car.lf + car.lr) * curvature_) + 0.12 * (curvature_ * x.vx - x.omega) +
                          (curvature_ > 0 ? 1 : -1) * (curvature_ == 0 ? 0 : 0.15);
    const double delta = std::clamp(wanted, -car.delta_max, car.delta_max);
    Input u;
    u.ddelta = std::clamp((delta - x.delta) / dt, -car.ddelta_max, car.ddelta_max);
    u.d = std::clamp(0.25 + 1.0 * (speed - x.vx), car.d_min, car.d_max);
    return u;
  }

 private:
  double random() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  std::uint64_t state_;
  int left_ = 0;
  double curvature_ = 0;
};

/// A sequence of steps of the true car: states (steering as it acted before each), inputs, friction factors.
struct Drive {
  std::vector<State> x;
  std::vector<Input> u;
  std::vector<double> factor;
  std::size_t steps() const { return x.size() - 1; }
};

/// The bend driver for `seconds`, friction by time.
template <class Factor>
Drive drive_bends(double seconds, unsigned seed, const Factor& factor_at) {
  BendDriver driver(seed);
  TrueCar truth;
  Drive drive;
  State x;
  x.vx = 0.5;
  drive.x.push_back(x);
  for (int i = 0; i * dt < seconds; ++i) {
    truth.factor = factor_at(i * dt);
    drive.factor.push_back(truth.factor);
    drive.u.push_back(driver.drive(drive.x.back(), truth));
    drive.x.push_back(truth.step(drive.x.back(), drive.u.back()));
  }
  return drive;
}

}  // namespace gripline::conformance
