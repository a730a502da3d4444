// The real-time controller: its solver, and the plugin as a stack loads it.
#include "controllers/mpc_sqp/sqp.hpp"

#include <gtest/gtest.h>

#include "support/allocation_counter.hpp"
#include "support/mpc_optimality.hpp"
#include "support/mpc_support.hpp"

namespace test_mpc_sqp {

using namespace gripline;
using namespace gripline::testing_support;
using mpc::Ocp;
using mpc_sqp::Sqp;
using mpc_sqp::SqpOptions;
using mpc_sqp::SqpStatistics;
using mpc_sqp::SqpStatus;

const Registry& registry() {
  static const Registry one = plugins();
  return one;
}

/// `count` instants of a drive by mpc_sqp, every `stride`-th step.
std::vector<Instant> record(DrivingScene& scene, int horizon, int count, int stride) {
  auto driver = scene.controller("mpc_sqp", {{"horizon", horizon}, {"q_yaw", 0.01}, {"q_v", 0.01}, {"tighten", 0.008}});
  std::vector<Instant> instants;
  for (int step = 0; static_cast<int>(instants.size()) < count; ++step) {
    const Observation now = scene.observe();
    const auto references = scene.references(horizon + 1);
    if (step % stride == stride - 1) instants.push_back({now, {references.begin(), references.end()}});
    scene.drive(driver->control(now, references, scene.model()).u);
  }
  return instants;
}

TEST(MpcSqp, SolutionsMeetTheConditionsOfOptimalityOnRecordedInstants) {
  for (const double tyre_error : {1.0, 0.85}) {
    DrivingScene scene(registry(), {.tyre_error = tyre_error});
    const auto instants = record(scene, 50, 25, 16);
    Ocp ocp(ocp_params(50), scene.car(), scene.dt);
    SqpOptions options;
    options.max_iter = 200;
    options.tol_step = 1e-8;
    Sqp sqp(50, state_size, options);
    for (const Instant& instant : instants) {
      ocp.set(instant.now, instant.references, scene.model());
      sqp.initialize(ocp, scene.model());
      const SqpStatistics statistics = sqp.solve(ocp, scene.model());
      ASSERT_EQ(statistics.status, SqpStatus::converged) << "t = " << instant.now.t;
      const Optimality off = optimality(ocp, sqp.x(), sqp.u(), scene.model());
      EXPECT_LT(off.defect, 1e-8);
      EXPECT_LT(off.stationarity, 1e-4) << "t = " << instant.now.t;
      EXPECT_LT(off.bounds, 1e-7);
      EXPECT_NEAR(statistics.cost, ocp.cost(sqp.x(), sqp.u()), 1e-12);
      EXPECT_LT(statistics.res_eq, 1e-6);  // of the iterate before the last, full step
      EXPECT_LE(statistics.step_norm, options.tol_step);
      EXPECT_GT(statistics.qp_active_set_iter + statistics.qp_ip_iter, 0);
    }
  }
}

TEST(MpcSqp, InRealTimeTheFirstInputIsTheConvergedOne) {
  DrivingScene scene(registry(), {.pace = 1.0});
  Ocp ocp(ocp_params(50), scene.car(), scene.dt);
  SqpOptions tight;
  tight.max_iter = 200;
  tight.tol_step = 1e-8;
  Sqp driver(50, state_size, {}), converged(50, state_size, tight);
  std::vector<double> errors;
  long programs = 0;
  for (int step = 0; step < 300; ++step) {
    const Observation now = scene.observe();
    ocp.set(now, scene.references(51), scene.model());
    if (step == 0) {
      driver.initialize(ocp, scene.model());
    } else {
      driver.shift();
    }
    std::copy(driver.x().begin(), driver.x().end(), converged.x().begin());
    std::copy(driver.u().begin(), driver.u().end(), converged.u().begin());
    const SqpStatistics statistics = driver.solve(ocp, scene.model());
    EXPECT_EQ(statistics.status, SqpStatus::converged) << "step " << step;
    programs += statistics.sqp_iter;
    if (step % 3 == 0 && converged.solve(ocp, scene.model()).status == SqpStatus::converged) {
      const Input found{driver.u()[0], driver.u()[1]}, exact{converged.u()[0], converged.u()[1]};
      errors.push_back(input_difference(found, exact, scene.car()));
    }
    scene.drive({driver.u()[0], driver.u()[1]});
  }
  EXPECT_FALSE(scene.was_outside());
  EXPECT_GT(errors.size(), 90u);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 95 / 100], 1e-3);
  EXPECT_LT(programs, 300 * 4);
}

TEST(MpcSqp, DrivesALapWithEitherHorizonAndNeverFails) {
  for (const bool mobil : {false, true}) {
    DrivingScene scene(registry(), {.mobil = mobil});
    const int n = mobil ? 20 : 50;
    auto controller = scene.controller("mpc_sqp", {{"horizon", n}, {"q_yaw", 0.01}, {"q_v", 0.01}, {"tighten", 0.008}});
    ASSERT_EQ(controller->horizon(), n + 1);
    double travelled = 0;
    for (int step = 0; step < 400; ++step) {
      const State before = scene.state();
      const Observation now = scene.observe();
      const Command command = controller->control(now, scene.references(n + 1), scene.model());
      EXPECT_TRUE(command.solved) << "step " << step;
      EXPECT_EQ(controller->predicted().size(), static_cast<std::size_t>(n + 1));
      scene.drive(command.u);
      travelled += std::hypot(scene.state().x - before.x, scene.state().y - before.y);
    }
    EXPECT_FALSE(scene.was_outside());
    EXPECT_GT(travelled, 12.0);
  }
}

TEST(MpcSqp, ThePlanIsThePredictionOfItsInputs) {
  DrivingScene scene(registry(), {});
  auto controller = scene.controller("mpc_sqp", {{"horizon", 20}, {"tolerance", 1e-7}});
  for (int step = 0; step < 40; ++step) {
    const Observation now = scene.observe();
    const Command command = controller->control(now, scene.references(21), scene.model());
    const auto plan = controller->predicted();
    EXPECT_EQ(plan[0].x, now.x.x);
    scene.drive(command.u);
    EXPECT_NEAR(plan[1].x, scene.state().x, 1e-4);
    EXPECT_NEAR(plan[1].vx, scene.state().vx, 1e-3);
  }
}

/// A mirror image along the x axis.
Instant mirrored(Instant instant) {
  State& x = instant.now.x;
  for (double* v : {&x.y, &x.yaw, &x.vy, &x.omega, &x.delta}) *v = -*v;
  for (RefPoint& r : instant.references) {
    r.y = -r.y;
    r.yaw = -r.yaw;
    r.kappa = -r.kappa;
    std::swap(r.left, r.right);
  }
  return instant;
}

TEST(MpcSqp, MirroredProblemsHaveMirroredSolutions) {
  DrivingScene scene(registry(), {});
  const auto instants = record(scene, 30, 60, 1);
  // From a cold start each: a plan carried along would be that of another instant of the recorded drive.
  for (const Instant& instant : instants) {
    auto one = scene.controller("mpc_sqp", {{"horizon", 30}, {"q_yaw", 0.05}, {"q_v", 0.02}});
    auto other = scene.controller("mpc_sqp", {{"horizon", 30}, {"q_yaw", 0.05}, {"q_v", 0.02}});
    const Instant image = mirrored(instant);
    const Command left = one->control(instant.now, instant.references, scene.model());
    const Command right = other->control(image.now, image.references, scene.model());
    EXPECT_EQ(left.solved, right.solved);
    EXPECT_NEAR(left.u.d, right.u.d, 1e-6);
    EXPECT_NEAR(left.u.ddelta, -right.u.ddelta, 1e-5);
  }
}

/// As above, each with the plan of its own drive carried along.
TEST(MpcSqp, AMirroredDriveIsTheMirroredDrive) {
  DrivingScene scene(registry(), {});
  auto one = scene.controller("mpc_sqp", {{"horizon", 30}, {"q_yaw", 0.01}, {"q_v", 0.01}, {"tighten", 0.008}});
  auto other = scene.controller("mpc_sqp", {{"horizon", 30}, {"q_yaw", 0.01}, {"q_v", 0.01}, {"tighten", 0.008}});
  for (int step = 0; step < 200; ++step) {
    const Observation now = scene.observe();
    const auto references = scene.references(31);
    const Instant image = mirrored({now, {references.begin(), references.end()}});
    const Command left = one->control(now, references, scene.model());
    const Command right = other->control(image.now, image.references, scene.model());
    EXPECT_TRUE(left.solved && right.solved) << "step " << step;
    EXPECT_LT(input_difference(left.u, {right.u.d, -right.u.ddelta}, scene.car()), 1e-4) << "step " << step;
    scene.drive(left.u);
  }
}

TEST(MpcSqp, AWholeTurnOfTheHeadingChangesNothing) {
  DrivingScene scene(registry(), {});
  auto one = scene.controller("mpc_sqp", {{"horizon", 20}});
  auto other = scene.controller("mpc_sqp", {{"horizon", 20}});
  for (int step = 0; step < 30; ++step) {
    const Observation now = scene.observe();
    const auto references = scene.references(21);
    const Command command = one->control(now, references, scene.model());
    Observation wrapped = now;
    if (step % 2 == 1) wrapped.x.yaw += 2 * std::numbers::pi;
    const Command same = other->control(wrapped, references, scene.model());
    EXPECT_TRUE(same.solved);
    EXPECT_LT(input_difference(command.u, same.u, scene.car()), 1e-3);
    scene.drive(command.u);
  }
}

TEST(MpcSqp, TheSameDriveGivesTheSameBytes) {
  const auto drive = [] {
    DrivingScene scene(registry(), {});
    auto controller = scene.controller("mpc_sqp", {{"horizon", 50}});
    std::vector<double> inputs;
    for (int step = 0; step < 60; ++step) {
      const Observation now = scene.observe();
      const Command command = controller->control(now, scene.references(51), scene.model());
      inputs.insert(inputs.end(), {command.u.d, command.u.ddelta, command.cost});
      scene.drive(command.u);
    }
    return inputs;
  };
  EXPECT_EQ(drive(), drive());
}

TEST(MpcSqp, AStepAllocatesNothingAfterTheFirst) {
  if (!rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  DrivingScene scene(registry(), {.tyre_error = 0.85});
  auto controller = scene.controller("mpc_sqp", {{"horizon", 50}, {"front_slip", 1.0}});
  for (int step = 0; step < 60; ++step) {
    const Observation now = scene.observe();
    const auto references = scene.references(51);
    const long before = rig::allocations.load();
    const Command command = controller->control(now, references, scene.model());
    const long allocated = rig::allocations.load() - before;
    if (step > 0) {
      EXPECT_EQ(allocated, 0) << "step " << step;
    }
    scene.drive(command.u);
  }
}

/// At rest where it is to stay: the first step is exactly nothing, and that is the solution.
TEST(MpcSqp, NothingToDoIsASolution) {
  DrivingScene scene(registry(), {});
  auto controller = scene.controller("mpc_sqp", {{"horizon", 20}});
  Observation now;
  const std::vector<RefPoint> stay(21);
  const Command command = controller->control(now, stay, scene.model());
  EXPECT_TRUE(command.solved);
  EXPECT_LE(command.iterations, 2);
}

TEST(MpcSqp, APredictionThatFailsIsReportedAndSurvived) {
  DrivingScene scene(registry(), {});
  Failing model(scene.model());
  auto controller = scene.controller("mpc_sqp", {{"horizon", 20}});
  for (int step = 0; step < 90; ++step) {
    model.broken = step == 0 || (step >= 30 && step < 33);
    const Observation now = scene.observe();
    const long before = model.calls;
    const Command command = controller->control(now, scene.references(21), model);
    EXPECT_EQ(command.solved, !model.broken) << "step " << step;
    EXPECT_LT(model.calls - before, 200);
    EXPECT_TRUE(std::isfinite(command.u.d) && std::isfinite(command.u.ddelta) && std::isfinite(command.cost));
    scene.drive(command.u);
  }
  EXPECT_FALSE(scene.was_outside());
}

TEST(MpcSqp, OutOfIterationsItDrivesItsBestAndSaysSo) {
  DrivingScene scene(registry(), {});
  auto controller = scene.controller(
      "mpc_sqp",
      {{"horizon", 50}, {"iterations", 1}, {"tolerance", 1e-9}, {"q_yaw", 0.01}, {"q_v", 0.01}, {"tighten", 0.008}});
  for (int step = 0; step < 150; ++step) {
    const Observation now = scene.observe();
    const Command command = controller->control(now, scene.references(51), scene.model());
    EXPECT_FALSE(command.solved);
    EXPECT_EQ(command.iterations, 1);
    EXPECT_LE(std::abs(command.u.ddelta), scene.car().ddelta_max);
    scene.drive(command.u);
  }
  EXPECT_FALSE(scene.was_outside());
}

/// Bounds may move from one step to the next so that the last plan is outside: it is brought back, whatever that costs.
TEST(MpcSqp, APlanThatBoundsHaveLeftIsBroughtBack) {
  constexpr int n = 30;
  DrivingScene scene(registry(), {.pace = 0.9});
  Ocp ocp(ocp_params(n), scene.car(), scene.dt);
  Sqp sqp(n, state_size, {});
  int left = 0, solved = 0;
  for (int step = 0; step < 150; ++step) {
    ocp.set(scene.observe(), scene.references(n + 1), scene.model());
    if (step == 0) {
      sqp.initialize(ocp, scene.model());
    } else {
      sqp.shift();
    }
    const bool tight = step % 2 == 1;
    ocp.bound_front_slip(sqp.x(), tight ? 0.02 : 0.3);
    double beyond = 0;
    for (int k = 1; k <= n; ++k) {
      const double delta = sqp.x()[static_cast<std::size_t>(k * state_size + 6)];
      beyond = std::max({beyond, ocp.stage(k).delta_min - delta, delta - ocp.stage(k).delta_max});
    }
    const bool converged = sqp.solve(ocp, scene.model()).status == SqpStatus::converged;
    if (beyond > 0.05) {
      ++left;
      solved += converged ? 1 : 0;
      for (int k = 1; k <= n; ++k) {
        const double delta = sqp.x()[static_cast<std::size_t>(k * state_size + 6)];
        EXPECT_GE(delta, ocp.stage(k).delta_min - 1e-6) << "step " << step << ", stage " << k;
        EXPECT_LE(delta, ocp.stage(k).delta_max + 1e-6) << "step " << step << ", stage " << k;
      }
    }
    if (!tight) scene.drive({sqp.u()[0], sqp.u()[1]});
  }
  EXPECT_GT(left, 20);
  EXPECT_GT(solved, 0.7 * left);
}

/// Brakes hold a car that stands however little they are released, so that nothing in a braked plan says that there is
/// more to have by driving.
TEST(MpcSqp, ACarThatWasStoppedDrivesOffAgain) {
  DrivingScene scene(registry(), {});
  constexpr int n = 20, stopped = 100, driving = 75;
  auto controller = scene.controller("mpc_sqp", {{"horizon", n}, {"q_yaw", 0.01}, {"q_v", 0.1}, {"tighten", 0.008}});
  for (int step = 0; step < stopped + driving; ++step) {
    const Observation now = scene.observe();
    const auto ahead = scene.references(n + 1);
    std::vector<RefPoint> references(ahead.begin(), ahead.end());
    if (step < stopped) {
      std::fill(references.begin(), references.end(), references.front());
      for (RefPoint& one : references) one.v = 0.0;
    }
    scene.drive(controller->control(now, references, scene.model()).u);
    if (step == stopped - 1) {
      ASSERT_LT(std::abs(scene.state().vx), 0.05);
    }
  }
  EXPECT_GT(scene.state().vx, 0.5);
}

TEST(MpcSqp, PlansStayWithinTheFrontSlipTheyAreGiven) {
  constexpr int n = 30;
  constexpr double largest = 0.2;
  DrivingScene scene(registry(), {.pace = 0.9});
  Ocp ocp(ocp_params(n), scene.car(), scene.dt);
  Sqp sqp(n, state_size, {});
  int held = 0, solved = 0;
  for (int step = 0; step < 150; ++step) {
    const Observation now = scene.observe();
    ocp.set(now, scene.references(n + 1), scene.model());
    if (step == 0) {
      sqp.initialize(ocp, scene.model());
    } else {
      sqp.shift();
    }
    ocp.bound_front_slip(sqp.x(), largest);
    const bool converged = sqp.solve(ocp, scene.model()).status == SqpStatus::converged;
    if (converged) ++solved;
    for (int k = 1; converged && k <= n; ++k) {
      const double delta = sqp.x()[static_cast<std::size_t>(k * state_size + 6)];
      const mpc::OcpStage& s = ocp.stage(k);
      EXPECT_GE(delta, s.delta_min - 1e-6) << "step " << step << ", stage " << k;
      EXPECT_LE(delta, s.delta_max + 1e-6) << "step " << step << ", stage " << k;
      if (std::min(delta - s.delta_min, s.delta_max - delta) < 1e-6) ++held;
    }
    scene.drive({sqp.u()[0], sqp.u()[1]});
  }
  EXPECT_GE(solved, 145);
  EXPECT_GT(held, 10);
  EXPECT_FALSE(scene.was_outside());
}

// The tyres of this car gain force up to its lock: there is nothing to bound.
TEST(MpcSqp, WithoutAPeakWithinTheLockNothingIsBounded) {
  DrivingScene scene(registry(), {});
  auto free = scene.controller("mpc_sqp", {{"horizon", 20}});
  auto bounded = scene.controller("mpc_sqp", {{"horizon", 20}, {"front_slip", 1.0}});
  for (int step = 0; step < 30; ++step) {
    const Observation now = scene.observe();
    const auto references = scene.references(21);
    const Command command = free->control(now, references, scene.model());
    const Command same = bounded->control(now, references, scene.model());
    EXPECT_EQ(command.u.d, same.u.d);
    EXPECT_EQ(command.u.ddelta, same.u.ddelta);
    scene.drive(command.u);
  }
}

TEST(MpcSqp, SteeringBeyondItsLimitIsBroughtBack) {
  DrivingScene scene(registry(), {});
  const auto instants = record(scene, 20, 1, 50);
  auto controller = scene.controller("mpc_sqp", {{"horizon", 20}});
  Instant instant = instants[0];
  instant.now.x.delta = 0.5;
  const Command command = controller->control(instant.now, instant.references, scene.model());
  EXPECT_TRUE(command.solved);
  EXPECT_NEAR(command.u.ddelta, -5.0, 1e-6);  // 0.5 - 0.1 is still beyond 0.35
}

}  // namespace test_mpc_sqp
