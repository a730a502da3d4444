#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_friction_speed {

using namespace testing_support;
using Changes = std::vector<std::pair<std::string, double>>;

class FrictionSpeedTest : public ::testing::Test {
 protected:
  Instance<SpeedPlanner> make(const Changes& changes = {}) {
    PluginContext context;
    context.car = car_;
    context.dt = 0.02;
    context.course = &course_;
    context.nominal = &model_.prediction();
    const PluginEntry& entry = registry_.find(abi::Kind::planner, "friction_speed");
    return create<SpeedPlanner>(entry, context, values_of(entry, changes));
  }
  static Observation seen(const State& x, double t = 0) {
    Observation now;
    now.t = t;
    now.x = x;
    return now;
  }
  State on_line(const LinePoint& p, double v) const {
    State x;
    x.x = p.x;
    x.y = p.y;
    x.yaw = p.yaw;
    x.vx = v;
    return x;
  }
  static Belief believe(double front, double rear) { return {front, rear, 0, 0, true}; }

  Registry registry_ = plugins();
  Car car_ = car_1_43();
  Track track_ = ethz();
  TrackCourse course_{track_, car_};
  DynamicCar model_{registry_, 0.02};
};

TEST_F(FrictionSpeedTest, LineLiesInsideTheTrackByHalfTheCarAndTheMargin) {
  const auto planner = make({{"margin", 0.02}});
  ASSERT_FALSE(planner->line().empty());
  for (const LinePoint& p : planner->line()) {
    EXPECT_GE(p.left, 0.035 - 2e-3);
    EXPECT_GE(p.right, 0.035 - 2e-3);
    EXPECT_NEAR(p.left + p.right, 0.37, 1e-9);
  }
}

TEST_F(FrictionSpeedTest, PlannedFrictionFallsAtOnceAndRisesAsSlowlyAsTold) {
  const auto slow = make({{"rise", 0.5}});
  const auto published = make();
  const State x = on_line(slow->line()[300], 1.0);
  const auto speed = [&](SpeedPlanner& planner, double mu) {
    std::array<RefPoint, 2> horizon{};
    planner.plan(seen(x), believe(mu, mu), nullptr, horizon);
    return horizon[0].v;
  };
  EXPECT_EQ(speed(*slow, 0.5), speed(*published, 0.5));
  for (int k = 1; k <= 20; ++k) EXPECT_NEAR(speed(*slow, 0.9), speed(*published, 0.5 + 0.01 * k), 1e-9);
  for (int k = 0; k < 40; ++k) speed(*slow, 0.9);
  EXPECT_EQ(speed(*slow, 0.9), speed(*published, 0.9));
  EXPECT_EQ(speed(*slow, 0.4), speed(*published, 0.4));
}

TEST_F(FrictionSpeedTest, PlansForLessThanItBelievesByAsManyDeviationsAsTold) {
  const auto cautious = make({{"sigma", 2.0}});
  const auto published = make();
  const State x = on_line(published->line()[300], 1.0);
  const auto speed = [&](SpeedPlanner& planner, const Belief& belief) {
    std::array<RefPoint, 2> horizon{};
    planner.plan(seen(x), belief, nullptr, horizon);
    return horizon[0].v;
  };
  EXPECT_NEAR(speed(*cautious, {0.9, 0.9, 0.1, 0.1, true}), speed(*published, believe(0.7, 0.7)), 1e-9);
  EXPECT_EQ(speed(*published, {0.9, 0.9, 0.1, 0.1, true}), speed(*published, believe(0.9, 0.9)));
  // The whole car's deviation is that of its axles by their loads.
  const double whole = (0.1 * car_.lr + 0.03 * car_.lf) / (car_.lf + car_.lr), mu = 0.9 - 2.0 * whole;
  EXPECT_NEAR(speed(*cautious, {0.9, 0.9, 0.1, 0.03, true}), speed(*published, believe(mu, mu)), 1e-9);
}

TEST_F(FrictionSpeedTest, HorizonStartsAtTheFootAndAdvancesByTheSpeedsItStates) {
  const auto planner = make();
  const LinePoint p = planner->line()[300];
  State x = on_line(p, 1.0);
  x.x -= 0.03 * std::sin(p.yaw);  // 3 cm to the left of the line
  x.y += 0.03 * std::cos(p.yaw);
  std::vector<RefPoint> horizon(21);
  planner->plan(seen(x, 5.0), believe(1, 1), nullptr, horizon);
  EXPECT_NEAR(std::hypot(horizon[0].x - p.x, horizon[0].y - p.y), 0.0, 2e-3);
  for (std::size_t k = 1; k < horizon.size(); ++k) {
    const double way = std::hypot(horizon[k].x - horizon[k - 1].x, horizon[k].y - horizon[k - 1].y);
    EXPECT_NEAR(way, 0.02 * (k == 1 ? x.vx : horizon[k - 1].v), 1e-3);
    EXPECT_NEAR(horizon[k].at.t, 5.0 + 0.02 * static_cast<double>(k), 1e-12);
    EXPECT_LT(std::abs(horizon[k].yaw - horizon[k - 1].yaw), 0.6);
  }
}

TEST_F(FrictionSpeedTest, PlaceAndEdgesBelongToThePoint) {
  const auto planner = make();
  std::vector<RefPoint> horizon(30);
  planner->plan(seen(on_line(planner->line()[100], 2.0)), believe(1, 1), nullptr, horizon);
  for (const RefPoint& r : horizon) {
    const CoursePoint c = course_.locate(r.x, r.y, r.at.s);
    EXPECT_NEAR(r.at.s, c.s, 2e-3);
    EXPECT_NEAR(r.at.n, c.n, 1e-3);
    EXPECT_NEAR(std::remainder(r.at.yaw_line - c.yaw, 2 * std::numbers::pi), 0, 0.06);
    EXPECT_NEAR(r.left, 0.185 - c.n, 1e-3);
    EXPECT_NEAR(r.right, 0.185 + c.n, 1e-3);
    EXPECT_NEAR(r.at.lap_fraction, r.at.s / track_.length(), 1e-3);
  }
}

TEST_F(FrictionSpeedTest, FasterWithMoreFrictionAndWithPace) {
  const auto planner = make({{"from_car_speed", 0}});
  const auto paced = make({{"from_car_speed", 0}, {"pace", 0.9}});
  double slow = 0, fast = 0;
  for (std::size_t i = 0; i < planner->line().size(); i += 50) {
    const State x = on_line(planner->line()[i], 1.5);
    std::array<RefPoint, 3> low{}, high{}, scaled{};
    planner->plan(seen(x), believe(0.6, 0.6), nullptr, low);
    planner->plan(seen(x), believe(0.9, 0.9), nullptr, high);
    paced->plan(seen(x), believe(0.9, 0.9), nullptr, scaled);
    EXPECT_LE(low[0].v, high[0].v + 1e-9);
    EXPECT_NEAR(scaled[0].v, 0.9 * high[0].v, 1e-9);
    slow += low[0].v;
    fast += high[0].v;
  }
  EXPECT_GT(fast, 1.1 * slow);
}

TEST_F(FrictionSpeedTest, SpeedIsInterpolatedAtTheTotalMu) {
  const auto planner = make({{"from_car_speed", 0}});
  const State x = on_line(planner->line()[10], 1.5);
  const auto speed = [&](double front, double rear) {
    std::array<RefPoint, 2> horizon{};
    planner->plan(seen(x), believe(front, rear), nullptr, horizon);
    return horizon[0].v;
  };
  // Axles that differ but carry the same total, and the middle of a grid interval.
  EXPECT_NEAR(speed(0.7 + 0.029 * 2, 0.7 - 0.033 * 2), speed(0.7, 0.7), 1e-9);
  EXPECT_NEAR(speed(0.72, 0.72), 0.5 * (speed(0.70, 0.70) + speed(0.74, 0.74)), 1e-9);
  EXPECT_NEAR(speed(0.075, 0.075), 0.5 * speed(0.3, 0.3), 1e-9);
  EXPECT_DOUBLE_EQ(speed(2.0, 2.0), speed(1.3, 1.3));
}

TEST_F(FrictionSpeedTest, FromStandstillReferencesGainSpeedAsTheCarCan) {
  const auto planner = make();
  const auto published = make({{"from_car_speed", 0}});
  std::vector<RefPoint> horizon(21), eager(21);
  const State x = start_state(track_);
  planner->plan(seen(x), believe(1, 1), nullptr, horizon);
  published->plan(seen(x), believe(1, 1), nullptr, eager);
  for (std::size_t k = 1; k < horizon.size(); ++k) EXPECT_LE(horizon[k].v, x.vx + 6.0 * 0.02 * static_cast<double>(k));
  EXPECT_GT(eager[1].v, 1.0);
}

TEST_F(FrictionSpeedTest, ProjectionFollowsTheLineForALapAndFindsALostCar) {
  const auto planner = make();
  const std::vector<LinePoint> line(planner->line().begin(), planner->line().end());
  std::array<RefPoint, 2> horizon{};
  double previous = -1;
  for (std::size_t i = 0; i < line.size(); i += 7) {
    planner->plan(seen(on_line(line[i], 2)), believe(1, 1), nullptr, horizon);
    EXPECT_NEAR(horizon[0].s, line[i].s, 1e-3);
    EXPECT_GT(horizon[0].s, previous);
    previous = horizon[0].s;
  }
  planner->plan(seen(on_line(line[350], 2)), believe(1, 1), nullptr, horizon);  // carried to the other side
  EXPECT_NEAR(horizon[0].s, line[350].s, 1e-3);
}

TEST_F(FrictionSpeedTest, HeadingIsTheOneNearestToTheCars) {
  const auto planner = make();
  State x = on_line(planner->line()[500], 2);
  x.yaw += 6 * std::numbers::pi;
  std::array<RefPoint, 5> horizon{};
  planner->plan(seen(x), believe(1, 1), nullptr, horizon);
  EXPECT_NEAR(horizon[0].yaw, x.yaw, 0.05);
}

TEST_F(FrictionSpeedTest, RefusesAnEmptyGrid) { EXPECT_THROW(make({{"mu_lo", 1.0}, {"mu_hi", 0.5}}), PluginError); }

}  // namespace test_friction_speed
}  // namespace gripline
