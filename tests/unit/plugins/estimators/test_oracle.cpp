#include "support/learning_rig.hpp"

namespace gripline {
namespace test_oracle {

using namespace rig;

/// The 1:43 car's truth, on ground that rises by `tilt` ahead of the car beside the road's own slopes; or a black box
/// that keeps its accelerations to itself.
class FixedTruth final : public Truth {
 public:
  explicit FixedTruth(bool black_box, double tilt = 0) : black_box_(black_box), tilt_(tilt) { car_.factor = 0.7; }
  const TrueCar& car() const { return car_; }
  double factor() const override { return car_.factor; }
  double mu(Axle axle) const override {
    const Car& c = car_.car;
    const double share = (axle == Axle::front ? c.lr : c.lf) / (c.lf + c.lr);
    return car_.factor * (axle == Axle::front ? car_.Df : car_.Dr) / (c.m * gravity * share);
  }
  double tyre_force(Axle axle, double slip) const override { return car_.force(axle, slip); }
  bool accelerations(const Points<double>& points) const override {
    if (black_box_) return false;
    for (std::size_t i = 0; i < points.n; ++i) {
      auto& q = points.q[i];
      const State rates = car_.rates({0, 0, q.yaw, q.vx, q.vy, q.omega, q.delta}, q.d);
      q.ax = rates.vx;
      q.ay = rates.vy;
      q.aw = rates.omega;
      q.grade = points.at[i].grade + tilt_;
      q.bank = points.at[i].bank;
    }
    return true;
  }
  bool accelerations(const Points<Dual8>&) const override { return false; }

 private:
  bool black_box_;
  double tilt_;
  TrueCar car_;
};

TEST(Oracle, MakesTheNominalModelTheTrueOne) {
  const FixedTruth truth(false);
  Nominal nominal("ekinematic");
  const auto oracle = make_estimator("oracle", nominal, {}, 1, &truth);
  CorrectedModel model = corrected(nominal, *oracle);
  const Drive drive = drive_bends(6, 3, [](double) { return 0.7; });
  for (std::size_t i = 25; i < drive.steps(); ++i) {
    const State found = model.advance(drive.x[i], drive.u[i], {});
    EXPECT_NEAR(found.vx, drive.x[i + 1].vx, 2e-3);
    EXPECT_NEAR(found.vy, drive.x[i + 1].vy, 2e-3);
    EXPECT_NEAR(found.omega, drive.x[i + 1].omega, 0.1);  // one Runge-Kutta step against twenty
  }
}

TEST(Oracle, FeelsGradeAndBank) {
  const FixedTruth truth(false);
  Nominal nominal("ekinematic");
  const auto oracle = make_estimator("oracle", nominal, {}, 1, &truth);
  CorrectedModel model = corrected(nominal, *oracle);
  Place sloped;
  sloped.grade = 0.05;
  sloped.bank = 0.03;
  State x;
  x.vx = 1.5;
  const auto flat = model.rates(x, {0, 0}, {}), slope = model.rates(x, {0, 0}, sloped);
  EXPECT_NEAR(slope.vx - flat.vx, -gravity * std::sin(0.05), 1e-12);
  EXPECT_NEAR(slope.vy - flat.vy, gravity * std::sin(0.03), 1e-12);
}

TEST(Oracle, FeelsSlopesOfTheTrueCarThatNoMapHas) {
  const FixedTruth level(false), tilted(false, 0.05);
  Nominal nominal("ekinematic");
  const auto rates = [&](const Truth& truth) {
    const auto oracle = make_estimator("oracle", nominal, {}, 1, &truth);
    State x;
    x.vx = 1.5;
    return corrected(nominal, *oracle).rates(x, {0, 0}, {});
  };
  EXPECT_NEAR(rates(tilted).vx - rates(level).vx, -gravity * std::sin(0.05), 1e-12);
}

TEST(Oracle, BelievesTheTruth) {
  const FixedTruth truth(false);
  Nominal nominal("ekinematic");
  const auto oracle = make_estimator("oracle", nominal, {}, 1, &truth);
  EXPECT_NEAR(total_mu(oracle->belief(), small_car()), truth.car().mu(), 1e-12);
  std::vector<double> force(2), sigma(2, 1.0);
  ASSERT_TRUE(oracle->tyre_force(Axle::rear, std::vector<double>{0.1, -0.2}, force, sigma));
  EXPECT_EQ(force[1], truth.car().force(Axle::rear, -0.2));
  EXPECT_EQ(sigma[0], 0.0);
}

TEST(Oracle, LeavesTheNominalModelBesideABlackBox) {
  const FixedTruth truth(true);
  Nominal nominal("ekinematic");
  const auto oracle = make_estimator("oracle", nominal, {}, 1, &truth);
  CorrectedModel model = corrected(nominal, *oracle);
  State x;
  x.vx = 1.5;
  x.delta = 0.1;
  EXPECT_EQ(model.rates(x, {0.2, 1.0}, {}).omega, nominal.prediction().rates(x, {0.2, 1.0}, {}).omega);
}

TEST(Oracle, DeclaresThatItNeedsTruthAndRefusesToDoWithout) {
  EXPECT_TRUE(registry().find(gripline::abi::Kind::estimator, "oracle").needs_truth());
  Nominal nominal("ekinematic");
  EXPECT_THROW(make_estimator("oracle", nominal), PluginError);
}

TEST(None, LearnsNothing) {
  Nominal nominal("ekinematic");
  const auto none = make_estimator("none", nominal);
  learn(*none, nominal, drive_bends(3, 3, [](double) { return 1.0; }));
  EXPECT_EQ(none->belief().mu_front, 1.0);
  CorrectedModel model = corrected(nominal, *none);
  State x;
  x.vx = 1.5;
  x.delta = 0.1;
  EXPECT_EQ(model.rates(x, {0.2, 1.0}, {}).omega, nominal.prediction().rates(x, {0.2, 1.0}, {}).omega);
  std::vector<double> force(1);
  EXPECT_FALSE(none->tyre_force(Axle::front, std::vector<double>{0.1}, force, {}));
}

}  // namespace test_oracle
}  // namespace gripline
