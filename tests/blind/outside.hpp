// Effects outside the catalogue: what the answer's author knows and the diagnosis does not. Some are those of
// the first given cases, the others are ours. None can be fitted, none is a plugin.
#pragma once

#include <gripline/plugin.hpp>

#include "blind/sizes.hpp"

namespace gripline::blind {

inline double window(double f, double s0, double w) {
  double q = f - s0;
  q -= std::floor(q + 0.5);
  return 0.5 * (std::tanh((q + 0.5 * w) / 0.012) - std::tanh((q - 0.5 * w) / 0.012));
}

/// What the simulation asks of an outside effect at every instant; memory is the effect's own.
class Outside {
 public:
  Outside(Effect e, double v_ref) : e_(std::move(e)), v_ref_(v_ref) {}
  const Effect& effect() const { return e_; }

  /// The command that acts: play in the steering, a bent throttle map, a battery that sags.
  void command(double t, double vx, double& d, double& delta) {
    if (e_.id == "steer_backlash") {
      const double half = p("half_gap");
      if (!started_) play_ = delta;
      started_ = true;
      play_ = std::clamp(play_, delta - half, delta + half);
      delta = play_;
    } else if (e_.id == "throttle_map") {
      d += p("a") * d * (1.0 - std::abs(d));
    } else if (e_.id == "steer_compliance") {
      delta *= 1.0 - p("k") * vx * vx * std::abs(delta) / (v_ref_ * v_ref_ * 0.1);
    } else if (e_.id == "motor_cut" && t > p("t0") && d > 0.0) {
      d *= 1.0 - p("k");
    } else if (e_.id == "rev_limiter" && d > 0.0) {
      d *= 1.0 / (1.0 + std::exp((vx / v_ref_ - p("u0")) / 0.02));
    } else if (e_.id == "servo_rate") {
      // A servo turns no faster than this; it starts where it is told to.
      if (!started_) play_ = delta;
      const double most = p("rate") * std::max(0.0, t - last_);
      play_ = std::clamp(delta, play_ - most, play_ + most);
      last_ = std::max(last_, t);
      started_ = true;
      delta = play_;
    }
    pedal_ = d;
  }
  /// Factors on the peak forces and on what follows the sign of the slip.
  double grip() const {
    if (e_.id == "tyre_thermal") return std::max(0.3, 1.0 - p("k") * heat_);
    if (e_.id == "tyre_wear") return std::max(0.3, 1.0 - p("k") * (1.0 - std::exp(-worn_ / 12.0)));
    return 1.0;
  }
  /// Downforce of a front wing alone.
  double front(double vx) const { return e_.id == "front_wing" ? 1.0 + p("k") * square(vx / v_ref_) : 1.0; }
  double side(double slip) const {
    if (e_.id != "lr_asym_grip") return 1.0;
    const double k = p("k");
    return k > 0.0 ? (slip < 0.0 ? 1.0 - k : 1.0) : (slip > 0.0 ? 1.0 + k : 1.0);
  }
  /// Dissipated power of the tyres, relative to a typical one; grip falls with it over 15 s.
  void warm(double power, double dt) {
    heat_ += dt / 15.0 * (power - heat_);
    worn_ += dt * power;
  }
  /// Accelerations added.
  void accelerate(const Place& at, double vx, double w, double& ax, double& ay, double& aw) const {
    const double direction = at.direction;
    if (e_.id == "yaw_sine") aw += p("a") * std::sin(2.0 * std::numbers::pi * p("hz") * at.t + p("phase"));
    if (e_.id == "lat_gust_t" && std::abs(at.t - p("t0")) < p("half")) ay += p("a");
    if (e_.id == "bump_pos") ay += p("a") * direction * window(at.lap_fraction, p("s0"), p("w"));
    if (e_.id == "drag_patch") ax -= p("a") * window(at.lap_fraction, p("s0"), p("w"));
    // A brake that pulls to one side; a car in front that takes the wind off for a while.
    if (e_.id == "brake_pull") aw += p("k") * std::max(0.0, -pedal_);
    if (e_.id == "slipstream" && std::abs(at.t - p("t0")) < p("half")) ax += p("a") * square(vx / v_ref_);
    if (e_.id == "yaw_quad") aw -= p("k") * w * std::abs(w);
    if (e_.id == "speed_hump") ax -= p("a") * std::exp(-square((vx / v_ref_ - p("u0")) / 0.07));
  }

 private:
  static double square(double x) { return x * x; }
  double p(const char* name) const { return e_.params.at(name); }
  Effect e_;
  double v_ref_;
  double play_ = 0, heat_ = 0, worn_ = 0, last_ = 0, pedal_ = 0;
  bool started_ = false;
};

/// An effect drawn for a case, and what the diagnosis may say of the remainder: what it depends on, and the interval of
/// time or place in which it acts (empty: none).
struct OutsideCase {
  Effect effect;
  std::vector<std::string> where;
  std::vector<double> interval;
};

inline std::vector<std::string> outside_ids() {
  return {"steer_backlash", "lr_asym_grip",     "yaw_sine",  "throttle_map", "lat_gust_t", "tyre_thermal",
          "bump_pos",       "steer_compliance", "motor_cut", "drag_patch",   "yaw_quad",   "speed_hump"};
}

/// Others, that came later: the figures of the first twelve stay what they were.
inline std::vector<std::string> more_outside_ids() {
  return {"rev_limiter", "servo_rate", "tyre_wear", "front_wing", "brake_pull", "slipstream"};
}

inline OutsideCase draw_outside(const std::string& id, int car, double share, double seconds, Random& r) {
  const bool full = car == 1;
  const auto size = [&](double low, double high) { return share * uniform(r, low, high); };
  if (id == "steer_backlash")
    return {{id, {{"half_gap", full ? size(0.004, 0.010) : size(0.006, 0.015)}}}, {"input", "state"}, {}};
  if (id == "lr_asym_grip") return {{id, {{"k", sign(r) * size(0.06, 0.15)}}}, {"state", "input"}, {}};
  if (id == "yaw_sine")
    return {{id,
             {{"a", full ? size(0.15, 0.35) : size(4, 10)},
              {"hz", full ? uniform(r, 0.2, 0.8) : uniform(r, 0.3, 1.2)},
              {"phase", uniform(r, 0, 6.28)}}},
            {"time"},
            {}};
  if (id == "throttle_map") return {{id, {{"a", sign(r) * size(0.2, 0.45)}}}, {"input", "state"}, {}};
  if (id == "lat_gust_t") {
    const double half = full ? uniform(r, 2, 4) : uniform(r, 1, 3), t0 = uniform(r, half + 1, seconds - half - 1);
    return {{id, {{"a", sign(r) * size(1, 2.5)}, {"t0", t0}, {"half", half}}}, {"time"}, {t0 - half, t0 + half}};
  }
  if (id == "tyre_thermal") return {{id, {{"k", size(0.08, 0.2)}}}, {"time", "state"}, {}};
  if (id == "bump_pos" || id == "drag_patch") {
    const double s0 = uniform(r, 0, 1), w = id == "bump_pos" ? 0.04 : 0.06;
    return {{id, {{"a", sign(r) * size(1.2, 2.5)}, {"s0", s0}, {"w", w}}}, {"position"}, {s0 - 0.5 * w, s0 + 0.5 * w}};
  }
  if (id == "steer_compliance") return {{id, {{"k", size(0.1, 0.3)}}}, {"input", "state"}, {}};
  if (id == "motor_cut") {
    const double t0 = uniform(r, 0.25, 0.75) * seconds;
    return {{id, {{"k", size(0.1, 0.3)}, {"t0", t0}}}, {"time", "input"}, {}};
  }
  if (id == "rev_limiter")
    return {{id, {{"u0", full ? uniform(r, 0.85, 1.0) : uniform(r, 1.0, 1.15)}}}, {"state", "input"}, {}};
  if (id == "servo_rate") return {{id, {{"rate", full ? size(0.10, 0.25) : size(1.2, 2.5)}}}, {"input", "state"}, {}};
  if (id == "tyre_wear") return {{id, {{"k", size(0.08, 0.2)}}}, {"time", "state"}, {}};
  if (id == "front_wing") return {{id, {{"k", size(0.06, 0.2)}}}, {"state", "input"}, {}};
  if (id == "brake_pull")
    return {{id, {{"k", sign(r) * (full ? size(0.3, 1.0) : size(4, 12))}}}, {"input", "state"}, {}};
  if (id == "slipstream") {
    const double half = full ? uniform(r, 3, 6) : uniform(r, 2, 4), t0 = uniform(r, half + 1, seconds - half - 1);
    return {{id, {{"a", size(0.4, 1.0)}, {"t0", t0}, {"half", half}}}, {"time"}, {t0 - half, t0 + half}};
  }
  if (id == "yaw_quad") return {{id, {{"k", full ? size(1.5, 4) : size(1, 3)}}}, {"state"}, {}};
  return {{id, {{"a", size(0.5, 1.2)}, {"u0", full ? uniform(r, 0.8, 0.95) : uniform(r, 1.0, 1.15)}}}, {"state"}, {}};
}

}  // namespace gripline::blind
