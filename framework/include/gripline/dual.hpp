/// \file
/// Dual<N>: a value and its derivatives along N directions (forward-mode differentiation).
///
/// A formula written once for any scalar T gives values with T = double and exact directional derivatives with
/// T = Dual<N>. Dual8 is the width that crosses plugin boundaries: callers that need more directions call again with
/// the next eight. Layout: N + 1 doubles, value first; nothing is allocated.
///
/// Points without a derivative: abs, min, max and comparisons act on the value and take the derivative of the branch
/// chosen; at a tie the first argument (for abs: the positive branch) wins. atan2(0, 0) has derivative 0; so have sqrt,
/// hypot and powers below 1 at 0, where the derivative is infinite or does not exist.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <type_traits>

namespace gripline {

/// \cond
namespace dual_detail {

// Four derivatives at a time. Written out because a compiler that cannot prove a and b distinct from the result does
// not vectorise the plain loop; the alignment is a double's own, so nothing about layouts changes.
#if defined(__GNUC__)
using Lane = double __attribute__((vector_size(32), aligned(8), may_alias));
inline constexpr int lane_size = 4;
#endif

/// r = ca a + cb b, element by element; r may be a or b.
template <int N>
constexpr void combine(double* r, double ca, const double* a, double cb, const double* b) {
#if defined(__GNUC__)
  if constexpr (N % lane_size == 0) {
    if (!std::is_constant_evaluated()) {
      for (int i = 0; i < N; i += lane_size)
        *reinterpret_cast<Lane*>(r + i) =
            ca * *reinterpret_cast<const Lane*>(a + i) + cb * *reinterpret_cast<const Lane*>(b + i);
      return;
    }
  }
#endif
  for (int i = 0; i < N; ++i) r[i] = ca * a[i] + cb * b[i];
}

/// r = c a, element by element; r may be a.
template <int N>
constexpr void scale(double* r, double c, const double* a) {
#if defined(__GNUC__)
  if constexpr (N % lane_size == 0) {
    if (!std::is_constant_evaluated()) {
      for (int i = 0; i < N; i += lane_size)
        *reinterpret_cast<Lane*>(r + i) = c * *reinterpret_cast<const Lane*>(a + i);
      return;
    }
  }
#endif
  for (int i = 0; i < N; ++i) r[i] = c * a[i];
}

/// r += a, or r -= a for Sign = -1.
template <int N, int Sign>
constexpr void accumulate(double* r, const double* a) {
#if defined(__GNUC__)
  if constexpr (N % lane_size == 0) {
    if (!std::is_constant_evaluated()) {
      for (int i = 0; i < N; i += lane_size) {
        Lane& lane = *reinterpret_cast<Lane*>(r + i);
        if constexpr (Sign > 0)
          lane += *reinterpret_cast<const Lane*>(a + i);
        else
          lane -= *reinterpret_cast<const Lane*>(a + i);
      }
      return;
    }
  }
#endif
  for (int i = 0; i < N; ++i) r[i] += Sign * a[i];
}

/// r = a, element by element.
template <int N>
constexpr void copy(double* r, const double* a) {
#if defined(__GNUC__)
  if constexpr (N % lane_size == 0) {
    if (!std::is_constant_evaluated()) {
      for (int i = 0; i < N; i += lane_size) *reinterpret_cast<Lane*>(r + i) = *reinterpret_cast<const Lane*>(a + i);
      return;
    }
  }
#endif
  for (int i = 0; i < N; ++i) r[i] = a[i];
}

/// r = 0, element by element.
template <int N>
constexpr void clear(double* r) {
#if defined(__GNUC__)
  if constexpr (N % lane_size == 0) {
    if (!std::is_constant_evaluated()) {
      for (int i = 0; i < N; i += lane_size) *reinterpret_cast<Lane*>(r + i) = Lane{};
      return;
    }
  }
#endif
  for (int i = 0; i < N; ++i) r[i] = 0.0;
}

}  // namespace dual_detail
/// \endcond

/// A value and its derivatives along N directions.
template <int N>
struct Dual {
  double v = 0.0;    ///< value
  double d[N] = {};  ///< derivatives

  /// Zero, without derivatives.
  constexpr Dual() = default;
  /// A copy. Written out because the compiler's own moves 16 bytes at a time from the value on: what was written as
  /// four derivatives is then read across two writes, which a CPU cannot serve before both have reached its cache.
  [[gnu::always_inline]] constexpr Dual(const Dual& b) : v(b.v) { dual_detail::copy<N>(d, b.d); }
  /// A copy, written out for the same reason.
  // NOLINTNEXTLINE(bugprone-unhandled-self-assignment): of numbers, to itself, it changes nothing
  [[gnu::always_inline]] constexpr Dual& operator=(const Dual& b) {
    v = b.v;
    dual_detail::copy<N>(d, b.d);
    return *this;
  }
  /// A constant.
  [[gnu::always_inline]] constexpr Dual(
      double value)  // NOLINT(google-explicit-constructor): a constant is a number too
      : v(value) {
    dual_detail::clear<N>(d);
  }

  /// The variable itself: value `value`, derivative 1 along `direction`.
  static constexpr Dual variable(double value, int direction) {
    Dual x(value);
    x.d[direction] = 1.0;
    return x;
  }

  /// \name Arithmetic
  ///@{

  /// Arithmetic of the values, with derivatives by the sum, product and quotient rules.
  constexpr Dual& operator+=(const Dual& b) {
    v += b.v;
    dual_detail::accumulate<N, 1>(d, b.d);
    return *this;
  }
  constexpr Dual& operator-=(const Dual& b) {
    v -= b.v;
    dual_detail::accumulate<N, -1>(d, b.d);
    return *this;
  }
  constexpr Dual& operator*=(const Dual& b) {
    dual_detail::combine<N>(d, b.v, d, v, b.d);
    v *= b.v;
    return *this;
  }
  constexpr Dual& operator/=(const Dual& b) {
    const double inverse = 1.0 / b.v;
    v *= inverse;
    dual_detail::combine<N>(d, inverse, d, -v * inverse, b.d);
    return *this;
  }
  constexpr Dual& operator+=(double b) {
    v += b;
    return *this;
  }
  constexpr Dual& operator-=(double b) {
    v -= b;
    return *this;
  }
  constexpr Dual& operator*=(double b) {
    v *= b;
    dual_detail::scale<N>(d, b, d);
    return *this;
  }
  constexpr Dual& operator/=(double b) { return *this *= 1.0 / b; }

  friend constexpr Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend constexpr Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend constexpr Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend constexpr Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend constexpr Dual operator+(Dual a, double b) { return a += b; }
  friend constexpr Dual operator-(Dual a, double b) { return a -= b; }
  friend constexpr Dual operator*(Dual a, double b) { return a *= b; }
  friend constexpr Dual operator/(Dual a, double b) { return a /= b; }
  friend constexpr Dual operator+(double a, Dual b) { return b += a; }
  friend constexpr Dual operator-(double a, const Dual& b) { return Dual(a) -= b; }
  friend constexpr Dual operator*(double a, Dual b) { return b *= a; }
  friend constexpr Dual operator/(double a, const Dual& b) { return Dual(a) /= b; }
  friend constexpr Dual operator-(Dual a) { return a *= -1.0; }
  friend constexpr Dual operator+(const Dual& a) { return a; }
  ///@}

  /// \name Comparisons
  ///@{

  /// Compare the values; derivatives are ignored.
  friend constexpr bool operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend constexpr bool operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend constexpr bool operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  friend constexpr bool operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
  ///@}
};

/// The width that crosses plugin boundaries.
using Dual8 = Dual<8>;

/// A number without its derivatives. In a formula this drops what the caller asks for: use it to choose an index or a
/// branch, never on the way to a result.
constexpr double value(double x) { return x; }
/// The value of a Dual, its derivatives dropped.
template <int N>
constexpr double value(const Dual<N>& x) {
  return x.v;
}

/// f(x) with value f and derivative f' applied to x's directions: the chain rule for hand-written derivatives.
template <int N>
constexpr Dual<N> chain(double f, double slope, const Dual<N>& x) {
  Dual<N> y(f);
  dual_detail::scale<N>(y.d, slope, x.d);
  return y;
}
/// chain() for a plain number, which has no derivatives: returns f.
constexpr double chain(double f, double /*slope*/, double /*x*/) { return f; }

/// Sine and cosine of one angle.
template <class T>
struct SineCosine {
  T sine;    ///< of it
  T cosine;  ///< of it
};
/// Both of them, by one call of the mathematics library.
inline SineCosine<double> sine_cosine(double angle) { return {std::sin(angle), std::cos(angle)}; }
/// Sine and cosine of an angle with derivatives.
template <int N>
SineCosine<Dual<N>> sine_cosine(const Dual<N>& angle) {
  const double s = std::sin(angle.v), c = std::cos(angle.v);
  return {chain(s, c, angle), chain(c, -s, angle)};
}

/// \name Functions
///@{

/// The standard function of the value, with its derivatives; the head of dual.hpp says what it is where there is no
/// derivative.
template <int N>
Dual<N> sin(const Dual<N>& x) {
  return chain(std::sin(x.v), std::cos(x.v), x);
}
template <int N>
Dual<N> cos(const Dual<N>& x) {
  return chain(std::cos(x.v), -std::sin(x.v), x);
}
template <int N>
Dual<N> tan(const Dual<N>& x) {
  const double t = std::tan(x.v);
  return chain(t, 1.0 + t * t, x);
}
template <int N>
Dual<N> atan(const Dual<N>& x) {
  return chain(std::atan(x.v), 1.0 / (1.0 + x.v * x.v), x);
}
template <int N>
Dual<N> exp(const Dual<N>& x) {
  const double e = std::exp(x.v);
  return chain(e, e, x);
}
template <int N>
Dual<N> log(const Dual<N>& x) {
  return chain(std::log(x.v), 1.0 / x.v, x);
}
template <int N>
Dual<N> tanh(const Dual<N>& x) {
  const double t = std::tanh(x.v);
  return chain(t, 1.0 - t * t, x);
}
template <int N>
Dual<N> sqrt(const Dual<N>& x) {
  const double r = std::sqrt(x.v);
  return chain(r, r > 0.0 ? 0.5 / r : 0.0, x);
}
template <int N>
Dual<N> abs(const Dual<N>& x) {
  return x.v < 0.0 ? -x : x;
}
template <int N>
Dual<N> pow(const Dual<N>& x, double p) {
  const bool cusp = p < 1.0 && !(x.v < 0.0) && !(x.v > 0.0);
  return chain(std::pow(x.v, p), cusp ? 0.0 : p * std::pow(x.v, p - 1.0), x);
}
template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double r2 = x.v * x.v + y.v * y.v;
  const double inverse = r2 > 0.0 ? 1.0 / r2 : 0.0;
  Dual<N> a(std::atan2(y.v, x.v));
  dual_detail::combine<N>(a.d, x.v * inverse, y.d, -y.v * inverse, x.d);
  return a;
}
template <int N>
Dual<N> hypot(const Dual<N>& x, const Dual<N>& y) {
  return sqrt(x * x + y * y);
}
template <int N>
Dual<N> min(const Dual<N>& a, const Dual<N>& b) {
  return b.v < a.v ? b : a;
}
template <int N>
Dual<N> max(const Dual<N>& a, const Dual<N>& b) {
  return b.v > a.v ? b : a;
}
///@}

/// \name A number with derivatives beside a plain one
///@{

/// A function of a Dual and a plain number, which counts as a constant.
template <int N>
Dual<N> atan2(const Dual<N>& y, double x) {
  return atan2(y, Dual<N>(x));
}
template <int N>
Dual<N> atan2(double y, const Dual<N>& x) {
  return atan2(Dual<N>(y), x);
}
template <int N>
Dual<N> hypot(const Dual<N>& x, double y) {
  return hypot(x, Dual<N>(y));
}
template <int N>
Dual<N> hypot(double x, const Dual<N>& y) {
  return hypot(Dual<N>(x), y);
}
template <int N>
Dual<N> min(const Dual<N>& a, double b) {
  return min(a, Dual<N>(b));
}
template <int N>
Dual<N> min(double a, const Dual<N>& b) {
  return min(Dual<N>(a), b);
}
template <int N>
Dual<N> max(const Dual<N>& a, double b) {
  return max(a, Dual<N>(b));
}
template <int N>
Dual<N> max(double a, const Dual<N>& b) {
  return max(Dual<N>(a), b);
}
///@}

/// \name Plain numbers
///@{

/// For plain numbers, so that a formula with `using gripline::max;` compiles for double and for Dual. abs and hypot are
/// templates so that after `using std::abs;` overload resolution prefers the standard's.
constexpr double min(double a, double b) { return b < a ? b : a; }
constexpr double max(double a, double b) { return b > a ? b : a; }
template <std::floating_point F>
F abs(F x) {
  return std::abs(x);
}
template <std::floating_point F>
F hypot(F x, F y) {
  return std::hypot(x, y);
}
///@}

/// x times x.
template <class T>
constexpr T square(const T& x) {
  return x * x;
}
/// x, or the limit it is beyond; beyond a limit the derivative is 0.
template <class T>
constexpr T clamp_value(const T& x, double lo, double hi) {
  if (x < T(lo)) return T(lo);
  if (x > T(hi)) return T(hi);
  return x;
}

}  // namespace gripline
