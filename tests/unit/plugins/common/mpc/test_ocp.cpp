// The optimal control ocp that the model-predictive controllers share.
#include "common/mpc/ocp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "common/mpc/saturation_slip.hpp"
#include "support/planner_support.hpp"

namespace test_ocp {

using namespace gripline;
using mpc::Ocp;
using mpc::OcpParams;

/// Moves a car along its heading at its speed; as many states as asked for.
class Glide final : public Prediction {
 public:
  explicit Glide(int states = state_size) : states_(states) {}
  int states() const noexcept override { return states_; }
  double dt() const noexcept override { return 0.02; }
  void start(const State& now, std::span<double> x) const override {
    const double row[] = {now.x, now.y, now.yaw, now.vx, now.vy, now.omega, now.delta};
    std::copy_n(row, state_size, x.begin());
    std::fill(x.begin() + state_size, x.end(), 0.5);
  }
  void step(std::size_t, std::span<const double>, std::span<const double>, std::span<const Place>, std::span<double>,
            std::span<double>, std::span<double>) override {}
  Rates rates(const State&, const Input&, const Place&) override { return {}; }

 private:
  int states_;
};

OcpParams no_cost() {
  OcpParams p;
  p.horizon = 3;
  p.q_x = p.q_y = p.r_d = p.r_ddelta = 0;
  p.regularization = 0;
  p.track_bounds = false;
  return p;
}

/// References one metre apart along a heading, with edges 0.2 m to the left and 0.3 m to the right.
std::vector<RefPoint> straight(int count, double yaw) {
  std::vector<RefPoint> references(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < references.size(); ++k) {
    RefPoint& r = references[k];
    r.x = static_cast<double>(k) * std::cos(yaw);
    r.y = static_cast<double>(k) * std::sin(yaw);
    r.yaw = yaw;
    r.v = 2;
    r.left = 0.2;
    r.right = 0.3;
    r.at.s = static_cast<double>(k);
  }
  return references;
}

/// Rows with every state on its reference.
std::vector<double> on_reference(const Ocp& ocp) {
  std::vector<double> x(static_cast<std::size_t>((ocp.horizon() + 1) * ocp.states()));
  for (int k = 0; k <= ocp.horizon(); ++k) {
    double* row = x.data() + k * ocp.states();
    row[0] = ocp.stage(k).x;
    row[1] = ocp.stage(k).y;
    row[2] = ocp.stage(k).yaw;
    row[3] = ocp.stage(k).v;
  }
  return x;
}

struct Case {
  explicit Case(const OcpParams& params, double yaw = 0, Observation now = {})
      : ocp(params, testing_support::car_1_43(), 0.02) {
    ocp.set(now, straight(params.horizon + 1, yaw), Glide());
    x = on_reference(ocp);
    u.assign(static_cast<std::size_t>(2 * params.horizon), 0.0);
  }
  double cost() const { return ocp.cost(x, u); }
  double& state(int k, int i) { return x[static_cast<std::size_t>(k * ocp.states() + i)]; }
  Ocp ocp;
  std::vector<double> x, u;
};

TEST(MpcOcp, DefaultsAreThePublishedCost) {
  const OcpParams p;
  EXPECT_EQ(p.horizon, 20);
  EXPECT_EQ(p.q_x, 1);
  EXPECT_EQ(p.q_y, 1);
  EXPECT_EQ(p.r_d, 5e-3);
  EXPECT_EQ(p.r_ddelta, 1);
  for (const double zero : {p.q_lag, p.q_contour, p.q_yaw, p.q_v, p.p_x, p.p_y, p.p_yaw, p.p_v, p.slack_linear})
    EXPECT_EQ(zero, 0);
}

TEST(MpcOcp, EveryParameterIsDeclaredOnceWithItsUnitAndMeaning) {
  std::set<std::string> names;
  std::apply(
      [&](const auto&... declared) {
        const auto check = [&](const gripline::abi::ParamDecl& d) {
          EXPECT_TRUE(names.insert(d.name).second) << d.name;
          EXPECT_GT(std::string(d.unit).size(), 0u) << d.name;
          EXPECT_GT(std::string(d.doc).size(), 10u) << d.name;
          EXPECT_LE(d.lo, d.default_value) << d.name;
          EXPECT_GE(d.hi, d.default_value) << d.name;
        };
        (std::for_each(declared.decls.begin(), declared.decls.end(), check), ...);
      },
      mpc::ocp_parameters());
  EXPECT_TRUE(names.contains("horizon"));
  EXPECT_TRUE(names.contains("slack_linear"));
}

TEST(MpcOcp, OnTheReferenceNothingIsPaid) {
  OcpParams p;
  p.horizon = 3;
  p.q_yaw = p.q_v = p.q_lag = p.q_contour = 1;
  EXPECT_EQ(Case(p, 0.7).cost(), 0);
}

TEST(MpcOcp, PositionErrorsAreWeightedAlongTheAxesOfTheWorldAndOfTheReference) {
  OcpParams p = no_cost();
  p.q_x = 2;
  p.q_y = 3;
  Case world(p, 0.7);
  world.state(2, 0) += 0.1;
  EXPECT_NEAR(world.cost(), 2 * 0.01, 1e-15);
  world.state(2, 1) += 0.2;
  EXPECT_NEAR(world.cost(), 2 * 0.01 + 3 * 0.04, 1e-15);

  p = no_cost();
  p.q_lag = 5;
  p.q_contour = 7;
  Case line(p, 0.7);
  line.state(1, 0) += 0.1 * std::cos(0.7) - 0.2 * std::sin(0.7);  // 0.1 ahead, 0.2 to the left
  line.state(1, 1) += 0.1 * std::sin(0.7) + 0.2 * std::cos(0.7);
  EXPECT_NEAR(line.cost(), 5 * 0.01 + 7 * 0.04, 1e-15);
}

TEST(MpcOcp, HeadingSpeedAndTheEndHaveTheirWeights) {
  OcpParams p = no_cost();
  p.q_yaw = 2;
  p.q_v = 3;
  p.p_x = 10;
  p.p_y = 20;
  p.p_yaw = 30;
  p.p_v = 40;
  for (const int k : {1, 2, 3}) {
    Case c(p);
    c.state(k, 0) += 0.1;
    c.state(k, 1) -= 0.1;
    c.state(k, 2) += 0.1;
    c.state(k, 3) -= 0.1;
    EXPECT_NEAR(c.cost(), 0.01 * (k == 3 ? 10 + 20 + 32 + 43 : 5), 1e-15);
  }
}

TEST(MpcOcp, TheFirstStateIsGivenAndCostsNothing) {
  Case c{OcpParams{.horizon = 3}};
  c.state(0, 0) += 5;
  EXPECT_EQ(c.cost(), 0);
}

TEST(MpcOcp, InputsPayForTheirChangeAndALittleForThemselves) {
  OcpParams p = no_cost();
  p.r_d = 0.5;
  p.r_ddelta = 2;
  Observation now;
  now.d = 0.4;  // the throttle of the step before
  Case c(p, 0, now);
  c.u = {0.6, 1.0, 0.6, 0.0, 0.1, -3.0};
  EXPECT_NEAR(c.cost(), 0.5 * (0.04 + 0.25) + 2 * (1 + 9) * 0.02 * 0.02, 1e-15);
  p.r_d = p.r_ddelta = 0;
  p.regularization = 0.1;
  Case small(p, 0, now);
  small.u = c.u;
  EXPECT_NEAR(small.cost(), 0.1 * (0.36 + 0.36 + 0.01 + 10 * 0.02 * 0.02), 1e-15);
}

TEST(MpcOcp, EdgesCostOnlyBeyondThem) {
  OcpParams p = no_cost();
  p.track_bounds = true;
  p.tighten = 0.05;
  p.slack = 100;
  p.slack_linear = 2;
  const double yaw = 2.1;
  const auto cost_at = [&](double to_the_left) {
    Case c(p, yaw);
    c.state(2, 0) -= to_the_left * std::sin(yaw);
    c.state(2, 1) += to_the_left * std::cos(yaw);
    return c.cost();
  };
  EXPECT_NEAR(cost_at(0.149), 0, 1e-12);
  EXPECT_NEAR(cost_at(-0.249), 0, 1e-12);
  EXPECT_NEAR(cost_at(0.16), 100 * 1e-4 + 2 * 0.01, 1e-12);
  EXPECT_NEAR(cost_at(-0.27), 100 * 4e-4 + 2 * 0.02, 1e-12);
  p.track_bounds = false;
  EXPECT_EQ(cost_at(5), 0);
}

TEST(MpcOcp, MarginsThatDoNotFitAskForTheMiddle) {
  OcpParams p = no_cost();
  p.track_bounds = true;
  p.tighten = 0.4;
  Case c(p);
  EXPECT_DOUBLE_EQ(c.ocp.stage(1).edge_lower, -0.05);  // edges at -0.3 and +0.2
  EXPECT_DOUBLE_EQ(c.ocp.stage(1).edge_upper, -0.05);
}

TEST(MpcOcp, HeadingsContinueTheCars) {
  Observation now;
  now.x.yaw = 40 * std::numbers::pi + 3.1;
  Ocp ocp(no_cost(), testing_support::car_1_43(), 0.02);
  auto references = straight(4, 0);
  const double turning[] = {3.1, -3.1, -2.9, 2.9};  // across the cut and back
  for (std::size_t k = 0; k < 4; ++k) references[k].yaw = turning[k];
  ocp.set(now, references, Glide());
  const double expected[] = {3.1, -3.1 + 2 * std::numbers::pi, -2.9 + 2 * std::numbers::pi, 2.9};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(ocp.stage(k).yaw, 40 * std::numbers::pi + expected[k], 1e-12);
}

TEST(MpcOcp, SteeringBeyondItsLimitMayReturnAtItsRate) {
  Observation now;
  now.x.delta = -0.55;  // limit 0.35, 0.1 per step
  Case c(no_cost(), 0, now);
  EXPECT_NEAR(c.ocp.stage(1).delta_max, 0.45, 1e-12);
  EXPECT_NEAR(c.ocp.stage(2).delta_max, 0.35, 1e-12);
  EXPECT_NEAR(c.ocp.stage(3).delta_max, 0.35, 1e-12);
}

/// Rows of a plan that moves the front axle by `course` [rad] from the car's axis.
std::vector<double> moving(const Ocp& ocp, double vx, double course) {
  std::vector<double> x;
  for (int k = 0; k <= ocp.horizon(); ++k) {
    x.insert(x.end(), {0, 0, 0, vx, 0.5 * vx * std::tan(course), 0.5 * vx * std::tan(course) / ocp.car().lf, 0});
  }
  return x;
}

TEST(MpcOcp, SteeringKeepsToWhereTheFrontAxleMovesWithinItsSlip) {
  Case c(no_cost());
  c.ocp.bound_front_slip(moving(c.ocp, 2.0, 0.1), 0.15);
  for (int k = 1; k <= 3; ++k) {
    EXPECT_NEAR(c.ocp.stage(k).delta_min, -0.05, 1e-12);
    EXPECT_NEAR(c.ocp.stage(k).delta_max, 0.25, 1e-12);
  }
}

TEST(MpcOcp, AnAxleThatMovesBeyondTheLockIsFollowedToTheLock) {
  Observation now;
  now.x.delta = 0.3;  // 0.1 per step
  for (const double side : {1.0, -1.0}) {
    now.x.delta = 0.3 * side;
    Case c(no_cost(), 0, now);
    c.ocp.bound_front_slip(moving(c.ocp, 2.0, 0.6 * side), 0.1);
    const auto& last = c.ocp.stage(3);
    EXPECT_NEAR(side > 0 ? last.delta_max : -last.delta_min, 0.35, 1e-12);
    EXPECT_NEAR(last.delta_max - last.delta_min, 0.01, 1e-12);  // a tenth of a step: solvers need an interior
  }
}

TEST(MpcOcp, SteeringReturnsToItsSlipAtItsRate) {
  Observation now;
  now.x.delta = 0.3;  // 0.1 per step
  Case c(no_cost(), 0, now);
  c.ocp.bound_front_slip(moving(c.ocp, 2.0, 0.0), 0.05);
  EXPECT_NEAR(c.ocp.stage(1).delta_max, 0.205, 1e-12);  // and a twentieth of a step to spare
  EXPECT_NEAR(c.ocp.stage(2).delta_max, 0.105, 1e-12);
  EXPECT_NEAR(c.ocp.stage(3).delta_max, 0.05, 1e-12);
  for (int k = 1; k <= 3; ++k) EXPECT_NEAR(c.ocp.stage(k).delta_min, -0.05, 1e-12);
}

TEST(MpcOcp, ASlowCarSteersAsItLikes) {
  Case c(no_cost());
  c.ocp.bound_front_slip(moving(c.ocp, 1.5 * c.ocp.car().v_min, 0.0), 0.05);
  EXPECT_DOUBLE_EQ(c.ocp.stage(1).delta_max, c.ocp.car().delta_max);
  EXPECT_DOUBLE_EQ(c.ocp.stage(1).delta_min, -c.ocp.car().delta_max);
}

/// A car that moves askew so that its rear axle slips by `slip`; its front axle moves by -slip from the car's axis.
std::vector<double> askew(const Ocp& ocp, double slip) {
  std::vector<double> x;
  for (int k = 0; k <= ocp.horizon(); ++k) x.insert(x.end(), {0, 0, 0, 2.0, -2.0 * std::tan(slip), 0, 0});
  return x;
}

TEST(MpcOcp, ARearAxleThatSlipsTooMuchTakesBackTheFrontAxlesSlip) {
  constexpr double front = 0.08, rear = 0.05;
  for (const double side : {1.0, -1.0})
    for (const auto& [slip, inward] : {std::pair(0.03, 1.0), {0.05, 1.0}, {0.075, 0.5}, {0.1, 0.0}, {0.15, -0.875}}) {
      Case c(no_cost());
      c.ocp.bound_front_slip(askew(c.ocp, side * slip), front, rear);
      const auto& stage = c.ocp.stage(3);  // 0.1 per step
      const double outer = side > 0 ? stage.delta_min : -stage.delta_max;
      const double inner = side > 0 ? stage.delta_max : -stage.delta_min;
      EXPECT_NEAR(outer, -slip - front, 1e-12) << slip;
      EXPECT_NEAR(inner, -slip + inward * front, 1e-12) << slip;  // at least a tenth of a step inside the other
    }
}

/// Turned by a front tyre D sin(C atan(B slip)).
class FrontTyre : public Prediction {
 public:
  FrontTyre(double B, double C) : B_(B), C_(C) {}
  int states() const noexcept override { return state_size; }
  double dt() const noexcept override { return 0.02; }
  void start(const State&, std::span<double>) const override {}
  void step(std::size_t, std::span<const double>, std::span<const double>, std::span<const Place>, std::span<double>,
            std::span<double>, std::span<double>) override {}
  Rates rates(const State& x, const Input&, const Place&) override {
    Rates r;
    r.omega = 7.0 * std::sin(C_ * std::atan(B_ * x.delta)) * std::cos(x.delta);
    return r;
  }

 private:
  double B_, C_;
};

TEST(MpcSaturationSlip, IsWhereTheTyreHasNearlyItsLargestForceWithinTheLock) {
  const Car car = testing_support::car_1_43();
  for (const double B : {9.0, 12.0, 20.0}) {
    FrontTyre tyre(B, 1.6);
    EXPECT_NEAR(mpc::front_saturation_slip(tyre, car, 2.0), std::tan(std::asin(0.99) / 1.6) / B, 2e-3) << B;
  }
  FrontTyre levels(20.0, 1.02), late(3.0, 1.3), rising(2.0, 1.0);
  EXPECT_LT(mpc::front_saturation_slip(levels, car, 2.0), 0.3);
  EXPECT_EQ(mpc::front_saturation_slip(late, car, 2.0), INFINITY);  // its peak is at 0.87 rad
  EXPECT_EQ(mpc::front_saturation_slip(rising, car, 2.0), INFINITY);
  Glide no_tyre;
  EXPECT_EQ(mpc::front_saturation_slip(no_tyre, car, 2.0), INFINITY);
}

/// Turned by a rear tyre.
class RearTyre final : public FrontTyre {
 public:
  using FrontTyre::FrontTyre;
  Rates rates(const State& x, const Input& u, const Place& at) override {
    const double front = x.delta - std::atan2(x.vy, x.vx);
    State straight;
    straight.delta = -std::atan2(x.vy, x.vx);  // the slip of the rear axle
    Rates r;
    r.omega = front - FrontTyre::rates(straight, u, at).omega / std::cos(straight.delta);
    return r;
  }
};

TEST(MpcSaturationSlip, OfTheRearAxleIsTakenWithoutForceInFront) {
  const Car car = testing_support::car_1_43();
  for (const double B : {9.0, 12.0, 20.0}) {
    RearTyre tyre(B, 1.6);
    EXPECT_NEAR(mpc::rear_saturation_slip(tyre, car, 2.0), std::tan(std::asin(0.99) / 1.6) / B, 2e-3) << B;
  }
  RearTyre late(3.0, 1.3);
  EXPECT_EQ(mpc::rear_saturation_slip(late, car, 2.0), INFINITY);
}

TEST(MpcOcp, TheStartAndThePlacesAreTheModelsAndTheReferences) {
  Observation now;
  now.x.vx = 1.5;
  Ocp ocp(no_cost(), testing_support::car_1_43(), 0.02);
  ocp.set(now, straight(4, 0), Glide(9));
  EXPECT_EQ(ocp.states(), 9);
  EXPECT_EQ(ocp.start()[3], 1.5);
  EXPECT_EQ(ocp.start()[8], 0.5);  // memory, as the model carries it
  ASSERT_EQ(ocp.places().size(), 3u);
  EXPECT_EQ(ocp.places()[2].s, 2.0);
}

TEST(MpcOcp, LeavesTheSlopeOutWhenTold) {
  OcpParams p = no_cost();
  std::vector<RefPoint> references = straight(p.horizon + 1, 0.3);
  for (RefPoint& r : references) {
    r.at.grade = 0.05;
    r.at.bank = -0.02;
  }
  for (const bool slope : {true, false}) {
    p.slope = slope;
    Ocp ocp(p, testing_support::car_1_43(), 0.02);
    ocp.set(Observation{}, references, Glide());
    ASSERT_FALSE(ocp.places().empty());
    for (std::size_t k = 0; k < ocp.places().size(); ++k) {
      EXPECT_EQ(ocp.places()[k].grade, slope ? 0.05 : 0.0);
      EXPECT_EQ(ocp.places()[k].bank, slope ? -0.02 : 0.0);
      EXPECT_EQ(ocp.places()[k].s, references[k].at.s);
    }
  }
}

}  // namespace test_ocp
