#include "common/planning/speed_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_speed_profile {

using namespace planning;
using namespace testing_support;

ClosedLine circle(double radius, std::size_t n) {
  std::vector<LinePoint> samples(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    samples[i].s = radius * angle;
    samples[i].x = radius * std::cos(angle);
    samples[i].y = radius * std::sin(angle);
    samples[i].yaw = std::remainder(angle + std::numbers::pi / 2, 2 * std::numbers::pi);
    samples[i].kappa = 1 / radius;
    samples[i].left = samples[i].right = 0.2;
  }
  return ClosedLine(std::move(samples));
}

// Tyres of the 1:43 car, per mass.
vehicle::AxleTyres true_tyres(double factor) {
  return {{2.579, 1.2, 0.192 / 0.041 * factor}, {3.3852, 1.2691, 0.1737 / 0.041 * factor}};
}

/// Time to drive the line once at these speeds [s].
double lap_time(const ClosedLine& line, std::span<const double> v) {
  double t = 0;
  for (std::size_t i = 0; i < v.size(); ++i) t += 2.0 * line.spacing() / (v[i] + v[(i + 1) % v.size()]);
  return t;
}

TEST(ClosedLine, PositionAndFootOnACircle) {
  const ClosedLine line = circle(1.0, 100);
  for (double s = 0.013; s < 13.0; s += 0.37) {
    const LinePoint p = line.at(s);
    EXPECT_NEAR(p.x, std::cos(s), 1e-6);
    EXPECT_NEAR(p.y, std::sin(s), 1e-6);
    EXPECT_NEAR(std::remainder(p.yaw - s - std::numbers::pi / 2, 2 * std::numbers::pi), 0.0, 1e-5);
    const ClosedLine::Foot foot = line.project(1.1 * std::cos(s), 1.1 * std::sin(s));
    EXPECT_NEAR(std::remainder(foot.s - s, line.length()), 0.0, 1e-5);
    EXPECT_NEAR(foot.distance, 0.1, 1e-5);
    EXPECT_NEAR(std::remainder(line.project(std::cos(s), std::sin(s), s - 0.4).s - s, line.length()), 0.0, 1e-5);
  }
}

TEST(ClosedLine, RefusesTooFewSamples) { EXPECT_THROW(ClosedLine(std::vector<LinePoint>(3)), std::invalid_argument); }

TEST(DriveLimits, OfASpeedThatIsNoNumberAreNone) {
  const Registry registry = plugins();
  DynamicCar model(registry, 0.02);
  const DriveLimits limits(model.prediction(), car_1_43(), 0, 0);
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(limits.coast(none)));
  EXPECT_TRUE(std::isnan(limits.drive(none)));
  EXPECT_TRUE(std::isnan(limits.brake(none)));
  EXPECT_NEAR(limits.coast(100 * limits.top_speed()), limits.coast(limits.top_speed()), 1e-9);
}

TEST(CornerLimits, DragOfATurnThatIsNoNumberIsNone) {
  const CornerLimits corners(car_1_43(), true_tyres(1.0), 3.0);
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(corners.drag(0.8, 1.0, none, 0.0)));
  EXPECT_TRUE(std::isnan(corners.drag(0.8, none, 1.0, 0.0)));
}

TEST(DriveLimits, AreTheOnesOfThe143Car) {
  const Registry registry = plugins();
  DynamicCar model(registry, 0.02);
  const DriveLimits limits(model.prediction(), car_1_43(), 0, 0);
  EXPECT_NEAR(limits.top_speed(), 4.21, 0.01);
  EXPECT_NEAR(limits.coast(2) + limits.drive(2), 3.04, 0.01);
  EXPECT_NEAR(limits.coast(3) + limits.drive(3), 1.67, 0.01);
  EXPECT_NEAR(limits.brake(1) - limits.coast(1), 1.84, 0.01);
  EXPECT_NEAR(limits.brake(3) - limits.coast(3), 1.64, 0.01);
}

TEST(DriveLimits, KnownResistanceAddsToAModelWithoutIt) {
  const Registry registry = plugins();
  DynamicCar model(registry, 0.02);
  const DriveLimits bare(model.prediction(), car_1_43(), 0, 0), resisted(model.prediction(), car_1_43(), 0.5, 0.1);
  EXPECT_NEAR(bare.coast(2) - resisted.coast(2), 0.5 + 0.1 * 4, 1e-3);
  EXPECT_LT(resisted.top_speed(), bare.top_speed());
}

// The limit speed of a turn is one of the plant: held there at full steering, nothing but the speed's own balance
// moves.
TEST(CornerLimits, SteeringLimitsSharpTurns) {
  const Registry registry = plugins();
  const Car car = car_1_43();
  // Computed apart from the published parameters, without the cosine of the steering angle and the side component of
  // the drive force.
  const std::array<std::pair<double, double>, 9> table{{{.18, .49},
                                                        {.20, .85},
                                                        {.215, 1.02},
                                                        {.25, 1.27},
                                                        {.30, 1.49},
                                                        {.40, 1.79},
                                                        {.585, 2.20},
                                                        {.755, 2.51},
                                                        {.985, 2.88}}};
  for (const double factor : {1.0, 0.6}) {
    DynamicCar plant(registry, 0.02, factor);
    const vehicle::AxleTyres grip = true_tyres(factor);
    const CornerLimits corner(car, true_tyres(1.0), 4.21);
    for (const auto& [radius, speed] : table) {
      const double v = corner.speed(factor, 1 / radius, 0);
      EXPECT_NEAR(v, speed * std::sqrt(factor), 0.1) << radius;
      EXPECT_DOUBLE_EQ(corner.speed(factor, -1 / radius, 0), v);
      const SteadyTurn turn = steady_turn(car, grip, 1 / radius, v * v / radius);
      EXPECT_NEAR(turn.steering, car.delta_max, 5e-3);
      State x;
      x.vx = v * std::cos(turn.beta);
      x.vy = v * std::sin(turn.beta);
      x.omega = v / radius;
      x.delta = turn.steering;
      const Prediction::Rates r = plant.prediction().rates(x, {0, 0}, {});
      EXPECT_NEAR(r.vy, 0.0, 0.01) << radius;
      EXPECT_NEAR(r.omega, 0.0, 2.0) << radius;  // of 4000 rad/s2 that one axle alone would give
    }
    EXPECT_LE(corner.speed(factor, 1 / 2.0, 0), std::sqrt(corner.lateral_limit(factor) * 2.0) + 1e-9);
  }
}

// Also in a crawl, beyond the limit of the turn, and where the bank holds the car.
TEST(CornerLimits, OneTableServesEveryFriction) {
  const Car car = car_1_43();
  const CornerLimits shared(car, true_tyres(0.8), 4.21);
  for (const double mu : {0.2, 0.7, 1.0, 1.9}) {
    const CornerLimits own(car, true_tyres(mu), 4.21);
    const double share = mu / 0.8;
    EXPECT_NEAR(shared.lateral_limit(share), own.lateral_limit(1.0), 1e-9 * own.lateral_limit(1.0));
    for (const double kappa : {-28.0, -6.1, -1.03, 0.0, 0.4, 2.7, 5.5})
      for (const double bank : {-0.05, 0.0, 0.2}) {
        EXPECT_NEAR(shared.speed(share, kappa, bank), own.speed(1.0, kappa, bank), 1e-8) << mu << ' ' << kappa;
        for (const double v : {0.5, 1.7, 3.9})
          EXPECT_NEAR(shared.drag(share, v, kappa, bank), own.drag(1.0, v, kappa, bank), 1e-6) << mu << ' ' << kappa;
      }
  }
}

TEST(CornerLimits, ALineSharperThanTheSteeringIsACrawl) {
  const CornerLimits corner(car_1_43(), true_tyres(1), 4.21);
  EXPECT_GT(corner.speed(1, 28.0, 0), 0.0);
  EXPECT_LT(corner.speed(1, 28.0, 0), 0.25);
}

TEST(CornerLimits, BankHelpsTheTurnTowardsTheLowSide) {
  const CornerLimits corner(car_1_43(), true_tyres(1), 4.21);
  const double flat = corner.speed(1, 2, 0);
  EXPECT_GT(corner.speed(1, 2, 0.1), flat);   // right side higher, left turn
  EXPECT_LT(corner.speed(1, -2, 0.1), flat);  // right side higher, right turn
  EXPECT_DOUBLE_EQ(corner.speed(1, 2, 0.1), corner.speed(1, -2, -0.1));
}

TEST(CornerLimits, DragOfTheTyresIsThePlants) {
  const Registry registry = plugins();
  DynamicCar plant(registry, 0.02);
  const Car car = car_1_43();
  const double v = 1.5, kappa = 2.0;
  const SteadyTurn turn = steady_turn(car, true_tyres(1), kappa, v * v * kappa);
  State x;
  x.vx = v * std::cos(turn.beta);
  x.vy = v * std::sin(turn.beta);
  x.omega = v * kappa;
  x.delta = turn.steering;
  const Prediction::Rates r = plant.prediction().rates(x, {0, 0}, {});
  const double along = r.vx * std::cos(turn.beta) + r.vy * std::sin(turn.beta);
  const DriveLimits limits(plant.prediction(), car, 0, 0);
  EXPECT_NEAR(along, limits.coast(v) - turn.drag, 0.03);
  EXPECT_GT(turn.drag, 0.3);
  EXPECT_NEAR(CornerLimits(car, true_tyres(1), 4.2).drag(1, v, -kappa, 0), turn.drag, 1e-3);
}

class ProfileTest : public ::testing::Test {
 protected:
  Registry registry_ = plugins();
  DynamicCar model_{registry_, 0.02};
  Track track_ = ethz();
  Car car_ = car_1_43();
  TrackCourse course_{track_, car_};
  DriveLimits limits_{model_.prediction(), car_, 0, 0};
  CornerLimits corner_{car_, equal_friction(1.0, car_, 3.0, 1.3), limits_.top_speed()};
  ClosedLine line_ = [this] {
    std::vector<LinePoint> samples(800);
    course_.minimum_curvature({0.0, 4.7}, samples);
    return ClosedLine(std::move(samples));
  }();
};

TEST_F(ProfileTest, ObeysDriveBrakesAndCorners) {
  const std::vector<double> v = speed_profile(line_, limits_, corner_, 0.9, 1.0);
  const double ds = line_.spacing();
  int braking = 0, driving = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const std::size_t j = (i + 1) % v.size();
    const double a = (v[j] * v[j] - v[i] * v[i]) / (2 * ds);
    const LinePoint& p = line_.samples()[i];
    EXPECT_LE(v[i], corner_.speed(0.9, p.kappa, p.bank) + 1e-9);
    EXPECT_LE(a, limits_.coast(v[i]) + limits_.drive(v[i]) + 1e-6);
    EXPECT_GE(a,
              limits_.coast(v[j]) - limits_.brake(v[j]) - corner_.drag(0.9, v[j], line_.samples()[j].kappa, 0) - 1e-6);
    braking += a < -1.0;
    driving += a > 1.0;
  }
  EXPECT_GT(braking, 50);
  EXPECT_GT(driving, 50);
}

TEST_F(ProfileTest, IsTheFastestOfAFixedPoint) {
  // Raising any speed by 1 % must break a limit: every sample is at its corner speed or tied to a neighbour.
  const std::vector<double> v = speed_profile(line_, limits_, corner_, 0.9, 0.0);
  const double ds = line_.spacing();
  const auto accel = [&](double u, const LinePoint& p, double force) {
    return limits_.coast(u) - corner_.drag(0.9, u, p.kappa, p.bank) + force;
  };
  int loose = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const std::size_t before = (i + v.size() - 1) % v.size(), after = (i + 1) % v.size();
    const double raised = 1.01 * v[i];
    const LinePoint &p = line_.samples()[before], &q = line_.samples()[after];
    const bool too_fast = raised > corner_.speed(0.9, line_.samples()[i].kappa, 0);
    const bool cannot_gain =
        raised * raised > v[before] * v[before] + 2 * ds * accel(v[before], p, limits_.drive(v[before]));
    const bool cannot_lose =
        raised * raised > v[after] * v[after] - 2 * ds * accel(v[after], q, -limits_.brake(v[after]));
    loose += !(too_fast || cannot_gain || cannot_lose);
  }
  EXPECT_EQ(loose, 0);
}

TEST_F(ProfileTest, LibraryInterpolatesAndIsNotOneProfileTimesARoot) {
  const std::vector<double> mus{0.5, 0.6, 0.9, 1.0};
  const ProfileLibrary library(line_, car_, limits_, {}, mus);
  double previous = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mus.size(); ++i) {
    const double t = lap_time(line_, library.profile(i));
    EXPECT_LT(t, previous);
    previous = t;
  }
  const double t5 = lap_time(line_, library.profile(0)), t10 = lap_time(line_, library.profile(3));
  EXPECT_LT(t5 / t10, 0.97 * std::sqrt(2.0));
  const Bracket place = line_.bracket(1.234);
  const double half = library.speed(library.select(0.55), place);
  EXPECT_NEAR(half, 0.5 * (library.speed(library.select(0.5), place) + library.speed(library.select(0.6), place)),
              1e-12);
  EXPECT_DOUBLE_EQ(library.speed(library.select(2.0), place), library.speed(library.select(1.0), place));
}

// Were the least friction of the grid planned for, a car on ice would be driven off the road.
TEST_F(ProfileTest, LibraryIsDrivenMoreSlowlyBelowItsLeastFriction) {
  const ProfileLibrary library(line_, car_, limits_, {}, std::vector<double>{0.4, 0.8});
  const Bracket place = line_.bracket(1.234);
  const double least = library.speed(library.select(0.4), place);
  EXPECT_NEAR(library.speed(library.select(0.1), place), 0.5 * least, 1e-12);
  EXPECT_NEAR(library.speed(library.select(0.3999), place), least, 1e-3 * least);
  EXPECT_NEAR(library.speed(library.select(-1.0), place), std::sqrt(0.01 / 0.4) * least, 1e-12);
}

TEST_F(ProfileTest, SlopeCostsSpeedUphill) {
  std::vector<LinePoint> samples(line_.samples().begin(), line_.samples().end());
  for (LinePoint& p : samples) p.grade = 0.1;
  const ClosedLine uphill(std::move(samples));
  EXPECT_GT(lap_time(uphill, speed_profile(uphill, limits_, corner_, 0.9, 1.0)),
            lap_time(line_, speed_profile(line_, limits_, corner_, 0.9, 1.0)));
}

}  // namespace test_speed_profile
}  // namespace gripline
