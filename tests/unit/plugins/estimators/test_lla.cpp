// Look-back adaptation, with a bank small enough for a test; the published one has 20 000 models.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/learning_rig.hpp"

namespace gripline {
namespace test_lla {

using namespace rig;

constexpr double L = 0.062, weight = 0.041 * gravity;

double fresh(double) { return 1.0; }
const Settings bank = {{"models", 2000}};

/// The true car, for the privileged row only.
class TrueTyres final : public Truth {
 public:
  double factor() const override { return 1; }
  double mu(Axle axle) const override {
    return axle == Axle::front ? car_.Df * L / (weight * car_.car.lr) : car_.Dr * L / (weight * car_.car.lf);
  }
  double tyre_force(Axle axle, double slip) const override {
    return axle == Axle::front ? 0.192 * std::sin(1.2 * std::atan(2.579 * slip))
                               : 0.1737 * std::sin(1.2691 * std::atan(3.3852 * slip));
  }
  bool accelerations(const Points<double>& points) const override {
    for (std::size_t i = 0; i < points.n; ++i) {
      auto& q = points.q[i];
      const State rates = car_.rates({0, 0, q.yaw, q.vx, q.vy, q.omega, q.delta}, q.d);
      q.ax = rates.vx;
      q.ay = rates.vy;
      q.aw = rates.omega;
    }
    return true;
  }
  bool accelerations(const Points<Dual8>&) const override { return false; }

 private:
  TrueCar car_;
};

TEST(Lla, TheModelsThatPredictedBestExplainTheNextSteps) {
  Nominal nominal("ekinematic");
  const Drive before = drive_bends(6, 3, fresh), after = drive_bends(3, 4, fresh);
  const auto estimator = make_estimator("lla", nominal, bank);
  const Validation untaught = validate(nominal, *estimator, after);
  learn(*estimator, nominal, before);
  const Validation taught = validate(nominal, *estimator, after);
  EXPECT_GT(taught.r2[1], 0.8);  // one model of 2000 at random is no fit
  EXPECT_GT(taught.r2[2], 0.9);
  EXPECT_LT(taught.rmse[1], untaught.rmse[1]);
}

TEST(Lla, NoticesThatGripIsGone) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(16, 3, [](double t) { return t < 8 ? 1.0 : 0.5; });
  const auto estimator = make_estimator("lla", nominal, bank);
  double grippy = 0, slippery = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    estimator->update(
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]));
    const Belief belief = estimator->belief();
    const double mu = 0.5 * (belief.mu_front + belief.mu_rear), t = static_cast<double>(i) * dt;
    if (t > 4 && t < 8) grippy += mu * dt / 4;
    if (t > 10) slippery += mu * dt / 6;
  }
  EXPECT_LT(slippery, 0.75 * grippy);
}

/// What a bank pulls is not taken for friction: it would be more to one side and less to the other.
TEST(Lla, ABankIsNoFriction) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("lla", nominal, bank);
  const TrueCar truth;
  BendDriver driver(3);
  Place banked;
  banked.bank = 0.1;
  State x;
  x.vx = 1.5;
  double sum[2] = {0, 0};  // of what is believed in turns to the right and to the left
  int count[2] = {0, 0};
  for (std::int64_t i = 0; i < 1500; ++i) {
    const Input u = driver.drive(x, truth);
    const State next = truth.step(x, u, 0.0, banked.bank);
    estimator->update(make_sample(nominal.prediction(), i, x, u, next, banked));
    x = next;
    if (i < 200 || std::abs(x.omega) < 2.0) continue;
    const Belief belief = estimator->belief();
    sum[x.omega > 0] += belief.mu_front + belief.mu_rear;
    ++count[x.omega > 0];
  }
  ASSERT_GT(std::min(count[0], count[1]), 100);
  EXPECT_NEAR(sum[1] / count[1] / (sum[0] / count[0]), 1.0, 0.05);
}

/// Until its window is full the privileged row drives with the true tyre, the other with a generic one.
TEST(Lla, OnlyThePrivilegedBankIsCentredOnTheTruth) {
  Nominal nominal("ekinematic");
  const TrueTyres truth;
  const auto told = make_estimator("lla_privileged", nominal, bank, 1, &truth);
  const auto plain = make_estimator("lla", nominal, bank);
  const std::vector<double> slip = {-0.3, 0.05, 0.2, 0.4};
  std::vector<double> force(slip.size()), generic(slip.size()), sigma(slip.size());
  ASSERT_TRUE(told->tyre_force(Axle::rear, slip, force, sigma));
  ASSERT_TRUE(plain->tyre_force(Axle::rear, slip, generic, sigma));
  const double load = weight * small_car().lf / L;
  for (std::size_t i = 0; i < slip.size(); ++i) {
    EXPECT_NEAR(force[i], truth.tyre_force(Axle::rear, slip[i]), 1e-4);
    EXPECT_NEAR(generic[i], load * std::sin(1.4 * std::atan(4 * slip[i])), 1e-12);
  }
}

TEST(Lla, ThePrivilegedRowRefusesToDoWithoutTheTruth) {
  EXPECT_TRUE(registry().find(abi::Kind::estimator, "lla_privileged").needs_truth());
  EXPECT_FALSE(registry().find(abi::Kind::estimator, "lla").needs_truth());
  Nominal nominal("ekinematic");
  EXPECT_THROW(make_estimator("lla_privileged", nominal, bank), PluginError);
}

/// It learns the true resistance less what its nominal model has of it already.
TEST(Lla, ThePrivilegedRowCountsResistanceOnce) {
  const TrueTyres truth;
  for (const Settings& known : {Settings{}, Settings{{"Cr0", 0.03}, {"Cd", 0.0002}}}) {
    Nominal nominal("ekinematic", known);
    const auto told = make_estimator("lla_privileged", nominal, bank, 1, &truth);
    CorrectedModel model = corrected(nominal, *told);
    State x;
    x.vx = 1.5;
    EXPECT_NEAR(model.rates(x, {0.3, 0}, {}).vx, TrueCar{}.rates(x, 0.3).vx, 1e-9);
  }
}

TEST(Lla, SameSeedSameBytesOtherSeedOtherBank) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(3, 5, fresh);
  const auto friction = [&](std::uint64_t seed) {
    const auto estimator = make_estimator("lla", nominal, bank, seed);
    learn(*estimator, nominal, drive);
    return estimator->belief().mu_front;
  };
  EXPECT_EQ(friction(1), friction(1));
  EXPECT_NE(friction(1), friction(2));
}

TEST(Lla, JacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  const auto estimator = make_estimator("lla", nominal, bank);
  learn(*estimator, nominal, drive_bends(3, 3, fresh));
  CorrectedModel model = corrected(nominal, *estimator);
  State x;
  x.vx = 1.8;
  x.vy = -0.2;
  x.omega = 2;
  x.delta = 0.15;
  EXPECT_LT(jacobian_error(model, x, {0.4, 0.5}), 1e-6);
}

}  // namespace test_lla
}  // namespace gripline
