// A function of one variable with two continuous derivatives: a cubic spline through equally spaced values whose end
// slopes are those of the parabolas through the three values there. Parabolas are reproduced exactly.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace gripline::time_optimal {

class CubicSpline {
 public:
  /// values[i] at lo + i (hi - lo) / (size - 1); at least four.
  CubicSpline(double lo, double hi, std::span<const double> values)
      : lo_(lo), step_((hi - lo) / static_cast<double>(values.size() - 1)), values_(values.begin(), values.end()) {
    slopes_ = slopes();
  }

  struct Value {
    double f = 0, slope = 0, curvature = 0;
  };
  /// Beyond the ends the curve goes on along its last tangent; where x is NaN, all of it is.
  Value at(double x) const {
    const double position = (x - lo_) / step_;
    const double last = static_cast<double>(values_.size() - 1);
    if (position <= 0.0) return {values_.front() + slopes_.front() * position, slopes_.front() / step_, 0.0};
    if (position >= last) return {values_.back() + slopes_.back() * (position - last), slopes_.back() / step_, 0.0};
    const std::size_t i = position < last - 1.0 ? static_cast<std::size_t>(position) : values_.size() - 2;
    const double u = position - static_cast<double>(i);
    const double p = values_[i], rise = values_[i + 1] - p, a = slopes_[i], b = slopes_[i + 1];
    const double c2 = 3.0 * rise - 2.0 * a - b, c3 = a + b - 2.0 * rise;
    return {p + u * (a + u * (c2 + u * c3)), (a + u * (2.0 * c2 + 3.0 * u * c3)) / step_,
            (2.0 * c2 + 6.0 * u * c3) / (step_ * step_)};
  }
  std::span<const double> values() const { return values_; }

 private:
  // Slopes per step m_i: m_i-1 + 4 m_i + m_i+1 = 3 (f_i+1 - f_i-1), Thomas' algorithm.
  std::vector<double> slopes() const {
    const std::size_t n = values_.size();
    const std::vector<double>& f = values_;
    std::vector<double> m(n), upper(n, 0.0);
    m[0] = -1.5 * f[0] + 2.0 * f[1] - 0.5 * f[2];
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double pivot = 4.0 - upper[i - 1];
      upper[i] = 1.0 / pivot;
      m[i] = (3.0 * (f[i + 1] - f[i - 1]) - m[i - 1]) / pivot;
    }
    m[n - 1] = 1.5 * f[n - 1] - 2.0 * f[n - 2] + 0.5 * f[n - 3];
    for (std::size_t i = n - 1; i-- > 1;) m[i] -= upper[i] * m[i + 1];
    return m;
  }

  double lo_, step_;
  std::vector<double> values_, slopes_;
};

}  // namespace gripline::time_optimal
