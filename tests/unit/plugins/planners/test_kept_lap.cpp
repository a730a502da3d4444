#include "planners/time_optimal/kept_lap.hpp"

#include <gtest/gtest.h>

#include <cstddef>

#include "planners/time_optimal/lap_setup.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_kept_lap {

using namespace time_optimal;
using namespace testing_support;

/// The lap that is kept, at another friction than it was solved for.
class KeptLapTest : public ::testing::Test, protected PlannerRig {
 protected:
  const CarBelief typical_{planning::equal_friction(0.8, car_, 4.0, 1.3), {}};
  PluginContext context_ = context_on(mobil_);
  LapSetup setup_{context_, SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}},
                  typical_};
  KeptLap kept_{setup_, typical_.tyres};
  static constexpr std::size_t node = 11;
  const KeptLap::States solved_ = kept_.at(node);
};

TEST_F(KeptLapTest, IsDrivenMoreSlowlyWhereThereIsLessFriction) {
  EXPECT_EQ(kept_.slowed(node, 0.9), solved_);
  const KeptLap::States slowed = kept_.slowed(node, 0.2);
  EXPECT_DOUBLE_EQ(slowed[lap_vx], 0.5 * solved_[lap_vx]);
  EXPECT_DOUBLE_EQ(slowed[lap_omega], 0.5 * solved_[lap_omega]);
  EXPECT_EQ(slowed[lap_delta], solved_[lap_delta]);
  EXPECT_EQ(kept_.at(node), solved_);
  kept_.slow_down(node, 0.79);  // as good as the same
  EXPECT_EQ(kept_.at(node), solved_);
  kept_.slow_down(node, 0.2);
  EXPECT_EQ(kept_.at(node), slowed);
  EXPECT_EQ(kept_.slowed(node, 0.2), slowed);  // once
}

TEST_F(KeptLapTest, BeginsAgainFromWhatItRemembers) {
  kept_.nodes()[node].started = true;
  kept_.nodes()[node].z[lap_n] = 0.1;
  kept_.reset(node, 0.2);
  EXPECT_FALSE(kept_.nodes()[node].started);
  EXPECT_EQ(kept_.at(node)[lap_n], solved_[lap_n]);
  EXPECT_DOUBLE_EQ(kept_.at(node)[lap_vx], 0.5 * solved_[lap_vx]);
  kept_.nodes()[node].z[lap_n] = 0.1;
  kept_.remember();
  kept_.nodes()[node].z[lap_n] = 0.2;
  kept_.reset(node, 0.8);
  EXPECT_EQ(kept_.at(node)[lap_n], 0.1);
}

// Along the same way with the same slips: time per metre grows by the square root, and so do multipliers by ways.
TEST_F(KeptLapTest, AWindowAtAShareOfItsFrictionIsTheSameMotion) {
  kept_.nodes()[node].z[lap_a] = 2.0;
  kept_.nodes()[node].z[lap_rate] = 1.0;
  kept_.nodes()[node].pi.fill(1.0);
  kept_.scale(node, 0.25, 0.2);
  const WindowNode& scaled = kept_.nodes()[node];
  EXPECT_DOUBLE_EQ(scaled.z[lap_vx], 0.5 * solved_[lap_vx]);
  EXPECT_DOUBLE_EQ(scaled.z[lap_a], 0.5);
  EXPECT_DOUBLE_EQ(scaled.pi[lap_n], 2.0);
  EXPECT_DOUBLE_EQ(scaled.pi[lap_vx], 4.0);
  EXPECT_DOUBLE_EQ(scaled.pi[lap_xi], 2.0);
  EXPECT_DOUBLE_EQ(scaled.pi[lap_delta], 2.0);
  EXPECT_DOUBLE_EQ(scaled.pi[lap_omega], 4.0);
  EXPECT_DOUBLE_EQ(scaled.z[lap_rate], 0.5);
  EXPECT_EQ(kept_.slowed(node, 0.2), scaled.z);
}

}  // namespace test_kept_lap
}  // namespace gripline
