#include "estimators/elm_rls/noise_matching.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::elm_rls {
namespace test_noise_matching {

constexpr double dt = 0.02;  // [s]
const NoiseMatching::Stated stated{{0.1, 0.2, 0.3}, {1.0, 2.0, 3.0}};

/// Matches `steps` innovations of variance 1 in channel 1 whose errors change sign (as noise may) or keep it (as what
/// the equations leave out).
void match(NoiseMatching& noise, double error, bool lasting, int steps) {
  for (int i = 0; i < steps; ++i) noise.match(1, {lasting || i % 2 == 0 ? error : -error, 1.0}, dt);
}

TEST(NoiseMatching, BeginsWithTheStatedValues) {
  const NoiseMatching noise(stated);
  for (int c = 0; c < channels; ++c) {
    EXPECT_EQ(noise.sigma()[c], stated.sigma[c]);
    EXPECT_EQ(noise.misfit(c), stated.misfit[c]);
  }
}

TEST(NoiseMatching, SigmaFollowsTheSizeOfInnovations) {
  NoiseMatching small(stated), right(stated), large(stated);
  match(small, 0.5, false, 20);
  match(right, 1.0, false, 20);
  match(large, 1.5, false, 20);
  EXPECT_LT(small.sigma()[1], 0.95 * stated.sigma[1]);
  EXPECT_NEAR(right.sigma()[1], stated.sigma[1], 1e-12);
  EXPECT_GT(large.sigma()[1], 1.05 * stated.sigma[1]);
}

TEST(NoiseMatching, MisfitGrowsWhereErrorsLastOnly) {
  NoiseMatching changing(stated), lasting(stated);
  match(changing, 1.0, false, 20);
  match(lasting, 1.0, true, 20);
  EXPECT_EQ(changing.misfit(1), stated.misfit[1]);
  EXPECT_GT(lasting.misfit(1), 1.3 * stated.misfit[1]);
}

/// Misfit over the stated one after `seconds` of errors in steps of `step`, which are as noisy in their mean over 20 ms
/// whatever the step is: each has as many times the variance as the step is shorter.
double misfit_after(double seconds, double step, double error, bool lasting = true) {
  NoiseMatching noise(stated);
  for (int i = 0; i < static_cast<int>(std::lround(seconds / step)); ++i)
    noise.match(1, {lasting || i % 2 == 0 ? error : -error, dt / step}, step);
  return noise.misfit(1) / stated.misfit[1];
}

TEST(NoiseMatching, WhatLastsIsSeenAsWellAtShorterSteps) {
  const double expected = misfit_after(2.0, dt, 0.6);
  EXPECT_GT(expected, 1.5);
  for (const double step : {0.01, 0.005, 0.002}) {
    EXPECT_NEAR(misfit_after(2.0, step, 0.6), expected, 1e-9) << step;
    EXPECT_EQ(misfit_after(2.0, step, 0.6, false), 1.0) << step;
  }
  EXPECT_GT(misfit_after(2.0, 0.04, 0.6), 1.3);  // one by one
}

TEST(NoiseMatching, StaysWithinBoundsOfItsOwnChannel) {
  NoiseMatching small(stated), large(stated);
  match(small, 0.0, false, 5000);
  match(large, 100.0, true, 5000);
  EXPECT_NEAR(small.sigma()[1], 0.02 * stated.sigma[1], 1e-12);
  EXPECT_EQ(small.misfit(1), stated.misfit[1]);
  EXPECT_NEAR(large.sigma()[1], 10 * stated.sigma[1], 1e-12);
  EXPECT_NEAR(large.misfit(1), 100 * stated.misfit[1], 1e-9);
  for (const int other : {0, 2}) {
    EXPECT_EQ(large.sigma()[other], stated.sigma[other]);
    EXPECT_EQ(large.misfit(other), stated.misfit[other]);
  }
}

TEST(NoiseMatching, OneInnovationFarOffMovesSigmaByOneAndAHalfPercent) {
  NoiseMatching noise(stated);
  noise.match(1, {1e6, 1.0}, dt);
  EXPECT_NEAR(noise.sigma()[1], stated.sigma[1] * std::exp(0.015), 1e-12);
}

TEST(NoiseMatching, ErrorsOnBothSidesOfABreakDoNotLast) {
  NoiseMatching whole(stated), one(stated), all(stated), other(stated);
  for (NoiseMatching* noise : {&whole, &one, &all, &other}) match(*noise, 1.0, true, 10);
  one.break_sequence(1);
  all.break_sequence();
  other.break_sequence(2);
  for (NoiseMatching* noise : {&whole, &one, &all, &other}) match(*noise, 1.0, true, 1);
  EXPECT_LT(one.misfit(1), whole.misfit(1));
  EXPECT_EQ(all.misfit(1), one.misfit(1));
  EXPECT_EQ(other.misfit(1), whole.misfit(1));
}

TEST(NoiseMatching, StartsOver) {
  NoiseMatching noise(stated);
  match(noise, 3.0, true, 50);
  noise.start_over();
  EXPECT_EQ(noise.sigma()[1], stated.sigma[1]);
  EXPECT_EQ(noise.misfit(1), stated.misfit[1]);
  noise.match(1, {1.0, 1.0}, dt);  // follows nothing
  EXPECT_EQ(noise.misfit(1), stated.misfit[1]);
}

}  // namespace test_noise_matching
}  // namespace gripline::elm_rls
