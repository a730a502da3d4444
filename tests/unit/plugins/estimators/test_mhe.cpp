// Moving-horizon estimation of both axles' tyre parameters.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/learning_rig.hpp"

namespace gripline {
namespace test_mhe {

using namespace rig;

double fresh(double) { return 1.0; }
double mean_mu(const Belief& b) { return 0.5 * (b.mu_front + b.mu_rear); }

TEST(Mhe, WhatItLearnedExplainsTheNextSteps) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("mhe", nominal);
  learn(*estimator, nominal, drive_bends(6, 3, fresh));
  const Validation taught = validate(nominal, *estimator, drive_bends(3, 4, fresh));
  EXPECT_GT(taught.r2[1], 0.97);
  EXPECT_GT(taught.r2[2], 0.97);
}

TEST(Mhe, FollowsFrictionThatFades) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(16, 3, [](double t) { return t < 8 ? 1.0 : 0.5; });
  const auto estimator = make_estimator("mhe", nominal);
  double grippy = 0, slippery = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    estimator->update(
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]));
    const double mu = mean_mu(estimator->belief()), t = static_cast<double>(i) * dt;
    if (t > 4 && t < 8) grippy += mu * dt / 4;
    if (t > 10) slippery += mu * dt / 6;
  }
  EXPECT_LT(slippery, 0.7 * grippy);
}

/// Before anything was learned the belief is the prior with its spread; what is learned narrows it.
TEST(Mhe, SaysHowWellItKnowsFriction) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("mhe", nominal);
  const Belief before = estimator->belief();
  EXPECT_DOUBLE_EQ(mean_mu(before), 1.0);
  EXPECT_DOUBLE_EQ(before.sigma_front, 0.5);
  const TrueCar truth;
  State straight;
  straight.vx = 2.0;
  for (std::int64_t i = 0; i < 10; ++i) {  // says nothing of friction
    const State next = truth.step(straight, {0.3, 0.0});
    estimator->update(make_sample(nominal.prediction(), i, straight, {0.3, 0.0}, next));
    straight = next;
  }
  EXPECT_GT(estimator->belief().sigma_front, 0.45);
  EXPECT_GT(estimator->belief().sigma_rear, 0.45);
  learn(*estimator, nominal, drive_bends(6, 3, fresh));
  const Belief after = estimator->belief();
  EXPECT_LT(after.sigma_front, 0.1);
  EXPECT_LT(after.sigma_rear, 0.1);
  std::vector<double> slip = {0.1}, force(1), sigma(1);
  ASSERT_TRUE(estimator->tyre_force(Axle::rear, slip, force, sigma));
  EXPECT_GT(force[0], 0.0);
  EXPECT_GT(sigma[0], 0.0);
  EXPECT_LT(sigma[0], 0.1 * force[0]);
}

TEST(Mhe, StaysWithinItsBoundsWhateverItIsTold) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("mhe", nominal);
  const Drive drive = drive_bends(2, 3, fresh);
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    State wild = drive.x[i + 1];
    wild.vy += i % 2 == 0 ? 30.0 : -30.0;
    wild.omega *= -50.0;
    estimator->update(make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], wild));
    const Belief belief = estimator->belief();
    for (const double mu : {belief.mu_front, belief.mu_rear}) {
      ASSERT_GE(mu, 0.0199);
      ASSERT_LE(mu, 5.001);
    }
    ASSERT_TRUE(std::isfinite(belief.sigma_front + belief.sigma_rear));
  }
}

TEST(Mhe, JacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("mhe", nominal);
  learn(*estimator, nominal, drive_bends(3, 3, fresh));
  CorrectedModel model = corrected(nominal, *estimator);
  State x;
  x.vx = 1.8;
  x.vy = -0.2;
  x.omega = 2;
  x.delta = 0.15;
  EXPECT_LT(jacobian_error(model, x, {0.4, 0.5}), 1e-6);
}

}  // namespace test_mhe
}  // namespace gripline
