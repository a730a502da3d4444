#include "planners/time_optimal/window_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "planners/time_optimal/lap_solver.hpp"
#include "support/allocation_counter.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_window_solver {

using namespace time_optimal;
using namespace testing_support;

constexpr std::size_t nodes = 200, window = 80;

/// A lap of 12 m whose curvature swings, for the 1:43 car.
LapProblem swinging_road(double mu) {
  const Car car = car_1_43();
  const double weight = mu * gravity / (car.lf + car.lr);
  LapProblem p{.car = car,
               .tyres = {{4.0, 1.3, weight * car.lr}, {4.0, 1.3, weight * car.lf}},
               .drive = {CubicSpline(0, 4, std::vector<double>{-0.5, -0.6, -0.8, -1.2, -1.6}),
                         CubicSpline(0, 4, std::vector<double>{7, 5.5, 4, 2.5, 1.6}),
                         CubicSpline(0, 4, std::vector<double>{1, 1.5, 1.8, 1.9, 2})},
               .top_speed = 4.0,
               .use = {.slip_bound = 0.7},
               .places = {},
               .ds = std::vector<double>(nodes, 12.0 / nodes),
               .n_lo = std::vector<double>(nodes, -0.15),
               .n_hi = std::vector<double>(nodes, 0.15),
               .mid_lo = std::vector<double>(nodes, -0.15),
               .mid_hi = std::vector<double>(nodes, 0.15)};
  for (std::size_t k = 0; k < nodes; ++k) {
    const double turn = 2.0 * std::numbers::pi, u = turn * static_cast<double>(k) / nodes;
    p.places.push_back({turn / 12.0 * (1.0 + 1.6 * std::cos(2.0 * u) + 0.8 * std::sin(5.0 * u)), 0.0, 0.0});
  }
  return p;
}

/// On the centre line, at 0.7 of a speed for which turns take the side force over mass `accel`, and straights `most`.
LapSolution guess_for(const LapProblem& p, double most = 2.5, double accel = 5.5) {
  LapSolution guess;
  for (const LapPlace& place : p.places) {
    const double v = 0.7 * std::min(most, std::sqrt(accel / std::max(1e-6, std::abs(place.kappa))));
    guess.z.push_back({0.0, 0.0, v, 0.0, v * place.kappa, (p.car.lf + p.car.lr) * place.kappa, 0.0, 0.0});
  }
  return guess;
}

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

/// The Newton step of a window as one dense system, in which states, inputs, slacks and all multipliers are unknown:
///   H dw + A' pi + J' lambda = -g,   A dw = -defect,   J dw + dt = -(c + t),   t lambda + lambda_now dt = mu
/// with derivatives by automatic differentiation, for a barrier that does not rise towards the end.
class DenseStep {
 public:
  DenseStep(const IntervalProgram& program, const std::vector<WindowNode>& lap, std::size_t first, int count)
      : program_(program),
        scale_(program.scales()),
        lap_(lap),
        first_(first),
        count_(count),
        g_(VectorXd::Zero(variables())),
        defect_(VectorXd::Zero(lap_states * count)),
        c_(VectorXd::Zero(interval_rows * count)),
        t_(c_),
        lambda_(c_),
        H_(MatrixXd::Zero(variables(), variables())),
        A_(MatrixXd::Zero(defect_.size(), variables())),
        J_(MatrixXd::Zero(c_.size(), variables())),
        middles_(H_) {
    for (int k = 0; k < count; ++k) add_interval(k);
  }
  /// Half the square of a node's distance from a state, times a weight.
  void add_end(int k, const std::array<double, lap_variables>& near, double weight) {
    for (int j = 0; j < lap_states; ++j) {
      const auto at = static_cast<std::size_t>(j);
      g_[state(k) + j] += weight * (node(k).z[at] - near[at]) / scale_[at];
      H_(state(k) + j, state(k) + j) += weight;
    }
  }
  /// Whether the program is convex along its dynamics with so much curvature added to the middles of the intervals.
  bool convex(double curvature) const {
    const MatrixXd barrier = J_.transpose() * lambda_.cwiseQuotient(t_).asDiagonal() * J_;
    const MatrixXd along = Eigen::FullPivLU<MatrixXd>(A_).kernel();
    return Eigen::LLT<MatrixXd>(along.transpose() * (H_ + barrier + curvature * middles_) * along).info() ==
           Eigen::Success;
  }
  void solve(double mu, double curvature) {
    const Eigen::Index n = g_.size(), m = defect_.size(), r = c_.size();
    MatrixXd system = MatrixXd::Zero(n + m + 2 * r, n + m + 2 * r);
    system.topRows(n) << H_ + curvature * middles_, A_.transpose(), J_.transpose(), MatrixXd::Zero(n, r);
    system.block(n, 0, m, n) = A_;
    system.block(n + m, 0, r, n) = J_;
    system.block(n + m, n + m + r, r, r).setIdentity();
    system.bottomRightCorner(r, 2 * r) << MatrixXd(t_.asDiagonal()), MatrixXd(lambda_.asDiagonal());
    VectorXd right(system.rows());
    right << -g_, -defect_, -(c_ + t_), VectorXd::Constant(r, mu);
    const VectorXd all = system.partialPivLu().solve(right);
    dw_ = all.head(n);
    pi_ = all.segment(n, m);
    full_lambda_ = all.segment(n + m, r);
    dt_ = all.tail(r);
  }
  /// Of the step, in units of the variables (SI); of the slacks; and the multipliers after a full step.
  double dz(int k, int j) const {
    return scale_[static_cast<std::size_t>(j)] * dw_[j < lap_states ? state(k) + j : input(k) + j - lap_states];
  }
  double pi(int k, int j) const { return pi_[lap_states * k + j]; }
  double slack(int k, int row) const { return t_[interval_rows * k + row]; }
  double dt(int k, int row) const { return dt_[interval_rows * k + row]; }
  double lambda(int k, int row) const { return full_lambda_[interval_rows * k + row]; }
  double largest_pi() const { return pi_.lpNorm<Eigen::Infinity>(); }
  /// Of a state or input half-way through an interval, in typical sizes.
  double largest_change() const {
    double largest = 0;
    for (int k = 0; k < count_; ++k) largest = std::max(largest, (to_middle(k) * dw_).lpNorm<Eigen::Infinity>());
    return largest;
  }

 private:
  using MatrixXd = Eigen::MatrixXd;
  using VectorXd = Eigen::VectorXd;
  using Dual = SecondOrderDual<lap_variables>;
  static constexpr int inputs = lap_variables - lap_states;

  int state(int k) const { return lap_states * k; }
  int input(int k) const { return lap_states * (count_ + 1) + inputs * k; }
  int variables() const { return input(count_); }
  std::size_t index(int k) const { return (first_ + static_cast<std::size_t>(k)) % lap_.size(); }
  const WindowNode& node(int k) const { return lap_[index(k)]; }

  /// How state and input half-way through an interval follow from all variables, in typical sizes.
  MatrixXd to_middle(int k) const {
    MatrixXd T = MatrixXd::Zero(lap_variables, variables());
    for (int j = 0; j < lap_states; ++j) T(j, state(k) + j) = T(j, state(k + 1) + j) = 0.5;
    for (int j = 0; j < inputs; ++j) T(lap_states + j, input(k) + j) = 1.0;
    return T;
  }
  VectorXd gradient(const Dual& f) const {
    VectorXd g(lap_variables);
    for (int j = 0; j < lap_variables; ++j) g[j] = f.g[j] * scale_[static_cast<std::size_t>(j)];
    return g;
  }
  MatrixXd hessian(const Dual& f) const {
    MatrixXd h(lap_variables, lap_variables);
    for (int i = 0; i < lap_variables; ++i)
      for (int j = 0; j < lap_variables; ++j)
        h(i, j) = f.h[Dual::entry(std::max(i, j), std::min(i, j))] * scale_[static_cast<std::size_t>(i)] *
                  scale_[static_cast<std::size_t>(j)];
    return h;
  }

  void add_interval(int k) {
    const std::size_t i = index(k);
    const MatrixXd T = to_middle(k);
    Dual z[lap_variables];
    for (int j = 0; j < lap_variables; ++j) {
      const auto at = static_cast<std::size_t>(j);
      z[j] = Dual::variable(j < lap_states ? 0.5 * (node(k).z[at] + node(k + 1).z[at]) : node(k).z[at], j);
    }
    const LapRates<Dual> rates = program_.rates(i, z);
    Dual lagrangian = program_.cost(i, z, rates);
    g_ += T.transpose() * gradient(lagrangian);
    for (int j = 0; j < lap_states; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const double step = program_.problem().ds[i] / scale_[at];
      defect_[state(k) + j] = (node(k + 1).z[at] - node(k).z[at]) / scale_[at] - step * rates.state[j].v;
      A_.row(state(k) + j) = -step * gradient(rates.state[j]).transpose() * T;
      A_(state(k) + j, state(k + 1) + j) += 1.0;
      A_(state(k) + j, state(k) + j) -= 1.0;
      lagrangian -= (step * node(k).pi[at]) * rates.state[j];
    }
    program_.curved_rows_of(i, z, rates, [&](int row, const Dual& value) {
      c_[interval_rows * k + row] = value.v;
      J_.row(interval_rows * k + row) = gradient(value).transpose() * T;
      lagrangian += node(k).lambda[static_cast<std::size_t>(row)] * value;
    });
    add_linear_rows(k, T);
    for (int row = interval_rows * k; row < interval_rows * (k + 1); ++row) {
      const auto at = static_cast<std::size_t>(row - interval_rows * k);
      t_[row] = std::max(node(k).t[at], -c_[row]);
      lambda_[row] = node(k).lambda[at];
    }
    H_ += T.transpose() * hessian(lagrangian) * T;
    middles_ += T.transpose() * T;
  }
  /// Their gradients are differences.
  void add_linear_rows(int k, const MatrixXd& T) {
    double z[lap_variables];
    for (std::size_t j = 0; j < lap_variables; ++j)
      z[j] = j < lap_states ? 0.5 * (node(k).z[j] + node(k + 1).z[j]) : node(k).z[j];
    const double next = node(k + 1).z[lap_n];
    const auto values = [&](double n_next) {
      VectorXd all(first_curved_row);
      program_.linear_rows(index(k), z, n_next, [&](int row, double value) { all[row] = value; });
      return all;
    };
    const VectorXd here = values(next);
    c_.segment(interval_rows * k, first_curved_row) = here;
    auto rows = J_.middleRows(interval_rows * k, first_curved_row);
    for (int j = 0; j < lap_variables; ++j) {
      const double before = z[j];
      z[j] += scale_[static_cast<std::size_t>(j)];
      rows += (values(next) - here) * T.row(j);
      z[j] = before;
    }
    rows.col(state(k + 1) + lap_n) += values(next + scale_[lap_n]) - here;
  }

  const IntervalProgram& program_;
  const std::array<double, lap_variables>& scale_;
  const std::vector<WindowNode>& lap_;
  std::size_t first_;
  int count_;
  VectorXd g_, defect_, c_, t_, lambda_;  // gradient of cost and ends; constraints, slacks and multipliers
  MatrixXd H_, A_, J_;                    // of the Lagrangian; of the dynamics; of the constraints
  MatrixXd middles_;                      // sum of T'T
  VectorXd dw_, pi_, full_lambda_, dt_;
};

/// A road with everything that a place can have, and how the car's axles share friction on it.
struct SmallWindow {
  std::string name;
  double combined = 0, ellipse = 0;
  std::size_t first = 30;
};

class NewtonStepTest : public ::testing::TestWithParam<SmallWindow> {
 protected:
  static constexpr int count = 6;
  static constexpr double mu = 1e-3;  // beyond that of a window's end

  NewtonStepTest() {
    for (std::size_t k = 0; k < nodes; ++k) {
      const double u = 2.0 * std::numbers::pi * static_cast<double>(k) / nodes;
      problem_.places[k].grade = 0.03 * std::sin(3.0 * u);
      problem_.places[k].bank = 0.05 * std::cos(7.0 * u);
      problem_.places[k].curve = 0.2 * std::sin(4.0 * u);
      problem_.ds[k] *= 1.0 + 0.3 * std::sin(9.0 * u);
    }
    problem_.use.combined = GetParam().combined;
    problem_.use.sharing = {GetParam().ellipse, 0.4, 0.62, 0.02, -0.015};
    believe(program_ = IntervalProgram(problem_));
    believe(solver_ = WindowSolver(problem_, count));
  }
  /// Another car than that of the problem.
  void believe(auto& one) const {
    AxleTyres tyres = problem_.tyres;
    tyres.front.D *= 0.9;
    one.set_car(tyres, {0.2, 0.03});
    one.set_grip(index(2), 0.8);
  }
  std::size_t index(int k) const { return (GetParam().first + static_cast<std::size_t>(k)) % nodes; }

  /// An iterate that is neither feasible nor settled, after a few steps from the centre line.
  std::vector<WindowNode> iterate_at_random(std::mt19937& draw) const {
    const LapSolution guess = guess_for(problem_);
    std::vector<WindowNode> lap(nodes);
    for (std::size_t k = 0; k < nodes; ++k) lap[k].z = guess.z[k];
    WindowSolver solver = solver_;
    for (int i = 0; i < 8; ++i)
      solver.iterate(lap, GetParam().first, count, mu, guess.z[index(0)], guess.z[index(count)]);
    const auto within = [&](double size) { return std::uniform_real_distribution(-size, size)(draw); };
    for (int k = 0; k <= count; ++k) {
      WindowNode& node = lap[index(k)];
      for (std::size_t j = 0; j < node.z.size(); ++j) node.z[j] += within(0.01) * program_.scales()[j];
      for (double& one : node.pi) one *= 1.0 + within(0.2);
      for (double& one : node.t) one *= 1.0 + within(0.2);
      for (double& one : node.lambda) one *= 1.0 + within(0.2);
    }
    return lap;
  }
  /// One step of the solver beside the dense one, with the least curvature added that makes the program convex: none,
  /// or a ten-thousandth times a power of four. What was added.
  double expect_same_step(std::vector<WindowNode> lap) {
    std::array<double, lap_variables> begin = lap[index(0)].z, end = lap[index(count)].z;
    begin[lap_n] += 0.01, begin[lap_vx] -= 0.05, end[lap_xi] += 0.03, end[lap_omega] += 0.2;
    DenseStep dense(program_, lap, GetParam().first, count);
    dense.add_end(0, begin, WindowSolver::begin_weight);
    dense.add_end(count, end, WindowSolver::end_weight);
    double curvature = 0.0;
    while (!dense.convex(curvature)) curvature = curvature > 0.0 ? 4.0 * curvature : 1e-4;
    dense.solve(mu, curvature);
    const std::vector<WindowNode> before = lap;
    const WindowStep step = solver_.iterate(lap, GetParam().first, count, mu, begin, end);
    EXPECT_TRUE(step.good);
    if (!step.good) return curvature;
    EXPECT_NEAR(step.change, dense.largest_change(), 1e-8);
    int held = 0;  // multipliers that are not as the step says
    for (int k = 0; k <= count; ++k) {
      const WindowNode &from = before[index(k)], &to = lap[index(k)];
      const int moved = k < count ? lap_variables : lap_states;
      for (int j = 0; j < moved; ++j) {
        const auto at = static_cast<std::size_t>(j);
        EXPECT_NEAR((to.z[at] - from.z[at]) / (step.share * program_.scales()[at]),
                    dense.dz(k, j) / program_.scales()[at], 1e-8)
            << "node " << k << ", variable " << j;
      }
      if (k == count) break;
      for (int j = 0; j < lap_states; ++j) {
        const auto at = static_cast<std::size_t>(j);
        EXPECT_NEAR(from.pi[at] + (to.pi[at] - from.pi[at]) / step.share, dense.pi(k, j), 1e-8 * dense.largest_pi())
            << "dynamics of node " << k << ", state " << j;
      }
      for (int row = 0; row < interval_rows; ++row) {
        const auto at = static_cast<std::size_t>(row);
        const double slack = dense.slack(k, row) + step.share * dense.dt(k, row);
        const double lambda = std::lerp(from.lambda[at], dense.lambda(k, row), step.share), far = mu / to.t[at];
        if (slack > 0.02 * dense.slack(k, row) && !program_.shares_friction()) {
          EXPECT_NEAR(to.t[at], slack, 1e-8) << "slack of node " << k << ", row " << row;
        }
        if (lambda > 0.0101 * far && lambda < 99.0 * far) {
          EXPECT_NEAR(to.lambda[at], lambda, 1e-8 * (1.0 + lambda)) << "constraint of node " << k << ", row " << row;
        } else {
          ++held;
        }
      }
    }
    EXPECT_LT(held, count * interval_rows / 4);
    return curvature;
  }

  LapProblem problem_ = swinging_road(0.8);
  IntervalProgram program_{problem_};
  WindowSolver solver_{problem_, count};
};

TEST_P(NewtonStepTest, IsThatOfTheDenseOptimalityConditions) {
  std::mt19937 draw(31);
  for (int i = 0; i < 5 && !HasFailure(); ++i) {
    believe(solver_ = WindowSolver(problem_, count));
    EXPECT_EQ(expect_same_step(iterate_at_random(draw)), 0.0);
  }
}

// Multipliers of the dynamics that are far off bend the program down.
TEST_P(NewtonStepTest, AddsTheLeastCurvatureWhereTheProgramIsNotConvex) {
  std::mt19937 draw(32);
  for (int i = 0; i < 5 && !HasFailure(); ++i) {
    believe(solver_ = WindowSolver(problem_, count));
    std::vector<WindowNode> lap = iterate_at_random(draw);
    for (WindowNode& node : lap)
      for (double& one : node.pi) one *= -50.0;
    EXPECT_GT(expect_same_step(std::move(lap)), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, NewtonStepTest,
                         ::testing::Values(SmallWindow{"NoSharing"}, SmallWindow{"OneCircle", 0.9, 0.0},
                                           SmallWindow{"Axles", 0.0, 1.1},
                                           SmallWindow{"AcrossTheEndOfTheLap", 0.0, 0.0, nodes - 3}),
                         [](const auto& one) { return one.param.name; });

}  // namespace test_window_solver
}  // namespace gripline
