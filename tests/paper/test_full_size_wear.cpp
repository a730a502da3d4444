// The full-size experiments keep their claims: fading friction and slope against no slope, on two seeds each, and the
// forces of one run.
#include <gtest/gtest.h>

#include "experiment/experiment.hpp"
#include "experiment/force_validation.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_full_size_wear {

const Registry& registry() {
  static const Registry all({testing_support::plugin_dir()});
  return all;
}

TEST(FullSizeWear, AxleForcesAreLearnedFromNoisyStates) {
  const std::filesystem::path file = testing_support::source_dir() / "experiments/full_size_forces.json";
  const RaceSpec race = read_race(file, load_experiment(file, {}), registry());
  const std::filesystem::path out = std::filesystem::path(testing::TempDir()) / "full_size_forces";
  std::filesystem::create_directories(out);
  int axles = 0;
  const ForceScores found = validate_forces(race, {"elm", "best"}, out);
  for (const ChannelScore& score : found.scores) {
    if (score.channel != "force_front" && score.channel != "force_rear") continue;
    EXPECT_GE(score.r2, 0.97) << score.estimator << ", " << score.channel;
    EXPECT_GT(score.n, 2000u);
    ++axles;
  }
  EXPECT_EQ(axles, 4);
}

void expect_claims(const std::string& experiment, const std::string& rows) {
  const std::filesystem::path out = std::filesystem::path(testing::TempDir()) / experiment;
  const testing_support::Outcome run =
      testing_support::run_program({testing_support::gripline_program(), "compare",
                                    testing_support::source_dir() / ("experiments/" + experiment + ".json"), "--only",
                                    rows, "--set", "/seeds/count=2", "-j", "1", "--out", out.string(), "--force"});
  EXPECT_EQ(run.code, 0) << run.out << run.err;
}

TEST(FullSizeWear, FadingFrictionIsDrivenToTheEndWithLearningOnly) {
  // "finished" is whoever stands somewhere at the end of the duration; the claims on lap 2 say who drove
  expect_claims("full_size_wear", "none,elm,best,oracle");
}

TEST(FullSizeWear, SlopeInThePredictionLowersTheDeviationOnHills) {
  expect_claims("full_size_slope", "best,best_no_slope");
}

}  // namespace test_full_size_wear
}  // namespace gripline
