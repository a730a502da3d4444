// A driver for blind cases: follows the centre line with a wandering offset at a share of the grip, with the unsteady
// hands and feet of a person.
#pragma once

#include "blind/sizes.hpp"
#include "geometry/track.hpp"

namespace gripline::blind {

struct Style {
  double pace = 0.85;     // of the speed that the nominal grip allows
  double swing = 0.08;    // relative change of pace from lap to lap
  double wander = 0.3;    // of the half width
  double unsteady = 1.0;  // factor on the noise of hands and feet
  int direction = 1;
};

class Driver {
 public:
  Driver(const Track& track, int car, Style style, Random& r) : track_(track), style_(style), full_(car == 1), r_(r) {
    const double n = std::floor(track.length() / (full_ ? 1.0 : 0.02));
    step_ = track.length() / n;
    speed_.resize(static_cast<std::size_t>(n));
    for (double& phase : phase_) phase = uniform(r, 0.0, 6.28);
    plan();
  }

  double speed_at(double s) const {
    const double x = track_.wrap(s) / step_;
    return speed_[static_cast<std::size_t>(x) % speed_.size()];
  }

  /// Command for the next sample, from the state now.
  struct Command {
    double d, delta;
  };
  Command decide(double t, double x, double y, double yaw, double vx, double vy, double w, double dt) {
    const CurveLocation here = track_.locate(x, y, hint_);
    hint_ = here.s;
    const double dir = style_.direction;
    const double v = std::hypot(vx, vy);
    const double ahead = full_ ? 5.0 + 0.45 * v : 0.12 + 0.16 * v;
    const CurvePoint target = track_.at(track_.wrap(here.s + dir * ahead));
    const double half = track_.half_width_left(0.0) * style_.wander;
    const double slow = full_ ? 0.12 : 0.6;
    const double offset = half * 0.6 * (std::sin(slow * t + phase_[0]) + 0.7 * std::sin(2.3 * slow * t + phase_[1]));
    const double tx = target.x - offset * std::sin(target.yaw), ty = target.y + offset * std::cos(target.yaw);
    // Towards the target as a car without slip would, plus what the slip of the front axle needs.
    const double course = yaw + std::atan2(vy, vx);
    const double alpha = std::remainder(std::atan2(ty - y, tx - x) - course, 2.0 * std::numbers::pi);
    const double L = full_ ? 2.6 : 0.062;
    const double kappa = 2.0 * std::sin(alpha) / ahead;
    const double grip = full_ ? 10.0 : 8.9;
    const double load = std::clamp(kappa * v * v / grip, -1.1, 1.1);
    const double understeer = full_ ? 0.015 : 0.05;
    double delta = std::atan(L * kappa) + understeer * load * (1.0 + load * load);
    // Turning more than the road does is taken back.
    const double road_turn = dir * here_kappa(here.s) * v;
    delta -= (full_ ? 0.12 : 0.012) * (w - road_turn);
    const double want = speed_at(here.s + dir * v * 0.1) * (1.0 + pace_of_lap(t));
    const double later = speed_at(here.s + dir * v * (full_ ? 0.5 : 0.15));
    const double rise = (later - want) / (full_ ? 0.4 : 0.12);
    double d = full_ ? 0.07 + (want - vx) * 0.45 + rise / (rise > 0 ? 3.6 : 6.0)
                     : 0.33 + (want - vx) * 0.9 + rise / (rise > 0 ? 5.0 : 7.0);
    // Hands and feet: a slow part and a quick one.
    const double tau = full_ ? 0.4 : 0.15, keep = std::exp(-dt / tau), fresh = std::sqrt(1.0 - keep * keep);
    hands_ = keep * hands_ + fresh * normal(r_);
    feet_ = keep * feet_ + fresh * normal(r_);
    const double u = style_.unsteady;
    delta += u * ((full_ ? 0.006 : 0.018) * hands_ + (full_ ? 0.0025 : 0.007) * normal(r_));
    d += u * ((full_ ? 0.12 : 0.1) * feet_ + 0.03 * normal(r_));
    // A hand has inertia.
    delta_ += (full_ ? 0.4 : 0.6) * (delta - delta_);
    const double limit = full_ ? 0.45 : 0.35;
    return {std::clamp(d, -1.0, 1.0), std::clamp(delta_, -limit, limit)};
  }

 private:
  double here_kappa(double s) const { return track_.at(s).kappa; }
  double pace_of_lap(double t) const { return style_.swing * std::sin((full_ ? 0.11 : 0.45) * t + phase_[2]); }
  /// Speed by curvature, then what braking and drive allow, twice around.
  void plan() {
    const std::size_t n = speed_.size();
    const double grip = style_.pace * style_.pace * (full_ ? 9.3 : 8.4),
                 top = (full_ ? 29.0 : 2.75) * std::min(1.05, style_.pace + 0.12);
    for (std::size_t i = 0; i < n; ++i) {
      double kappa = 0.0;
      for (int j = -6; j <= 6; ++j)
        kappa += std::abs(track_.at(track_.wrap((static_cast<double>(i) + 0.5 * j) * step_)).kappa) / 13.0;
      speed_[i] = std::min(top, std::sqrt(grip / std::max(1e-3, kappa)));
    }
    const double brake = full_ ? 4.5 : 3.0, drive = full_ ? 2.3 : 2.5;
    for (std::size_t around = 0; around < 2 * n; ++around) {
      const std::size_t i = around % n, next = (i + 1) % n;
      const double forward = style_.direction > 0 ? drive : brake;
      speed_[next] = std::min(speed_[next], std::sqrt(speed_[i] * speed_[i] + 2.0 * forward * step_));
    }
    for (std::size_t around = 2 * n; around-- > 0;) {
      const std::size_t i = around % n, next = (i + 1) % n;
      const double backward = style_.direction > 0 ? brake : drive;
      speed_[i] = std::min(speed_[i], std::sqrt(speed_[next] * speed_[next] + 2.0 * backward * step_));
    }
  }

  const Track& track_;
  Style style_;
  bool full_;
  Random& r_;
  double step_ = 1, hint_ = std::nan(""), hands_ = 0, feet_ = 0, delta_ = 0;
  std::array<double, 3> phase_{};
  std::vector<double> speed_;
};

}  // namespace gripline::blind
