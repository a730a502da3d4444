#include "diagnose/result/ranking.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_ranking {

using test::DiagnoseRig;

/// A gyroscope that is out by an offset in the last third of the log only. What is fitted to the rest knows nothing of
/// it, and does not help there; a model that has seen the last third would.
TEST(Ranking, PredictionsAreOfDataThatWereNotFitted) {
  const DiagnoseRig rig;
  const Catalogue& catalogue = rig.catalogue();
  Log log = rig.simulate(catalogue.null_model(), {.seconds = 12, .seed = 95});
  for (std::size_t k = log.size() - log.size() / 3; k < log.size(); ++k) log.reading[k * channels + 5] += 0.3;
  const Problem problem = rig.problem({log});
  const Noise noise = rig.noise(problem, 0.1);
  ModelPool pool(problem);
  const Fit null_model = pool.fit_once(catalogue.null_model(), noise);
  const Fit offset = pool.fit_once(rig.with("yawrate_bias", {0.0}), noise);
  EXPECT_GT(offset.theta.front(), 0.03) << "an offset as the whole log has it";
  const SearchResult found{.pool = std::move(pool), .null_model = null_model, .best = offset};
  const HoldOut hold_out(problem, rig.road(), {});
  const std::vector<RankedEffect> ranking =
      with_predictions(found, hold_out, {{.effect = "yawrate_bias"}, {.effect = "aero_drag"}});
  const auto row = [&](const char* effect) { return *std::ranges::find(ranking, effect, &RankedEffect::effect); };
  constexpr std::array<double, 1> second = {1.0};
  const StartErrors refitted = hold_out.predict_refitted(offset);
  EXPECT_EQ(row("yawrate_bias").held_out, refitted.rms());
  EXPECT_EQ(row("yawrate_bias").rollout.change, compare(refitted, hold_out.predict_refitted(null_model)).change);
  EXPECT_GT(refitted.rms(), 1.05 * hold_out.predict(offset, second).front().rms()) << "it has seen the last third";
  EXPECT_TRUE(std::isnan(row("aero_drag").held_out)) << "nobody fitted it";
  EXPECT_FALSE(row("aero_drag").rollout.measured());
}

}  // namespace test_diagnose_ranking
}  // namespace gripline::diagnose
