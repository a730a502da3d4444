#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "diagnose/inference/bootstrap.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_bootstrap {

using test::DiagnoseRig;

TEST(Bootstrap, TheBetterModelWinsAndSharesAddUp) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("drive_gain", {0.05});
  const Problem problem = rig.problem({rig.simulate(truth, {10, 96, 1})});
  Fit with, without;
  with.model = truth;
  without.model = rig.catalogue().null_model();
  with.noise = without.noise = rig.noise(problem, 0.5);
  const std::vector<const Fit*> models{&with, &without};
  const std::vector<double> share = block_bootstrap(problem, models, 200);
  EXPECT_NEAR(std::accumulate(share.begin(), share.end(), 0.0), 1.0, 1e-9);
  EXPECT_GT(share[0], 0.95);
  EXPECT_EQ(block_bootstrap(problem, models, 200), share);
  // A penalty that no likelihood makes up for.
  with.penalty = 1e9;
  EXPECT_EQ(block_bootstrap(problem, models, 200)[0], 0.0);
}

/// Three fits that the log cannot tell apart, a parameter two standard deviations off to either side in two of them: no
/// resampled log makes up for the prior.
TEST(Bootstrap, PriorsCount) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 1e-6);
  const Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {10, 96, 1})});
  std::array<Fit, 3> fits;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    fits[i].model = rig.catalogue().null_model();
    fits[i].model.nuisance.front() += (static_cast<double>(i) - 1.0) * 2.0 * rig.catalogue().nuisances().front().sigma;
    fits[i].noise = rig.noise(problem, 0.5);
  }
  const std::vector<const Fit*> models{&fits[0], &fits[1], &fits[2]};
  EXPECT_NEAR(block_bootstrap(problem, models, 200)[1], 1.0, 1e-9);
}

TEST(Bootstrap, PosteriorFollowsTheEvidence) {
  Fit a, b;
  a.evidence = 10.0;
  b.evidence = 10.0 - std::log(3.0);
  const std::vector<double> p = posterior(std::vector<const Fit*>{&a, &b});
  EXPECT_NEAR(p[0], 0.75, 1e-12);
  EXPECT_NEAR(p[1], 0.25, 1e-12);
}

}  // namespace test_diagnose_bootstrap
}  // namespace gripline::diagnose
