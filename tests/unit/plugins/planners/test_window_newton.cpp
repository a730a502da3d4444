#include "planners/time_optimal/window_newton.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "planners/time_optimal/second_order_dual.hpp"
#include "planners/time_optimal/window_solver.hpp"
#include "support/swinging_road.hpp"

namespace gripline {
namespace test_window_newton {

using namespace time_optimal;
using namespace testing_support;

constexpr std::size_t nodes = swinging_nodes;

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

}  // namespace test_window_newton
}  // namespace gripline
