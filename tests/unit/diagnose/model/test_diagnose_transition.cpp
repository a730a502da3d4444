#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "diagnose/model/transition.hpp"

namespace gripline::diagnose {
namespace test_diagnose_transition {

constexpr std::size_t n = 10;  // six of motion, one memory, three that fade

/// A car whose lag settles thirty times within the step, or hardly at all.
std::vector<double> matrix(double lag_rate) {
  std::vector<double> A(n * n, 0.0);
  const auto a = [&](std::size_t i, std::size_t j) -> double& { return A[i * n + j]; };
  a(0, 3) = a(1, 4) = a(2, 5) = 1.0;
  a(0, 2) = -0.7;
  a(3, 3) = -0.4, a(3, 4) = 0.3;
  a(4, 4) = -9.0, a(4, 5) = -1.8, a(4, 6) = 3.0;
  a(5, 4) = 6.0, a(5, 5) = -8.0, a(5, 6) = -20.0;
  a(6, 4) = 2.0, a(6, 6) = -lag_rate;
  for (std::size_t c = 0; c < 3; ++c) {
    a(3 + c, 7 + c) = 1.0;
    a(7 + c, 7 + c) = -4.0;
  }
  return A;
}

/// The same by the classical Runge-Kutta method in steps that are short for the fastest part.
std::vector<double> integrate(const std::vector<double>& A, double h, std::vector<double> z,
                              const std::array<double, 3>& b0, const std::array<double, 3>& b1) {
  constexpr int steps = 4000;
  const double part = h / steps;
  const auto rate = [&](const std::vector<double>& at, double share) {
    std::vector<double> r(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) r[i] += A[i * n + j] * at[j];
    for (std::size_t c = 0; c < 3; ++c) r[3 + c] += b0[c] + share * (b1[c] - b0[c]);
    return r;
  };
  const auto moved = [&](const std::vector<double>& k, double by) {
    std::vector<double> to = z;
    for (std::size_t i = 0; i < n; ++i) to[i] += by * k[i];
    return to;
  };
  for (int s = 0; s < steps; ++s) {
    const double from = static_cast<double>(s) / steps, middle = (s + 0.5) / steps, to = (s + 1.0) / steps;
    const auto k1 = rate(z, from), k2 = rate(moved(k1, 0.5 * part), middle);
    const auto k3 = rate(moved(k2, 0.5 * part), middle), k4 = rate(moved(k3, part), to);
    for (std::size_t i = 0; i < n; ++i) z[i] += part / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  }
  return z;
}

/// To within what the power series leaves out at its longest step; of these lags some need just that step, or nearly
/// twice as long a one.
TEST(Transition, AgreesWithIntegrationAlsoWhereItIsStiff) {
  constexpr double h = 0.02;
  for (const double lag_rate : {15.0, 49.0, 60.0, 75.0, 99.0, 100.0, 400.0, 1500.0}) {
    const std::vector<double> A = matrix(lag_rate);
    std::vector<double> F(n * n), in0(n * 3), in1(n * 3);
    transition(A.data(), n, h, F.data(), in0.data(), in1.data());
    for (std::size_t j = 0; j < n; ++j) {
      std::vector<double> unit(n, 0.0);
      unit[j] = 1.0;
      const std::vector<double> z = integrate(A, h, unit, {}, {});
      for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(F[i * n + j], z[i], 1e-4) << lag_rate << ' ' << i << ' ' << j;
    }
    for (std::size_t c = 0; c < 3; ++c)
      for (const bool end : {false, true}) {
        std::array<double, 3> b0{}, b1{};
        (end ? b1 : b0)[c] = 1.0;
        const std::vector<double> z = integrate(A, h, std::vector<double>(n, 0.0), b0, b1);
        const std::vector<double>& in = end ? in1 : in0;
        for (std::size_t i = 0; i < n; ++i)
          EXPECT_NEAR(in[i * 3 + c], z[i], 1e-5 * h) << lag_rate << ' ' << i << ' ' << c << end;
      }
  }
}

}  // namespace test_diagnose_transition
}  // namespace gripline::diagnose
