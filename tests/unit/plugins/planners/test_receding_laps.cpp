#include "planners/time_optimal/receding_laps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "support/allocation_counter.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_receding_laps {

using namespace time_optimal;
using namespace testing_support;

/// The laps themselves, of a car that stays where it is.
class RecedingLapsTest : public ::testing::Test, protected PlannerRig {
 protected:
  static CarBelief believed(double mu) {
    const Car car = car_1_43();
    const double weight = mu * gravity / (car.lf + car.lr);
    return {{{4.0, 1.3, weight * car.lr}, {4.0, 1.3, weight * car.lf}}, {}};
  }
  void SetUp() override {
    setup_ = std::make_unique<LapSetup>(
        context_on(mobil_), SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}},
        believed(0.8));
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

  /// Mean planned speed of the nodes ahead of the car [m/s].
  double mean_speed() const {
    double sum = 0;
    for (std::size_t k = 10; k < 60; ++k) sum += plan_.nodes[(laps_->changed_first() + k) % plan_.nodes.size()].v;
    return sum / 50;
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
    return LapSetup(context_on(track),
                    SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}}, believed(0.8))
        .nodes();
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

// A window that is nearly the lap may keep a part that is driven backwards (history.md, "Windows that are nearly the
// lap").
TEST_F(RecedingLapsTest, ALongWindowIsAtMostHalfOfTheLap) {
  const SetupOptions fine{.margin = 0.4 * car_.width, .spacing = 0.045, .use = {.slip_bound = 0.7}};
  const LapSetup setup(context_on(mobil_), fine, believed(0.8));
  const std::size_t nodes = setup.nodes().s.size();
  ASSERT_GT(nodes, 220U);
  for (const int asked : {40, 90, 1000}) {
    RecedingLaps laps(setup, believed(0.8), {60.0, asked, 2, 0.05});
    LapPlan plan = laps.whole_plan();
    laps.step(believed(0.8), 0.0, station, plan);
    EXPECT_EQ(laps.changed_count(), asked < 100 ? static_cast<std::size_t>(asked) : nodes / 2) << nodes;
  }
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

// A lap that begins with more resistance than is typical has it once, also when the solver is told of the car again.
TEST_F(RecedingLapsTest, ResistanceCountsOnce) {
  CarBelief car = believed(0.8);
  car.resistance = {2.0, 0.0};
  laps_ = std::make_unique<RecedingLaps>(*setup_, car, RecedingOptions{});
  plan_ = laps_->whole_plan();
  steps(300, car, 0.0);
  const double before = mean_speed();
  laps_->set_slip_bound_slow_car(0.7001);
  steps(300, car, 0.0);
  EXPECT_NEAR(mean_speed(), before, 1e-3 * before);
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
                           Wrong{"no front axle", 1, 0.05, 1, 0, 6}, Wrong{"tyres of jelly", 0.05, 1, 1, 0, 6},
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

/// A car beside its plan or faster than it, which goes on along the base line.
class RecedingLapsOffPlan : public RecedingLapsAfterAWrongBelief {
 protected:
  std::size_t node() const { return setup_->node_at(at_); }
  const LapPlan::Node& planned() const { return plan_.nodes[node()]; }
  /// At `at_`, this far to the left of the plan at the node behind it, at a multiple of its speed.
  State off_plan(double beside, double faster) const {
    const LinePoint p = setup_->base().at(at_);
    const double n = planned().n + beside;
    State x;
    x.x = p.x - std::sin(p.yaw) * n;
    x.y = p.y + std::cos(p.yaw) * n;
    x.yaw = p.yaw + std::atan2(planned().slope, 1.0 - n * p.kappa);
    x.vx = faster * planned().v;
    x.omega = x.vx * p.kappa;
    return x;
  }
  void plan_from(const State& x, int count) {
    for (int i = 0; i < count; ++i) laps_->step(believed(0.8), 0.0, at_, plan_, &x);
  }
  /// The most that the plan leaves the road by, in the next two seconds [m].
  double outside() const {
    const LapProblem problem = setup_->problem(believed(0.8));
    double most = 0;
    for (std::size_t k = 0; k < 60; ++k) {
      const std::size_t i = (node() + k) % plan_.nodes.size();
      most = std::max({most, plan_.nodes[i].n - problem.n_hi[i], problem.n_lo[i] - plan_.nodes[i].n});
    }
    return most;
  }
};

TEST_F(RecedingLapsOffPlan, APlanBeginsWithTheCarsOwnStateAndJoinsTheLap) {
  drive(3.0, believed(0.8));
  const LapPlan before = plan_;
  const std::size_t here = node();
  const State x = off_plan(-0.02, 1.06);
  const long allocated = rig::allocations.load();
  plan_from(x, 15);
  EXPECT_EQ(rig::allocations.load(), allocated);
  EXPECT_EQ(laps_->changed_first(), here);
  const double since = at_ - setup_->nodes().s[here];
  EXPECT_NEAR(plan_.nodes[here].n, before.nodes[here].n - 0.02 - before.nodes[here].slope * since, 2e-3);
  EXPECT_NEAR(plan_.nodes[here].v, x.vx, 0.01 * x.vx);
  EXPECT_LT(outside(), 1e-3);
  const std::size_t later = (here + 50) % plan_.nodes.size();
  EXPECT_NEAR(plan_.nodes[later].n, before.nodes[later].n, 3e-3);
  EXPECT_NEAR(plan_.nodes[later].v, before.nodes[later].v, 0.01 * before.nodes[later].v);
}

// In the middle of braking for a turn nobody can be a quarter faster and stay on the road.
TEST_F(RecedingLapsOffPlan, WhereNoPlanBeginsWithTheCarItBeginsNearby) {
  const auto loss = [&](std::size_t k) { return plan_.nodes[k].v - plan_.nodes[(k + 5) % plan_.nodes.size()].v; };
  std::size_t hardest = 0;
  for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
    if (loss(k) > loss(hardest)) hardest = k;
  at_ = setup_->nodes().s[hardest] - 3.0 * speed;
  drive(3.0, believed(0.8));
  const State x = off_plan(0.0, 1.25);
  plan_from(x, 40);
  EXPECT_GT(planned().v, 0.8 * x.vx);
  EXPECT_LT(planned().v, 0.97 * x.vx);
  EXPECT_LT(outside(), 2e-3);
}

TEST_F(RecedingLapsOffPlan, ACarThatIsBackHasThePlanThatItHadBefore) {
  drive(3.0, believed(0.8));
  const LapPlan before = plan_;
  const std::size_t here = node();
  plan_from(off_plan(-0.02, 1.06), 15);
  EXPECT_GT(plan_.nodes[here].v, 1.04 * before.nodes[here].v);
  drive(4.0, believed(0.8));
  EXPECT_LE(laps_->barrier(), 1e-4);
  EXPECT_LT(difference_ahead(before), 0.05);
}

/// The curvature that a plan says it has, beside that of the path which it makes.
class RecedingLapsCurvature : public RecedingLapsOffPlan {
 protected:
  std::size_t size() const { return plan_.nodes.size(); }
  /// Change of heading from the node before to the one after [rad], and the length of the path that is drawn between
  /// them, in short chords [m].
  struct Bend {
    double turn, way;
  };
  Bend bend_at(std::size_t k) const {
    const LapNodes& nodes = setup_->nodes();
    const std::size_t before = (k + size() - 1) % size(), after = (k + 1) % size();
    const double first = nodes.s[before], length = nodes.ds[before] + nodes.ds[k];
    constexpr int chords = 40;
    Bend bend{std::remainder(follower_->at(nodes.s[after]).yaw - follower_->at(first).yaw, 2.0 * std::numbers::pi),
              0.0};
    const auto point_at = [&](double s) { return follower_->at(std::fmod(s, setup_->base().length())); };
    PlanPoint here = point_at(first);
    for (int i = 1; i <= chords; ++i) {
      const PlanPoint next = point_at(first + length * i / chords);
      bend.way += std::hypot(next.x - here.x, next.y - here.y);
      here = next;
    }
    return bend;
  }
  void draw() {
    if (!follower_) follower_.emplace(*setup_);
    follower_->set(plan_);
  }
  /// The nodes whose curvature is not that of the path, of which the planner takes the way by the trapezoidal rule.
  std::vector<std::size_t> wrong() {
    draw();
    std::vector<std::size_t> nodes;
    for (std::size_t k = 0; k < size(); ++k)
      if (const Bend b = bend_at(k);
          !(std::abs(plan_.nodes[k].kappa - b.turn / b.way) < 0.01 + 0.03 * std::abs(b.turn / b.way)))
        nodes.push_back(k);
    return nodes;
  }
  std::optional<PlanFollower> follower_;
};

/// What a follower is told of in parts, of which not every node has moved, is what it is told of as a whole.
TEST_F(RecedingLapsCurvature, PartsOfAPlanAreFollowedLikeAWholeOne) {
  struct Part {
    std::size_t first, count, moved, every;  // window; the first node of it that moves, and how many later the next
  };
  const std::size_t n = size();
  draw();
  for (const Part& part :
       {Part{n - 3, 8, 0, 1}, Part{0, n, 0, 3}, Part{5, 6, 5, 9}, Part{5, 6, 0, 9}, Part{9, 1, 0, 1}}) {
    for (std::size_t k = part.moved; k < part.count; k += part.every) {
      LapPlan::Node& node = plan_.nodes[(part.first + k) % n];
      const double change = 0.001 * static_cast<double>(k % 4 + 1);
      if (k % 3 == 0) node.n += change;
      if (k % 3 == 1) node.slope += change;
      if (k % 3 == 2) node.kappa += change;
      node.v += change;
    }
    follower_->set(plan_, part.first, part.count);
    PlanFollower whole(*setup_);
    whole.set(plan_);
    ASSERT_FALSE(whole.samples().empty());
    for (std::size_t i = 0; i < whole.samples().size(); ++i) {
      const LinePoint &a = follower_->samples()[i], &b = whole.samples()[i];
      EXPECT_TRUE(a.x == b.x && a.y == b.y && a.yaw == b.yaw && a.kappa == b.kappa && a.left == b.left)
          << part.first << ", " << part.count << ": sample " << i;
    }
    for (const double s : setup_->nodes().s) EXPECT_EQ(follower_->at(s).v, whole.at(s).v);
  }
}

TEST_F(RecedingLapsCurvature, OfAWholeLapIsThatOfItsPath) {
  EXPECT_EQ(wrong(), std::vector<std::size_t>{});
  double turned = 0, most = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    turned += 0.5 * plan_.nodes[k].kappa * bend_at(k).way;
    most = std::max(most, std::abs(plan_.nodes[k].kappa));
  }
  EXPECT_NEAR(turned, -2.0 * std::numbers::pi, 0.05);  // clockwise
  EXPECT_GT(most, 2.0);                                // of radii of 0.3 m on a road that is 0.46 m wide
  EXPECT_LT(most, 8.0);
}

// A part of the plan moves with the window; what it has in common with the rest of the lap is not left behind, nor
// where the lap ends and begins.
TEST_F(RecedingLapsCurvature, FollowsThePathRoundTheEndOfTheLap) {
  const LapPlan before = plan_;
  at_ = setup_->base().length() - 4.0;
  int across = 0;
  for (int i = 0; i < 150 && !HasFailure(); ++i) {
    drive(0.02, believed(0.6));
    across += laps_->changed_first() + laps_->changed_count() > size();
    EXPECT_EQ(wrong(), std::vector<std::size_t>{}) << "control step " << i;
  }
  EXPECT_GT(across, 50);
  for (const std::size_t k : {size() - 1, std::size_t{0}, std::size_t{1}})
    EXPECT_GT(std::abs(plan_.nodes[k].kappa - before.nodes[k].kappa), 1e-3) << k;
}

// The node behind the car has no node before it on the same plan; the plan that ends there stays as it was.
TEST_F(RecedingLapsCurvature, OfAPlanThatBeginsAtTheCarBeginsWithIt) {
  at_ = setup_->nodes().s.back() + 0.01 - 3.0 * speed;
  drive(3.0, believed(0.8));
  const LapPlan before = plan_;
  ASSERT_EQ(node(), size() - 1);
  plan_from(off_plan(-0.02, 1.0), 15);
  ASSERT_EQ(laps_->changed_first(), size() - 1);
  EXPECT_EQ(wrong(), (std::vector{size() - 2, size() - 1}));
  EXPECT_EQ(plan_.nodes[size() - 1].kappa, plan_.nodes[0].kappa);
  EXPECT_EQ(plan_.nodes[size() - 2].kappa, before.nodes[size() - 2].kappa);
  EXPECT_GT(std::abs(plan_.nodes[0].kappa - before.nodes[0].kappa), 1e-3);
}

// Where the road is slippery turns are planned at the speed that its friction allows.
TEST_F(RecedingLapsTest, PlansForASlipperyPlace) {
  steps(100, believed(0.8), 0.0);
  const LapPlan before = plan_;
  const std::size_t from = setup_->node_at(station + 0.8), to = setup_->node_at(station + 5.0);
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

}  // namespace test_receding_laps
}  // namespace gripline
