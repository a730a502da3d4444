// A tyre with combined slip, load sensitivity and relaxation, valid down to standstill.
//
// Steady state: the Magic Formula by similarity (Pacejka, Tyre and Vehicle Dynamics, sections 4.2 and 4.3). With slips
// normalised by the slips of their peaks,
//   sx = slip_x / peak_x,   sy = slip_y / peak_y,   s = sqrt(sx^2 + sy^2)
//   Fx = f mu_x Fz g_x(s) sx / s,   Fy = f mu_y Fz g_y(s) sy / s
//   g(s) = sin(C atan(x - E (x - atan x))),   x = x_peak s
// so that pure slip in either direction is its Magic Formula, the force turns with the slip, and the peaks of all
// directions form an ellipse. f is the road's friction factor; it scales the whole curve, as in the published plant.
// Load (same book, section 4.3.2): mu = mu_0 (1 - k (Fz / Fz0 - 1)); cornering stiffness ~ sin(2 atan(Fz / (p Fz0))).
//
// Slips: slip_x = (r spin - Vx) / Vt, slip_y = -Vy / Vt with Vt = max(|V|, |r spin|), so that neither grows without
// bound on a locked, a spinning or a sideways sliding wheel.
// Transient (section 5.4, deflection of the carcass): sigma(s) d slip / dt = Vt (steady slip - slip). sigma shrinks
// with the secant of the curve, so that the deflection never exceeds force over carcass stiffness. At a standstill the
// tyre is the carcass as a spring; section 8.6's damping at low speed is added to the slip, inside the friction limit.
// Where a wheel slides across or rolls backwards, the sigma of a slow wheel follows the carcass alone: with the damping
// in it, it is shorter while the carcass is bent than while it springs back, which gives back more than was put in, and
// a car that had slid to rest across would sway for ever. Driving forward the difference fades away with the speed; it
// is kept there so that results stay what they are.
#pragma once

#include <algorithm>
#include <cmath>

namespace gripline::double_track {

/// The normalised curve of one direction: g(0) = 0, g(1) = 1 is its peak.
class Shape {
 public:
  Shape() = default;
  /// Needs C > 1 and E < 1, else there is no peak.
  Shape(double C, double E) : C_(C), E_(E), x_peak_(find_peak(C, E)) {}

  double at(double s) const {
    const double x = x_peak_ * s;
    return std::sin(C_ * std::atan(x - E_ * (x - std::atan(x))));
  }
  /// g(s) / s, which at s = 0 is the slope there.
  double over(double s) const { return s > 1e-6 ? at(s) / s : slope(); }
  double slope() const { return C_ * x_peak_; }
  /// Slip of the peak times the stiffness factor B.
  double x_peak() const { return x_peak_; }
  double C() const { return C_; }

 private:
  // C atan(phi(x)) = pi / 2, phi rising for E < 1
  static double find_peak(double C, double E) {
    const double wanted = std::tan(std::acos(0.0) / C);
    double lo = 0.0;
    double hi = 1.0;
    const auto phi = [&](double x) { return x - E * (x - std::atan(x)); };
    while (phi(hi) < wanted && hi < 1e9) hi *= 2.0;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (lo + hi);
      (phi(middle) < wanted ? lo : hi) = middle;
    }
    return 0.5 * (lo + hi);
  }

  double C_ = 1.5, E_ = 0.0, x_peak_ = 1.0;
};

/// What the four tyres share.
struct TyreData {
  double mu_x = 0, mu_y = 0;                  // peak at static load [-]
  double sensitivity = 0;                     // k: loss of mu when the load doubles [-]
  double stiffness_x = 0;                     // slip stiffness over load [-]
  double stiffness_load = 0;                  // p: load of the largest cornering stiffness over the static load [-]
  double relaxation_x = 0, relaxation_y = 0;  // sigma at small slip [m]
  double damping = 0, damping_below = 0;      // at a standstill [N s/m], and the speed above which there is none [m/s]
  Shape x, y;
};

/// Forces of one tyre in its own axes, and how fast its transient slips change.
struct TyreForce {
  double x = 0, y = 0;            // [N]
  double rate_x = 0, rate_y = 0;  // [1/s]
};

/// Motion of the wheel over the ground, in the wheel's axes.
struct WheelMotion {
  double Vx = 0, Vy = 0;  // of the contact point [m/s]
  double Vr = 0;          // radius times spin [m/s]
};

class Tyre {
 public:
  Tyre() = default;
  /// stiffness_y: cornering stiffness over load at static load [1/rad]; Fz0: static load [N].
  Tyre(const TyreData& data, double stiffness_y, double Fz0)
      : data_(data), stiffness_y_(stiffness_y), Fz0_(Fz0), load_unit_(1.0 / (data.stiffness_load * Fz0)) {}

  /// Peak friction at a load, for mu_0 at static load. Not below a third of it, however large the load.
  double mu(double mu_0, double Fz) const {
    return mu_0 * std::max(1.0 / 3.0, 1.0 - data_.sensitivity * (Fz / Fz0_ - 1.0));
  }
  /// Cornering stiffness over load [1/rad]; sin(2 atan q) = 2 q / (1 + q^2).
  double cornering(double Fz) const {
    const double q = Fz * load_unit_;
    const double q0 = 1.0 / data_.stiffness_load;
    return stiffness_y_ * (1.0 + q0 * q0) / (1.0 + q * q);
  }

  /// Steady lateral force at a slip angle [rad], without longitudinal slip.
  double lateral(double Fz, double slip_angle) const {
    const double mu_y = mu(data_.mu_y, Fz);
    return mu_y * Fz * data_.y.at(std::sin(slip_angle) * to_normal_y(Fz, mu_y));
  }

  static double transport(const WheelMotion& w) {
    return std::max(std::sqrt(w.Vx * w.Vx + w.Vy * w.Vy), std::abs(w.Vr));
  }

  /// Forces with transient slips `slip_x`, `slip_y` at load Fz >= 0 on friction factor f. `step` is the integration
  /// step [s]: sigma is kept long enough for it.
  TyreForce force(const WheelMotion& w, double slip_x, double slip_y, double Fz, double f, double step) const {
    const double Vt = transport(w);
    const double mu_x = mu(data_.mu_x, Fz);
    const double mu_y = mu(data_.mu_y, Fz);
    const double nx = data_.stiffness_x / (data_.x.slope() * mu_x);  // B / x_peak, with B = stiffness / (C mu)
    const double ny = to_normal_y(Fz, mu_y);

    double held_x = slip_x;
    double held_y = slip_y;
    bool carcass_alone = false;
    if (Vt < data_.damping_below && Fz > 0.0) {
      const double fade = 1.0 - Vt / data_.damping_below;
      const double damping = data_.damping * fade * fade / Fz;
      held_x += damping / data_.stiffness_x * (w.Vr - w.Vx);
      held_y += damping / cornering(Fz) * -w.Vy;
      carcass_alone = w.Vx < std::abs(w.Vy);
    }
    const double sx = held_x * nx;
    const double sy = held_y * ny;
    const double s = std::sqrt(sx * sx + sy * sy);
    const double over_x = data_.x.over(s);
    const double over_y = data_.y.over(s);

    const double shortest = 2.0 * Vt * step;
    const double bent = carcass_alone ? std::hypot(slip_x * nx, slip_y * ny) : s;
    const double secant_x = carcass_alone ? data_.x.over(bent) : over_x;  // F / s of the carcass
    const double secant_y = carcass_alone ? data_.y.over(bent) : over_y;
    const double sigma_x = std::max(data_.relaxation_x * std::max(0.0, secant_x) / data_.x.slope(), shortest);
    const double sigma_y = std::max(data_.relaxation_y * std::max(0.0, secant_y) / data_.y.slope(), shortest);
    return {f * mu_x * Fz * over_x * sx, f * mu_y * Fz * over_y * sy, (w.Vr - w.Vx - Vt * slip_x) / sigma_x,
            (-w.Vy - Vt * slip_y) / sigma_y};
  }

  double static_load() const { return Fz0_; }

 private:
  double to_normal_y(double Fz, double mu_y) const { return cornering(Fz) / (data_.y.slope() * mu_y); }

  TyreData data_;
  double stiffness_y_ = 1, Fz0_ = 1, load_unit_ = 1;
};

}  // namespace gripline::double_track
