// The stage-wise quadratic program inside the mpc_sqp plugin, and its solver.
#include "controllers/mpc_sqp/ocp_qp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "controllers/mpc_sqp/active_set.hpp"
#include "controllers/mpc_sqp/interior_point.hpp"
#include "controllers/mpc_sqp/riccati.hpp"
#include "support/allocation_counter.hpp"
#include "support/ocp_support.hpp"

namespace {

using namespace gripline::ocp;
using namespace gripline::testing_support;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<double> random_state(int states, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<double> x(static_cast<std::size_t>(states));
  for (double& v : x) v = normal(random);
  return x;
}

QpOptions interior_only() {
  QpOptions options;
  options.active_set_iterations = 0;
  return options;
}

std::vector<double> inputs_of(const OcpQpSolver& solver, int horizon) {
  std::vector<double> u;
  for (int k = 0; k < horizon; ++k) u.insert(u.end(), solver.input(k), solver.input(k) + 2);
  return u;
}

int held_rows(const OcpQp& qp, const OcpQpSolver& solver, Row row) {
  int count = 0;
  for (int k = 0; k <= qp.horizon(); ++k) count += solver.side(k)[row] != Side::free ? 1 : 0;
  return count;
}

TEST(OcpQp, RandomProgramsMeetTheirConditionsOfOptimality) {
  std::mt19937_64 random(1);
  int interior = 0, held[row_count] = {};
  for (int trial = 0; trial < 200; ++trial) {
    const int states[] = {4, 8, 8, 10, 16, 21};
    const ProgramShape shape{.horizon = trial % 2 ? 50 : 12,
                             .states = states[trial % 6],
                             .soft_quadratic = trial % 3 ? 100.0 : 1e4,
                             .pull = trial % 4 ? 1.0 : 5.0};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.states, random);
    OcpQpSolver solver(shape.horizon, shape.states);
    const QpReport report = solver.solve(qp, x0.data(), {});
    ASSERT_TRUE(report.solved) << "trial " << trial;
    EXPECT_LT(residuals(qp, solver).worst(), 2e-5 * shape.pull * (1 + shape.soft_quadratic / 100)) << "trial " << trial;
    interior += report.interior_iterations > 0 ? 1 : 0;
    for (int row = 0; row < row_count; ++row) held[row] += held_rows(qp, solver, static_cast<Row>(row));
  }
  for (const int count : held) EXPECT_GT(count, 50);  // every kind of bound was at work
  EXPECT_GT(interior, 20);                            // and both methods
  EXPECT_LT(interior, 180);
}

TEST(OcpQp, TheInteriorPointMethodAloneFindsTheSameSolutions) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const ProgramShape shape{.horizon = 30, .states = 8, .soft_quadratic = trial % 2 ? 100.0 : 1e4};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.states, random);
    OcpQpSolver by_sides(shape.horizon, shape.states), by_interior(shape.horizon, shape.states);
    ASSERT_TRUE(by_sides.solve(qp, x0.data(), {}).solved);
    const QpReport report = by_interior.solve(qp, x0.data(), interior_only());
    ASSERT_TRUE(report.solved) << "trial " << trial;
    EXPECT_GT(report.interior_iterations, 0);
    EXPECT_LE(report.interior_iterations, 25);
    for (int k = 0; k < shape.horizon; ++k) {
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(by_sides.input(k)[i], by_interior.input(k)[i], 1e-6);
    }
  }
}

TEST(OcpQp, AnInteriorSolutionWithoutExactFinishIsOptimalToItsTolerance) {
  std::mt19937_64 random(12);
  const ProgramShape shape{.horizon = 30, .states = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  Point point(shape.horizon, shape.states);
  point.start(x0.data(), shape.states);
  const auto riccati = make_riccati(shape.horizon, shape.states);
  ActiveSet sides(shape.horizon);
  ASSERT_TRUE(sides.measure_stiffness(qp, *riccati, point));
  InteriorPoint interior(shape.horizon, shape.states);
  interior.start(qp, *riccati, point);
  InteriorPoint::State state = InteriorPoint::State::suggests;
  while (state == InteriorPoint::State::suggests) state = interior.iterate(qp, *riccati, point, 1e-9, 40);
  ASSERT_EQ(state, InteriorPoint::State::converged);
  interior.solution(point);
  OcpQpSolver exact(shape.horizon, shape.states);
  ASSERT_TRUE(exact.solve(qp, x0.data(), {}).exact);
  for (int k = 0; k < shape.horizon; ++k) {
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(point.stage(k)[i], exact.input(k)[i], 1e-6);
  }
}

TEST(OcpQp, NoFeasibleNeighbourIsCheaper) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    const ProgramShape shape{.horizon = 20, .states = 8, .soft_linear = trial % 2 ? 0.5 : 0.0};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(shape.states, random);
    OcpQpSolver solver(shape.horizon, shape.states);
    ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
    const auto best = inputs_of(solver, shape.horizon);
    const double cost = rolled_out_cost(qp, x0, best);
    ASSERT_TRUE(std::isfinite(cost));
    for (int neighbour = 0; neighbour < 200; ++neighbour) {
      auto u = best;
      const double reach = std::pow(10.0, -1.0 - neighbour % 4);
      const int from = neighbour % shape.horizon;
      for (int k = from; k < std::min(shape.horizon, from + 3); ++k) {
        for (int i = 0; i < 2; ++i) {
          double& v = u[static_cast<std::size_t>(2 * k + i)];
          v = std::clamp(v + reach * normal(random), qp.lower(k)[i], qp.upper(k)[i]);
        }
      }
      EXPECT_GE(rolled_out_cost(qp, x0, u), cost - 1e-9);
    }
  }
}

TEST(OcpQp, WithoutBoundsItIsTheDenseLinearSystem) {
  std::mt19937_64 random(4);
  const int horizon = 6, states = 5, per_stage = states + 2;
  OcpQp qp = random_program({.horizon = horizon, .states = states}, random);
  for (int k = 0; k <= horizon; ++k) {
    std::fill_n(qp.lower(k), row_count, -infinity);
    std::fill_n(qp.upper(k), row_count, infinity);
  }
  const auto x0 = random_state(states, random);
  // Unknowns: z_0 .. z_N-1 = (u, x), x_N, then the multipliers of x_0 and of every link.
  const int unknowns = horizon * per_stage + states, rows = (horizon + 1) * states;
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(unknowns + rows, unknowns + rows);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns + rows);
  const auto x_at = [&](int k) { return k == horizon ? horizon * per_stage : k * per_stage + 2; };
  for (int k = 0; k <= horizon; ++k) {
    for (int i = 0; i < states; ++i) {
      right(x_at(k) + i) = -qp.links.gradient(k)[4 + i];
      for (int j = 0; j < states; ++j) kkt(x_at(k) + i, x_at(k) + j) = qp.links.hessian_x(k)[i * qp.links.n + j];
      kkt(unknowns + k * states + i, x_at(k) + i) = 1;
      right(unknowns + k * states + i) = k == 0 ? x0[static_cast<std::size_t>(i)] : qp.links.offset(k - 1)[i];
      if (k == 0) continue;
      const double* m = qp.links.link(k - 1) + i * qp.links.width;
      for (int j = 0; j < states; ++j) kkt(unknowns + k * states + i, x_at(k - 1) + j) = -m[4 + j];
      for (int j = 0; j < 2; ++j) kkt(unknowns + k * states + i, (k - 1) * per_stage + j) = -m[j];
    }
    if (k == horizon) break;
    for (int i = 0; i < 2; ++i) {
      const double* h = qp.links.hessian_u(k) + i * qp.links.width;
      right(k * per_stage + i) = -qp.links.gradient(k)[i];
      for (int j = 0; j < 2; ++j) kkt(k * per_stage + i, k * per_stage + j) = h[j];
      for (int j = 0; j < states; ++j)
        kkt(k * per_stage + i, x_at(k) + j) = kkt(x_at(k) + j, k * per_stage + i) = h[4 + j];
    }
  }
  kkt.topRightCorner(unknowns, rows) = kkt.bottomLeftCorner(rows, unknowns).transpose();
  const Eigen::VectorXd dense = kkt.partialPivLu().solve(right);

  OcpQpSolver solver(horizon, states);
  const QpReport report = solver.solve(qp, x0.data(), {});
  ASSERT_TRUE(report.exact);
  EXPECT_EQ(report.active_set_iterations, 1);
  for (int k = 0; k < horizon; ++k) {
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(solver.input(k)[i], dense(k * per_stage + i), 1e-10);
    for (int i = 0; i < states; ++i) EXPECT_NEAR(solver.state(k + 1)[i], dense(x_at(k + 1) + i), 1e-10);
  }
}

TEST(OcpQp, ALinearPenaltyHoldsARowAtItsEdge) {
  std::mt19937_64 random(5);
  int held = 0, past = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const ProgramShape shape{.horizon = 20, .states = 8, .soft_quadratic = 20, .soft_linear = 0.3};
    const OcpQp qp = random_program(shape, random);
    const auto x0 = random_state(8, random);
    OcpQpSolver solver(shape.horizon, shape.states);
    for (const QpOptions& options : {QpOptions{}, interior_only()}) {
      solver.forget_guess();
      ASSERT_TRUE(solver.solve(qp, x0.data(), options).solved) << "trial " << trial;
      EXPECT_LT(residuals(qp, solver).worst(), 1e-4) << "trial " << trial;
    }
    for (int k = 1; k <= shape.horizon; ++k) {
      const Side side = solver.side(k)[row_soft];
      held += side == Side::at_lower || side == Side::at_upper ? 1 : 0;
      past += side == Side::past_lower || side == Side::past_upper ? 1 : 0;
    }
  }
  EXPECT_GT(held, 50);
  EXPECT_GT(past, 50);
}

TEST(OcpQp, TheDynamicsMultipliersAreTheDerivativeOfTheOptimalCost) {
  std::mt19937_64 random(6);
  const ProgramShape shape{.horizon = 15, .states = 6};
  OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(6, random);
  OcpQpSolver solver(shape.horizon, shape.states);
  const auto optimum = [&] {
    EXPECT_TRUE(solver.solve(qp, x0.data(), {}).exact);
    return rolled_out_cost(qp, x0, inputs_of(solver, shape.horizon));
  };
  optimum();
  Buffer pi(static_cast<std::size_t>((shape.horizon + 1) * qp.links.n));
  solver.dynamics_multipliers(qp, pi.data());
  for (const int k : {1, 7, 15}) {
    double& c = qp.links.offset(k - 1)[1];
    const double before = c, h = 1e-4;
    c = before + h;
    const double more = optimum();
    c = before - h;
    const double less = optimum();
    c = before;
    EXPECT_NEAR((more - less) / (2 * h), pi.data()[k * qp.links.n + 1], 1e-4);
  }
}

TEST(OcpQp, AKnownActiveSetTakesOneSweep) {
  std::mt19937_64 random(7);
  const ProgramShape shape{.horizon = 50, .states = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.horizon, shape.states);
  EXPECT_GT(solver.solve(qp, x0.data(), {}).active_set_iterations, 1);
  const auto first = inputs_of(solver, shape.horizon);
  const QpReport again = solver.solve(qp, x0.data(), {});
  EXPECT_TRUE(again.exact);
  EXPECT_EQ(again.active_set_iterations, 1);
  EXPECT_EQ(again.interior_iterations, 0);
  const auto second = inputs_of(solver, shape.horizon);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i], second[i], 1e-8);
}

TEST(OcpQp, AnyGuessOfTheActiveSetLeadsToTheSameSolution) {
  std::mt19937_64 random(8);
  const ProgramShape shape{.horizon = 30, .states = 8};
  const OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.horizon, shape.states);
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  const auto expected = inputs_of(solver, shape.horizon);
  for (int trial = 0; trial < 20; ++trial) {
    for (int k = 0; k <= shape.horizon; ++k) {
      for (int row = 0; row < row_state + 1; ++row)
        solver.side(k)[row] = static_cast<Side>(static_cast<int>(random() % 3) - 1);
      solver.side(k)[row_soft] = static_cast<Side>(2 * (static_cast<int>(random() % 3) - 1));
    }
    ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved) << "trial " << trial;
    const auto found = inputs_of(solver, shape.horizon);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << "trial " << trial;
  }
}

TEST(OcpQp, DegenerateBoundsAreNoTrouble) {
  std::mt19937_64 random(9);
  const ProgramShape shape{.horizon = 20, .states = 8};
  OcpQp qp = random_program(shape, random);
  const auto x0 = random_state(8, random);
  OcpQpSolver solver(shape.horizon, shape.states);
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).exact);
  // Bounds that touch the solution without pushing, and an input that is fixed.
  for (int k = 0; k < shape.horizon; ++k) {
    if (solver.side(k)[0] == Side::free) qp.upper(k)[0] = solver.input(k)[0];
  }
  const auto before = inputs_of(solver, shape.horizon);
  solver.forget_guess();
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  const auto touched = inputs_of(solver, shape.horizon);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(before[i], touched[i], 1e-6);

  qp.lower(3)[1] = qp.upper(3)[1] = 0.25;
  solver.forget_guess();
  ASSERT_TRUE(solver.solve(qp, x0.data(), {}).solved);
  EXPECT_NEAR(solver.input(3)[1], 0.25, 1e-8);
  const Residuals off = residuals(qp, solver);
  EXPECT_LT(off.dynamics, 1e-9);
  EXPECT_LT(off.stationarity, 2e-5);
  EXPECT_LT(off.bounds, 1e-7);
  EXPECT_LT(off.complementarity, 2e-5);
  EXPECT_LT(off.softness, 1e-3);
}

TEST(OcpQp, ARowThatCannotBeReachedIsReported) {
  std::mt19937_64 random(10);
  const ProgramShape shape{.horizon = 10, .states = 8};
  OcpQp qp = random_program(shape, random);
  qp.lower(1)[row_state] = 5;  // one step moves the steering by 0.1 at most
  qp.upper(1)[row_state] = 6;
  OcpQpSolver solver(shape.horizon, shape.states);
  EXPECT_FALSE(solver.solve(qp, nullptr, {}).solved);
}

TEST(OcpQp, WhatIsNotConvexOrNotFiniteIsReportedAndForgotten) {
  std::mt19937_64 random(11);
  const ProgramShape shape{.horizon = 10, .states = 8};
  const OcpQp good = random_program(shape, random);
  OcpQpSolver solver(shape.horizon, shape.states);
  for (const double poison : {std::nan(""), infinity, -1e6}) {
    OcpQp bad = good;
    bad.links.hessian_u(4)[0] = poison;
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    bad = good;
    bad.links.offset(4)[2] = poison > 0 ? poison : std::nan("");
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    bad = good;
    bad.links.link(4)[3 * bad.links.width + 5] = std::nan("");
    EXPECT_FALSE(solver.solve(bad, nullptr, {}).solved);
    solver.forget_guess();
    EXPECT_TRUE(solver.solve(good, nullptr, {}).solved);
    EXPECT_LT(residuals(good, solver).worst(), 2e-5);
  }
}

TEST(OcpQp, MirroredProgramsHaveMirroredSolutions) {
  std::mt19937_64 random(13);
  const ProgramShape shape{.horizon = 30, .states = 8};
  const OcpQp qp = random_program(shape, random);
  OcpQp mirrored = qp;
  for (int k = 0; k <= shape.horizon; ++k) {
    for (int row = 0; row < row_count; ++row) {
      mirrored.lower(k)[row] = -qp.upper(k)[row];
      mirrored.upper(k)[row] = -qp.lower(k)[row];
    }
    for (int i = 0; i < qp.links.width; ++i) mirrored.links.gradient(k)[i] = -qp.links.gradient(k)[i];
    for (int i = 0; k < shape.horizon && i < qp.links.n; ++i) mirrored.links.offset(k)[i] = -qp.links.offset(k)[i];
  }
  OcpQpSolver one(shape.horizon, shape.states), other(shape.horizon, shape.states);
  for (const QpOptions& options : {QpOptions{}, interior_only()}) {
    ASSERT_TRUE(one.solve(qp, nullptr, options).solved);
    ASSERT_TRUE(other.solve(mirrored, nullptr, options).solved);
    for (int k = 0; k < shape.horizon; ++k) {
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(one.input(k)[i], -other.input(k)[i], 1e-9);
    }
  }
}

TEST(OcpQp, SolvingAllocatesNothing) {
  if (!gripline::rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  std::mt19937_64 random(14);
  for (const int states : {8, 12, 20}) {
    const ProgramShape shape{.horizon = 50, .states = states};
    const OcpQp qp = random_program(shape, random);
    OcpQpSolver solver(shape.horizon, shape.states);
    const QpOptions interior = interior_only(), usual{};
    const long before = gripline::rig::allocations.load();
    const bool solved = solver.solve(qp, nullptr, interior).solved && solver.solve(qp, nullptr, usual).solved;
    EXPECT_EQ(gripline::rig::allocations.load(), before) << states << " states";
    EXPECT_TRUE(solved);
  }
}

TEST(OcpQp, TheSameProgramGivesTheSameBytes) {
  std::mt19937_64 random(15);
  const ProgramShape shape{.horizon = 50, .states = 8};
  const OcpQp qp = random_program(shape, random);
  OcpQpSolver one(shape.horizon, shape.states), other(shape.horizon, shape.states);
  ASSERT_TRUE(one.solve(qp, nullptr, interior_only()).solved);
  ASSERT_TRUE(other.solve(qp, nullptr, interior_only()).solved);
  EXPECT_EQ(inputs_of(one, shape.horizon), inputs_of(other, shape.horizon));
}

}  // namespace
