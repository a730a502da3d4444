#include "car/integrator.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

namespace gripline {
namespace test_integrator {

using Vec = std::array<double, 2>;

/// An oscillator whose frequency changes with time and amplitude: every kind of term of the order conditions.
Vec rate(double t, const Vec& y) {
  const double stiffness = 1.0 + 0.3 * std::sin(t) + 0.2 * y[0] * y[0];
  return {y[1], -stiffness * y[0] + 0.1 * y[1] * std::cos(2 * t)};
}

Vec integrate(const Tableau& method, int steps) {
  const double h = 2.0 / steps;
  Vec y = {1.0, 0.3};
  for (int n = 0; n < steps; ++n) {
    std::array<Vec, 8> k{};
    for (int i = 0; i < method.stages; ++i) {
      Vec at = y;
      for (int j = 0; j < i; ++j)
        for (int c = 0; c < 2; ++c) at[c] += h * method.weight(i, j) * k[j][c];
      k[i] = rate(n * h + method.c[i] * h, at);
    }
    for (int i = 0; i < method.stages; ++i)
      for (int c = 0; c < 2; ++c) y[c] += h * method.b[i] * k[i][c];
  }
  return y;
}

double error(const Tableau& method, int steps) {
  static const Vec exact = integrate(*find_tableau("rk6"), 4000);
  const Vec y = integrate(method, steps);
  return std::hypot(y[0] - exact[0], y[1] - exact[1]);
}

class Methods : public testing::TestWithParam<std::string> {};

TEST_P(Methods, RowsAreConsistent) {
  const Tableau& method = *find_tableau(GetParam());
  ASSERT_EQ(method.b.size(), static_cast<std::size_t>(method.stages));
  ASSERT_EQ(method.c.size(), static_cast<std::size_t>(method.stages));
  ASSERT_EQ(method.a.size(), static_cast<std::size_t>(method.stages * (method.stages - 1) / 2));
  double total = 0;
  for (int i = 0; i < method.stages; ++i) {
    double row = 0;
    for (int j = 0; j < i; ++j) row += method.weight(i, j);
    EXPECT_NEAR(row, method.c[i], 1e-15) << "stage " << i;
    total += method.b[i];
  }
  EXPECT_NEAR(total, 1.0, 1e-15);
}

/// Halving the step divides the error by 2^order, and by no more: the order is neither less nor more than stated.
TEST_P(Methods, ShowTheirOrder) {
  const Tableau& method = *find_tableau(GetParam());
  for (const int steps : {16, 32, 64}) {
    const double order = std::log2(error(method, steps) / error(method, 2 * steps));
    EXPECT_NEAR(order, method.order, 0.35) << steps << " steps";
  }
}

INSTANTIATE_TEST_SUITE_P(Tableaux, Methods, testing::Values("euler", "heun", "rk4", "rkf5", "rk6"),
                         [](const auto& one) { return one.param; });

TEST(Integrator, FindsByName) {
  EXPECT_EQ(find_tableau("rk6")->order, 6);
  EXPECT_EQ(find_tableau("rkf5")->order, 5);
  EXPECT_EQ(find_tableau("rk4")->order, 4);
  EXPECT_EQ(find_tableau("rk8"), nullptr);
  EXPECT_EQ(tableaux().size(), 5u);  // all of them are tested above
}

}  // namespace test_integrator
}  // namespace gripline
