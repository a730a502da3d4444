#include <gtest/gtest.h>

#include <numbers>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/noise_estimate.hpp"
#include "diagnose/inference/reference.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_adequacy {

using test::DiagnoseRig;

constexpr std::array<double, 3> smooth = {0, 0, 0}, everywhere = {1, 1, 1};

/// Process noise explains an oscillation too; the test finds it all the same, with its frequency.
TEST(ResidualTests, TellsASpectralLineFromNoise) {
  DiagnoseRig rig;
  Log log = rig.simulate(rig.catalogue().null_model(), {40, 45, 1});
  // What a yaw acceleration of 6 rad/s2 at 0.7 Hz adds to the readings of yaw and yaw rate.
  const double rate = 2.0 * std::numbers::pi * 0.7;
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double t = static_cast<double>(k) * log.dt;
    log.reading[k * channels + 2] -= 6.0 / (rate * rate) * std::sin(rate * t);
    log.reading[k * channels + 5] -= 6.0 / rate * std::cos(rate * t);
  }
  Problem problem = rig.problem({log});
  Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 8);
  smooth_reference(problem, rig.road(), f);
  f = fit(problem, f.model, f.noise, 8);
  double statistic = 0.0, frequency = 0.0;
  for (const ResidualTest& test : residual_tests(problem, f))
    if (test.quantity == "frequency") statistic = test.statistic, frequency = test.from;
  EXPECT_GT(statistic, thresholds::misfit);
  EXPECT_NEAR(frequency, 0.7, 0.03);
}

/// Noise in some accelerations only is a deficient model's, in all three a road's.
TEST(ResidualTests, TellsProcessNoiseFromADeficientModel) {
  DiagnoseRig rig;
  const auto uneven = [&](const std::array<double, 3>& rough) {
    Problem problem =
        rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 87, .rough = rough})});
    Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 8);
    smooth_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    double statistic = 0.0;
    for (const ResidualTest& test : residual_tests(problem, f))
      if (test.quantity == "noise") statistic = test.statistic;
    return statistic;
  };
  EXPECT_LT(uneven(smooth), thresholds::misfit);
  EXPECT_LT(uneven(everywhere), thresholds::misfit);
  EXPECT_LT(uneven({0.25, 0.25, 0.25}), thresholds::misfit);
  EXPECT_GT(uneven({1, 0, 0}), thresholds::misfit);
  EXPECT_GT(uneven({0, 0, 2}), thresholds::misfit);
}

/// The largest ordinates of a noisy spectrum are no lines.
TEST(ResidualTests, FindsNoSpectralLineInProcessNoise) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {81, 82, 83, 84, 85}) {
    Problem problem =
        rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = seed, .rough = everywhere})});
    Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 8);
    smooth_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    ASSERT_TRUE(has_strong_process_noise(problem, f.noise));
    for (const ResidualTest& test : residual_tests(problem, f))
      EXPECT_LT(test.statistic, thresholds::misfit) << test.quantity << seed;
  }
}

/// Twice the gain of all tests for functions of the state, which is a chi-square where nothing is left.
struct StateTests {
  double chi_square = 0.0, dof = 0.0;
  void add(const Problem& problem, const Fit& fitted) {
    for (const ResidualTest& test : residual_tests(problem, fitted)) {
      if (test.where != Where::state || !test.focused || !test.quantity.empty()) continue;
      chi_square += 2.0 * test.gain;
      dof += static_cast<double>(test.dof);
    }
  }
};

/// Noise that turns the car shows in its smoothed yaw rate too, and must not pass for a function of it: twice the gain
/// of a test is a chi-square, on a rough road and where shaking hands were recorded every 80 ms only.
TEST(ResidualTests, FunctionsOfTheStateDoNotExplainNoise) {
  DiagnoseRig rig;
  for (const bool shaking : {false, true}) {
    StateTests noise;
    for (const std::uint64_t seed : {91, 92}) {
      DiagnoseRig::Drive drive{.seconds = 40, .seed = seed};
      if (shaking) drive.unsteady = 2.0;
      if (!shaking) drive.rough = {1, 1, 4};
      const Log whole = rig.simulate(rig.catalogue().null_model(), drive);
      Problem problem = rig.problem({shaking ? DiagnoseRig::thinned(DiagnoseRig::thinned(whole)) : whole});
      if (shaking) problem.substeps = 6;
      Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 8);
      iterate_reference(problem, rig.road(), f);
      if (shaking) {
        const MeasuredNoise measured = measure_noise(problem, f, {.sensors = false, .commands = true});
        assume(problem, measured);
        f = fit(problem, f.model, measured.noise, 6);
        iterate_reference(problem, rig.road(), f);
      }
      f = fit(problem, f.model, f.noise, 8);
      noise.add(problem, f);
    }
    EXPECT_LT(noise.chi_square / noise.dof, 1.5) << (shaking ? "unknown commands" : "a rough road");
  }
}

/// Nor what is named: its own function is known along the smoothed motion, which has the noise in it, and differs from
/// that of the predicted motion by noise.
TEST(ResidualTests, FunctionsBesideAnEffectDoNotExplainNoise) {
  DiagnoseRig rig;
  StateTests noise;
  for (const std::uint64_t seed : {93, 94}) {
    Problem problem = rig.problem({rig.simulate(rig.with("aero_drag", {0.5}),
                                                {.seconds = 40, .seed = seed, .rough = {3, 1, 1}, .noise_time = 1.0})});
    problem.noise_time = 1.0;
    Fit f = fit(problem, rig.with("aero_drag", {0.5}), rig.noise(problem, 1.0), 8);
    iterate_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    noise.add(problem, f);
  }
  EXPECT_LT(noise.chi_square / noise.dof, 1.5);
}

TEST(ResidualTests, FindsAPlaceAndItsInterval) {
  // friction_patch may not be named: what it does is then a remainder in one place.
  DiagnoseRig rig({"friction_patch", "bank", "grade"});
  const ModelSpec truth = rig.with("friction_patch", {-0.3, 0.25, 0.15});
  Problem problem = rig.problem({rig.simulate(truth, {40, 43, 1})});
  Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 8);
  iterate_reference(problem, rig.road(), f);
  f = fit(problem, f.model, f.noise, 8);
  const ResidualTest place = residual_tests(problem, f).front();
  ASSERT_EQ(place.where, Where::position);
  EXPECT_GT(place.statistic, thresholds::misfit);
  EXPECT_NEAR(0.5 * (place.from + place.to), 0.25, 0.075) << "outside the patch";
}

/// Rounded commands that are expected values, and held ones of which the log left some out, are no normal noise: a
/// joint test beside them counts half.
TEST(ResidualTests, CountHalfWhereCommandsAreUncertain) {
  const DiagnoseRig rig;
  const ModelSpec bare = rig.catalogue().null_model();
  const Log log = DiagnoseRig::rounded(rig.simulate(bare, {.seconds = 20, .seed = 45, .unsteady = 1}), 0.01);
  const auto share = [&](Problem problem) {
    Fit f = fit(problem, bare, rig.noise(problem, 5.0), 4);
    const ResidualTest in_place = residual_tests(problem, f).front();
    const auto dof = static_cast<double>(in_place.dof);
    return in_place.statistic * std::sqrt(2.0 * dof) / (2.0 * in_place.gain - dof);
  };
  Problem as_written = rig.problem({log}), expected = as_written, left_out = as_written;
  expected.command_step = {0.0, 0.01};
  expected.unround_commands();
  left_out.hold_commands({.halves = true});
  EXPECT_NEAR(share(as_written), 1.0, 1e-9);
  EXPECT_NEAR(share(expected), 0.5, 1e-9);
  EXPECT_NEAR(share(left_out), 0.5, 1e-9);
}

/// A friction that is named although it fades: what it leaves is between some seconds, in each test that says so.
TEST(ResidualTests, WhatChangesWithTimeHasAnInterval) {
  DiagnoseRig rig({"friction_drift"});
  Problem problem = rig.problem({rig.simulate(rig.with("friction_drift", {-0.4}), {40, 44, 1})});
  Fit f = fit(problem, rig.with("friction_scale", {-0.1}), rig.noise(problem, 5.0), 8);
  iterate_reference(problem, rig.road(), f);
  int over_time = 0;
  for (const ResidualTest& test : residual_tests(problem, f)) {
    if (test.where != Where::time || !test.quantity.empty()) continue;
    ++over_time;
    EXPECT_LT(test.from, test.to) << "statistic " << test.statistic;
    EXPECT_GE(test.from, 0.0);
    EXPECT_LE(test.to, 40.0);
  }
  EXPECT_EQ(over_time, 2) << "functions of time, and friction times such";
}

}  // namespace test_diagnose_adequacy
}  // namespace gripline::diagnose
