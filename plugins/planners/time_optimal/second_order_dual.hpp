// SecondOrderDual<N>: a value with its gradient and Hessian along N directions, for exact Hessians of small functions.
#pragma once

#include <cmath>
#include <cstddef>

#include <gripline/dual.hpp>

namespace gripline::time_optimal {

template <int N>
struct SecondOrderDual {
  double v = 0.0;
  double g[N] = {};
  double h[N * (N + 1) / 2] = {};  // lower triangle by rows

  SecondOrderDual() = default;
  SecondOrderDual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): a constant is a number too
  static SecondOrderDual variable(double value, int direction) {
    SecondOrderDual x(value);
    x.g[direction] = 1.0;
    return x;
  }
  static constexpr int entry(int row, int column) { return row * (row + 1) / 2 + column; }
  static constexpr int entries = N * (N + 1) / 2;

  SecondOrderDual& operator+=(const SecondOrderDual& b) {
    v += b.v;
    for (int i = 0; i < N; ++i) g[i] += b.g[i];
    for (int i = 0; i < entries; ++i) h[i] += b.h[i];
    return *this;
  }
  SecondOrderDual& operator-=(const SecondOrderDual& b) {
    v -= b.v;
    for (int i = 0; i < N; ++i) g[i] -= b.g[i];
    for (int i = 0; i < entries; ++i) h[i] -= b.h[i];
    return *this;
  }
  SecondOrderDual& operator*=(double b) {
    v *= b;
    for (double& one : g) one *= b;
    for (double& one : h) one *= b;
    return *this;
  }
  friend SecondOrderDual operator+(SecondOrderDual a, const SecondOrderDual& b) { return a += b; }
  friend SecondOrderDual operator-(SecondOrderDual a, const SecondOrderDual& b) { return a -= b; }
  friend SecondOrderDual operator-(SecondOrderDual a) { return a *= -1.0; }
  friend SecondOrderDual operator*(SecondOrderDual a, double b) { return a *= b; }
  friend SecondOrderDual operator*(double a, SecondOrderDual b) { return b *= a; }
  friend SecondOrderDual operator+(SecondOrderDual a, double b) {
    a.v += b;
    return a;
  }
  friend SecondOrderDual operator+(double a, SecondOrderDual b) { return b + a; }
  friend SecondOrderDual operator-(SecondOrderDual a, double b) { return a + (-b); }
  friend SecondOrderDual operator-(double a, SecondOrderDual b) {
    b *= -1.0;
    return b + a;
  }
  friend SecondOrderDual operator*(const SecondOrderDual& a, const SecondOrderDual& b) {
    SecondOrderDual r(a.v * b.v);
    for (int i = 0; i < N; ++i) r.g[i] = a.v * b.g[i] + b.v * a.g[i];
    for (int i = 0, e = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j, ++e) r.h[e] = a.v * b.h[e] + b.v * a.h[e] + a.g[i] * b.g[j] + a.g[j] * b.g[i];
    return r;
  }
  friend SecondOrderDual operator/(const SecondOrderDual& a, const SecondOrderDual& b) {
    const double u = 1.0 / b.v;
    return a * chain(u, -u * u, 2.0 * u * u * u, b);
  }
  friend SecondOrderDual operator/(const SecondOrderDual& a, double b) { return a * (1.0 / b); }
  friend SecondOrderDual operator/(double a, const SecondOrderDual& b) { return SecondOrderDual(a) / b; }

  /// f(x) from f, f', f'' at x's value.
  friend SecondOrderDual chain(double f, double slope, double curvature, const SecondOrderDual& x) {
    SecondOrderDual r(f);
    for (int i = 0; i < N; ++i) r.g[i] = slope * x.g[i];
    for (int i = 0, e = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j, ++e) r.h[e] = slope * x.h[e] + curvature * x.g[i] * x.g[j];
    return r;
  }
};

inline double chain(double f, double /*slope*/, double /*curvature*/, double /*x*/) { return f; }
template <int N>
Dual<N> chain(double f, double slope, double /*curvature*/, const Dual<N>& x) {
  return gripline::chain(f, slope, x);
}

template <int N>
SecondOrderDual<N> sin(const SecondOrderDual<N>& x) {
  const double s = std::sin(x.v);
  return chain(s, std::cos(x.v), -s, x);
}
template <int N>
SecondOrderDual<N> cos(const SecondOrderDual<N>& x) {
  const double c = std::cos(x.v);
  return chain(c, -std::sin(x.v), -c, x);
}
template <int N>
SecondOrderDual<N> atan(const SecondOrderDual<N>& x) {
  const double u = 1.0 / (1.0 + x.v * x.v);
  return chain(std::atan(x.v), u, -2.0 * x.v * u * u, x);
}

}  // namespace gripline::time_optimal
