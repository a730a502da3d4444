#include <gtest/gtest.h>

#include "diagnose/inference/evaluation.hpp"
#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/predicted_motion.hpp"
#include "diagnose/inference/reference.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_fit {

using test::DiagnoseRig;

TEST(Fit, FindsParametersWithinTheirUncertainty) {
  DiagnoseRig rig;
  const std::vector<std::pair<const char*, std::vector<double>>> effects = {{"rolling_res", {0.3}},
                                                                            {"front_stiff", {-0.15}},
                                                                            {"steer_lag", {0.04}},
                                                                            {"input_delay", {0.031}},
                                                                            {"vx_bias", {0.05}}};
  for (const auto& [id, values] : effects) {
    const ModelSpec truth = rig.with(id, values);
    Problem problem = rig.problem({rig.simulate(truth, {20, 21, 1})});
    const Fit rough = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 4);
    smooth_reference(problem, rig.road(), rough);
    const Fit found =
        fit(problem, rig.catalogue().with(rig.catalogue().null_model(), rig.catalogue().find(id)), rough.noise, 15);
    EXPECT_NEAR(found.theta.front(), values.front(), 4.0 * std::sqrt(found.covariance.front())) << id;
    EXPECT_LT(std::sqrt(found.covariance.front()), 0.05 * std::abs(values.front())) << id;
  }
}

TEST(Fit, ProcessVariancesVanishWhenThereIsNone) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {20, 23, 1})});
  const Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 12);
  for (std::size_t i = 0; i < noise_states; ++i)
    EXPECT_LT(std::sqrt(f.noise.process[i]), 0.1 * problem.process_unit[i]);
}

/// On a rough road the score is that of the state where the filter is: along the smoothed reference, which has seen what
/// the score is to explain, the inertia came out as 0.44 and 0.45 in two of three, nearly five standard deviations off.
TEST(Fit, FindsAnInertiaOnARoughRoad) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with("yaw_inertia", {0.25});
  for (const std::uint64_t seed : {31, 32, 33}) {
    Problem problem = rig.problem({rig.simulate(truth, {.seconds = 60, .seed = seed, .rough = {3, 3, 5}})});
    const Fit rough = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 3.0), 10);
    smooth_reference(problem, rig.road(), rough);
    const std::size_t inertia = rig.catalogue().find("yaw_inertia");
    const Fit found = fit(problem, rig.catalogue().with(rig.catalogue().null_model(), inertia), rough.noise, 30);
    EXPECT_NEAR(found.theta.front(), 0.25, 3.5 * std::sqrt(found.covariance.front())) << seed;
    EXPECT_LT(std::sqrt(found.covariance.front()), 0.05) << seed;
  }
}

/// Yaw accelerations that are not known turn the car while speeds are steady: no rough road, but motion holds noise. A
/// result is then differentiated along predictions, a model that is compared with others is not. What the likelihood is
/// does not depend on that.
TEST(Fit, AResultIsDifferentiatedAlongPredictionsWhereverMotionHoldsNoise) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("yaw_inertia", {0.25}), start = rig.with("yaw_inertia", {0.1});
  const Problem problem = rig.problem({rig.simulate(truth, {.seconds = 10, .seed = 31, .rough = {0, 0, 5}})});
  const Noise calm = rig.noise(problem, 1e-4);
  Noise turning = calm;
  turning.process[2] = std::pow(problem.process_unit[2], 2);
  const auto ahead = [&](const Noise& noise, FitFor purpose) {
    return differentiate(problem, truth, problem.traces.front(), noise, purpose).predicted.has_value();
  };
  EXPECT_FALSE(ahead(turning, FitFor::comparison));
  EXPECT_TRUE(ahead(turning, FitFor::result));
  EXPECT_FALSE(ahead(calm, FitFor::result));
  EXPECT_TRUE(ahead(rig.noise(problem, 1.0), FitFor::comparison)) << "a rough road";
  EXPECT_DOUBLE_EQ(evaluate(problem, truth, turning, FitFor::result).cost, evaluate(problem, truth, turning).cost);
  const auto inertia = [&](FitFor purpose) {
    return fit(problem, start, turning, 4, {.purpose = purpose}).theta.front();
  };
  EXPECT_GT(std::abs(inertia(FitFor::result) - inertia(FitFor::comparison)), 1e-6);
}

/// A tyre that relaxes shows nothing of its stiffness in the rates of an instant, only through what is remembered.
TEST(Fit, FindsWhatActsBeforeAnEffectThatRemembers) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("relaxation", {0.05}), "front_stiff", {0.15});
  Problem problem = rig.problem({rig.simulate(truth, {20, 25, 1})});
  const Fit rough = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 4);
  smooth_reference(problem, rig.road(), rough);
  const ModelSpec start = rig.with(rig.with("relaxation", {0.04}), "front_stiff", {0.02});
  Fit found = fit(problem, start, rough.noise, 15);
  smooth_reference(problem, rig.road(), found);
  found = fit(problem, found.model, found.noise, 10);
  const auto stiff = found.model.values[found.model.position(rig.catalogue().find("front_stiff"))][0];
  const auto sigma = found.model.values[found.model.position(rig.catalogue().find("relaxation"))][0];
  EXPECT_NEAR(stiff, 0.15, 0.003);
  EXPECT_NEAR(sigma, 0.05, 0.003);
}

/// Shape parameters cost less than those that stand for an effect of their own, but never nothing.
TEST(Problem, ChargesShapesLess) {
  Problem p;
  p.rows = 6000;
  const double one = 0.5 * std::log(6000.0);
  EXPECT_DOUBLE_EQ(p.penalty(1), one);
  EXPECT_DOUBLE_EQ(p.penalty(3), 3 * one);
  EXPECT_DOUBLE_EQ(p.penalty(10), (3 + 7 * 0.4) * one);
}

/// Places that were not driven through: there a calm shape does nothing, and elsewhere it is what it was.
TEST(Fit, CalmShapesRestWhereNothingWasSeen) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with("bank", {0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02});
  Problem problem = rig.problem({rig.simulate(truth, {.seconds = 3, .seed = 89})});
  std::array<double, 10> seen{};
  for (const Place& at : problem.traces.front().at)
    seen[static_cast<std::size_t>(10.0 * at.lap_fraction + 0.5) % 10] += 0.01;
  ModelSpec start = truth;
  for (double& c : start.values.front()) c = 0.08;
  problem.shape_prior = true;
  const Fit f = fit(problem, start, rig.noise(problem, 0.003), 10);
  int rested = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    const bool near = seen[i] + seen[(i + 1) % 10] + seen[(i + 9) % 10] + seen[(i + 2) % 10] + seen[(i + 8) % 10] > 0.0;
    if (near) continue;
    ++rested;
    EXPECT_LT(std::abs(f.theta[i]), 0.005) << i;
  }
  EXPECT_GT(rested, 2);
  EXPECT_GT(*std::max_element(f.theta.begin(), f.theta.end()), 0.012);
}

/// A model that gives no numbers is no model: going on with it leaves it the worst.
TEST(Fit, WhatCannotBeEvaluatedStaysTheWorst) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {10, 54, 1})});
  const Fit broken = fit(problem, rig.with("drive_gain", {std::nan("")}), rig.noise(problem, 5.0), 4);
  EXPECT_EQ(broken.evidence, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(continue_fit(problem, broken, 4, {}).evidence, -std::numeric_limits<double>::infinity());
}

/// Going on from what is known gives what beginning at its end gives.
TEST(Fit, GoesOnFromWhereItEnded) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("front_stiff", {-0.15}), {20, 56, 1})});
  const Fit begun = fit(problem, rig.with("front_stiff", {0.0}), rig.noise(problem, 5.0), 2);
  const Fit more = continue_fit(problem, begun, 20, {}), anew = fit(problem, begun.model, begun.noise, 20);
  EXPECT_EQ(more.evidence, anew.evidence);
  EXPECT_EQ(more.theta, anew.theta);
  EXPECT_GT(more.evidence, begun.evidence + 1.0);
}

/// A parameter that may be a little off and an effect that does nearly the same trade places along a valley that only
/// the prior slopes. It is curved: their product counts. A fit finds its bottom from far up.
TEST(Fit, FollowsACurvedValley) {
  DiagnoseRig rig;
  rig.trust({"Dr", "Br"}, 0.02);
  const double Dr = rig.catalogue().nuisances().front().nominal;
  const ModelSpec truth = rig.with("rear_grip", {-0.07});
  Problem problem = rig.problem({rig.simulate(truth, {.seconds = 60, .seed = 58})});
  ModelSpec up = rig.with("rear_grip", {-0.03});
  up.nuisance.front() = 0.96 * Dr;
  for (const double process : {0.01, 1.0}) {
    const Noise noise = rig.noise(problem, process);
    const Fit from_truth = fit(problem, truth, noise, 20), from_far = fit(problem, up, noise, 12);
    EXPECT_GT(from_far.evidence, from_truth.evidence - 1.0) << process;
    EXPECT_GT(from_far.theta.front(), 0.99 * Dr) << process;
  }
}

/// A fit that cannot come near what is wanted stops early, and says no more than it found.
TEST(Fit, StopsWhenTheScoreIsOutOfReach) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("drive_gain", {0.12}), {20, 53, 1})});
  const ModelSpec start = rig.with("yaw_inertia", {0.1});
  const Fit whole = fit(problem, start, rig.noise(problem, 5.0), 10);
  const Fit early = fit(problem, start, rig.noise(problem, 5.0), 10, {0.01, whole.evidence + 1e6});
  EXPECT_LE(early.evidence, whole.evidence + 1e-6);
  EXPECT_FALSE(early.converged);
}

}  // namespace test_diagnose_fit
}  // namespace gripline::diagnose
