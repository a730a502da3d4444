#include "common/planning/join_path.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/full_size_car.hpp"

namespace gripline {
namespace test_join_path {

using planning::JoinPath;
using testing_support::full_size_car;

constexpr double length = 1000, half_width = 6, mu = 0.5, horizon_s = 1;

/// The line is the x axis, in the middle of the road.
RefPoint on_line(double s) {
  RefPoint r;
  r.s = s;
  r.x = s;
  r.left = r.right = half_width;
  r.v = 30;
  return r;
}
Observation car_at(double y, double yaw, double v) {
  Observation now;
  now.x.x = 100;
  now.x.y = y;
  now.x.yaw = yaw;
  now.x.vx = v;
  return now;
}
JoinPath joining(double y, double yaw, double v) {
  JoinPath join(full_size_car(), length);
  join.update(car_at(y, yaw, v), 100, mu, horizon_s, on_line);
  return join;
}
RefPoint moved(const JoinPath& join, double s) {
  std::array one{on_line(s)};
  join.move(one);
  return one[0];
}

TEST(JoinPath, LeadsFromTheCarsPlaceAndHeadingToTheLine) {
  const double turn = std::numbers::pi / 6;
  for (const double y : {4.0, -4.0}) {
    for (const double yaw : {0.0, turn, -turn}) {
      for (const double v : {0.1, 6.0, 15.0}) {
        const JoinPath join = joining(y, yaw, v);
        ASSERT_TRUE(join.active());
        const RefPoint first = moved(join, 100), last = moved(join, 500);
        EXPECT_NEAR(first.y, y, 1e-9);
        EXPECT_NEAR(first.yaw, yaw, 1e-9);
        EXPECT_NEAR(first.left, half_width - y, 1e-9);
        EXPECT_NEAR(first.right, half_width + y, 1e-9);
        EXPECT_EQ(last.y, 0);
        EXPECT_EQ(last.yaw, 0);
        EXPECT_EQ(join.speed(500), std::numeric_limits<double>::infinity());
      }
    }
  }
}

// An edge between the car and its way would hold it where it is: it goes further out at first where it faces outwards.
TEST(JoinPath, LeavesRoomBesideAWayOutsideOfTheRoad) {
  const double outside = 3, width = full_size_car().width;
  for (const double side : {1.0, -1.0}) {
    const JoinPath join = joining(side * (half_width + outside), 0.2 * side, 0.1);
    const RefPoint first = moved(join, 100);
    EXPECT_NEAR(side > 0 ? first.left : first.right, width, 1e-9);
    EXPECT_NEAR(side > 0 ? first.right : first.left, 2 * half_width + outside, 1e-9);
  }
  // Nearer to the edge than its width it has as much room as it is off; on the edge none.
  EXPECT_NEAR(moved(joining(half_width + 0.5, 0, 0.1), 100).left, 0.5, 1e-9);
  EXPECT_NEAR(moved(joining(half_width, 0, 0.1), 100).left, 0, 1e-9);
}

// In a slide that is planned the car stands across its course: on the line it goes along it, however slowly forward.
TEST(JoinPath, LeavesACarThatSlidesAlongItsLineToTheController) {
  const double v = 7, askew = 1.1;
  Observation slides = car_at(0, askew, v * std::cos(askew));
  slides.x.vy = -v * std::sin(askew);
  ASSERT_LT(slides.x.vx, 2 * full_size_car().v_min);
  JoinPath join(full_size_car(), length);
  join.update(slides, 100, mu, horizon_s, on_line);
  EXPECT_FALSE(join.active());
  // With the same heading, and a course across the line, it is led back to it.
  slides.x.vy = 0;
  slides.x.vx = v;
  join.update(slides, 100, mu, horizon_s, on_line);
  EXPECT_TRUE(join.active());
}

TEST(JoinPath, IsAsSharpAsFrictionAllowsAtTheSpeedItAsksFor) {
  for (const double v : {0.1, 15.0, 30.0}) {
    const JoinPath join = joining(4, 0, v);
    for (double s = 101; s < 400; s += 1) {
      const double e = 0.1;
      const double bend = (moved(join, s + e).y - 2 * moved(join, s).y + moved(join, s - e).y) / (e * e);
      EXPECT_LE(std::abs(bend) * v * v, 0.32 * mu * gravity) << "s = " << s << ", v = " << v;
    }
  }
}

/// Beside the road every second counts: the way back is sharper than from well inside of it, and shorter.
TEST(JoinPath, LeadsBackSoonerFromBesideTheRoad) {
  const auto way = [](double y) {
    const JoinPath join = joining(y, 0, 20);
    double s = 100;
    while (s < 600 && moved(join, s).y > 0.5 * y) s += 0.5;
    return (s - 100) / std::sqrt(y);  // at one curvature ways grow with the square root of the offset
  };
  EXPECT_LT(way(half_width + 1), 0.8 * way(half_width - 2));
}

TEST(JoinPath, StaysOnTheRoadAndSlowsDownForIt) {
  const double turn = std::numbers::pi / 6;
  double slowest = 30;
  for (const double yaw : {turn, -turn}) {
    const JoinPath join = joining(2, yaw, 25);
    for (double s = 100; s < 600; s += 1) {
      EXPECT_LE(std::abs(moved(join, s).y), half_width) << "s = " << s;
      slowest = std::min(slowest, join.speed(s));
    }
  }
  EXPECT_LT(slowest, 15);
  EXPECT_GT(slowest, 3);
}

/// 2 m from the edge, askew towards it: while a car slows down its wheels turn. In the middle of the road there is room.
TEST(JoinPath, IsSlowerWhereItLeadsTowardsAnEdgeThatIsNear) {
  const double turn = std::numbers::pi / 6;
  const JoinPath near = joining(4, turn, 5), middle = joining(0, turn, 5);
  EXPECT_NEAR(near.speed(101), 3.5, 0.01);
  EXPECT_GT(middle.speed(101), 5);
  double s = 100;
  while (moved(near, s + 1).y > moved(near, s).y) s += 1;
  EXPECT_GT(near.speed(s + 3), 3.6);  // on its way back
}

/// Whether there is room is not seen from where the way begins: the road narrows after 15 m, on either side.
TEST(JoinPath, TurnsSoonerWhereTheRoadNarrowsAhead) {
  const double turn = std::numbers::pi / 9;
  for (const double side : {1.0, -1.0}) {
    const auto farthest = [&](double narrow) {
      const auto narrows = [&](double s) {
        RefPoint r = on_line(s);
        (side > 0 ? r.left : r.right) = s < 115 ? 20 : narrow;
        return r;
      };
      JoinPath join(full_size_car(), length);
      join.update(car_at(3 * side, turn * side, 5), 100, mu, horizon_s, narrows);
      EXPECT_TRUE(join.active());
      double most = 0;
      for (double s = 115; s < 300; s += 1) most = std::max(most, side * moved(join, s).y);
      return most;
    };
    EXPECT_GT(farthest(20), 6);
    EXPECT_LT(farthest(5), 5 - 0.5 * full_size_car().width);
  }
}

/// Speeds along the way are what the car can brake to from bend to bend.
TEST(JoinPath, SpeedsFallNoFasterThanTheCarBrakes) {
  const JoinPath join = joining(2, std::numbers::pi / 6, 25);
  ASSERT_TRUE(join.active());
  for (double s = 100; join.speed(s + 1) < 100; s += 1) {
    const double now = join.speed(s), then = join.speed(s + 1);
    EXPECT_LE(now * now - then * then, 2 * 0.62 * mu * gravity) << "s = " << s;
  }
}

/// A fast car can neither brake at once nor turn as sharply as a slow one, however much room a sharp way keeps.
TEST(JoinPath, OfAFastCarIsOneThatItCanSlowDownFor) {
  for (const double yaw : {0.3, -0.3}) {
    JoinPath join(full_size_car(), 5 * length);
    join.update(car_at(3.5, yaw, 40), 100, 1.0, horizon_s, on_line);
    ASSERT_TRUE(join.active());
    EXPECT_GT(join.speed(100), 15) << yaw;
  }
}

TEST(JoinPath, OfASlowCarIsOneThatItCanSteer) {
  const Car car = full_size_car();
  const double full_lock = std::tan(car.delta_max) / (car.lf + car.lr);
  for (const double y : {-3.5, -3.0, 3.0, 3.5})
    for (const double yaw : {-0.5, -0.3, 0.0, 0.3, 0.5}) {
      const JoinPath join = joining(y, yaw, 5);
      ASSERT_TRUE(join.active());
      for (double s = 100.25; s < 150; s += 0.25) {
        const double e = 0.05, slope = (moved(join, s + e).y - moved(join, s - e).y) / (2 * e);
        const double bend = (moved(join, s + e).y - 2 * moved(join, s).y + moved(join, s - e).y) / (e * e);
        EXPECT_LE(std::abs(bend) / std::pow(1 + slope * slope, 1.5), 1.05 * full_lock) << y << " " << yaw << " " << s;
      }
    }
}

/// A line that is itself near an edge is no reason to reach it sooner.
TEST(JoinPath, IsGentleTowardsALineNearAnEdge) {
  const auto near_edge = [](double s) {
    RefPoint r = on_line(s);
    r.left = s > 105 ? 0.95 : half_width;
    return r;
  };
  JoinPath beside(full_size_car(), length), free(full_size_car(), length);
  beside.update(car_at(-3, 0, 10), 100, mu, horizon_s, near_edge);
  free.update(car_at(-3, 0, 10), 100, mu, horizon_s, on_line);
  ASSERT_TRUE(beside.active());
  EXPECT_EQ(moved(beside, 115).y, moved(free, 115).y);
}

/// In a turn the way is driven no faster than friction allows in its bends and the line's together, but a line that is
/// planned for more than the friction of a level road, in a banked turn, is driven as planned.
TEST(JoinPath, IsAsSlowInATurnAsBothBendsAsk) {
  constexpr double kappa = 0.02;
  for (const double planned : {15.0, 22.0}) {
    const auto turn = [planned](double s) {
      RefPoint r = on_line(s);
      r.kappa = kappa;
      r.v = planned;
      return r;
    };
    JoinPath join(full_size_car(), length);
    join.update(car_at(-4, 0, 12), 100, mu, horizon_s, turn);
    ASSERT_TRUE(join.active());
    const double most = std::max(mu * gravity, kappa * planned * planned);
    double slowest = 100;
    for (double s = 101; join.speed(s) < 100; s += 1) slowest = std::min(slowest, join.speed(s));
    EXPECT_LT(slowest, 0.95 * std::sqrt(most / kappa)) << "where the way turns with the line";
    EXPECT_GT(slowest, 0.5 * std::sqrt(most / kappa));
  }
}

TEST(JoinPath, GoesOnBeyondTheEndOfALap) {
  const auto within = [](double s) {
    EXPECT_TRUE(s >= 0 && s < length) << s;
    return on_line(s);
  };
  JoinPath join(full_size_car(), length);
  Observation now = car_at(4, 0, 15);
  now.x.x = 990;
  join.update(now, 990, mu, horizon_s, within);
  ASSERT_TRUE(join.active());
  EXPECT_NEAR(moved(join, 5).y, moved(joining(4, 0, 15), 115).y, 1e-9);
  EXPECT_NEAR(join.speed(5), joining(4, 0, 15).speed(115), 1e-9);
}

TEST(JoinPath, LeavesACarAloneThatIsOnTheLine) {
  const JoinPath join = joining(1.5, 0.1, 25);
  EXPECT_FALSE(join.active());
  EXPECT_EQ(moved(join, 120).y, 0);
  EXPECT_EQ(join.speed(120), std::numeric_limits<double>::infinity());
}

/// References advance by v / stretch along the line: on the way itself that is v.
TEST(JoinPath, IsLongerThanTheLineOnTheOutsideOfATurn) {
  constexpr double kappa = 0.02, radius = 1 / kappa;  // a turn to the left about (0, radius)
  const auto on_turn = [](double s) {
    RefPoint r = on_line(s);
    r.x = radius * std::sin(kappa * s);
    r.y = radius * (1 - std::cos(kappa * s));
    r.yaw = kappa * s;
    r.kappa = kappa;
    return r;
  };
  for (const double off : {-5.0, 5.0}) {
    JoinPath join(full_size_car(), length);
    Observation now = car_at(off, 0, 10);
    now.x.x = 0;
    join.update(now, 0, mu, horizon_s, on_turn);
    ASSERT_TRUE(join.active());
    for (double s = 0; s < 30; s += 3) {
      constexpr double e = 0.01;
      std::array ends{on_turn(s - e), on_turn(s + e)};
      join.move(ends);
      const double way = std::hypot(ends[1].x - ends[0].x, ends[1].y - ends[0].y) / (2 * e);
      if (s > 0) {
        EXPECT_NEAR(join.stretch(s, kappa), way, 1e-3) << "s = " << s << ", off = " << off;
      }
    }
    EXPECT_NEAR(join.stretch(0, kappa), 1 - off * kappa, 1e-9);
    EXPECT_EQ(join.stretch(300, kappa), 1.0);
  }
}

/// What the controller is left to take back by itself is no way, the more so the more of the friction it may use.
TEST(JoinPath, BeginsBeyondWhatTheControllerReaches) {
  constexpr double wide_horizon = 2, off = 4;
  for (const double reach : {0.4, 1.0}) {
    JoinPath join(full_size_car(), length, reach);
    join.update(car_at(off, 0, 15), 100, mu, wide_horizon, on_line);
    EXPECT_EQ(join.active(), off > 0.25 * reach * mu * gravity * wide_horizon * wide_horizon) << reach;
  }
}

/// The way stays where it began: what a controller is shown does not move along with the car.
TEST(JoinPath, KeepsItsWayWhileTheCarFollowsIt) {
  JoinPath join = joining(4, 0, 15);
  const double planned = moved(join, 125).y;
  Observation now = car_at(moved(join, 110).y + 0.3, moved(join, 110).yaw, 15);
  now.x.x = 110;
  join.update(now, 110, mu, horizon_s, on_line);
  EXPECT_EQ(moved(join, 125).y, planned);
  now.x.y += 3.5;  // pushed off: it begins anew
  join.update(now, 110, mu, horizon_s, on_line);
  EXPECT_NEAR(moved(join, 110).y, now.x.y, 1e-9);
}

}  // namespace test_join_path
}  // namespace gripline
