// Learns rolling + drag v^2, the deceleration that the nominal model lacks, from what the car did.
//
//   y = straight - (vx' - vy omega + Ff sin(delta) / m + g sin(grade)),   straight: the nominal model's vx' at no slip
//   (rolling, drag) minimise  sum_i retain^((t - t_i) / 20 ms) (y_i - rolling - drag v_i^2)^2 / noise^2 + prior
//
// a memory of 20 s, whatever the control step is. vx' is a difference of two noisy readings: y is that over 20 ms, the
// mean over as many shorter steps, since over one of them noise alone would pass for more than a resistance can be.
//
// A planner is given the learned tyres (TyreCurve) but not the rest of what its stack learned; this is the rest it
// needs.
#pragma once

#include <cmath>
#include <gripline/interfaces.hpp>

#include "common/reference_step.hpp"
#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {

class ResistanceFit {
 public:
  /// `v_ref`: typical speed; the prior holds both parts to within 0.3 m g at it.
  ResistanceFit(const SpecificResistance& prior, double v_ref) : prior_(prior), v_ref2_(v_ref * v_ref) {}

  /// One step of dt from `before` to `now`, with the steering angle and throttle held in it, and the front tyre.
  void learn(const Observation& before, const Observation& now, double dt, const MagicFormula& front, const Car& car,
             Prediction& nominal) {
    const auto mean = [](double a, double b) { return 0.5 * (a + b); };
    State straight;
    straight.vx = mean(before.x.vx, now.x.vx);
    if (!(straight.vx > 2.0 * car.v_min)) return;
    const double vy = mean(before.x.vy, now.x.vy), omega = mean(before.x.omega, now.x.omega), delta = now.x.delta;
    const double slip = forward_front_slip(straight.vx, vy, omega, delta, car);
    const double change = (now.x.vx - before.x.vx) / dt;
    const double turn = vy * omega - front.force(slip) * std::sin(delta);
    const double expected = nominal.rates(straight, Input{now.d, 0.0}, Place{}).vx - gravity * std::sin(now.at.grade);
    steps_.add(expected + turn, change, straight.vx);
    const double passed = steps_.count * dt;
    constexpr double rounding = 1e-9;
    if (passed < (1.0 - rounding) * reference_step) return;
    add((steps_.expected - steps_.change) / steps_.count, steps_.speed / steps_.count,
        std::pow(retain, passed / reference_step));
    steps_ = {};
  }

  SpecificResistance value() const {
    // (A + P) z = b, z relative to the prior, drag in units of 1 / v_ref^2.
    const double p = square(noise / spread);
    const double a = a11_ + p, d = a22_ + p, det = a * d - a12_ * a12_;
    const double rolling = (d * b1_ - a12_ * b2_) / det, drag = (a * b2_ - a12_ * b1_) / det;
    return {prior_.rolling + rolling, prior_.drag + drag / v_ref2_};
  }

 private:
  static constexpr double noise = 1.0;             // of one y [m/s2]
  static constexpr double spread = 0.3 * gravity;  // of the prior, both parts [m/s2]
  static constexpr double retain = 0.999;          // share of what was seen that counts after a reference_step

  void add(double y, double v, double retained) {
    const double rest = y - prior_.at(v), u = v * v / v_ref2_;
    if (!(std::abs(rest) <= 2.0 * gravity)) return;  // not a resistance: a crash, a jump of the sensors, no number
    for (double* sum : {&a11_, &a12_, &a22_, &b1_, &b2_}) *sum *= retained;
    a11_ += 1.0;
    a12_ += u;
    a22_ += u * u;
    b1_ += rest;
    b2_ += u * rest;
  }

  /// Sums over the steps since the last y.
  struct Steps {
    int count = 0;
    double expected = 0, change = 0;  // of vx' at no resistance, and as it was [m/s2]
    double speed = 0;                 // [m/s]
    void add(double expected_now, double change_now, double speed_now) {
      ++count;
      expected += expected_now;
      change += change_now;
      speed += speed_now;
    }
  };

  SpecificResistance prior_;
  double v_ref2_;
  Steps steps_;
  double a11_ = 0, a12_ = 0, a22_ = 0, b1_ = 0, b2_ = 0;
};

}  // namespace gripline::time_optimal
