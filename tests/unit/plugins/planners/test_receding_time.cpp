#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/planning/closed_line.hpp"
#include "common/planning/line_follower.hpp"
#include "support/allocation_counter.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_receding_time {

using namespace testing_support;
using planning::ClosedLine;
using planning::LineFollower;
using Changes = std::vector<std::pair<std::string, double>>;

class RecedingTimeTest : public ::testing::Test, protected PlannerRig {
 protected:
  Instance<SpeedPlanner> make(const Track& track, const Changes& changes) {
    const PluginEntry& entry = registry_.find(abi::Kind::planner, "receding_time");
    return create<SpeedPlanner>(entry, context_on(track), values_of(entry, changes));
  }
  /// Why no planner is made of these.
  std::string refusal(const Changes& changes) {
    try {
      make(mobil_, changes);
    } catch (const PluginError& error) {
      return error.what();
    }
    return "nothing was thrown";
  }
  static Belief believe(double mu) { return {mu, mu, 0.0, 0.0, true}; }

  /// Drives the references exactly for so many steps; what is driven after half of them, over what was driven there
  /// [m].
  double drive(SpeedPlanner& planner, const Belief& belief, int steps) {
    double way = 0;
    for (int i = 0; i < steps; ++i) {
      planner.plan(now_, belief, nullptr, horizon_);
      const RefPoint& r = horizon_[1];
      if (i >= steps / 2) way += std::hypot(r.x - now_.x.x, r.y - now_.x.y);
      now_.t += 0.02;
      now_.x = {r.x, r.y, r.yaw - r.beta, r.v, r.v * std::tan(r.beta), 0.0, 0.0};
      now_.at = r.at;
      room_ = std::min({room_, r.left, r.right});
    }
    return way;
  }
  void start(SpeedPlanner& planner) {
    const LinePoint& p = planner.line()[0];
    now_ = {};
    now_.x = {p.x, p.y, p.yaw, 1.5, 0.0, 0.0, 0.0};
    now_.at.s = p.station;
  }

  /// Speeds along the path that are asked for at twelve places, of a car that is too fast there [m/s].
  std::vector<double> asked(double mu, Changes changes) {
    changes.insert(changes.end(), {{"spacing", 0.1}, {"start", 0.9}, {"factor", 1.0}, {"rise", 100.0}});
    const auto planner = make(mobil_, changes);
    std::vector<double> speeds;
    for (std::size_t i = 0; i < 12; ++i) {
      const LinePoint& p = planner->line()[i * planner->line().size() / 12];
      now_.x = {p.x, p.y, p.yaw, 6.0, 0.0, 0.0, 0.0};
      now_.at.s = p.station;
      Belief belief = believe(mu);
      belief.trusted = trusted_;
      planner->plan(now_, belief, nullptr, horizon_);
      for (const RefPoint& r : {horizon_[0], horizon_[1]}) speeds.push_back(r.v / std::cos(r.beta));
    }
    return speeds;
  }

  std::vector<RefPoint> horizon_ = std::vector<RefPoint>(20);
  Observation now_;
  double room_ = INFINITY;
  bool trusted_ = true;  // what asked() believes
};

TEST_F(RecedingTimeTest, FollowsTheFrictionThatIsBelievedWithoutAllocating) {
  const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}, {"rise", 1.0}, {"factor", 1.0}});
  start(*planner);
  drive(*planner, believe(0.9), 50);
  const long allocated = rig::allocations.load();
  // Half of them are about a lap.
  const double fast = drive(*planner, believe(0.9), 500), slow = drive(*planner, believe(0.6), 500);
  EXPECT_EQ(rig::allocations.load(), allocated);
  EXPECT_GT(fast, 1.08 * slow);  // sqrt(0.9 / 0.6) is 1.22, where nothing but friction limits
  EXPECT_LT(fast, 1.25 * slow);
  // The line keeps its margin of 0.4 widths, and half a width is the car's own.
  EXPECT_GT(room_, 0.3 * car_.width);
}

/// Laps are solved for `mu_lo` at least. Friction below that is driven at the root of its share.
TEST_F(RecedingTimeTest, DrivesMoreSlowlyBelowTheLeastFrictionThatItExpects) {
  const Changes least{{"mu_lo", 0.6}};
  const std::vector<double> expected = asked(0.6, least);
  const double planned_slip = horizon_[1].beta;
  const std::vector<double> below = asked(0.3, least);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(below[i], std::sqrt(0.5) * expected[i], 1e-4) << i;
  // Half of the force at half of the friction slips as far.
  EXPECT_NEAR(horizon_[1].beta, planned_slip, 1e-4);
}

TEST_F(RecedingTimeTest, WhatIsDrivenBelowTheLeastFrictionRisesAsSlowlyAsAPlan) {
  const auto planner = make(mobil_, {{"spacing", 0.1}, {"mu_lo", 0.6}, {"start", 0.9}, {"factor", 1.0}, {"rise", 0.1}});
  start(*planner);
  const auto speed_asked = [&](double mu) {
    planner->plan(now_, believe(mu), nullptr, horizon_);
    return horizon_[1].v / std::cos(horizon_[1].beta);
  };
  const double slow = speed_asked(0.3);
  EXPECT_LT(speed_asked(1.0), 1.02 * slow);
  for (int i = 0; i < 100; ++i) speed_asked(1.0);
  EXPECT_GT(speed_asked(1.0), 1.2 * slow);  // 2 s later 0.5 is driven
}

/// `pace` less `pace_fall` times the planned speed is the share of it that is driven.
TEST_F(RecedingTimeTest, KeepsBackMoreOfALargerSpeed) {
  const double pace = 0.98, fall = 0.05;  // [1, s/m]
  const std::vector<double> planned = asked(0.9, {}), driven = asked(0.9, {{"pace", pace}, {"pace_fall", fall}});
  for (std::size_t i = 0; i < planned.size(); ++i)
    EXPECT_NEAR(driven[i], (pace - fall * planned[i]) * planned[i], 1e-9) << i;
  const auto [slowest, fastest] = std::minmax_element(planned.begin(), planned.end());
  EXPECT_GT(*fastest, 1.5 * *slowest);
}

/// E[max(0, mu - M)] / mu of a normal M, by the midpoint rule.
double mean_fall(double mu, double mean, double spread) {
  constexpr int count = 20000;
  const double lowest = mean - 10.0 * spread, step = (mu - lowest) / count;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double m = lowest + (i + 0.5) * step, z = (m - mean) / spread;
    sum += (mu - m) * std::exp(-0.5 * z * z) * step;
  }
  return sum / (spread * std::sqrt(2.0 * std::numbers::pi) * mu);
}

/// What `pace` keeps back is for friction that falls at once: a part of it is kept in proportion to how far it can
/// fall.
TEST_F(RecedingTimeTest, KeepsBackLessWhereLessFrictionIsLeftToLose) {
  const double pace = 0.9, kept = 0.25, mean = 0.9, spread = 0.2;
  const Changes reserve{{"pace", pace}, {"pace_kept", kept}, {"pace_friction", mean}, {"pace_spread", spread}};
  for (const double mu : {0.6, 0.9, 1.0}) {
    const double fall = mean_fall(mu, mean, spread) / mean_fall(mean, mean, spread);
    const double share = mu > mean ? 1.0 : kept + (1.0 - kept) * fall;
    const std::vector<double> planned = asked(mu, {}), driven = asked(mu, reserve);
    for (std::size_t i = 0; i < planned.size(); ++i)
      EXPECT_NEAR(driven[i], (1.0 - share * (1.0 - pace)) * planned[i], 1e-6) << mu << ", " << i;
    if (mu < mean) {
      EXPECT_LT(share, 0.9);
    }
  }
}

/// What is planned for before learning is trusted says nothing of how far friction can fall.
TEST_F(RecedingTimeTest, KeepsAllBackUntilItTrustsItsBelief) {
  // 0.9 is planned for, 1.2 expected: far less than all would be kept at the same friction, believed.
  const Changes reserve{{"pace", 0.9}, {"pace_kept", 0.25}, {"pace_friction", 1.2}, {"pace_spread", 0.2}};
  trusted_ = false;
  const std::vector<double> planned = asked(0.9, {}), driven = asked(0.9, reserve);
  ASSERT_FALSE(planned.empty());
  ASSERT_EQ(driven.size(), planned.size());
  for (std::size_t i = 0; i < planned.size(); ++i) EXPECT_NEAR(driven[i], 0.9 * planned[i], 1e-9) << i;
}

TEST_F(RecedingTimeTest, RefusesToDriveLessFrictionFaster) {
  EXPECT_THAT(refusal({{"pace", 0.7}, {"pace_kept", 0.0}, {"pace_friction", 0.9}, {"pace_spread", 0.1}}),
              ::testing::HasSubstr("pace_kept"));
}

TEST_F(RecedingTimeTest, RefusesToDriveFasterPlansMoreSlowly) {
  EXPECT_THAT(refusal({{"pace", 0.5}, {"pace_fall", 0.1}}), ::testing::HasSubstr("pace_fall"));
}

TEST_F(RecedingTimeTest, RefusesALeastFrictionAboveTheLargest) {
  EXPECT_THAT(refusal({{"mu_lo", 1.0}, {"mu_hi", 0.5}}), ::testing::HasSubstr("\"mu_lo\" is above \"mu_hi\""));
}

/// The road is told in metres, the parameter is in widths of the car: the message has both.
TEST_F(RecedingTimeTest, AMarginThatLeavesNoRoadIsToldInWidthsAndMetres) {
  EXPECT_THAT(refusal({{"margin", 8.0}}),
              ::testing::AllOf(::testing::HasSubstr("the road is 0.46 m wide"),
                               ::testing::HasSubstr("this planner's \"margin\" is in widths of the car: 8, which are "
                                                    "0.24 m from the centre of gravity to each edge")));
}

TEST_F(RecedingTimeTest, RefusesASpacingThatDoesNotSuitTheLap) {
  for (const double spacing : {1e-3, 50.0})
    EXPECT_THAT(refusal({{"spacing", spacing}}),
                ::testing::ContainsRegex("\"spacing\" of .* m; expected 0\\.00[0-9]* to [01]\\.[0-9]* m"));
}

/// A car that drives at a share of its plan's speed needs less side force in a turn than the plan, and slips less.
TEST_F(RecedingTimeTest, PlansLessSideslipAtALowerPace) {
  double slip[2] = {0, 0}, speed[2] = {0, 0};
  for (const bool slow : {false, true}) {
    const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}, {"pace", slow ? 0.8 : 1.0}});
    const std::span<const LinePoint> line = planner->line();
    const auto tightest = std::max_element(line.begin(), line.end(), [](const LinePoint& a, const LinePoint& b) {
      return std::abs(a.kappa) < std::abs(b.kappa);
    });
    now_ = {};
    now_.x = {tightest->x, tightest->y, tightest->yaw, 0.5, 0.0, 0.0, 0.0};
    now_.at.s = tightest->station;
    planner->plan(now_, believe(0.9), nullptr, horizon_);
    slip[slow] = car_.lr * horizon_[0].kappa - horizon_[0].beta;
    speed[slow] = horizon_[0].v / std::cos(horizon_[0].beta);
  }
  EXPECT_GT(std::abs(slip[0]), 0.1);
  EXPECT_GT(slip[1] / slip[0], 0.2);
  EXPECT_LT(slip[1] / slip[0], 0.7);            // 0.64 of the force
  EXPECT_NEAR(speed[1], 0.8 * speed[0], 1e-9);  // along the path, whatever the car's angle to it
}

/// References say by how much friction differs from that below the car: nothing where no place is known, and on the lap
/// after a place was met what changes on the way into it and out of it, right also while the belief is a moment late on
/// the way in. Just behind it no more than is believed.
TEST_F(RecedingTimeTest, SaysWhereTheRoadAheadIsSlippery) {
  const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}, {"rise", 10.0}, {"places", 1.0}});
  const auto wet = [this](const Place& at) {
    const double share = at.s / mobil_.length();
    return share > 0.5 && share < 0.7;
  };
  const auto near_its_end = [this](const Place& at) {  // within a piece of the road that has one friction
    return std::abs(at.s - 0.7 * mobil_.length()) < 0.1;
  };
  start(*planner);
  double believed = 0.9, before = 0.9;
  int dry_laps = 0, into = 0, out_of = 0;
  for (int i = 0; i < 1100 && dry_laps < 3; ++i) {  // three laps
    const double here = now_.at.s;
    drive(*planner, believe(believed), 1);
    if (now_.at.s < here) ++dry_laps;
    const RefPoint &first = horizon_.front(), &last = horizon_.back();
    if (dry_laps == 0) {
      ASSERT_EQ(last.at.grip, 1.0) << i;
    } else if (dry_laps == 2) {
      const double expected = wet(last.at) ? 0.6 : 0.9;  // but just before the place, which begins a little early
      const bool early = !wet(last.at) && last.at.s / mobil_.length() > 0.4 && last.at.s / mobil_.length() < 0.5;
      const bool behind = !wet(first.at) && believed < 0.75;  // the place may have grown
      if (near_its_end(first.at) || near_its_end(last.at)) {
        EXPECT_LE(last.at.grip, 1.51) << i;
        EXPECT_GE(last.at.grip, 0.6) << i;
      } else if (behind) {
        EXPECT_LE(last.at.grip, 1.0) << i;
      } else if (!early) {
        EXPECT_NEAR(last.at.grip * believed, expected, 0.05) << i;
      }
      into += !wet(first.at) && wet(last.at) ? 1 : 0;
      out_of += wet(first.at) && !wet(last.at) ? 1 : 0;
    }
    believed = before;  // a step late
    before = wet(now_.at) && dry_laps > 0 ? 0.6 : 0.9;
  }
  EXPECT_EQ(dry_laps, 3);
  EXPECT_GT(into, 5);
  EXPECT_GT(out_of, 5);
}

/// Behind a slippery place that is known the road is as it was in front of it, though friction rises slowly otherwise and
/// the belief comes back later than in the lap before.
TEST_F(RecedingTimeTest, IsAsFastBehindAKnownSlipperyPlaceAsWithoutIt) {
  const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}, {"mu_lo", 0.8}, {"rise", 0.1}, {"places", 1.0}});
  start(*planner);
  std::array<double, 4> way{};  // behind the place, by lap; the first begins behind it [m]
  std::array<int, 4> steps{};
  std::array<double, 12> believed{};  // in the last steps
  believed.fill(0.9);
  std::size_t lap = 0;
  for (int i = 0; i < 1500; ++i) {
    const double here = now_.at.s;
    drive(*planner, believe(believed[lap < 3 ? 8 : 0]), 1);
    if (now_.at.s < here && ++lap == way.size()) break;
    const double share = now_.at.s / mobil_.length();
    if (share > 0.72 && share < 0.85) {
      way[lap] += std::hypot(now_.x.vx, now_.x.vy) * 0.02;
      ++steps[lap];
    }
    std::ranges::rotate(believed, believed.begin() + 1);
    believed.back() = share > 0.5 && share < 0.7 && lap > 1 ? 0.6 : 0.9;
  }
  ASSERT_EQ(lap, way.size());
  EXPECT_GT(way[3] / steps[3], 0.97 * way[1] / steps[1]);
  EXPECT_LT(way[2] / steps[2], 0.95 * way[1] / steps[1]) << "when it was new";
}

// Larger slips than `slip_max` are planned where the car has slipped nearly as far, not before, and not at speed.
TEST_F(RecedingTimeTest, PlansLargeSlipsOnceTheyWereSeen) {
  const auto horizons = [&](double most, double slip_fast = 0.0) {
    const auto planner =
        make(mobil_, {{"spacing", 0.1}, {"start", 0.6}, {"slip_most", most}, {"slip_fast", slip_fast}});
    start(*planner);
    std::vector<RefPoint> all;
    for (const double vy : {0.0, -1.5})  // a slip of pi / 4
      for (int i = 0; i < 50; ++i) {
        now_.x.vy = vy;
        planner->plan(now_, believe(0.6), nullptr, horizon_);
        all.insert(all.end(), horizon_.begin(), horizon_.end());
        now_.t += 0.02;
      }
    return all;
  };
  const std::vector<RefPoint> plain = horizons(0.0);
  const auto differences = [&](const std::vector<RefPoint>& bold) {
    std::array<double, 2> largest{};
    for (std::size_t i = 0; i < plain.size(); ++i) {
      double& half = largest[i < plain.size() / 2 ? 0 : 1];
      half = std::max(half, std::hypot(bold[i].x - plain[i].x, bold[i].y - plain[i].y));
    }
    return largest;
  };
  const auto bold = differences(horizons(1.0));
  EXPECT_EQ(bold[0], 0.0);
  EXPECT_GT(bold[1], 1e-3);
  const auto slow_only = differences(horizons(1.0, 0.1));  // every speed here is faster
  EXPECT_LT(slow_only[1], 0.2 * bold[1]);
}

/// Where the car is nearly as far outside of a turn as the turn's radius, steps without the curvature hardly converge.
TEST_F(RecedingTimeTest, FindsTheNearestPointOfACarOutsideOfATurn) {
  const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}});
  const std::span<const LinePoint> line = planner->line();
  const auto tightest = std::max_element(line.begin(), line.end(), [](const LinePoint& a, const LinePoint& b) {
    return std::abs(a.kappa) < std::abs(b.kappa);
  });
  const auto place = static_cast<std::size_t>(tightest - line.begin());
  for (std::size_t i = 0; i < 9; i += 2) {
    const LinePoint& p = line[(place + line.size() - 4 + i) % line.size()];
    const double off = (p.kappa > 0 ? -0.85 : 0.85) / std::abs(tightest->kappa);
    now_.x = {p.x - off * std::sin(p.yaw), p.y + off * std::cos(p.yaw), p.yaw, 0.5, 0.0, 0.0, 0.0};
    planner->plan(now_, believe(0.9), nullptr, horizon_);
    const auto distance = [&](double x, double y) { return std::hypot(x - now_.x.x, y - now_.x.y); };
    double nearest = INFINITY;
    for (const LinePoint& q : line) nearest = std::min(nearest, distance(q.x, q.y));
    EXPECT_LT(distance(horizon_[0].x, horizon_[0].y), nearest + 1e-3) << i;
  }
}

/// The tyres that a planner without a learner believes in, as if they had been learned.
class KnownTyres final : public TyreCurve {
 public:
  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    const double peak = 0.9 * gravity * 0.041 * (axle == Axle::front ? 0.033 : 0.029) / 0.062;
    for (std::size_t i = 0; i < slip.size(); ++i) {
      force[i] = peak * std::sin(1.3 * std::atan(4.0 * slip[i]));
      if (i < sigma.size()) sigma[i] = 0.01 * peak;
    }
    return true;
  }
};

/// A driver who is much faster than planned once, and loses no more than 3 m/s2 in the two seconds after it.
class RecedingTimeTooFast : public RecedingTimeTest {
 protected:
  /// The way of twelve seconds [m], about two laps, that begin three seconds after it.
  double drive_on(bool from_car_state) {
    const auto planner =
        make(mobil_, {{"spacing", 0.1}, {"start", 0.9}, {"pace", 0.8}, {"from_car_state", from_car_state ? 1.0 : 0.0}});
    start(*planner);
    double way = 0;
    long before = 0;
    for (int i = 0; i < 850; ++i) {
      if (i == 50) before = rig::allocations.load();
      planner->plan(now_, believe(0.9), &tyres_, horizon_);
      const RefPoint& r = horizon_[1];
      if (i >= 250) way += std::hypot(r.x - now_.x.x, r.y - now_.x.y);
      double v = i > 100 && i < 200 ? std::max(r.v, now_.x.vx - 3.0 * 0.02) : r.v;
      if (i == 100) v = 1.4 * r.v;
      now_.t += 0.02;
      now_.x = {r.x, r.y, r.yaw - r.beta, v, v * std::tan(r.beta), v * r.kappa, 0.0};
      now_.at = r.at;
    }
    EXPECT_EQ(rig::allocations.load(), before);
    return way;
  }
  KnownTyres tyres_;
};

// A plan that begins with the car's own speed asks for `pace` of it: not again and again, which would end at a crawl.
// drive_on() looks at allocations too.
TEST_F(RecedingTimeTooFast, ItSlowsDownToItsPlanAndGoesOn) {
  const double plain = drive_on(false), own = drive_on(true);
  EXPECT_NEAR(own, plain, 0.01 * plain);
}

/// A driver who is put somewhere and then drives what is planned.
class RecedingTimeFromAnywhere : public RecedingTimeTest {
 protected:
  void SetUp() override { planner_ = make(mobil_, {{"spacing", 0.1}, {"start", 0.9}}); }
  void put(const LinePoint& p, double n, double turned, double vx, double vy, double omega) {
    now_.x = {p.x - n * std::sin(p.yaw), p.y + n * std::cos(p.yaw), p.yaw + turned, vx, vy, omega, 0.0};
  }
  /// Seconds until it goes along the line, at most two widths of the car beside it, for a second; negative: not in ten.
  double until_racing() {
    const ClosedLine line(std::vector<LinePoint>(planner_->line().begin(), planner_->line().end()));
    LineFollower follower;
    int good = 0;
    for (int i = 0; i < 500; ++i) {
      planner_->plan(now_, believe(0.9), nullptr, horizon_);
      const RefPoint& r = horizon_[1];
      EXPECT_TRUE(std::isfinite(r.x) && std::isfinite(r.y) && std::isfinite(r.v));
      now_.t += 0.02;
      now_.x = {r.x, r.y, r.yaw - r.beta, r.v, r.v * std::tan(r.beta), 0.0, 0.0};
      const LinePoint p = line.at(follower.locate(line, r.x, r.y, r.yaw));
      const double turned = std::remainder(now_.x.yaw - p.yaw, 2.0 * std::numbers::pi);
      const bool racing = std::hypot(r.x - p.x, r.y - p.y) < 2.0 * car_.width && std::abs(turned) < 0.6 && r.v > 0.5;
      good = racing ? good + 1 : 0;
      if (good == 50) return now_.t - 1.0;
    }
    return -1.0;
  }
  Instance<SpeedPlanner> planner_ = nullptr;
};

TEST_F(RecedingTimeFromAnywhere, ACarThatStandsSpinsOrFacesBackwardsGoesOn) {
  struct Pose {
    double n, turned, vx, vy, omega;
  };
  const double pi = std::numbers::pi;
  for (const Pose& pose : {Pose{0, 0, 0, 0, 0}, Pose{0.1, 0, 0, 0, 0}, Pose{0, pi, 0, 0, 0}, Pose{-0.1, -2.5, 0, 0, 0},
                           Pose{0, pi, -1.5, 0, 0}, Pose{0, 1.6, 0, -1.5, 12.0}, Pose{0.1, -2.0, -0.8, 1.0, -12.0},
                           Pose{0.5, 0.3, 1.0, 0, 0}}) {
    for (const std::size_t share : {0, 3}) {
      now_ = {};
      put(planner_->line()[planner_->line().size() * share / 7], pose.n, pose.turned, pose.vx, pose.vy, pose.omega);
      const double seconds = until_racing();
      EXPECT_GE(seconds, 0.0) << pose.n << " m, " << pose.turned << " rad";
    }
  }
}

// Half a lap beside the plan's own window: the car was carried to another part of the road.
TEST_F(RecedingTimeFromAnywhere, ACarThatWasCarriedElsewhereGetsItsWindowThere) {
  start(*planner_);
  drive(*planner_, believe(0.9), 100);
  put(planner_->line()[planner_->line().size() / 2], 0.0, 0.0, 1.5, 0.0, 0.0);
  EXPECT_GE(until_racing(), 0.0);
  EXPECT_LT(now_.t, 2.0 + 3.0);
}

}  // namespace test_receding_time
}  // namespace gripline
