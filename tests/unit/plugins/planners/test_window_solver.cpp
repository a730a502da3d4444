#include "planners/time_optimal/window_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "planners/time_optimal/lap_solver.hpp"
#include "support/allocation_counter.hpp"
#include "support/swinging_road.hpp"

namespace gripline {
namespace test_window_solver {

using namespace time_optimal;
using namespace testing_support;

constexpr std::size_t nodes = swinging_nodes, window = 80;

class WindowSolverTest : public ::testing::Test {
 protected:
  /// The window from node `first` with a falling barrier, near the states of a solved lap at both ends.
  WindowStep solve(WindowSolver& solver, std::vector<WindowNode>& lap, const LapSolution& solved, std::size_t first,
                   double barrier, int most) {
    WindowStep step;
    for (int i = 0; i < most; ++i) {
      step = solver.iterate(lap, first, window, barrier, solved.z[first], solved.z[first + window]);
      if (!step.good || step.change > 5e-3 || step.defect > 1e-4) continue;
      if (barrier <= 1e-5) break;
      barrier = std::max(1e-5, 0.2 * barrier);
    }
    return step;
  }
  static std::vector<WindowNode> nodes_of(const LapSolution& from) {
    std::vector<WindowNode> lap(nodes);
    for (std::size_t k = 0; k < nodes; ++k) lap[k].z = from.z[k];
    return lap;
  }
};

// What only windows are solved for would else be left out silently.
TEST(SolveLap, RefusesWhatOnlyAWindowIsSolvedFor) {
  LapProblem shares = swinging_road(0.8), bounds = swinging_road(0.8);
  shares.use.sharing.ratio = 1.1;
  bounds.use.small_slip_from_speed = 3.0;
  for (const LapProblem* problem : {&shares, &bounds})
    EXPECT_THROW(solve_lap(*problem, guess_for(*problem), 1), std::invalid_argument);
  EXPECT_NO_THROW(solve_lap(swinging_road(0.8), guess_for(shares), 1));
}

TEST_F(WindowSolverTest, FindsTheLapThatIpoptFinds) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution guess = guess_for(problem), solved = solve_lap(problem, guess);
  ASSERT_TRUE(solved.solved);
  WindowSolver solver(problem, window);
  solver.set_car(problem.tyres, {});
  const std::size_t first = 20;
  std::vector<WindowNode> lap = nodes_of(guess);
  lap[first].z = solved.z[first];
  const WindowStep step = solve(solver, lap, solved, first, 1e-2, 200);
  EXPECT_TRUE(step.good);
  EXPECT_LT(step.defect, 1e-4);
  // What alternates from node to node is invisible to the midpoint rule: means of neighbours. The last quarter of the
  // window depends on how it is made to end; the planner does not use it.
  for (std::size_t k = first + 2; k < first + window * 3 / 4; ++k)
    for (const int j : {lap_n, lap_vx}) {
      const auto i = static_cast<std::size_t>(j);
      const auto mean = [&](const auto& z) { return 0.25 * (z(k - 1) + 2.0 * z(k) + z(k + 1)); };
      const double own = mean([&](std::size_t at) { return lap[at].z[i]; });
      const double ipopt = mean([&](std::size_t at) { return solved.z[at][i]; });
      EXPECT_NEAR(own, ipopt, j == lap_n ? 0.01 : 0.04) << "node " << k << ", variable " << j;
    }
}

TEST_F(WindowSolverTest, FollowsChangedTyresWithoutAllocating) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution solved = solve_lap(problem, guess_for(problem));
  WindowSolver solver(problem, window);
  solver.set_car(problem.tyres, {});
  std::vector<WindowNode> lap = nodes_of(solved);
  solve(solver, lap, solved, 20, 1e-2, 200);
  const long allocated = rig::allocations.load();
  for (int i = 1; i <= 5; ++i) {
    AxleTyres tyres = problem.tyres;
    tyres.front.D *= 1.0 - 0.02 * i;
    tyres.rear.D *= 1.0 - 0.02 * i;
    solver.set_car(tyres, {});
    solve(solver, lap, solved, 20, 1e-4, 20);
  }
  const WindowStep last = solve(solver, lap, solved, 20, 1e-4, 60);
  EXPECT_LT(last.defect, 5e-3);
  EXPECT_EQ(rig::allocations.load(), allocated);
}

// What is planned near a window's end keeps away from constraints, by a barrier that rises to `end_barrier`.
TEST_F(WindowSolverTest, TheBarrierRisesTowardsTheEnd) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution solved = solve_lap(problem, guess_for(problem));
  WindowSolver solver(problem, window);
  std::vector<WindowNode> lap = nodes_of(solved);
  constexpr std::size_t first = 20;
  const WindowStep last = solve(solver, lap, solved, first, 1e-2, 200);
  ASSERT_LT(last.change, 5e-3);
  const auto barrier = [&](std::size_t k) {  // of a constraint that does not hold, as it follows the barrier at once
    return lap[first + k].t[xi_most] * lap[first + k].lambda[xi_most];
  };
  EXPECT_NEAR(barrier(WindowSolver::near_part(window) / 2), 1e-5, 2e-6);
  EXPECT_NEAR(barrier(window - 1), WindowSolver::end_barrier, 0.2 * WindowSolver::end_barrier);
  EXPECT_GT(barrier(window - 8), 2e-5);
}

// Larger slips leave every constraint on them more than before: an iterate does not violate anything for that.
TEST_F(WindowSolverTest, BoundsThatMoveAwayAreNotViolated) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution solved = solve_lap(problem, guess_for(problem));
  WindowSolver solver(problem, window);
  std::vector<WindowNode> lap = nodes_of(solved);
  solve(solver, lap, solved, 20, 1e-2, 200);
  solver.set_slip_bound_slow_car(1.2);
  solver.set_car(problem.tyres, {});
  const WindowStep step = solver.iterate(lap, 20, window, 1e-5, solved.z[20], solved.z[20 + window]);
  EXPECT_TRUE(step.good);
  EXPECT_LT(step.defect, 0.05);  // they moved by 0.5
}

/// A car of full size on the same road, fifty times as large, on half the friction of a dry road.
LapProblem full_size_road(bool mirrored) {
  constexpr double size = 50.0;
  LapProblem p = swinging_road(0.5);
  p.car.m = 1265;
  p.car.Iz = 2093;
  p.car.lf = 1.34;
  p.car.lr = 1.30;
  p.car.ddelta_max = 1.0;
  const double weight = 0.5 * gravity / (p.car.lf + p.car.lr);
  p.tyres = {{10.0, 1.5, weight * p.car.lr}, {10.0, 1.5, weight * p.car.lf}};
  p.drive = {CubicSpline(0, 50, std::vector<double>{-0.1, -0.2, -0.4, -0.7, -1.1}),
             CubicSpline(0, 50, std::vector<double>{7, 6, 5, 4, 3}),
             CubicSpline(0, 50, std::vector<double>{7, 7, 7, 7, 7})};
  p.top_speed = 50.0;
  p.use.combined = 1.0;
  for (std::size_t k = 0; k < nodes; ++k) {
    p.places[k].kappa *= (mirrored ? -1.0 : 1.0) / size;
    p.ds[k] *= size;
    p.n_hi[k] = p.mid_hi[k] = 3.0;
    p.n_lo[k] = p.mid_lo[k] = -3.0;
  }
  return p;
}

LapSolution full_size_guess(const LapProblem& p) { return guess_for(p, 35.0, 4.0); }

/// The rates of an interval of a solved lap, in its middle.
LapRates<double> rates_in(const LapProblem& p, const std::vector<WindowNode>& lap, std::size_t k,
                          double (&z)[lap_variables]) {
  for (std::size_t j = 0; j < lap_variables; ++j)
    z[j] = j < lap_states ? 0.5 * (lap[k].z[j] + lap[k + 1].z[j]) : lap[k].z[j];
  return lap_rates(p.car, p.tyres, p.drive.coast, p.places[k], z);
}

class FullSizeWindowSolverTest : public WindowSolverTest {
 protected:
  static constexpr std::size_t first = 20;
  std::vector<WindowNode> solved(const LapProblem& problem) {
    const LapSolution guess = full_size_guess(problem);
    WindowSolver solver(problem, window);
    std::vector<WindowNode> lap = nodes_of(guess);
    last_ = solve(solver, lap, guess, first, 1e-2, 150);
    return lap;
  }
  WindowStep last_;
};

// The friction circle is curved, and a change of the plan by a share of it violates it by the square of that share, in
// every interval at once.
TEST_F(FullSizeWindowSolverTest, TakesLongStepsAlongTheFrictionCircle) {
  const LapProblem problem = full_size_road(false);
  const LapSolution guess = full_size_guess(problem);
  WindowSolver solver(problem, window);
  std::vector<WindowNode> lap = nodes_of(guess);
  int steps = 0;
  for (double barrier = 1e-2; barrier > 3e-4; barrier *= 0.2) {
    WindowStep step;
    do {
      step = solver.iterate(lap, first, window, barrier, guess.z[first], guess.z[first + window]);
    } while (++steps < 100 && !(step.good && step.near_change < 0.02 && step.near_defect < 2e-3));
  }
  EXPECT_LT(steps, 30);
}

TEST_F(FullSizeWindowSolverTest, PlansNoSlipBeyondThePeakOfATyreInTurnsOfEitherSide) {
  double time[2] = {0, 0};
  for (const bool mirrored : {false, true}) {
    const LapProblem problem = full_size_road(mirrored);
    const std::vector<WindowNode> lap = solved(problem);
    EXPECT_LT(last_.near_defect, 2e-3);
    const double peak = std::tan(0.5 * std::numbers::pi / 1.5) / 10.0;
    double largest = 0;
    for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
      double z[lap_variables];
      const LapRates<double> r = rates_in(problem, lap, k, z);
      largest = std::max({largest, std::abs(r.slip_front), std::abs(r.slip_rear)});
      time[mirrored] += r.time * problem.ds[k];
    }
    EXPECT_LT(largest, peak + 2e-3);
    EXPECT_GT(largest, 0.5 * peak);
  }
  EXPECT_NEAR(time[0], time[1], 0.01 * time[0]);
}

TEST_F(FullSizeWindowSolverTest, EachAxleSharesTheFrictionOfItsLoad) {
  LapProblem problem = full_size_road(false);
  problem.use.sharing = {
      .ratio = 1.1, .drive_front = 0.4, .brake_front = 0.62, .load_front = -0.018, .load_rear = 0.017};
  const std::vector<WindowNode> lap = solved(problem);
  EXPECT_LT(last_.near_defect, 2e-3);
  double used[2] = {0, 0};
  for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
    double z[lap_variables];
    const LapRates<double> r = rates_in(problem, lap, k, z);
    const double a = z[lap_a];
    if (std::abs(a) < 2.0) continue;  // the front share goes from the brakes' to the drive's about 0
    const double front = a > 0 ? 0.4 : 0.62;
    const auto share = [&](double force, double along, double load, double D) {
      return std::hypot(force / D, along / (1.1 * D)) / (1.0 + load * a);
    };
    used[0] = std::max(used[0], share(r.front, front * a, -0.018, problem.tyres.front.D));
    used[1] = std::max(used[1], share(r.rear, (1.0 - front) * a, 0.017, problem.tyres.rear.D));
  }
  for (const double most : used) {
    EXPECT_LT(most, 1.03);
    EXPECT_GT(most, 0.8);
  }
}

// On a crest an axle has less friction to share, and is driven to that.
TEST_F(FullSizeWindowSolverTest, CrestsLeaveEachAxleLessFriction) {
  LapProblem problem = full_size_road(false);
  problem.use.sharing = {
      .ratio = 1.1, .drive_front = 0.4, .brake_front = 0.62, .load_front = -0.018, .load_rear = 0.017};
  const std::vector<WindowNode> level = solved(problem);
  for (LapPlace& place : problem.places) place.curve = -4e-4;
  const std::vector<WindowNode> crest = solved(problem);
  EXPECT_LT(last_.near_defect, 2e-3);
  double time[2] = {0, 0}, used = 0, relieved = 1;
  for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
    double z[lap_variables];
    time[0] += rates_in(problem, level, k, z).time * problem.ds[k];
    const LapRates<double> r = rates_in(problem, crest, k, z);
    time[1] += r.time * problem.ds[k];
    relieved = std::min(relieved, r.load);
    const double a = z[lap_a];
    if (std::abs(a) < 2.0) continue;
    const double front = a > 0 ? 0.4 : 0.62, D = problem.tyres.front.D;
    used = std::max(used, std::hypot(r.front / D, front * a / (1.1 * D)) / (r.load - 0.018 * a));
  }
  EXPECT_LT(relieved, 0.99);
  EXPECT_LT(used, 1.03);
  EXPECT_GT(used, 0.8);
  EXPECT_GT(time[1], time[0]);
}

}  // namespace test_window_solver
}  // namespace gripline
