// The full-size experiments keep their claims: forces of one run, slope against no slope.
#include <gtest/gtest.h>

#include "experiment.hpp"
#include "validation.hpp"

namespace gripline {
namespace {

const Registry& registry() {
  static const Registry all({GRIPLINE_PLUGIN_DIR});
  return all;
}

TEST(FullSizeWear, AxleForcesAreLearnedFromNoisyStates) {
  const std::filesystem::path file = std::filesystem::path(GRIPLINE_SOURCE_DIR) / "experiments/full_size_forces.json";
  const RaceSpec race = read_race(file, load_experiment(file, {}), registry());
  const std::filesystem::path out = std::filesystem::path(testing::TempDir()) / "full_size_forces";
  std::filesystem::create_directories(out);
  int axles = 0;
  for (const ChannelScore& score : validate_forces(race, {"elm", "best"}, out)) {
    if (score.channel != "force_front" && score.channel != "force_rear") continue;
    EXPECT_GE(score.r2, 0.97) << score.estimator << ", " << score.channel;
    EXPECT_GT(score.n, 2000u);
    ++axles;
  }
  EXPECT_EQ(axles, 4);
}

}  // namespace
}  // namespace gripline
