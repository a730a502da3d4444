#include "calibrate/fit/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_least_squares {

/// One parameter, whose true value is 0, from blocks that each have an estimate of their own: `scatter` times as far
/// apart as errors would leave them that are independent of one another.
struct Blocks {
  Blocks(std::size_t count, double scatter, std::mt19937_64& random) {
    constexpr double information = 100.0;
    std::normal_distribution<double> normal(0.0, scatter / std::sqrt(information));
    std::vector<double> own(count);
    for (double& one : own) estimate += (one = normal(random)) / static_cast<double>(count);
    for (const double one : own) {
      blocks.hessian.emplace_back(Eigen::MatrixXd::Constant(1, 1, information));
      blocks.gradient.emplace_back(Eigen::VectorXd::Constant(1, information * (estimate - one)));
    }
    unknown.sigma = 10.0;
    unknown.low = -100.0;
    unknown.high = 100.0;
  }
  Interval interval() const {
    return bootstrap(blocks, std::vector<double>{estimate}, std::vector<Unknown>{unknown}).interval.front();
  }
  double estimate = 0.0;
  BlockedNormalEquations blocks;
  Unknown unknown;
};

double covered(std::size_t count, double scatter) {
  constexpr int logs = 300;
  std::mt19937_64 random(7);
  int held = 0;
  for (int i = 0; i < logs; ++i) {
    const Interval found = Blocks(count, scatter, random).interval();
    held += found.low <= 0.0 && 0.0 <= found.high;
  }
  return static_cast<double>(held) / logs;
}

TEST(Bootstrap, IntervalsOfFewBlocksHoldTheTruthAsOftenAsTheySay) {
  EXPECT_GT(covered(3, 4.0), 0.91);
  EXPECT_GT(covered(6, 4.0), 0.91);
  EXPECT_GT(covered(20, 4.0), 0.91);
}

TEST(Bootstrap, UnknownsOfWhichTheBlocksSayNothingChangeNoInterval) {
  std::mt19937_64 random(9);
  const Blocks one(6, 4.0, random);
  constexpr Eigen::Index more = 16;
  BlockedNormalEquations blocks;
  for (std::size_t b = 0; b < one.blocks.hessian.size(); ++b) {
    blocks.hessian.emplace_back(Eigen::MatrixXd::Zero(1 + more, 1 + more)).topLeftCorner(1, 1) = one.blocks.hessian[b];
    blocks.gradient.emplace_back(Eigen::VectorXd::Zero(1 + more)).head(1) = one.blocks.gradient[b];
  }
  std::vector<double> params(1 + more, 0.0);
  params.front() = one.estimate;
  std::vector<Unknown> unknowns(1 + more, one.unknown);
  for (std::size_t i = 0; i < unknowns.size(); ++i) unknowns[i].index = i;
  const Interval found = bootstrap(blocks, params, unknowns).interval.front(), alone = one.interval();
  EXPECT_NEAR(found.high - found.low, alone.high - alone.low, 1e-6);
}

TEST(Bootstrap, IntervalsOfManyBlocksAreNoWiderThanTheyNeedBe) {
  std::mt19937_64 random(8);
  double width = 0.0;
  constexpr int logs = 50;
  for (int i = 0; i < logs; ++i) {
    const Interval found = Blocks(30, 1.0, random).interval();
    width += (found.high - found.low) / logs;
  }
  const double ideal = 2.0 * 1.96 / std::sqrt(30.0 * 100.0);
  EXPECT_LT(width, 1.25 * ideal);
  EXPECT_GT(width, 0.9 * ideal);
}

TEST(Bootstrap, WhatPriorAndCurvatureAllowIsDrawnAsWideAsTheBlocksScatter) {
  std::mt19937_64 random(9);
  const Blocks scattered(20, 5.0, random);
  const Bootstrap found =
      bootstrap(scattered.blocks, std::vector<double>{scattered.estimate}, std::vector<Unknown>{scattered.unknown});
  double square = 0.0;
  for (const Eigen::VectorXd& move : found.posterior_moves) square += move(0) * move(0) / 400.0;
  const double curvature = 1.0 / std::sqrt(20.0 * 100.0);  // were errors independent
  EXPECT_GT(std::sqrt(square), 3.0 * curvature);
  EXPECT_LT(std::sqrt(square), 8.0 * curvature);
}

/// Priors so narrow that their curvature is no number.
TEST(LeastSquares, MovesThatAreNoNumbersAreNotMade) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 20, .noise = 1});
  std::vector<FitLog> logs(1, FitLog(session, 0.02, {1.0}, 0.5, 0.5));
  PredictionErrors errors(rig.forecaster, logs);
  errors.weighing.horizon = {1.0};
  std::vector<Unknown> unknowns(2);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    unknowns[i].index = rig.forecaster.index(ForecastParameter::delay_position) + i;
    unknowns[i].sigma = 1e-200;
    unknowns[i].low = -0.5;
    unknowns[i].high = 1.0;
  }
  const std::vector<double> start = rig.forecaster.defaults();
  double cost = 0.0;
  EXPECT_EQ(least_squares(errors, unknowns, start, {}, cost), start);
  EXPECT_TRUE(std::isfinite(cost));
}

}  // namespace test_least_squares
}  // namespace gripline::calibrate
