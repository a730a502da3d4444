#include "common/planning/recovery_path.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/planning/line_follower.hpp"
#include "support/full_size_car.hpp"

namespace gripline {
namespace test_recovery_path {

using planning::ClosedLine;
using planning::LineFollower;
using planning::RecoveryPath;
using testing_support::full_size_car;

constexpr double pi = std::numbers::pi, mu = 0.5, dt = 0.02, circle = 150, half_width = 6;

/// A circle to the left about the origin.
ClosedLine round_line() {
  const std::size_t count = 2000;
  std::vector<LinePoint> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    LinePoint& p = samples[i];
    const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(count);
    p.s = circle * angle;
    p.x = circle * std::cos(angle);
    p.y = circle * std::sin(angle);
    p.yaw = angle + pi / 2;
    p.kappa = 1 / circle;
    p.left = p.right = half_width;
  }
  return ClosedLine(samples);
}

/// A driver that is where the references say, and the road it drives on.
class Driver {
 public:
  /// At an angle to the line at station 0, `n` metres to its left.
  Driver(double n, double angle, double v) {
    now_.x.x = circle - n;
    now_.x.yaw = pi / 2 + angle;
    now_.x.vx = v;
  }
  /// Whether it is on its way back.
  bool plan() {
    const auto reference = [&](double s) {
      const LinePoint p = line_.at(s);
      RefPoint r;
      r.s = p.s, r.x = p.x, r.y = p.y, r.yaw = p.yaw, r.kappa = p.kappa, r.left = p.left, r.right = p.right;
      return r;
    };
    foot_ = follower_.locate(line_, now_.x.x, now_.x.y, now_.x.yaw);
    if (!path_.update(now_, foot_, mu, reference)) return false;
    path_.fill(
        now_, dt, reference, [](double) { return 20.0; }, [](double) { return 3.0; }, horizon_);
    return true;
  }
  void drive() {
    const RefPoint& next = horizon_[1];
    now_.x.x = next.x;
    now_.x.y = next.y;
    now_.x.yaw = next.yaw;
    now_.x.vx = next.v;
    now_.t += dt;
  }
  double angle() const { return std::remainder(now_.x.yaw - line_.at(foot_).yaw, 2 * pi); }
  double off() const { return std::hypot(now_.x.x, now_.x.y) - circle; }  // to the right
  const Observation& now() const { return now_; }
  const std::array<RefPoint, 51>& horizon() const { return horizon_; }

 private:
  ClosedLine line_ = round_line();
  RecoveryPath path_{full_size_car(), line_};
  LineFollower follower_;
  Observation now_;
  double foot_ = 0;
  std::array<RefPoint, 51> horizon_{};
};

struct Pose {
  double n, angle;
};

TEST(RecoveryPath, LeadsBackFromAnyPose) {
  for (const Pose& pose : {Pose{0, pi}, Pose{4, 2.5}, Pose{-4, -2.5}, Pose{0, 1.6}, Pose{30, 0}, Pose{-40, 3},
                           Pose{60, -1.6}, Pose{5, -pi}}) {
    Driver driver(pose.n, pose.angle, 0);
    ASSERT_TRUE(driver.plan()) << pose.n << " m, " << pose.angle << " rad";
    EXPECT_NEAR(driver.horizon()[0].x, driver.now().x.x, 1e-9);
    EXPECT_NEAR(driver.horizon()[0].y, driver.now().x.y, 1e-9);
    EXPECT_NEAR(driver.horizon()[0].yaw, driver.now().x.yaw, 1e-9);
    double furthest = 0, fastest = 0;
    int steps = 0;
    do {
      const double before = driver.now().x.yaw, v = driver.now().x.vx;
      driver.drive();
      furthest = std::max(furthest, std::abs(driver.off()));
      fastest = std::max(fastest, std::abs(driver.now().x.yaw - before) / dt * v);
    } while (driver.plan() && ++steps < 5000);
    EXPECT_LT(steps, 4000) << pose.n << " m, " << pose.angle << " rad";
    EXPECT_LT(std::abs(driver.angle()), 0.6);
    EXPECT_LT(std::abs(driver.off()), 3.0);
    EXPECT_LT(furthest, std::max(std::abs(pose.n) + 17.0, half_width + 5.0));
    EXPECT_LT(fastest, 0.5 * mu * gravity) << "across, in m/s2";
  }
}

/// Along the line such a car would first be led further out, and a controller that looks a moment ahead rather stays.
TEST(RecoveryPath, LeadsBackACarThatStandsJustBesideTheRoad) {
  Driver outside(half_width + 0.5, 0.5, 0);
  EXPECT_TRUE(outside.plan());
  EXPECT_FALSE(Driver(half_width - 0.5, 0, 0).plan());
  EXPECT_FALSE(Driver(half_width + 0.5, 0.5, 5).plan());
  int steps = 0;
  double furthest = 0;
  do {
    outside.drive();
    furthest = std::max(furthest, -outside.off());
  } while (outside.plan() && ++steps < 2000);
  EXPECT_LT(steps, 1000);
  EXPECT_LT(furthest, half_width + 2.0);
  EXPECT_LT(std::abs(outside.off()), 3.0);
}

/// Shown the line at speed, a controller gains speed first and turns too late: a standing car that has little room on
/// the side it faces is led by arcs, and stays on the road where these can.
TEST(RecoveryPath, LeadsACarThatStandsAskewWithLittleRoom) {
  for (const double side : {1.0, -1.0}) {
    EXPECT_FALSE(Driver(0, 0.5 * side, 0).plan()) << "there is room enough";
    EXPECT_FALSE(Driver(4.5 * side, -0.5 * side, 0).plan()) << "it faces the line";
    EXPECT_FALSE(Driver(4 * side, 0.5 * side, 5).plan()) << "it is driving";
    EXPECT_FALSE(Driver(4.5 * side, 0.2 * side, 0).plan()) << "hardly askew";
    for (const Pose& pose : {Pose{4 * side, 0.5 * side}, Pose{0, 1.2 * side}}) {
      Driver driver(pose.n, pose.angle, 0);
      ASSERT_TRUE(driver.plan()) << pose.n << " m, " << pose.angle << " rad";
      double furthest = 0;
      int steps = 0;
      do {
        driver.drive();
        furthest = std::max(furthest, std::abs(driver.off()));
      } while (driver.plan() && ++steps < 2000);
      EXPECT_LT(steps, 1000);
      EXPECT_LT(furthest, half_width) << pose.n << " m, " << pose.angle << " rad";
    }
  }
}

/// It turns round within the width of its two radii, shared between both sides of the road.
TEST(RecoveryPath, TurnsRoundWithoutLeavingTheRoadFurtherThanItMust) {
  Driver driver(0, pi, 0);
  ASSERT_TRUE(driver.plan());
  double left = 0, right = 0;
  int steps = 0;
  do {
    driver.drive();
    left = std::max(left, -driver.off());
    right = std::max(right, driver.off());
  } while (driver.plan() && ++steps < 5000);
  EXPECT_LT(std::max(left, right), 12.5);
}

TEST(RecoveryPath, SlowsAFastCarDownAlongItsCourseFirst) {
  Driver driver(0, pi / 2, 20);
  ASSERT_TRUE(driver.plan());
  double last = 20;
  for (const RefPoint& r : driver.horizon()) {
    EXPECT_NEAR(r.y, 0, 1e-9);  // it moves towards the origin
    EXPECT_LE(r.v, last);
    last = r.v;
  }
  EXPECT_LT(last, 19);
  EXPECT_GT(last, 20 - mu * gravity);
}

TEST(RecoveryPath, LeavesOthersAlone) {
  for (const Pose& pose : {Pose{0, 0}, Pose{4, 0.5}, Pose{-4, -0.5}, Pose{0, 1.0}, Pose{10, 0}}) {
    Driver driver(pose.n, pose.angle, 15);
    EXPECT_FALSE(driver.plan()) << pose.n << " m, " << pose.angle << " rad";
  }
}

}  // namespace test_recovery_path
}  // namespace gripline
