// The stage-wise quadratic program inside the mpc_sqp plugin, and its solver.
#include "controllers/mpc_sqp/ocp_qp_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "controllers/mpc_sqp/active_set.hpp"
#include "controllers/mpc_sqp/interior_point.hpp"
#include "controllers/mpc_sqp/riccati.hpp"
#include "support/allocation_counter.hpp"
#include "support/ocp_support.hpp"

namespace test_ocp_qp_solver {

using namespace gripline::mpc_sqp;
using namespace gripline::testing_support;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<double> random_state(int states, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<double> x(static_cast<std::size_t>(states));
  for (double& v : x) v = normal(random);
  return x;
}

OcpQpSolverOptions interior_only() {
  OcpQpSolverOptions options;
  options.active_set_iter_max = 0;
  return options;
}

std::vector<double> inputs_of(const OcpQpSolver& solver, int horizon) {
  std::vector<double> u;
  for (int k = 0; k < horizon; ++k) u.insert(u.end(), solver.u(k), solver.u(k) + 2);
  return u;
}

int not_inactive(const OcpQp& qp, const OcpQpSolver& solver, Constraint row) {
  int count = 0;
  for (int k = 0; k <= qp.dims.N; ++k) count += solver.status(k)[row] != BoundStatus::inactive ? 1 : 0;
  return count;
}

TEST(OcpQp, RandomProgramsMeetTheirConditionsOfOptimality) {
  std::mt19937_64 random(1);
  int interior = 0, held[con_count] = {};
  for (int trial = 0; trial < 200; ++trial) {
    const int states[] = {4, 8, 8, 10, 16, 21};
    const ProgramShape shape{
        .N = trial % 2 ? 50 : 12, .nx = states[trial % 6], .Z = trial % 3 ? 200.0 : 2e4, .pull = trial % 4 ? 1.0 : 5.0};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.nx, random);
    OcpQpSolver solver(shape.N, shape.nx);
    const OcpQpSolverStatistics statistics = solver.solve(qp, x0.data(), {});
    ASSERT_TRUE(statistics.solved) << "trial " << trial;
    EXPECT_LT(residuals(qp, solver).worst(), 2e-5 * shape.pull * (1 + shape.Z / 200)) << "trial " << trial;
    interior += statistics.ip_iter > 0 ? 1 : 0;
    for (int row = 0; row < con_count; ++row) held[row] += not_inactive(qp, solver, static_cast<Constraint>(row));
  }
  for (const int count : held) EXPECT_GT(count, 50);  // every kind of bound was at work
  EXPECT_GT(interior, 20);                            // and both methods
  EXPECT_LT(interior, 180);
}

TEST(OcpQp, TheInteriorPointMethodAloneFindsTheSameSolutions) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const ProgramShape shape{.N = 30, .nx = 8, .Z = trial % 2 ? 200.0 : 2e4};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.nx, random);
    OcpQpSolver by_active_set(shape.N, shape.nx), by_interior(shape.N, shape.nx);
    ASSERT_TRUE(by_active_set.solve(qp, x0.data(), {}).solved);
    const OcpQpSolverStatistics statistics = by_interior.solve(qp, x0.data(), interior_only());
    ASSERT_TRUE(statistics.solved) << "trial " << trial;
    EXPECT_GT(statistics.ip_iter, 0);
    EXPECT_LE(statistics.ip_iter, 25);
    for (int k = 0; k < shape.N; ++k) {
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(by_active_set.u(k)[i], by_interior.u(k)[i], 1e-6);
    }
  }
}

TEST(OcpQp, AnInteriorSolutionWithoutExactFinishIsOptimalToItsTolerance) {
  std::mt19937_64 random(12);
  const ProgramShape shape{.N = 30, .nx = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  QpPoint point(shape.N, shape.nx);
  point.set_x0(x0.data(), shape.nx);
  const auto riccati = make_riccati(shape.N, shape.nx);
  ActiveSet active_set(shape.N);
  ASSERT_TRUE(active_set.update_curvature(qp, *riccati, point));
  InteriorPoint interior_point(shape.N, shape.nx);
  interior_point.start(qp, *riccati, point);
  InteriorPoint::Status status = InteriorPoint::Status::active_set_repeats;
  while (status == InteriorPoint::Status::active_set_repeats)
    status = interior_point.iterate(qp, *riccati, point, 1e-9, 40);
  ASSERT_EQ(status, InteriorPoint::Status::converged);
  interior_point.get_solution(point);
  OcpQpSolver exact(shape.N, shape.nx);
  ASSERT_TRUE(exact.solve(qp, x0.data(), {}).exact);
  for (int k = 0; k < shape.N; ++k) {
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(point.stage(k)[i], exact.u(k)[i], 1e-6);
  }
}

TEST(OcpQp, NoFeasibleNeighbourIsCheaper) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    const ProgramShape shape{.N = 20, .nx = 8, .z = trial % 2 ? 0.5 : 0.0};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.nx, random);
    OcpQpSolver solver(shape.N, shape.nx);
    ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
    const auto best = inputs_of(solver, shape.N);
    const double cost = rolled_out_cost(qp, x0, best);
    ASSERT_TRUE(std::isfinite(cost));
    for (int neighbour = 0; neighbour < 200; ++neighbour) {
      auto u = best;
      const double reach = std::pow(10.0, -1.0 - neighbour % 4);
      const int from = neighbour % shape.N;
      for (int k = from; k < std::min(shape.N, from + 3); ++k) {
        for (int i = 0; i < 2; ++i) {
          double& v = u[static_cast<std::size_t>(2 * k + i)];
          v = std::clamp(v + reach * normal(random), qp.lb(k)[i], qp.ub(k)[i]);
        }
      }
      EXPECT_GE(rolled_out_cost(qp, x0, u), cost - 1e-9);
    }
  }
}

TEST(OcpQp, WithoutBoundsItIsTheDenseLinearSystem) {
  std::mt19937_64 random(4);
  const int horizon = 6, states = 5, per_stage = states + 2;
  OcpQp qp = random_program({.N = horizon, .nx = states}, random);
  for (int k = 0; k <= horizon; ++k) {
    std::fill_n(qp.lb(k), con_count, -infinity);
    std::fill_n(qp.ub(k), con_count, infinity);
  }
  const auto x0 = random_state(states, random);
  // Unknowns: z_0 .. z_N-1 = (u, x), x_N, then the multipliers of x_0 and of every x_k+1 = A x + B u + b.
  const int unknowns = horizon * per_stage + states, rows = (horizon + 1) * states;
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(unknowns + rows, unknowns + rows);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns + rows);
  const auto x_at = [&](int k) { return k == horizon ? horizon * per_stage : k * per_stage + 2; };
  for (int k = 0; k <= horizon; ++k) {
    for (int i = 0; i < states; ++i) {
      right(x_at(k) + i) = -qp.q(k)[i];
      for (int j = 0; j < states; ++j) kkt(x_at(k) + i, x_at(k) + j) = qp.Q(k)[i * qp.dims.ldx + j];
      kkt(unknowns + k * states + i, x_at(k) + i) = 1;
      right(unknowns + k * states + i) = k == 0 ? x0[static_cast<std::size_t>(i)] : qp.b(k - 1)[i];
      if (k == 0) continue;
      const double *A = qp.A(k - 1) + i * qp.dims.ldux, *B = qp.B(k - 1) + i * qp.dims.ldux;
      for (int j = 0; j < states; ++j) kkt(unknowns + k * states + i, x_at(k - 1) + j) = -A[j];
      for (int j = 0; j < 2; ++j) kkt(unknowns + k * states + i, (k - 1) * per_stage + j) = -B[j];
    }
    if (k == horizon) break;
    for (int i = 0; i < 2; ++i) {
      const double *R = qp.R(k) + i * qp.dims.ldux, *S = qp.S(k) + i * qp.dims.ldux;
      right(k * per_stage + i) = -qp.r(k)[i];
      for (int j = 0; j < 2; ++j) kkt(k * per_stage + i, k * per_stage + j) = R[j];
      for (int j = 0; j < states; ++j) kkt(k * per_stage + i, x_at(k) + j) = kkt(x_at(k) + j, k * per_stage + i) = S[j];
    }
  }
  kkt.topRightCorner(unknowns, rows) = kkt.bottomLeftCorner(rows, unknowns).transpose();
  const Eigen::VectorXd dense = kkt.partialPivLu().solve(right);

  OcpQpSolver solver(horizon, states);
  const OcpQpSolverStatistics statistics = solver.solve(qp, x0.data(), {});
  ASSERT_TRUE(statistics.exact);
  EXPECT_EQ(statistics.active_set_iter, 1);
  for (int k = 0; k < horizon; ++k) {
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(solver.u(k)[i], dense(k * per_stage + i), 1e-10);
    for (int i = 0; i < states; ++i) EXPECT_NEAR(solver.x(k + 1)[i], dense(x_at(k + 1) + i), 1e-10);
  }
}

TEST(OcpQp, ALinearPenaltyHoldsARowAtItsEdge) {
  std::mt19937_64 random(5);
  int held = 0, past = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const ProgramShape shape{.N = 20, .nx = 8, .Z = 40, .z = 0.3};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(8, random);
    OcpQpSolver solver(shape.N, shape.nx);
    for (const OcpQpSolverOptions& options : {OcpQpSolverOptions{}, interior_only()}) {
      solver.reset();
      ASSERT_TRUE(solver.solve(qp, x0.data(), options).solved) << "trial " << trial;
      EXPECT_LT(residuals(qp, solver).worst(), 1e-4) << "trial " << trial;
    }
    for (int k = 1; k <= shape.N; ++k) {
      const BoundStatus side = solver.status(k)[con_g];
      held += side == BoundStatus::lower_active || side == BoundStatus::upper_active ? 1 : 0;
      past += side == BoundStatus::lower_violated || side == BoundStatus::upper_violated ? 1 : 0;
    }
  }
  EXPECT_GT(held, 50);
  EXPECT_GT(past, 50);
}

TEST(OcpQp, TheDynamicsMultipliersAreTheDerivativeOfTheOptimalCost) {
  std::mt19937_64 random(6);
  const ProgramShape shape{.N = 15, .nx = 6};
  OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(6, random);
  OcpQpSolver solver(shape.N, shape.nx);
  const auto optimum = [&] {
    EXPECT_TRUE(solver.solve(qp, x0.data(), {}).exact);
    return rolled_out_cost(qp, x0, inputs_of(solver, shape.N));
  };
  optimum();
  Buffer pi(static_cast<std::size_t>((shape.N + 1) * qp.dims.ldx));
  solver.get_pi(qp, pi.data());
  for (const int k : {1, 7, 15}) {
    double& c = qp.b(k - 1)[1];
    const double before = c, h = 1e-4;
    c = before + h;
    const double more = optimum();
    c = before - h;
    const double less = optimum();
    c = before;
    EXPECT_NEAR((more - less) / (2 * h), pi.data()[k * qp.dims.ldx + 1], 1e-4);
  }
}

TEST(OcpQp, AKnownActiveSetTakesOneSweep) {
  std::mt19937_64 random(7);
  const ProgramShape shape{.N = 50, .nx = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.N, shape.nx);
  EXPECT_GT(solver.solve(qp, x0.data(), {}).active_set_iter, 1);
  const auto first = inputs_of(solver, shape.N);
  const OcpQpSolverStatistics again = solver.solve(qp, x0.data(), {});
  EXPECT_TRUE(again.exact);
  EXPECT_EQ(again.active_set_iter, 1);
  EXPECT_EQ(again.ip_iter, 0);
  const auto second = inputs_of(solver, shape.N);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i], second[i], 1e-8);
}

TEST(OcpQp, AnyGuessOfTheActiveSetLeadsToTheSameSolution) {
  std::mt19937_64 random(8);
  const ProgramShape shape{.N = 30, .nx = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.N, shape.nx);
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  const auto expected = inputs_of(solver, shape.N);
  for (int trial = 0; trial < 20; ++trial) {
    for (int k = 0; k <= shape.N; ++k) {
      for (int row = 0; row < con_x + 1; ++row)
        solver.status(k)[row] = static_cast<BoundStatus>(static_cast<int>(random() % 3) - 1);
      solver.status(k)[con_g] = static_cast<BoundStatus>(2 * (static_cast<int>(random() % 3) - 1));
    }
    ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved) << "trial " << trial;
    const auto found = inputs_of(solver, shape.N);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << "trial " << trial;
  }
}

TEST(OcpQp, DegenerateBoundsAreNoTrouble) {
  std::mt19937_64 random(9);
  const ProgramShape shape{.N = 20, .nx = 8};
  OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.N, shape.nx);
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).exact);
  // Bounds that touch the solution without pushing, and an input that is fixed.
  for (int k = 0; k < shape.N; ++k) {
    if (solver.status(k)[0] == BoundStatus::inactive) qp.ub(k)[0] = solver.u(k)[0];
  }
  const auto before = inputs_of(solver, shape.N);
  solver.reset();
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  const auto touched = inputs_of(solver, shape.N);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(before[i], touched[i], 1e-6);

  qp.lb(3)[1] = qp.ub(3)[1] = 0.25;
  solver.reset();
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  EXPECT_NEAR(solver.u(3)[1], 0.25, 1e-8);
  const Residuals off = residuals(qp, solver);
  EXPECT_LT(off.dynamics, 1e-9);
  EXPECT_LT(off.stationarity, 2e-5);
  EXPECT_LT(off.bounds, 1e-7);
  EXPECT_LT(off.complementarity, 2e-5);
  EXPECT_LT(off.softness, 1e-3);
}

TEST(OcpQp, ARowThatCannotBeReachedIsReported) {
  std::mt19937_64 random(10);
  const ProgramShape shape{.N = 10, .nx = 8};
  OcpQp qp = random_program(shape, random);
  qp.lb(1)[con_x] = 5;  // one step moves the steering by 0.1 at most
  qp.ub(1)[con_x] = 6;
  OcpQpSolver solver(shape.N, shape.nx);
  EXPECT_FALSE(solver.solve(qp, nullptr, {}).solved);
}

TEST(OcpQp, WhatIsNotConvexOrNotFiniteIsReportedAndForgotten) {
  std::mt19937_64 random(11);
  const ProgramShape shape{.N = 10, .nx = 8};
  const OcpQp good = random_program(shape, random);
  OcpQpSolver solver(shape.N, shape.nx);
  for (const double poison : {std::nan(""), infinity, -1e6}) {
    OcpQp bad = good;
    bad.R(4)[0] = poison;
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    bad = good;
    bad.b(4)[2] = poison > 0 ? poison : std::nan("");
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    bad = good;
    bad.A(4)[3 * bad.dims.ldux + 1] = std::nan("");
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    solver.reset();
    EXPECT_TRUE(solver.solve(good, nullptr, {}).solved);
    EXPECT_LT(residuals(good, solver).worst(), 2e-5);
  }
}

TEST(OcpQp, MirroredProgramsHaveMirroredSolutions) {
  std::mt19937_64 random(13);
  const ProgramShape shape{.N = 30, .nx = 8};
  const OcpQp qp = random_program(shape, random);
  OcpQp mirrored = qp;
  for (int k = 0; k <= shape.N; ++k) {
    for (int row = 0; row < con_count; ++row) {
      mirrored.lb(k)[row] = -qp.ub(k)[row];
      mirrored.ub(k)[row] = -qp.lb(k)[row];
    }
    for (int i = 0; i < qp.dims.ldux; ++i) mirrored.r(k)[i] = -qp.r(k)[i];  // q too
    for (int i = 0; k < shape.N && i < qp.dims.ldx; ++i) mirrored.b(k)[i] = -qp.b(k)[i];
  }
  OcpQpSolver one(shape.N, shape.nx), other(shape.N, shape.nx);
  for (const OcpQpSolverOptions& options : {OcpQpSolverOptions{}, interior_only()}) {
    ASSERT_TRUE(one.solve(qp, nullptr, options).solved);
    ASSERT_TRUE(other.solve(mirrored, nullptr, options).solved);
    for (int k = 0; k < shape.N; ++k) {
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(one.u(k)[i], -other.u(k)[i], 1e-9);
    }
  }
}

TEST(OcpQp, SolvingAllocatesNothing) {
  if (!gripline::rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  std::mt19937_64 random(14);
  for (const int states : {8, 12, 20}) {
    const ProgramShape shape{.N = 50, .nx = states};
    const OcpQp qp = random_program(shape, random);
    OcpQpSolver solver(shape.N, shape.nx);
    const OcpQpSolverOptions interior = interior_only(), usual{};
    const long before = gripline::rig::allocations.load();
    const bool solved = solver.solve(qp, nullptr, interior).solved && solver.solve(qp, nullptr, usual).solved;
    EXPECT_EQ(gripline::rig::allocations.load(), before) << states << " states";
    EXPECT_TRUE(solved);
  }
}

TEST(OcpQp, TheSameProgramGivesTheSameBytes) {
  std::mt19937_64 random(15);
  const ProgramShape shape{.N = 50, .nx = 8};
  const OcpQp qp = random_program(shape, random);
  OcpQpSolver one(shape.N, shape.nx), other(shape.N, shape.nx);
  ASSERT_TRUE(one.solve(qp, nullptr, interior_only()).solved);
  ASSERT_TRUE(other.solve(qp, nullptr, interior_only()).solved);
  EXPECT_EQ(inputs_of(one, shape.N), inputs_of(other, shape.N));
}

}  // namespace test_ocp_qp_solver
