// Formulas as authors write them at first: plain numbers beside numbers with derivatives.
#include <gripline/dual.hpp>
#include <gripline/slip.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gripline_users {  // as an author's code, outside the SDK's namespace
namespace test_dual {

using gripline::Dual8;

template <class T>
T with_both(const T& x) {
  using gripline::max, gripline::min, gripline::abs, gripline::hypot;
  using std::max, std::min, std::abs, std::hypot;
  return max(abs(x), 0.3) + min(0.5, x) + max(x, x) + hypot(x, 2.0) + hypot(1.0, x) + max(1.0, 2.0) + abs(-2.0);
}

template <class T>
T with_ours_alone(const T& x) {
  using gripline::max, gripline::min, gripline::abs, gripline::hypot;
  return max(abs(x), 0.3) + min(0.5, x) + max(x, x) + hypot(x, 2.0) + hypot(1.0, x) + max(1.0, 2.0) + abs(-2.0);
}

template <class T>
T angles(const T& x) {
  using std::atan2;
  return atan2(x, 2.0) + atan2(2.0, x);
}

/// Value as of plain numbers, derivative as by differences.
template <class Formula>
void expect_same(const Formula& formula, double x) {
  const Dual8 both = formula(Dual8::variable(x, 3));
  EXPECT_DOUBLE_EQ(both.v, formula(x));
  const double h = 1e-6;
  EXPECT_NEAR(both.d[3], (formula(x + h) - formula(x - h)) / (2 * h), 1e-8) << x;
  EXPECT_EQ(both.d[2], 0.0);
}

TEST(Dual, PlainNumbersMayStandBesideIt) {
  for (const double x : {-0.7, 0.1, 0.4, 2.5}) {
    expect_same([](const auto& at) { return with_both(at); }, x);
    expect_same([](const auto& at) { return with_ours_alone(at); }, x);
    expect_same([](const auto& at) { return angles(at); }, x);
  }
}

TEST(Dual, OfEqualNumbersTheFirstWins) {
  const Dual8 x = Dual8::variable(1.0, 0);
  EXPECT_EQ(gripline::max(x, 1.0).d[0], 1.0);
  EXPECT_EQ(gripline::max(1.0, x).d[0], 0.0);
  EXPECT_EQ(gripline::min(x, 1.0).d[0], 1.0);
  EXPECT_EQ(gripline::min(1.0, x).d[0], 0.0);
}

/// Where a derivative is infinite, that of a constant would be no number: rest would end a run.
TEST(Dual, RootsAndPowersHaveDerivativesAtZero) {
  const Dual8 zero = Dual8::variable(0.0, 0);
  for (const double p : {0.3, 0.5, 1.0, 1.5, 2.0})
    for (int i = 0; i < 8; ++i) EXPECT_EQ(pow(zero, p).d[i], p == 1.0 && i == 0 ? 1.0 : 0.0) << p << " " << i;
  EXPECT_EQ(pow(zero, 0.0).v, 1.0);
  EXPECT_EQ(pow(zero, 0.0).d[0], 0.0);
  EXPECT_EQ(sqrt(zero).d[0], 0.0);
  EXPECT_EQ(hypot(zero, zero).d[1], 0.0);
  expect_same(
      [](const auto& at) {
        using std::pow;
        return pow(at, 0.5);
      },
      0.25);
}

TEST(Slip, TakesTheCarsGeometryAsPlainNumbers) {
  constexpr double lf = 1.34, lr = 1.30, omega = 0.3, delta = 0.05;
  const auto front = [&](const auto& vy) { return gripline::front_slip(12.0, vy, omega, delta, lf); };
  const auto rear = [&](const auto& vy) { return gripline::rear_slip(12.0, vy, omega, lr); };
  expect_same(front, 0.4);
  expect_same(rear, 0.4);
  EXPECT_DOUBLE_EQ(front(0.4), delta - std::atan2(0.4 + lf * omega, 12.0));
  EXPECT_DOUBLE_EQ(rear(0.4), -std::atan2(0.4 - lr * omega, 12.0));
  const Dual8 all = gripline::rear_slip(Dual8(12.0), Dual8(0.4), Dual8::variable(omega, 1), Dual8(lr));
  EXPECT_DOUBLE_EQ(all.v, rear(0.4));
  EXPECT_GT(all.d[1], 0.0);
}

TEST(Slip, SteeringSeenAlongTheMotionKeepsItsDerivatives) {
  const Dual8 delta = Dual8::variable(0.2, 3);
  EXPECT_EQ(gripline::steered_along_motion(Dual8(-1.0), delta).v, -0.2);
  EXPECT_EQ(gripline::steered_along_motion(Dual8(-1.0), delta).d[3], -1.0);
  EXPECT_EQ(gripline::steered_along_motion(1.0, delta).d[3], 1.0);
  EXPECT_EQ(gripline::steered_along_motion(0.0, 0.2), 0.2);
  EXPECT_EQ(gripline::steered_along_motion(-1e-9, 0.2), -0.2);
}

}  // namespace test_dual
}  // namespace gripline_users
