#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/planning/closed_line.hpp"
#include "common/planning/line_follower.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/receding_laps.hpp"
#include "planners/time_optimal/window_solver.hpp"
#include "support/allocation_counter.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace {

using namespace time_optimal;
using namespace testing_support;
using planning::ClosedLine;
using planning::LineFollower;
using Changes = std::vector<std::pair<std::string, double>>;

constexpr std::size_t nodes = 200, window = 80;

/// A lap of 12 m whose curvature swings, for the 1:43 car.
LapProblem swinging_road(double mu) {
  const Car car = car_1_43();
  const double weight = mu * gravity / (car.lf + car.lr);
  LapProblem p{.car = car,
               .tyres = {{4.0, 1.3, weight * car.lr}, {4.0, 1.3, weight * car.lf}},
               .drive = {CubicSpline(0, 4, std::vector<double>{-0.5, -0.6, -0.8, -1.2, -1.6}),
                         CubicSpline(0, 4, std::vector<double>{7, 5.5, 4, 2.5, 1.6}),
                         CubicSpline(0, 4, std::vector<double>{1, 1.5, 1.8, 1.9, 2})},
               .top_speed = 4.0,
               .slip_max = 0.7,
               .places = {},
               .ds = std::vector<double>(nodes, 12.0 / nodes),
               .n_lo = std::vector<double>(nodes, -0.15),
               .n_hi = std::vector<double>(nodes, 0.15),
               .mid_lo = std::vector<double>(nodes, -0.15),
               .mid_hi = std::vector<double>(nodes, 0.15)};
  for (std::size_t k = 0; k < nodes; ++k) {
    const double turn = 2.0 * std::numbers::pi, u = turn * static_cast<double>(k) / nodes;
    p.places.push_back({turn / 12.0 * (1.0 + 1.6 * std::cos(2.0 * u) + 0.8 * std::sin(5.0 * u)), 0.0, 0.0});
  }
  return p;
}

/// On the centre line, at 0.7 of a speed for which turns take the side force over mass `accel`, and straights `most`.
LapSolution guess_for(const LapProblem& p, double most = 2.5, double accel = 5.5) {
  LapSolution guess;
  for (const LapPlace& place : p.places) {
    const double v = 0.7 * std::min(most, std::sqrt(accel / std::max(1e-6, std::abs(place.kappa))));
    guess.z.push_back({0.0, 0.0, v, 0.0, v * place.kappa, (p.car.lf + p.car.lr) * place.kappa, 0.0, 0.0});
  }
  return guess;
}

class WindowTest : public ::testing::Test {
 protected:
  /// The window from node `first` with a falling barrier, near the states of a solved lap at both ends.
  WindowStep solve(WindowSolver& solver, std::vector<WindowNode>& lap, const LapSolution& solved, std::size_t first,
                   double barrier, int most) {
    WindowStep step;
    for (int i = 0; i < most; ++i) {
      step = solver.iterate(lap, first, window, barrier, solved.z[first], solved.z[first + window]);
      if (!step.good || step.change > 5e-3 || step.defect > 1e-4) continue;
      if (barrier <= 1e-5) break;
      barrier = std::max(1e-5, 0.2 * barrier);
    }
    return step;
  }
  static std::vector<WindowNode> nodes_of(const LapSolution& from) {
    std::vector<WindowNode> lap(nodes);
    for (std::size_t k = 0; k < nodes; ++k) lap[k].z = from.z[k];
    return lap;
  }
};

TEST_F(WindowTest, FindsTheLapThatIpoptFinds) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution guess = guess_for(problem), solved = solve_lap(problem, guess);
  ASSERT_TRUE(solved.solved);
  WindowSolver solver(problem, window);
  solver.set_car(problem.tyres, {});
  const std::size_t first = 20;
  std::vector<WindowNode> lap = nodes_of(guess);
  lap[first].z = solved.z[first];
  const WindowStep step = solve(solver, lap, solved, first, 1e-2, 200);
  EXPECT_TRUE(step.good);
  EXPECT_LT(step.defect, 1e-4);
  // What alternates from node to node is invisible to the midpoint rule: means of neighbours. The last quarter of the
  // window depends on how it is made to end; the planner does not use it.
  for (std::size_t k = first + 2; k < first + window * 3 / 4; ++k)
    for (const int j : {lap_n, lap_vx}) {
      const auto i = static_cast<std::size_t>(j);
      const auto mean = [&](const auto& z) { return 0.25 * (z(k - 1) + 2.0 * z(k) + z(k + 1)); };
      const double own = mean([&](std::size_t at) { return lap[at].z[i]; });
      const double ipopt = mean([&](std::size_t at) { return solved.z[at][i]; });
      EXPECT_NEAR(own, ipopt, j == lap_n ? 0.01 : 0.04) << "node " << k << ", variable " << j;
    }
}

TEST_F(WindowTest, FollowsChangedTyresWithoutAllocating) {
  const LapProblem problem = swinging_road(0.8);
  const LapSolution solved = solve_lap(problem, guess_for(problem));
  WindowSolver solver(problem, window);
  solver.set_car(problem.tyres, {});
  std::vector<WindowNode> lap = nodes_of(solved);
  solve(solver, lap, solved, 20, 1e-2, 200);
  const long allocated = rig::allocations.load();
  for (int i = 1; i <= 5; ++i) {
    AxleTyres tyres = problem.tyres;
    tyres.front.D *= 1.0 - 0.02 * i;
    tyres.rear.D *= 1.0 - 0.02 * i;
    solver.set_car(tyres, {});
    solve(solver, lap, solved, 20, 1e-4, 20);
  }
  const WindowStep last = solve(solver, lap, solved, 20, 1e-4, 60);
  EXPECT_LT(last.defect, 5e-3);
  EXPECT_EQ(rig::allocations.load(), allocated);
}

/// A car of full size on the same road, fifty times as large, on half the friction of a dry road.
LapProblem full_size_road(bool mirrored) {
  constexpr double size = 50.0;
  LapProblem p = swinging_road(0.5);
  p.car.m = 1265;
  p.car.Iz = 2093;
  p.car.lf = 1.34;
  p.car.lr = 1.30;
  p.car.ddelta_max = 1.0;
  const double weight = 0.5 * gravity / (p.car.lf + p.car.lr);
  p.tyres = {{10.0, 1.5, weight * p.car.lr}, {10.0, 1.5, weight * p.car.lf}};
  p.drive = {CubicSpline(0, 50, std::vector<double>{-0.1, -0.2, -0.4, -0.7, -1.1}),
             CubicSpline(0, 50, std::vector<double>{7, 6, 5, 4, 3}),
             CubicSpline(0, 50, std::vector<double>{7, 7, 7, 7, 7})};
  p.top_speed = 50.0;
  p.combined = 1.0;
  for (std::size_t k = 0; k < nodes; ++k) {
    p.places[k].kappa *= (mirrored ? -1.0 : 1.0) / size;
    p.ds[k] *= size;
    p.n_hi[k] = p.mid_hi[k] = 3.0;
    p.n_lo[k] = p.mid_lo[k] = -3.0;
  }
  return p;
}

LapSolution full_size_guess(const LapProblem& p) { return guess_for(p, 35.0, 4.0); }

/// The rates of an interval of a solved lap, in its middle.
LapRates<double> rates_in(const LapProblem& p, const std::vector<WindowNode>& lap, std::size_t k,
                          double (&z)[lap_variables]) {
  for (std::size_t j = 0; j < lap_variables; ++j)
    z[j] = j < lap_states ? 0.5 * (lap[k].z[j] + lap[k + 1].z[j]) : lap[k].z[j];
  return lap_rates(p.car, p.tyres, p.drive.coast, p.places[k], z);
}

class FullSizeWindowTest : public WindowTest {
 protected:
  static constexpr std::size_t first = 20;
  std::vector<WindowNode> solved(const LapProblem& problem) {
    const LapSolution guess = full_size_guess(problem);
    WindowSolver solver(problem, window);
    std::vector<WindowNode> lap = nodes_of(guess);
    last_ = solve(solver, lap, guess, first, 1e-2, 150);
    return lap;
  }
  WindowStep last_;
};

// The friction circle is curved, and a change of the plan by a share of it violates it by the square of that share, in
// every interval at once.
TEST_F(FullSizeWindowTest, TakesLongStepsAlongTheFrictionCircle) {
  const LapProblem problem = full_size_road(false);
  const LapSolution guess = full_size_guess(problem);
  WindowSolver solver(problem, window);
  std::vector<WindowNode> lap = nodes_of(guess);
  int steps = 0;
  for (double barrier = 1e-2; barrier > 3e-4; barrier *= 0.2) {
    WindowStep step;
    do {
      step = solver.iterate(lap, first, window, barrier, guess.z[first], guess.z[first + window]);
    } while (++steps < 100 && !(step.good && step.near_change < 0.02 && step.near_defect < 2e-3));
  }
  EXPECT_LT(steps, 30);
}

TEST_F(FullSizeWindowTest, PlansNoSlipBeyondThePeakOfATyreInTurnsOfEitherSide) {
  double time[2] = {0, 0};
  for (const bool mirrored : {false, true}) {
    const LapProblem problem = full_size_road(mirrored);
    const std::vector<WindowNode> lap = solved(problem);
    EXPECT_LT(last_.near_defect, 2e-3);
    const double peak = std::tan(0.5 * std::numbers::pi / 1.5) / 10.0;
    double largest = 0;
    for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
      double z[lap_variables];
      const LapRates<double> r = rates_in(problem, lap, k, z);
      largest = std::max({largest, std::abs(r.slip_front), std::abs(r.slip_rear)});
      time[mirrored] += r.time * problem.ds[k];
    }
    EXPECT_LT(largest, peak + 2e-3);
    EXPECT_GT(largest, 0.5 * peak);
  }
  EXPECT_NEAR(time[0], time[1], 0.01 * time[0]);
}

TEST_F(FullSizeWindowTest, EachAxleSharesTheFrictionOfItsLoad) {
  LapProblem problem = full_size_road(false);
  problem.sharing = {.ratio = 1.1, .drive_front = 0.4, .brake_front = 0.62, .load_front = -0.018, .load_rear = 0.017};
  const std::vector<WindowNode> lap = solved(problem);
  EXPECT_LT(last_.near_defect, 2e-3);
  double used[2] = {0, 0};
  for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
    double z[lap_variables];
    const LapRates<double> r = rates_in(problem, lap, k, z);
    const double a = z[lap_a];
    if (std::abs(a) < 2.0) continue;  // the front share goes from the brakes' to the drive's about 0
    const double front = a > 0 ? 0.4 : 0.62;
    const auto share = [&](double force, double along, double load, double D) {
      return std::hypot(force / D, along / (1.1 * D)) / (1.0 + load * a);
    };
    used[0] = std::max(used[0], share(r.front, front * a, -0.018, problem.tyres.front.D));
    used[1] = std::max(used[1], share(r.rear, (1.0 - front) * a, 0.017, problem.tyres.rear.D));
  }
  for (const double most : used) {
    EXPECT_LT(most, 1.03);
    EXPECT_GT(most, 0.8);
  }
}

// On a crest an axle has less friction to share, and is driven to that.
TEST_F(FullSizeWindowTest, CrestsLeaveEachAxleLessFriction) {
  LapProblem problem = full_size_road(false);
  problem.sharing = {.ratio = 1.1, .drive_front = 0.4, .brake_front = 0.62, .load_front = -0.018, .load_rear = 0.017};
  const std::vector<WindowNode> level = solved(problem);
  for (LapPlace& place : problem.places) place.curve = -4e-4;
  const std::vector<WindowNode> crest = solved(problem);
  EXPECT_LT(last_.near_defect, 2e-3);
  double time[2] = {0, 0}, used = 0, relieved = 1;
  for (std::size_t k = first; k < first + WindowSolver::near_part(window); ++k) {
    double z[lap_variables];
    time[0] += rates_in(problem, level, k, z).time * problem.ds[k];
    const LapRates<double> r = rates_in(problem, crest, k, z);
    time[1] += r.time * problem.ds[k];
    relieved = std::min(relieved, r.load);
    const double a = z[lap_a];
    if (std::abs(a) < 2.0) continue;
    const double front = a > 0 ? 0.4 : 0.62, D = problem.tyres.front.D;
    used = std::max(used, std::hypot(r.front / D, front * a / (1.1 * D)) / (r.load - 0.018 * a));
  }
  EXPECT_LT(relieved, 0.99);
  EXPECT_LT(used, 1.03);
  EXPECT_GT(used, 0.8);
  EXPECT_GT(time[1], time[0]);
}

class RecedingTimeTest : public ::testing::Test {
 protected:
  PluginContext context_on(const Track& track) {
    course_ = std::make_unique<TrackCourse>(track, car_);
    PluginContext context;
    context.car = car_;
    context.dt = 0.02;
    context.course = course_.get();
    context.nominal = &model_.prediction();
    context.mu_init = 1.0;
    return context;
  }
  Instance<SpeedPlanner> make(const Track& track, const Changes& changes) {
    const PluginContext context = context_on(track);
    const PluginEntry& entry = registry_.find(abi::Kind::planner, "receding_time");
    return create<SpeedPlanner>(entry, context, values_of(entry, changes));
  }
  static Belief believe(double mu) { return {mu, mu, 0.0, 0.0, true}; }

  /// Drives the references exactly for so many steps; what is driven after half of them, over what was driven there [m].
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

  Registry registry_ = plugins();
  Car car_ = car_1_43();
  Track mobil_ = ethz_mobil();
  DynamicCar model_{registry_, 0.02};
  std::unique_ptr<TrackCourse> course_;
  std::vector<RefPoint> horizon_ = std::vector<RefPoint>(20);
  Observation now_;
  double room_ = INFINITY;
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
      if (behind) {
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

// Larger slips than `slip_max` are planned where the car has slipped nearly as far, and not before.
TEST_F(RecedingTimeTest, PlansLargeSlipsOnceTheyWereSeen) {
  const auto horizons = [&](double most) {
    const auto planner = make(mobil_, {{"spacing", 0.1}, {"start", 0.6}, {"slip_most", most}});
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
  const std::vector<RefPoint> plain = horizons(0.0), bold = horizons(1.0);
  double difference[2] = {0, 0};
  for (std::size_t i = 0; i < plain.size(); ++i) {
    double& largest = difference[i < plain.size() / 2 ? 0 : 1];
    largest = std::max(largest, std::hypot(bold[i].x - plain[i].x, bold[i].y - plain[i].y));
  }
  EXPECT_EQ(difference[0], 0.0);
  EXPECT_GT(difference[1], 1e-3);
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
      const LinePoint p = line.at(follower.locate(line, r.x, r.y));
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

/// The laps themselves, of a car that stays where it is.
class RecedingLapsTest : public RecedingTimeTest {
 protected:
  static CarBelief believed(double mu) {
    const Car car = car_1_43();
    const double weight = mu * gravity / (car.lf + car.lr);
    return {{{4.0, 1.3, weight * car.lr}, {4.0, 1.3, weight * car.lf}}, {}};
  }
  void SetUp() override {
    setup_ =
        std::make_unique<LapSetup>(context_on(mobil_), SetupOptions{0.4 * car_.width, 0.1, 0.0, 0.7}, believed(0.8));
    laps_ = std::make_unique<RecedingLaps>(*setup_, believed(0.8), RecedingOptions{});
    plan_ = laps_->whole_plan();
  }
  void steps(int count, const CarBelief& car, double spread) {
    for (int i = 0; i < count; ++i) laps_->step(car, spread, station, plan_);
  }
  /// Newton steps of so many control steps.
  long work(int count, const CarBelief& car, double spread) {
    const long before = laps_->iterations();
    steps(count, car, spread);
    return laps_->iterations() - before;
  }
  double slowest() const {
    double v = INFINITY;
    for (const LapPlan::Node& node : plan_.nodes) v = std::min(v, node.v);
    return v;
  }

  static constexpr double station = 1.0, settled = 2e-5;
  std::unique_ptr<LapSetup> setup_;
  std::unique_ptr<RecedingLaps> laps_;
  LapPlan plan_;
};

// The surface of a road is curved along it where its grade changes, and where its bank turns with it.
TEST_F(RecedingLapsTest, KnowsTheCurvatureOfTheRoadsSurface) {
  const auto places_on = [&](const StationTable& grade, double bank) {
    const double half = std::numbers::pi;
    const std::array segments{Segment::line(2.0), Segment::arc(0.5, half), Segment::line(2.0), Segment::arc(0.5, half)};
    const Track track(TrackShape{.name = "hilly",
                                 .centre = ClosedCurve::from_segments({0.0, 0.0, 0.0}, segments, 1e-3),
                                 .half_width_right = 0.2,
                                 .half_width_left = 0.2,
                                 .grade = grade,
                                 .bank = bank,
                                 .start = Pose{0.0, 0.0, 0.0},
                                 .points = std::nullopt});
    return LapSetup(context_on(track), SetupOptions{0.4 * car_.width, 0.1, 0.0, 0.7}, believed(0.8)).nodes();
  };
  const LapNodes banked = places_on(0.0, 0.1);
  int turning = 0, straight = 0;
  for (const LapPlace& place : banked.places) {
    const double turn = std::sin(0.1) / 0.5;
    (std::abs(place.curve) > 1e-9 ? turning : straight)++;
    EXPECT_NEAR(std::abs(place.curve), std::abs(place.curve) > 1e-9 ? turn : 0.0, 1e-6);
    EXPECT_GE(place.curve, 0.0);
  }
  EXPECT_GT(turning, 10);
  EXPECT_GT(straight, 10);
  const double length = 4.0 + std::numbers::pi;
  const LapNodes hilly = places_on(StationTable(length, {0.0, 0.25 * length, 0.75 * length}, {0.0, 0.03, -0.03}), 0.0);
  double rises = 0, falls = 0;
  for (std::size_t k = 0; k < hilly.ds.size(); ++k)
    (hilly.places[k].curve > 0 ? rises : falls) += hilly.places[k].curve * hilly.ds[k];
  EXPECT_NEAR(rises, 0.06, 2e-3);
  EXPECT_NEAR(falls, -0.06, 2e-3);
}

TEST_F(RecedingLapsTest, RestsWhereNothingChanges) {
  steps(100, believed(0.8), 0.0);
  EXPECT_EQ(work(50, believed(0.8), 0.0), 0);
  EXPECT_DOUBLE_EQ(laps_->barrier(), settled);
}

TEST_F(RecedingLapsTest, FollowsABeliefThatMovedByMoreThanItsResolution) {
  steps(100, believed(0.8), 0.0);
  EXPECT_EQ(work(20, believed(0.8 * 1.008), 0.04), 0);  // a quarter of 4 % is 1 %
  EXPECT_GT(work(20, believed(0.8 * 1.012), 0.04), 0);
  steps(100, believed(0.8 * 1.012), 0.04);
  EXPECT_EQ(work(20, believed(0.8 * 1.008), 0.04), 0);
}

TEST_F(RecedingLapsTest, AChangeOfTheBeliefRaisesTheBarrierByItsSize) {
  steps(100, believed(0.8), 0.0);
  steps(1, believed(0.8 * 1.004), 0.0);
  EXPECT_LE(laps_->barrier(), settled);  // a warm start bears that
  steps(100, believed(0.8 * 1.004), 0.0);
  steps(1, believed(0.8 * 1.1), 0.0);
  EXPECT_GT(laps_->barrier(), 1e-4);  // of which no plan is driven
}

TEST_F(RecedingLapsTest, ADrivenPlanFollowsALargeChangeWithinASecond) {
  steps(100, believed(0.8), 0.0);
  const double before = slowest();
  steps(1, believed(0.6), 0.0);
  EXPECT_NEAR(slowest(), before * std::sqrt(0.6 / 0.8), 0.02 * before);  // slower at once
  const LapPlan scaled = plan_;
  steps(50, believed(0.6), 0.0);
  steps(100, believed(0.6), 0.0);
  EXPECT_DOUBLE_EQ(laps_->barrier(), settled);
  EXPECT_EQ(work(20, believed(0.6), 0.0), 0);
  double moved = 0;
  for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
    moved = std::max(moved, std::abs(plan_.nodes[k].v - scaled.nodes[k].v));
  EXPECT_GT(moved, 0.02);  // the plan is of the new friction, no longer the old one driven slowly
}

/// What a learner that went wrong may say of a car, and how long a plan takes to come back after it.
struct Wrong {
  const char* what;
  double B, front, rear;  // stiffness and friction of the axles, over the true ones
  double rolling;         // resistance [m/s2]
  double within;          // [s]
};

/// Wrong beliefs while the car goes along the base line, and what the plan is like when the right one is back.
class RecedingLapsAfterAWrongBelief : public RecedingLapsTest {
 protected:
  static CarBelief wrong(const Wrong& w) {
    CarBelief car = believed(0.8);
    for (MagicFormula* tyre : {&car.tyres.front, &car.tyres.rear}) tyre->B *= w.B;
    car.tyres.front.D *= w.front;
    car.tyres.rear.D *= w.rear;
    car.resistance.rolling = w.rolling;
    return car;
  }
  void drive(double seconds, const CarBelief& car) {
    for (double t = 0; t < seconds; t += 0.02) {
      at_ += 0.02 * speed;
      laps_->step(car, 0.0, at_, plan_);
    }
  }
  /// The largest difference of planned speeds from one second to three ahead of the car [m/s].
  double difference_ahead(const LapPlan& other) const {
    double largest = 0;
    for (double s = at_ + 1.0 * speed; s < at_ + 3.0 * speed; s += 0.1) {
      const std::vector<double>& nodes = setup_->nodes().s;
      const double wrapped = std::fmod(s, setup_->base().length());
      const auto k =
          static_cast<std::size_t>(std::upper_bound(nodes.begin(), nodes.end(), wrapped) - nodes.begin()) - 1;
      largest = std::max(largest, std::abs(plan_.nodes[k].v - other.nodes[k].v));
    }
    return largest;
  }
  static constexpr double speed = 1.5;  // [m/s]
  double at_ = station;
};

// While nobody could drive the car that is believed, the old plan is driven. Then a plan is back within two seconds, or
// six where a much slower one was found and driven meanwhile.
TEST_F(RecedingLapsAfterAWrongBelief, APlanComesBack) {
  const LapPlan right = plan_;
  for (const Wrong& one : {Wrong{"more resistance than drive", 1, 1, 1, 20, 2}, Wrong{"a push", 1, 1, 1, -20, 2},
                           Wrong{"no front axle", 1, 0.05, 1, 0, 2}, Wrong{"tyres of jelly", 0.05, 1, 1, 0, 6},
                           Wrong{"no number", 1, 1, std::nan(""), 0, 2}, Wrong{"all of it", 0.1, 0.1, 0.02, 15, 6}}) {
    drive(3.0, wrong(one));
    for (const LapPlan::Node& node : plan_.nodes) {
      ASSERT_TRUE(std::isfinite(node.n) && std::isfinite(node.v) && std::isfinite(node.beta)) << one.what;
      ASSERT_GT(node.v, 0.0) << one.what;
    }
    const long allocated = rig::allocations.load();
    drive(one.within, believed(0.8));
    EXPECT_EQ(rig::allocations.load(), allocated) << one.what;
    EXPECT_LT(difference_ahead(right), 0.15) << one.what;
    EXPECT_LE(laps_->barrier(), 1e-4) << one.what;  // such windows are driven
  }
}

// A car that stands asks for no other window: one that no belief can drive must not hold the solver for good.
TEST_F(RecedingLapsAfterAWrongBelief, AStandingCarGetsItsPlanBack) {
  const LapPlan right = plan_;
  steps(100, wrong({"more resistance than drive", 1, 1, 1, 20, 2}), 0.0);
  steps(100, believed(0.8), 0.0);
  EXPECT_LE(laps_->barrier(), 1e-4);
  double moved = 0;
  for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
    moved = std::max(moved, std::abs(plan_.nodes[k].v - right.nodes[k].v));
  EXPECT_LT(moved, 0.1);
}

// Where the road is slippery turns are planned at the speed that its friction allows.
TEST_F(RecedingLapsTest, PlansForASlipperyPlace) {
  steps(100, believed(0.8), 0.0);
  const LapPlan before = plan_;
  const std::size_t from = laps_->node_at(station + 0.8), to = laps_->node_at(station + 5.0);
  for (std::size_t i = from; i < to; ++i) laps_->set_grip(i, 0.6);
  steps(200, believed(0.8), 0.0);
  double slowest = INFINITY, old = INFINITY;
  for (std::size_t i = from; i < to; ++i) {
    slowest = std::min(slowest, plan_.nodes[i].v);
    old = std::min(old, before.nodes[i].v);
  }
  EXPECT_LT(slowest, 0.9 * old);
  EXPECT_GT(slowest, 0.7 * old);  // sqrt(0.6) is 0.77
  EXPECT_DOUBLE_EQ(laps_->barrier(), settled);
}

}  // namespace
}  // namespace gripline
