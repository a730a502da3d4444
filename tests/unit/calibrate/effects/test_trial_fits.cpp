#include "calibrate/effects/trial_fits.hpp"

#include <gtest/gtest.h>

#include "calibrate/fit/fit.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_trial_fits {

/// An effect that the log's car has lowers the cost and gets its size; taken out again, the rest goes back to where it
/// was without it.
TEST(TrialFits, AnEffectIsFittedAndTakenOutAgain) {
  const test::CalibrateRig truth(
      test::small_car_world(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})"));
  const test::CalibrateRig nominal(test::small_car_world(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})"));
  const measured::Session session = test::drive(truth.vehicle.car(), {.seconds = 30, .noise = 1});
  const ForecastOptions forecast = test::CalibrateRig::options(nominal.spec);
  std::vector<FitLog> logs(1, FitLog(session, forecast.step, {1.0}, 0.5, 0.5));

  Trial base(nominal.spec, forecast);
  Errors errors;
  base.params = parameters_of(nominal.tree, base.forecaster, errors);
  base.unknowns = read_unknowns(nominal.tree, base.places, base.params, {}, errors);
  errors.throw_if_any();
  std::erase_if(base.unknowns, [](const Unknown& u) { return u.pointer != "/plant/params/Cm1"; });
  ASSERT_EQ(base.unknowns.size(), 1u);
  TrialFits fits(forecast, logs);
  fits.weighing.horizon = {1.0};
  fits.refit(base, 6);

  const auto candidates = candidate_effects(base.spec.vehicle, base.spec.car.car, testing_support::plugins(), false);
  const auto scores =
      score_candidates(base.vehicle.car(), candidates, forecast, logs, base.params, base.unknowns, fits.weighing);
  const auto score = std::ranges::find_if(
      scores, [&](const EffectScore& one) { return candidates[one.candidate].id() == "steer_offset"; });
  ASSERT_NE(score, scores.end());
  const auto more = fits.with(base, candidates[score->candidate], *score);
  EXPECT_LT(more->cost, base.cost);
  EXPECT_TRUE(fits.refit_near(*more, base.cost));
  EXPECT_LT(more->cost, 0.1 * base.cost);
  EXPECT_NEAR(more->params[more->find(pointer_of("steer_offset", "d0"))->index], 0.03, 0.003);
  EXPECT_FALSE(fits.refit_near(*more, 0.1 * more->cost)) << "a rival that is out of reach";

  const BlockedNormalEquations blocks = fits.errors(*more).linearise(more->params, more->unknowns);
  const auto less = fits.without(*more, blocks, added_effect("steer_offset"));
  EXPECT_TRUE(less->spec.vehicle.effects.empty());
  EXPECT_NEAR(less->cost, base.cost, 0.01 * base.cost);
  const std::size_t drive = base.unknowns.front().index;
  EXPECT_NEAR(less->params[drive], base.params[drive], 0.01 * base.params[drive]);
}

/// A parameter of an effect that the world lists is opened and closed again: the effect stays, and the parameter goes
/// back to where it did nothing.
TEST(TrialFits, AListedParameterIsOpenedAndClosedAgain) {
  const test::CalibrateRig truth(
      test::small_car_world(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9, "c": -2}}]}})"));
  const test::CalibrateRig nominal(
      test::small_car_world(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9}}]}})"));
  const measured::Session session = test::drive(truth.vehicle.car(), {.seconds = 30, .noise = 1});
  const ForecastOptions forecast = test::CalibrateRig::options(nominal.spec);
  std::vector<FitLog> logs(1, FitLog(session, forecast.step, {1.0}, 0.5, 0.5));
  Trial base(nominal.spec, forecast);
  base.unknowns.push_back(unknown_at(*base.find("/plant/params/Cm1"), 12.0));
  base.unknowns.back().sigma = 4.0;
  TrialFits fits(forecast, logs);
  fits.weighing.horizon = {1.0};
  fits.refit(base, 6);

  const auto candidates = candidates_beside(base, testing_support::plugins(), {});
  const auto scores =
      score_candidates(base.vehicle.car(), candidates, forecast, logs, base.params, base.unknowns, fits.weighing);
  const auto score = std::ranges::find_if(scores, [&](const EffectScore& one) {
    return addition_of(candidates[one.candidate], base).name == "steer_map.c";
  });
  ASSERT_NE(score, scores.end());
  const std::string pointer = "/plant/effects/steer_map/params/c";
  const auto more = fits.with(base, candidates[score->candidate], *score);
  EXPECT_TRUE(fits.refit_near(*more, base.cost));
  EXPECT_NEAR(more->params[more->find(pointer)->index], -2.0, 0.3);
  EXPECT_EQ(more->unknowns.size(), 2u);

  const BlockedNormalEquations blocks = fits.errors(*more).linearise(more->params, more->unknowns);
  const auto less = fits.without(*more, blocks, addition_of(candidates[score->candidate], base));
  EXPECT_EQ(less->spec.vehicle.effects.size(), 1u);
  EXPECT_EQ(less->unknowns.size(), 1u);
  EXPECT_EQ(less->params[less->find(pointer)->index], 0.0);
  EXPECT_NEAR(less->cost, base.cost, 0.01 * base.cost);
}

}  // namespace test_trial_fits
}  // namespace gripline::calibrate
