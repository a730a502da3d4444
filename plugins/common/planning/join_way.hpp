// The shape of a way that leads to a line: the offset from the line by the distance along it.
//
//   n(s) = h00(s / Ln) n0 + Ls h10(s / Ls) n0',   h00 and h10 quintic: n' = n'' = 0 where the way is on the line
//
// with the offset n0 and the slope n0' at its begin. Second derivatives of the parts are at most 10 / sqrt(3) n0 / Ln^2,
// and less than 4 n0' / Ls.
#pragma once

#include <algorithm>
#include <cmath>

namespace gripline::planning {

class JoinWay {
 public:
  struct Offset {
    double n = 0, slope = 0, bend = 0;  // n [m] to the left, dn/ds, d2n/ds2 [1/m]
  };
  /// A way of no length.
  JoinWay() = default;
  /// From offset n0 [m] and slope n0', each part with a second derivative of at most `bend` [1/m] unless it would be
  /// longer than `longest` [m].
  JoinWay(double n0, double slope0, double bend, double longest) : n0_(n0), slope0_(slope0) {
    along_slope_ = std::clamp(4.0 * std::abs(slope0) / bend, 1e-6, longest);
    along_n_ = std::clamp(std::sqrt(5.8 * std::abs(n0) / bend), along_slope_, longest);
    if (n0 * slope0 < 0) along_slope_ = along_n_;  // towards the line: no sharper turn than the offset asks for
  }

  /// Distance along the line to where the way is on it [m].
  double length() const { return along_n_; }
  /// `s` metres along the line from its begin; zero beyond its length.
  Offset at(double s) const {
    if (s >= length()) return {};
    const Offset n = from_offset(s / along_n_), slope = from_slope(std::min(s / along_slope_, 1.0));
    return {n0_ * n.n + along_slope_ * slope0_ * slope.n, n0_ / along_n_ * n.slope + slope0_ * slope.slope,
            n0_ / (along_n_ * along_n_) * n.bend + slope0_ / along_slope_ * slope.bend};
  }

 private:
  /// h00 = 1 - 10 u^3 + 15 u^4 - 6 u^5 with its derivatives.
  static Offset from_offset(double u) {
    const double left = 1.0 - u;
    return {left * left * left * (1.0 + 3.0 * u + 6.0 * u * u), -30.0 * u * u * left * left,
            -60.0 * u * left * (1.0 - 2.0 * u)};
  }
  /// h10 = u - 6 u^3 + 8 u^4 - 3 u^5 with its derivatives.
  static Offset from_slope(double u) {
    const double u2 = u * u, u3 = u2 * u;
    return {u - 6.0 * u3 + 8.0 * u3 * u - 3.0 * u3 * u2, 1.0 - 18.0 * u2 + 32.0 * u3 - 15.0 * u2 * u2,
            -36.0 * u + 96.0 * u2 - 60.0 * u3};
  }

  double n0_ = 0, slope0_ = 0;
  double along_n_ = 0, along_slope_ = 0;  // Ln, Ls [m]
};

}  // namespace gripline::planning
