#include <gtest/gtest.h>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_fixed_speed {

using namespace testing_support;
using Changes = std::vector<std::pair<std::string, double>>;

class FixedSpeedTest : public ::testing::Test {
 protected:
  Instance<SpeedPlanner> make(const char* id, double mu_init, const Changes& changes = {}) {
    PluginContext context;
    context.car = car_;
    context.dt = 0.02;
    context.course = &course_;
    context.nominal = &model_.prediction();
    context.mu_init = mu_init;
    const PluginEntry& entry = registry_.find(abi::Kind::planner, id);
    return create<SpeedPlanner>(entry, context, values_of(entry, changes));
  }
  static double speed(SpeedPlanner& planner, std::size_t i, double mu) {
    Observation now;
    now.x.x = planner.line()[i].x;
    now.x.y = planner.line()[i].y;
    now.x.yaw = planner.line()[i].yaw;
    std::array<RefPoint, 2> horizon{};
    planner.plan(now, {mu, mu, 0, 0, true}, nullptr, horizon);
    return horizon[0].v;
  }

  Registry registry_ = plugins();
  Car car_ = car_1_43();
  Track track_ = ethz();
  TrackCourse course_{track_, car_};
  DynamicCar model_{registry_, 0.02};
};

TEST_F(FixedSpeedTest, IgnoresWhatIsBelieved) {
  const auto planner = make("fixed_speed", 1.0);
  ASSERT_FALSE(planner->line().empty());
  for (std::size_t i = 0; i < planner->line().size(); i += 40)
    EXPECT_EQ(speed(*planner, i, 0.4), speed(*planner, i, 1.2));
}

TEST_F(FixedSpeedTest, DrivesLikeFrictionSpeedThatBelievesMuInit) {
  const auto fixed = make("fixed_speed", 0.7);
  const auto stated = make("fixed_speed", 1.0, {{"mu", 0.7}});
  const auto adaptive = make("friction_speed", 1.0);
  ASSERT_FALSE(fixed->line().empty());
  for (std::size_t i = 0; i < fixed->line().size(); i += 40) {
    EXPECT_NEAR(speed(*fixed, i, 1.0), speed(*adaptive, i, 0.7), 1e-9);  // 0.7 is a point of the default grid
    EXPECT_EQ(speed(*fixed, i, 1.0), speed(*stated, i, 1.0));
  }
}

TEST_F(FixedSpeedTest, IsCarefulForAsLongAsItIsTold) {
  const auto planner = make("fixed_speed", 0.5, {{"mu", 1.0}, {"careful_until", 10}});
  const auto careful = make("fixed_speed", 0.5);
  const auto fast = make("fixed_speed", 1.0);
  const auto speed_at = [&](double t) {
    Observation now;
    now.t = t;
    now.x.x = planner->line()[0].x;
    now.x.y = planner->line()[0].y;
    now.x.yaw = planner->line()[0].yaw;
    std::array<RefPoint, 2> horizon{};
    planner->plan(now, {1, 1, 0, 0, t < 5}, nullptr, horizon);
    return horizon[0].v;
  };
  EXPECT_EQ(speed_at(0), speed(*careful, 0, 1.0));
  EXPECT_EQ(speed_at(10), speed(*careful, 0, 1.0));
  EXPECT_EQ(speed_at(10.02), speed(*fast, 0, 1.0));
  EXPECT_GT(speed_at(10.02), speed_at(10));
}

TEST_F(FixedSpeedTest, RefusesALineOfTooManyOrTooFewSamples) {
  for (const double spacing : {1e-6, 10.0}) EXPECT_THROW(make("fixed_speed", 1.0, {{"spacing", spacing}}), PluginError);
}

TEST_F(FixedSpeedTest, NeedsACourseAndAModel) {
  const PluginEntry& entry = registry_.find(abi::Kind::planner, "fixed_speed");
  PluginContext context;
  context.car = car_;
  EXPECT_THROW(create<SpeedPlanner>(entry, context, values_of(entry)), PluginError);
  context.course = &course_;
  EXPECT_THROW(create<SpeedPlanner>(entry, context, values_of(entry)), PluginError);
}

}  // namespace test_fixed_speed
}  // namespace gripline
