#include "diagnose/inference/model_pool.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_model_pool {

using test::DiagnoseRig;

/// Commands that are taken wrongly, and noise, can make a smooth road look rough: when others are assumed, parameters
/// cost what they cost before. Another reference is no such thing.
TEST(ModelPool, ARoughRoadIsForgottenWithWhatMadeItLookRough) {
  const DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 6, .seed = 98})});
  const Noise noise = rig.noise(problem, 0.5);
  const double initial = problem.penalty_per_parameter();
  for (const bool by_noise : {false, true}) {
    ModelPool pool(problem);
    const Fit& fitted = pool.fit_once(rig.with("mass", {0.0}), noise);
    EXPECT_DOUBLE_EQ(fitted.penalty, initial);
    pool.penalise_as_rough();
    const double rough = pool.problem().penalty_per_parameter();
    EXPECT_NEAR(rough, 0.5 * std::log(3.0 * 6.02 / 0.5), 1e-9);
    EXPECT_DOUBLE_EQ(fitted.penalty, rough);
    EXPECT_DOUBLE_EQ(fitted.evidence, -fitted.cost - rough);
    const Fit kept = fitted;
    pool.restart(rig.road(), kept);
    EXPECT_EQ(pool.problem().penalty_per_parameter(), rough);
    if (by_noise)
      pool.restart(rig.road(), kept, MeasuredNoise{.noise = noise, .model = kept.model});
    else
      pool.restart(rig.road(), kept, measured::CommandHold{.until_next = true});
    EXPECT_EQ(pool.problem().penalty_per_parameter(), initial) << by_noise;
  }
}

}  // namespace test_diagnose_model_pool
}  // namespace gripline::diagnose
