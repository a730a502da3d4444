#include "diagnose/model/transition.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/model/states.hpp"

namespace gripline::diagnose {
namespace {

/// F = exp(h A) and the weights of an input that is linear in time: with P1 = h sum (hA)^i / (i+1)! and
/// P2 = h sum (hA)^i / (i+2)!, an input b0 at the start and b1 at the end adds (P1 - P2) b0 + P2 b1.
template <std::size_t N>
void exponentials(const double* A, double h, double* F, double* in0, double* in1) {
  // Power series by rows; P1 and P2 need the three columns 3..5. Nothing depends on x and y, so that columns begin with
  // the yaw; the unknown accelerations only fade.
  constexpr int order = 7;
  constexpr std::size_t body = N - noise_states, columns = N - 2;
  double term[body][columns] = {}, sum[body][columns] = {}, p1[body][3] = {}, p2[body][3] = {};
  double fading[noise_states];
  for (std::size_t i = 2; i < body; ++i) term[i][i - 2] = sum[i][i - 2] = 1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    p1[3 + c][c] = h;
    p2[3 + c][c] = 0.5 * h;
    fading[c] = 1.0;
  }
  double factorial = 1.0;
  for (int k = 1; k <= order; ++k) {
    double next[body][columns] = {};
    for (std::size_t i = 0; i < body; ++i) {
      for (std::size_t l = 2; l < body; ++l) {
        const double a = A[i * N + l] * h;
        if (a == 0.0) continue;
        for (std::size_t j = 0; j < columns; ++j) next[i][j] += a * term[l][j];
      }
      for (std::size_t c = 0; c < noise_states; ++c) next[i][body + c - 2] += A[i * N + body + c] * h * fading[c];
    }
    for (std::size_t c = 0; c < noise_states; ++c) fading[c] *= A[(body + c) * (N + 1)] * h;
    factorial *= k;
    const double f0 = 1.0 / factorial, f1 = h / (factorial * (k + 1)), f2 = h / (factorial * (k + 1) * (k + 2));
    for (std::size_t i = 0; i < body; ++i) {
      for (std::size_t j = 0; j < columns; ++j) {
        term[i][j] = next[i][j];
        sum[i][j] += f0 * next[i][j];
      }
      for (std::size_t c = 0; c < 3; ++c) {
        p1[i][c] += f1 * next[i][1 + c];
        p2[i][c] += f2 * next[i][1 + c];
      }
    }
  }
  std::fill_n(F, N * N, 0.0);
  std::fill_n(in0, N * 3, 0.0);
  std::fill_n(in1, N * 3, 0.0);
  F[0] = F[N + 1] = 1.0;
  for (std::size_t i = 0; i < body; ++i) {
    for (std::size_t j = 0; j < columns; ++j) F[i * N + 2 + j] = sum[i][j];
    for (std::size_t c = 0; c < 3; ++c) {
      in0[i * 3 + c] = p1[i][c] - p2[i][c];
      in1[i * 3 + c] = p2[i][c];
    }
  }
  for (std::size_t i = body; i < N; ++i) F[i * (N + 1)] = std::exp(A[i * (N + 1)] * h);
}

void exponentials(std::size_t n, const double* A, double h, double* F, double* in0, double* in1) {
  switch (n) {
    case 9:
      return exponentials<9>(A, h, F, in0, in1);
    case 10:
      return exponentials<10>(A, h, F, in0, in1);
    case 11:
      return exponentials<11>(A, h, F, in0, in1);
    case 12:
      return exponentials<12>(A, h, F, in0, in1);
    default:
      return exponentials<channels + max_memory + noise_states>(A, h, F, in0, in1);
  }
}

/// Longest step of the power series, over the shortest time constant: there it is off by 2e-5, at twice of it by 5e-3.
/// A halving takes two thirds of the series' time.
constexpr double longest_series_step = 1.0;

}  // namespace

/// Halves the step until the series converges well (a stiff lag) and puts the halves together again: an input linear in
/// time is (b0 + b1) / 2 in the middle, so that two steps of F, in0, in1 make
///
///   F F,   F (in0 + in1 / 2) + in0 / 2,   F in1 / 2 + in0 / 2 + in1.
///
/// Inputs and outputs as exponentials().
void transition(const double* A, std::size_t n, double h, double* F, double* in0, double* in1) {
  double fastest = 0.0;
  for (std::size_t i = 3; i < n; ++i) fastest = std::max(fastest, std::abs(A[i * n + i]));
  int halvings = 0;
  for (double part = h * fastest; part > longest_series_step && halvings < 40; part *= 0.5) ++halvings;
  exponentials(n, A, std::ldexp(h, -halvings), F, in0, in1);
  constexpr std::size_t most = channels + max_memory + noise_states;
  std::array<double, most * most> product;
  std::array<double, most * 3> first, second;
  const auto add_product = [&](const double* b, std::size_t columns, double* to) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t l = 0; l < n; ++l)
        for (std::size_t j = 0; j < columns; ++j) to[i * columns + j] += F[i * n + l] * b[l * columns + j];
  };
  for (int i = 0; i < halvings; ++i) {
    std::array<double, most * 3> early, late;
    for (std::size_t j = 0; j < n * 3; ++j) {
      early[j] = in0[j] + 0.5 * in1[j];
      late[j] = 0.5 * in1[j];
      first[j] = 0.5 * in0[j];
      second[j] = 0.5 * in0[j] + in1[j];
    }
    add_product(early.data(), 3, first.data());
    add_product(late.data(), 3, second.data());
    std::fill_n(product.begin(), n * n, 0.0);
    add_product(F, n, product.data());
    std::copy_n(product.begin(), n * n, F);
    std::copy_n(first.begin(), n * 3, in0);
    std::copy_n(second.begin(), n * 3, in1);
  }
}

}  // namespace gripline::diagnose
