#include "planners/time_optimal/interval_program.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_interval_program {

using namespace time_optimal;
using namespace testing_support;
using Dual = SecondOrderDual<lap_variables>;

/// One interval of a road with everything that a place can have.
LapProblem one_interval(const LapPlace& place) {
  const Car car = car_1_43();
  const double weight = 0.8 * gravity / (car.lf + car.lr);
  return {.car = car,
          .tyres = {{4.0, 1.35, weight * car.lr}, {5.0, 1.25, weight * car.lf}},
          .drive = {CubicSpline(0, 4, std::vector<double>{-0.5, -0.6, -0.8, -1.2, -1.6}),
                    CubicSpline(0, 4, std::vector<double>{7, 5.5, 4, 2.5, 1.6}),
                    CubicSpline(0, 4, std::vector<double>{1, 1.5, 1.8, 1.9, 2})},
          .top_speed = 4.0,
          .use = {.slip_bound = 0.5},
          .smoothness = 0.1,
          .places = {place},
          .ds = {0.06},
          .n_lo = {-0.15},
          .n_hi = {0.12},
          .mid_lo = {-0.15},
          .mid_hi = {0.12}};
}

/// Relative to the largest of what is compared.
template <class A, class B>
void expect_same(const std::string& what, const A& own, const B& automatic, std::size_t count) {
  double size = 1e-3;
  for (std::size_t m = 0; m < count; ++m) size = std::max(size, std::abs(automatic[m]));
  for (std::size_t m = 0; m < count; ++m)
    EXPECT_NEAR(own[m] / size, automatic[m] / size, 1e-11) << what << ", entry " << m;
}

/// The program's own derivatives at a random point, weights included, beside those of its templates.
void expect_same_derivatives(const IntervalProgram& program, std::mt19937& draw) {
  const auto between = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(draw); };
  const double z[lap_variables] = {between(-0.1, 0.1), between(-0.5, 0.5), between(0.8, 3.5), between(-0.6, 0.6),
                                   between(-6, 6),     between(-0.3, 0.3), between(-3, 3),    between(-3, 3)};
  std::array<double, lap_states> rate_weight{};
  for (double& w : rate_weight) w = between(-1, 1);
  std::array<double, curved_rows> row_weight{};
  for (double& w : row_weight) w = between(0, 1);
  IntervalDerivatives own;
  program.differentiate(0, z, rate_weight, row_weight, own);

  Dual x[lap_variables];
  for (int j = 0; j < lap_variables; ++j) x[j] = Dual::variable(z[j], j);
  const LapRates<Dual> rates = program.rates(0, x);
  const Dual cost = program.cost(0, x, rates);
  Dual sum = cost;
  EXPECT_NEAR(own.cost, cost.v, 1e-11 * (1.0 + std::abs(cost.v)));
  expect_same("cost", own.cost_by, cost.g, lap_variables);
  for (std::size_t j = 0; j < lap_states; ++j) {
    EXPECT_NEAR(own.rate[j], rates.state[j].v, 1e-11 * (1.0 + std::abs(rates.state[j].v)));
    expect_same("rate " + std::to_string(j), own.rate_by[j], rates.state[j].g, lap_variables);
    sum += rate_weight[j] * rates.state[j];
  }
  int rows = 0;
  program.curved_rows_of(0, x, rates, [&](int row, const Dual& value) {
    const auto at = static_cast<std::size_t>(row - first_curved_row);
    EXPECT_NEAR(own.row[at], value.v, 1e-11 * (1.0 + std::abs(value.v))) << "row " << row;
    expect_same("row " + std::to_string(row), own.row_by[at], value.g, lap_variables);
    sum += row_weight[at] * value;
    ++rows;
  });
  EXPECT_EQ(rows, curved_rows);
  expect_same("Hessian", own.lagrangian_by, sum.h, Dual::entries);
}

struct Manner {
  std::string name;
  double combined = 0, ellipse = 0, small_slip_from_speed = 0;
};

class IntervalProgramTest : public ::testing::TestWithParam<Manner> {};

TEST_P(IntervalProgramTest, DifferentiatesAsItsTemplatesDo) {
  std::mt19937 draw(20260);
  for (const LapPlace& place : {LapPlace{.kappa = 1.7}, LapPlace{.kappa = -2.0, .grade = 0.1, .bank = -0.06},
                                LapPlace{.kappa = 0.4, .curve = -0.5, .grip = 0.7},
                                LapPlace{.kappa = 0.4, .grade = -0.1, .bank = 0.2, .curve = 0.8, .grip = 0.9}}) {
    LapProblem problem = one_interval(place);
    problem.use.combined = GetParam().combined;
    problem.use.sharing = {GetParam().ellipse, 0.4, 0.62, 0.02, -0.015};
    problem.use.full_slip_until_speed = 1.0;
    problem.use.small_slip_from_speed = GetParam().small_slip_from_speed;
    IntervalProgram program(problem);
    program.set_slip_bound_slow_car(1.1);
    AxleTyres tyres = problem.tyres;
    tyres.front.D *= 0.9;
    program.set_car(tyres, {0.3, 0.04});
    for (int i = 0; i < 50 && !HasFailure(); ++i) expect_same_derivatives(program, draw);
  }
}

TEST(IntervalProgram, TheTableOfLinearRowsHasTheirSlopes) {
  const LapProblem problem = one_interval({.kappa = 1.7});
  const IntervalProgram program(problem);
  const auto values = [&](int variable) {
    double z[lap_variables] = {0.01, 0.1, 2.0, 0.1, 1.0, 0.1, 0.5, 0.4};
    if (variable >= 0) z[variable] += program.scales()[static_cast<std::size_t>(variable)];
    std::array<double, first_curved_row> all{};
    const double n_next = 0.02 + (variable == -1 ? program.scales()[lap_n] : 0.0);
    program.linear_rows(0, z, n_next, [&](int row, double value) { all[static_cast<std::size_t>(row)] = value; });
    return all;
  };
  const auto at_rest = values(-2);
  for (int variable = -1; variable < lap_variables; ++variable) {
    const auto moved = values(variable);
    for (std::size_t row = 0; row < moved.size(); ++row) {
      const bool next = row <= n_least;
      const bool depends = next ? variable == -1 : variable == linear_row[row].variable;
      EXPECT_NEAR(moved[row] - at_rest[row], depends ? linear_row[row].slope : 0.0, 1e-12)
          << "row " << row << ", variable " << variable;
    }
  }
}

/// Where a crest takes nearly all of the load, it stays at its least and does not change with speed.
TEST_P(IntervalProgramTest, KeepsTheLeastLoadOverACrest) {
  LapProblem problem = one_interval({.kappa = 0.4, .curve = -30.0});
  problem.use.combined = GetParam().combined;
  problem.use.sharing = {GetParam().ellipse, 0.4, 0.62, 0.02, -0.015};
  const IntervalProgram program(problem);
  std::mt19937 draw(7);
  for (int i = 0; i < 20 && !HasFailure(); ++i) expect_same_derivatives(program, draw);
}

INSTANTIATE_TEST_SUITE_P(Of, IntervalProgramTest,
                         ::testing::Values(Manner{"NoSharing"}, Manner{"OneCircle", 0.9, 0.0},
                                           Manner{"Axles", 0.0, 1.1}, Manner{"NoSharingFastSlips", 0.0, 0.0, 3.0},
                                           Manner{"OneCircleFastSlips", 0.9, 0.0, 3.0},
                                           Manner{"AxlesFastSlips", 0.0, 1.1, 3.0}),
                         [](const auto& one) { return one.param.name; });

TEST(IntervalProgram, BoundsSlipsOfFastCarsMore) {
  const SlipBound falls{1.0, 0.4, 1.0, 3.0};
  EXPECT_EQ(falls.at(0.9).f, 1.0);
  EXPECT_NEAR(falls.at(2.0).f, 0.7, 1e-12);
  EXPECT_NEAR(falls.at(3.1).f, 0.4, 1e-12);
  for (const double v : {0.5, 1.0 + 1e-4, 1.7, 2.4, 3.0 - 1e-4, 4.0}) {
    constexpr double h = 1e-5;
    const auto at = falls.at(v), more = falls.at(v + h), less = falls.at(v - h);
    EXPECT_NEAR(at.slope, (more.f - less.f) / (2 * h), 1e-6) << v;
    EXPECT_NEAR(at.curvature, (more.slope - less.slope) / (2 * h), 1e-4) << v;
    EXPECT_LE(at.slope, 0.0);
  }
  EXPECT_EQ((SlipBound{1.0, 0.4, 0.0, 0.0}.at(9.0).f), 1.0) << "at all speeds";
  EXPECT_EQ((SlipBound{0.3, 0.4, 1.0, 3.0}.at(9.0).f), 0.3) << "never more";
}

TEST(IntervalProgram, PlansNoSlipBeyondATyresPeakWhereFrictionIsShared) {
  LapProblem problem = one_interval({});
  problem.use.slip_bound = 1.4;
  problem.tyres.rear = problem.tyres.front;
  EXPECT_DOUBLE_EQ(IntervalProgram(problem).largest_slip(), 1.4);
  problem.use.combined = 0.9;
  const double peak = IntervalProgram(problem).largest_slip();
  EXPECT_LT(peak, 1.4);
  const auto force = [&](double slip) { return problem.tyres.front.force(slip); };
  EXPECT_LT(force(peak - 0.01), force(peak));
  EXPECT_LT(force(peak + 0.01), force(peak));
}

}  // namespace test_interval_program
}  // namespace gripline
