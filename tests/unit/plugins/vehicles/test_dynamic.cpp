#include <numbers>

#include "support/vehicle_checks.hpp"

namespace gripline {
namespace test_dynamic {

using namespace rig;

double turned(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

/// `dynamic` with friction set row by row.
class LogModel {
 public:
  LogModel(const char* tableau, int substeps)
      : nominal_("dynamic"), model_(nominal_.car(), Nominal::options(tableau, substeps)) {
    const PluginEntry& entry = registry().find(gripline::abi::Kind::vehicle, "dynamic");
    for (std::size_t i = 0; i < entry.params().size(); ++i) {
      if (std::string(entry.params()[i].name) == "Df") front_ = i;
      if (std::string(entry.params()[i].name) == "Dr") rear_ = i;
    }
  }
  State step(const State& x, const Input& u, double factor) {
    model_.set_parameter(front_, 0.192 * factor);
    model_.set_parameter(rear_, 0.1737 * factor);
    return model_.advance(x, u, {});
  }

 private:
  Nominal nominal_;
  CorrectedModel model_;
  std::size_t front_ = 0, rear_ = 0;
};

/// Largest difference in any of the six states.
double distance(const State& a, const State& b) {
  double worst = std::abs(turned(a.yaw - b.yaw));
  for (const double error : {a.x - b.x, a.y - b.y, a.vx - b.vx, a.vy - b.vy, a.omega - b.omega})
    worst = std::max(worst, std::abs(error));
  return worst;
}

void expect_published_steps(const Drive& log, const std::vector<double>& factor) {
  LogModel published("rkf5", 1), ours("rk6", 1), exact("rk6", 64);
  double worst = 0;
  for (std::size_t i = 0; i < log.steps(); ++i) {
    const State& next = log.x[i + 1];
    const State fehlberg = published.step(log.x[i], log.u[i], factor[i]);
    worst = std::max(worst, distance(fehlberg, next));
    const State sixth = ours.step(log.x[i], log.u[i], factor[i]);
    const State limit = exact.step(log.x[i], log.u[i], factor[i]);
    ASSERT_LE(distance(sixth, next), distance(sixth, limit) + distance(fehlberg, limit) + 1e-6) << "at row " << i;
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(Dynamic, FollowsThePaper) {
  const TestedModel tested("dynamic");
  const TrueCar truth;
  for (const Instant& at : instants(100)) {
    const State x{0, 0, 0, at[0], at[1], at[2], at[4]};
    const State expected = truth.rates(x, at[3]);
    const Quantities<double> q = tested.at(at);
    EXPECT_NEAR(q.ax, expected.vx, 1e-11);
    EXPECT_NEAR(q.ay, expected.vy, 1e-11);
    EXPECT_NEAR(q.aw, expected.omega, 1e-9);
    EXPECT_NEAR(q.force_front, truth.force(Axle::front, truth.front_slip(x)), 1e-14);
    EXPECT_NEAR(q.force_rear, truth.force(Axle::rear, truth.rear_slip(x)), 1e-14);
  }
}

TEST(Dynamic, SlopesPullTheWayTheDefinitionsSay) {
  Nominal nominal("dynamic");
  Place place;
  place.grade = 0.05;  // uphill: slower
  place.bank = 0.04;   // right side higher: pulled to the left
  State x;
  x.vx = 1.0;
  const auto flat = nominal.prediction().rates(x, {0, 0}, {});
  const auto sloped = nominal.prediction().rates(x, {0, 0}, place);
  EXPECT_NEAR(sloped.vx - flat.vx, -gravity * std::sin(0.05), 1e-12);
  EXPECT_NEAR(sloped.vy - flat.vy, gravity * std::sin(0.04), 1e-12);
  EXPECT_EQ(sloped.omega, flat.omega);
}

/// In a left turn whose outer, right side is higher the road presses more, whichever way the file goes; in one that falls
/// outwards less. On a straight only the slope's normal counts.
TEST(Dynamic, ABankedTurnPressesOnTheTyres) {
  Nominal nominal("dynamic");
  State x;
  x.vx = 2.0;
  Place place;
  place.bank = 0.2;
  const auto load = [&] { return nominal.prediction().rates(x, {0, 0}, place).load_rear; };
  EXPECT_NEAR(load(), std::cos(0.2), 1e-12);
  place.kappa = 0.5;
  EXPECT_NEAR(load(), std::cos(0.2) + 4.0 / gravity * 0.5 * std::sin(0.2), 1e-12);
  place.direction = -1.0;
  EXPECT_NEAR(load(), std::cos(0.2) - 4.0 / gravity * 0.5 * std::sin(0.2), 1e-12);
  place.kappa = 50.0;
  EXPECT_EQ(load(), 0.2) << "a car that leaves the road";
  // Forces go with it.
  place = {};
  x.vy = 0.1;
  const double flat = nominal.prediction().rates(x, {0, 0}, place).vy;
  place.kappa = 0.5, place.bank = 0.2;
  EXPECT_NEAR(nominal.prediction().rates(x, {0, 0}, place).vy - gravity * std::sin(0.2), load() * flat, 1e-12);
}

TEST(Dynamic, BrakesAreTheirOwnOrTheMotors) {
  const TestedModel motor("dynamic"), brakes("dynamic", {{"Cb", 0.5}});
  const Instant braking{2, 0, 0, -0.1, 0, 0}, driving{2, 0, 0, 0.6, 0, 0};
  EXPECT_NEAR(motor.at(braking).drive_force, -0.1 * (0.287 - 0.0545 * 2), 1e-15);
  EXPECT_NEAR(brakes.at(braking).drive_force, -0.05, 1e-15);
  EXPECT_EQ(motor.at(driving).drive_force, brakes.at(driving).drive_force);
}

TEST(Dynamic, DerivativesAgreeWithDifferences) {
  const TestedModel tested("dynamic", {{"Cb", 0.5}});
  for (const Instant& at : instants(20)) EXPECT_LT(derivative_error(*tested.model, at, tested.params), 3e-6);
}

class DynamicLogs : public testing_support::WithReference {};

TEST_F(DynamicLogs, OneStepIsThePublishedPlants) {
  const Drive log = read_log("run_bayesrace_nmpc_true_ethz.csv", 8.08);
  expect_published_steps(log, std::vector<double>(log.x.size(), 1.0));
}

TEST_F(DynamicLogs, OneStepIsThePublishedPlantsWithFadingFriction) {
  const Drive log = read_log("run_apacrace_ethz_varspeeds.csv");
  const auto factor = read_columns(reference("friction_schedules.csv"))["apac_ethz_decay"];
  ASSERT_GE(factor.size(), log.steps());
  expect_published_steps(log, factor);
}

}  // namespace test_dynamic
}  // namespace gripline
