#include "race/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/host_support.hpp"

namespace gripline {
namespace test_metrics {

using namespace testing_support;

std::vector<LinePoint> square() {
  std::vector<LinePoint> line(4);
  const double corner[][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  for (std::size_t i = 0; i < 4; ++i) {
    line[i].x = corner[i][0];
    line[i].y = corner[i][1];
  }
  return line;
}

TEST(DistanceToLine, IsToTheCurveNotToItsPoints) {
  const std::vector<LinePoint> line = square();
  EXPECT_DOUBLE_EQ(distance_to_line(line, 1, 0.25), 0.25);
  EXPECT_DOUBLE_EQ(distance_to_line(line, 1, -0.5), 0.5);
  EXPECT_DOUBLE_EQ(distance_to_line(line, -0.3, 1), 0.3);  // from the last point back to the first
  EXPECT_DOUBLE_EQ(distance_to_line(line, 5, 6), 5);
  EXPECT_DOUBLE_EQ(distance_to_line(line, 2, 2), 0);
  EXPECT_DOUBLE_EQ(distance_to_line(std::span(line).first(1), 3, 4), 5);
}

/// Drives a world and keeps its metrics, with whatever belief and line the test wants.
class Drive {
 public:
  explicit Drive(std::string_view world, std::string_view stack = "{}")
      : spec_(world_of(world)), stack_(stack_of(spec_.car, stack)), world_(spec_, 1), metrics_(world_, stack_, 7) {}
  World& world() { return world_; }
  Metrics& metrics() { return metrics_; }
  RunSummary summary() const { return metrics_.summary(Status::finished, ""); }

  void step(const Input& u, const Belief& mu = {}, std::span<const LinePoint> line = {}, bool solved = true) {
    world_.advance(u);
    metrics_.step();
    metrics_.decision({nullptr, mu, nullptr}, line, solved, 0.0);
  }
  /// Keeps to the centre line.
  Input follow(double speed) const {
    const State& x = world_.state();
    const Place& at = world_.place();
    const double heading = std::remainder(x.yaw - at.yaw_line, 2 * std::numbers::pi);
    const double wanted = std::atan(0.062 * (at.kappa - 10 * at.n - 6 * heading));
    return {0.25 + 2 * (speed - x.vx), (wanted - x.delta) / spec_.dt};
  }

 private:
  WorldSpec spec_;
  StackSpec stack_;
  World world_;
  Metrics metrics_;
};

TEST(Metrics, CountsSteps) {
  Drive drive(R"({"start": {"speed": 1}})", R"({"estimator": {"plugin": "oracle"}})");
  drive.metrics().start(true);
  for (int k = 0; k < 10; ++k) drive.step({0.3, 0}, {}, {}, k % 3 != 0);
  const RunSummary summary = drive.metrics().summary(Status::timeout, "why");
  EXPECT_EQ(summary.steps, 10);
  EXPECT_EQ(summary.solver_failures, 4);
  EXPECT_DOUBLE_EQ(summary.simulated_s, 0.2);
  EXPECT_EQ(summary.status, Status::timeout);
  EXPECT_EQ(summary.message, "why; 4 of 11 solves failed");
  EXPECT_EQ(summary.seed, 7u);
  EXPECT_EQ(summary.stack, "driver");
  EXPECT_TRUE(summary.needs_truth);
  EXPECT_EQ(summary.plan_latency_s, 0) << "of a planner that plans within the step";
}

TEST(Metrics, CountTheSolveBeforeTheFirstStep) {
  Drive drive(R"({"start": {"speed": 1}})");
  drive.metrics().start(false);
  for (int k = 0; k < 9; ++k) drive.step({0.3, 0});
  EXPECT_EQ(drive.summary().solver_failures, 1);
  EXPECT_EQ(drive.summary().steps, 9);
  EXPECT_EQ(drive.summary().message, "") << "one of ten is not more than one in ten";
}

TEST(Metrics, KeepTheLongestLatencyOfThePlanner) {
  Drive drive(R"({"start": {"speed": 1}})");
  for (const double latency : {0.0, 2.5, 2.0}) drive.metrics().decision({}, {}, true, latency);
  EXPECT_EQ(drive.summary().plan_latency_s, 2.5);
}

TEST(Metrics, DeviationIsTheTimeMeanOfTheDistance) {
  Drive drive(R"({"start": {"speed": 1, "y": 0.1}})");
  const std::vector<LinePoint> line = square();
  double sum = 0;
  for (int k = 0; k < 40; ++k) {
    drive.step({0.4, 0.5}, {}, line);
    sum += distance_to_line(line, drive.world().state().x, drive.world().state().y);
  }
  EXPECT_NEAR(drive.summary().mean_deviation_m.value(), sum / 40, 1e-15);
}

TEST(Metrics, WithoutALineThereIsNoDeviation) {
  Drive drive(R"({"start": {"speed": 1}})");
  for (int k = 0; k < 10; ++k) drive.step({0.3, 0});
  EXPECT_FALSE(drive.summary().mean_deviation_m.has_value());
  EXPECT_FALSE(drive.summary().hilly_deviation_m.has_value());
}

TEST(Metrics, HillyDeviationCountsWhereTheRoadIsSteep) {
  EXPECT_FALSE(Drive(R"({"start": {"speed": 1}})").summary().hilly_deviation_m.has_value());
  Drive drive(R"({"start": {"speed": 1}, "track": {"half_width": 0.3,
    "segments": [{"line": 2}, {"arc": {"radius": 1, "turn": "180 deg"}},
                 {"line": 2}, {"arc": {"radius": 1, "turn": "180 deg"}}],
    "grade": [{"s": 0, "grade": 0}, {"s": 0.2, "grade": 0}, {"s": 0.5, "grade": 0.1}, {"s": 0.8, "grade": 0},
              {"s": 4, "grade": 0}, {"s": 4.5, "grade": -0.06}, {"s": 5, "grade": 0}]}})");
  const std::vector<LinePoint> line = square();
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 60; ++k) {
    drive.step({0.4, 0.2}, {}, line);
    if (std::abs(std::tan(drive.world().place().grade)) <= 0.03) continue;
    sum += distance_to_line(line, drive.world().state().x, drive.world().state().y);
    ++count;
  }
  ASSERT_GT(count, 5);
  ASSERT_LT(count, 55);
  EXPECT_NEAR(drive.summary().hilly_deviation_m.value(), sum / count, 1e-12);
}

TEST(Metrics, ViolationsAreTimesOutside) {
  Drive drive(R"({"start": {"speed": 1.5, "yaw": "15 deg"}})");
  int centre = 0, body = 0, trusted = 0, trusted_body = 0;
  for (int k = 0; k < 120; ++k) {
    Belief mu;
    mu.trusted = k >= 70;
    drive.step({0.3, k > 60 && k < 70 ? -4.0 : 0.0}, mu);
    centre += drive.world().outside() ? 1 : 0;
    body += drive.world().body_outside() ? 1 : 0;
    trusted += drive.world().outside() && mu.trusted ? 1 : 0;
    trusted_body += drive.world().body_outside() && mu.trusted ? 1 : 0;
  }
  ASSERT_GT(trusted, 0);
  ASSERT_GT(centre, trusted);
  ASSERT_GT(body, centre);
  ASSERT_GT(trusted_body, trusted);
  const RunSummary summary = drive.summary();
  EXPECT_NEAR(summary.violation_s, 0.02 * centre, 1e-12);
  EXPECT_NEAR(summary.violation_body_s, 0.02 * body, 1e-12);
  EXPECT_NEAR(summary.violation_after_adapt_s.value(), 0.02 * trusted, 1e-12);
  EXPECT_NEAR(summary.violation_body_after_adapt_s.value(), 0.02 * trusted_body, 1e-12);
}

TEST(Metrics, WhoNeverTrustsHasNoViolationAfterAdaptingAndNoFrictionError) {
  Drive drive(R"({"start": {"speed": 1}})");
  for (int k = 0; k < 20; ++k) drive.step({0.3, 0});
  const RunSummary summary = drive.summary();
  EXPECT_FALSE(summary.violation_after_adapt_s.has_value());
  EXPECT_FALSE(summary.mu_rmse.has_value());
  EXPECT_FALSE(summary.mu_visited_rmse.has_value());
  EXPECT_FALSE(summary.mu_bias.has_value());
  Belief trusted;
  trusted.trusted = true;
  drive.step({0.3, 0}, trusted);
  EXPECT_EQ(drive.summary().violation_after_adapt_s, 0.0);
}

TEST(Metrics, LapsWithTheirMeanFactors) {
  Drive drive(R"({"start": {"speed": 1}, "duration": "40 s",
                  "friction": [{"t": 0, "factor": 1}, {"t": 40, "factor": 0.6}]})");
  double sum = 0, last = 0, travelled = 0;
  int count = 0;
  std::vector<double> laps, means, lengths;
  while (drive.world().time() < 30) {
    sum += drive.world().truth().factor();  // of the step that begins
    drive.step(drive.follow(1.2));
    ++count;
    const State& x = drive.world().state();
    const Place& at = drive.world().place();
    travelled += 0.02 * std::hypot(x.vx, x.vy) / (1 - at.n * at.kappa);  // along the centre line; bends are taken wide
    if (const auto ended = drive.world().lap_ended()) {
      laps.push_back(*ended - last);
      lengths.push_back(travelled);
      travelled = 0;
      means.push_back(sum / count);
      last = *ended;
      sum = count = 0;
    }
  }
  const RunSummary summary = drive.summary();
  ASSERT_GE(laps.size(), 3u);
  ASSERT_EQ(summary.laps.size(), laps.size());
  for (std::size_t i = 0; i < laps.size(); ++i) {
    EXPECT_NEAR(summary.laps[i], laps[i], 1e-12);
    EXPECT_NEAR(summary.lap_mean_factors[i], means[i], 1e-12);
  }
  EXPECT_NEAR(lengths[1], 4 + 1.6 * std::numbers::pi, 0.03);  // the oval's length, to a step
  EXPECT_LT(summary.lap_mean_factors[1], summary.lap_mean_factors[0]);
}

/// mu_true = 0.909 f; mu_visited is the same formula over the slips seen so far, and counts from two laps after trust.
TEST(Metrics, FrictionErrorsAgainstTheTruthAndAgainstWhatWasVisited) {
  Drive drive(R"({"start": {"speed": 1}, "duration": "60 s",
                  "friction": [{"t": 0, "factor": 1}, {"t": 60, "factor": 0.7}]})");
  const Car car = drive.world().spec().car.car;
  Belief belief;
  belief.mu_front = 0.9;
  belief.mu_rear = 0.8;
  const double believed = (0.9 * car.lr + 0.8 * car.lf) / (car.lf + car.lr);
  double squares = 0, bias = 0, visited_squares = 0, reach_front = 0, reach_rear = 0;
  double driven_at_trust = -1;
  int trusted = 0, visited = 0;
  while (drive.world().laps() < 5) {
    belief.trusted = drive.world().time() > 5;
    const double speed = 1.2 + 0.4 * std::sin(drive.world().time());
    drive.step(drive.follow(speed), belief);
    const World& world = drive.world();
    reach_front = std::max(reach_front, std::abs(world.slip(Axle::front)));
    reach_rear = std::max(reach_rear, std::abs(world.slip(Axle::rear)));
    if (!belief.trusted) continue;
    const double driven = world.covered() / world.track().length();
    if (driven_at_trust < 0) driven_at_trust = driven;
    const double f = world.truth().factor(), error = believed - f * 0.3657 / (0.041 * 9.81);
    squares += error * error;
    bias += error;
    ++trusted;
    if (driven < driven_at_trust + 2) continue;
    const double force = 0.192 * std::sin(1.2 * std::atan(2.579 * reach_front)) +
                         0.1737 * std::sin(1.2691 * std::atan(3.3852 * reach_rear));
    const double gap = believed - f * force / (0.041 * 9.81);
    visited_squares += gap * gap;
    ++visited;
  }
  ASSERT_GT(visited, 100);
  ASSERT_LT(reach_rear, 0.85);  // the curve rises that far
  const RunSummary summary = drive.summary();
  EXPECT_NEAR(summary.mu_rmse.value(), std::sqrt(squares / trusted), 1e-9);
  EXPECT_NEAR(summary.mu_bias.value(), bias / trusted, 1e-9);
  EXPECT_NEAR(summary.mu_visited_rmse.value(), std::sqrt(visited_squares / visited), 1e-9);
}

/// Wheels that are turned at rest, further than they slip later, have visited nothing.
TEST(Metrics, ACarThatStandsVisitsNoSlip) {
  Drive drive(R"({"start": {"speed": 0}})");
  Belief belief;
  belief.trusted = true;
  double at_rest = 0;
  for (int k = 0; k < 6; ++k) {
    drive.step({0, k < 3 ? 5.0 : -5.0}, belief);
    at_rest = std::max(at_rest, std::abs(drive.world().slip(Axle::front)));
  }
  ASSERT_GT(at_rest, 0.25);
  ASSERT_NEAR(drive.world().covered(), 0, 1e-9);
  double squares = 0, reach_front = 0, reach_rear = 0;
  int visited = 0;
  while (drive.world().laps() < 3) {
    ASSERT_LT(drive.world().time(), 60);
    drive.step(drive.follow(1.0), belief);
    const World& world = drive.world();
    if (std::hypot(world.state().vx, world.state().vy) < world.spec().car.car.v_min) continue;
    reach_front = std::max(reach_front, std::abs(world.slip(Axle::front)));
    reach_rear = std::max(reach_rear, std::abs(world.slip(Axle::rear)));
    if (world.covered() < 2 * world.track().length()) continue;
    const double force = 0.192 * std::sin(1.2 * std::atan(2.579 * reach_front)) +
                         0.1737 * std::sin(1.2691 * std::atan(3.3852 * reach_rear));
    squares += std::pow(1.0 - force / (0.041 * 9.81), 2);
    ++visited;
  }
  ASSERT_LT(reach_front, 0.8 * at_rest);
  ASSERT_GT(visited, 100);
  EXPECT_NEAR(drive.summary().mu_visited_rmse.value(), std::sqrt(squares / visited), 1e-9);
}

/// A tyre whose peak lies between two slips seen one after the other was visited there.
TEST(Metrics, APeakThatWasJumpedOverWasVisited) {
  Drive drive(R"({"start": {"speed": 1}, "plant": {"params": {"Bf": 60, "Br": 60}}})");
  const auto peak = [](double D, double C, double reach) {
    double best = 0;
    for (double slip = 0; slip <= reach; slip += 1e-4) best = std::max(best, D * std::sin(C * std::atan(60 * slip)));
    return best;
  };
  Belief belief;
  belief.trusted = true;
  double reach_front = 0, reach_rear = 0, before = 0, largest_jump = 0;
  while (drive.world().laps() < 3) {
    ASSERT_LT(drive.world().time(), 60);
    Input u = drive.follow(1.0);
    if (drive.world().step() == 3) u.ddelta = 5;  // 0.1 rad at once; the peak is at 0.06 rad
    drive.step(u, belief);
    const double slip = std::abs(drive.world().slip(Axle::front));
    largest_jump = std::max(largest_jump, slip - before);
    before = slip;
    reach_front = std::max(reach_front, slip);
    reach_rear = std::max(reach_rear, std::abs(drive.world().slip(Axle::rear)));
  }
  ASSERT_GT(largest_jump, 0.08);
  const double visited = (peak(0.192, 1.2, reach_front) + peak(0.1737, 1.2691, reach_rear)) / (0.041 * 9.81);
  ASSERT_GT(peak(0.192, 1.2, reach_front), 0.19);
  EXPECT_NEAR(drive.summary().mu_visited_rmse.value(), std::abs(1.0 - visited), 1e-3);
}

TEST(Metrics, StatusesHaveTheirNames) {
  EXPECT_EQ(status_name(Status::finished), "finished");
  EXPECT_EQ(status_name(Status::crashed), "crashed");
  EXPECT_EQ(status_name(Status::timeout), "timeout");
  EXPECT_EQ(status_name(Status::plugin_error), "plugin_error");
  EXPECT_EQ(status_name(Status::error), "error");
}

}  // namespace test_metrics
}  // namespace gripline
