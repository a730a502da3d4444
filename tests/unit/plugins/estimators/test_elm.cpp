#include <Eigen/Core>

#include "common/learning/window_gram.hpp"
#include "support/allocation_counter.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_elm {

using namespace rig;

double fresh(double) { return 1.0; }
/// The published decline: 1/2200 of the rest per step from 14.4 s on.
double fading(double t) { return t > 14.4 ? std::pow(1.0 - 1.0 / 2200, (t - 14.4) / dt) : 1.0; }

/// rms of mu against the true curves' maxima over the slips visited, from `from` seconds on.
double visited_error(Estimator& estimator, Nominal& nominal, const Drive& drive, double from) {
  TrueCar truth;
  Visited visited;
  double squares = 0;
  int n = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    estimator.update(
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]));
    visited.see(truth, drive.x[i + 1]);
    if (static_cast<double>(i) * dt < from) continue;
    truth.factor = drive.factor[i];
    const double error = total_mu(estimator.belief(), truth.car) - visited.mu(truth);
    squares += error * error;
    ++n;
  }
  return std::sqrt(squares / n);
}

std::vector<double> curve(const Estimator& estimator, Axle axle, const std::vector<double>& slips) {
  std::vector<double> force(slips.size());
  EXPECT_TRUE(estimator.tyre_force(axle, slips, force, {}));
  return force;
}

TEST(WindowGram, HoldsExactlyTheLastSamplesWithTheirWeights) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const int unknowns = 5, window = 7;
  const double retain = 0.9;
  learning::WindowGram gram(unknowns, 2, window, retain);
  std::vector<Eigen::MatrixXd> rows;
  std::vector<Eigen::VectorXd> targets;
  for (int k = 0; k < 60; ++k) {
    rows.push_back(Eigen::MatrixXd::NullaryExpr(unknowns, 2, [&] { return normal(random); }));
    targets.push_back(Eigen::VectorXd::NullaryExpr(2, [&] { return normal(random); }));
    gram.add(rows.back(), targets.back());
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd moment = Eigen::VectorXd::Zero(unknowns), work(unknowns);
    const Eigen::VectorXd z = Eigen::VectorXd::Constant(unknowns, 0.3);
    double residual = 0, weight = 0;
    for (int i = std::max(0, k - window + 1); i <= k; ++i) {
      const double w = std::pow(retain, k - i);
      expected += w * rows[i] * rows[i].transpose();
      moment += w * rows[i] * targets[i];
      residual += w * (rows[i].transpose() * z - targets[i]).squaredNorm();
      weight += w;
    }
    ASSERT_NEAR((gram.gram() - expected).norm(), 0, 1e-12 * expected.norm());
    ASSERT_NEAR((gram.moment() - moment).norm(), 0, 1e-11);
    ASSERT_NEAR(gram.residual(z, work), residual, 1e-10);
    ASSERT_NEAR(gram.weight(), weight, 1e-12);
    ASSERT_EQ(gram.count(), std::min(k + 1, window));
  }
}

TEST(Elm, LearnsTyresAndResistance) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  learn(*elm, nominal, drive_bends(16, 3, fresh));
  const TrueCar truth;
  const std::vector<double> slips = {-0.35, -0.25, -0.15, -0.05, 0.05, 0.15, 0.25, 0.35};
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const auto force = curve(*elm, axle, slips);
    for (std::size_t i = 0; i < slips.size(); ++i)
      EXPECT_NEAR(force[i], truth.force(axle, slips[i]), 0.006) << slips[i];
  }
  EXPECT_LT(resistance_error(nominal, *elm), 0.05);
  EXPECT_LT(elm->belief().sigma_front, 0.01);
}

TEST(Elm, LooksNoFurtherThanItsCap) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(4, 3, fresh);
  const auto beyond = make_estimator("elm", nominal, {{"slip_cap", 0.2}, {"slip_start", 0.3}});
  const auto within = make_estimator("elm", nominal, {{"slip_cap", 0.2}, {"slip_start", 0.2}});
  learn(*beyond, nominal, drive);
  learn(*within, nominal, drive);
  EXPECT_EQ(beyond->belief().mu_front, within->belief().mu_front);
  EXPECT_EQ(beyond->belief().mu_rear, within->belief().mu_rear);
}

TEST(Elm, CarriesOnWithAnyNominalModel) {
  for (const char* const id : {"kinematic", "ekinematic", "dynamic"}) {
    Nominal nominal(id);
    const auto elm = make_estimator("elm", nominal);
    const Drive drive = drive_bends(16, 3, fresh);
    learn(*elm, nominal, drive);
    CorrectedModel model = corrected(nominal, *elm);
    double worst = 0;
    for (std::size_t i = 600; i < drive.steps(); ++i)
      worst = std::max(worst, std::abs(model.advance(drive.x[i], drive.u[i], {}).omega - drive.x[i + 1].omega));
    EXPECT_LT(worst, 0.15) << id;
  }
}

TEST(Elm, MuFollowsTheVisitedCurveWhileFrictionFades) {
  Nominal nominal("ekinematic");
  for (const unsigned seed : {3u, 4u, 5u}) {
    const auto elm = make_estimator("elm", nominal);
    EXPECT_LT(visited_error(*elm, nominal, drive_bends(36, seed, fading), 24.0), 0.03) << seed;
  }
}

TEST(Elm, BelievesWhatItWasToldUntilItLearned) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  EXPECT_EQ(elm->belief().mu_front, 1.0);
  EXPECT_EQ(elm->belief().mu_rear, 1.0);
  std::vector<double> force(1, 7.0);
  EXPECT_FALSE(elm->tyre_force(Axle::front, std::vector<double>{0.1}, force, {}));
  EXPECT_EQ(force[0], 7.0);
}

/// Tyres without any force would be a correction too.
TEST(Elm, CorrectsNothingUntilItLearned) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  CorrectedModel model = corrected(nominal, *elm);
  State x;
  x.vx = 2.0;
  x.vy = -0.1;
  x.omega = 1.0;
  x.delta = 0.1;
  const Input u = {0.4, 0.5};
  const auto expect_nominal = [&] {
    const Prediction::Rates plain = nominal.prediction().rates(x, u, {}), better = model.rates(x, u, {});
    EXPECT_EQ(better.vx, plain.vx);
    EXPECT_EQ(better.vy, plain.vy);
    EXPECT_EQ(better.omega, plain.omega);
  };
  expect_nominal();
  learn(*elm, nominal, drive_bends(0.5, 3, fresh));
  EXPECT_EQ(elm->belief().mu_front, 1.0);
  expect_nominal();
  learn(*elm, nominal, drive_bends(4, 3, fresh));
  EXPECT_NE(model.rates(x, u, {}).vy, nominal.prediction().rates(x, u, {}).vy);
}

TEST(Elm, ForgetsWhatLeftTheWindow) {
  // With equal weights and the pseudo-inverse, only the window's samples can matter.
  Nominal nominal("ekinematic");
  const Settings settings = {{"solver", 1}, {"retain", 1}, {"window", 200}};
  const Drive drive = drive_bends(14, 3, [](double t) { return t < 6 ? 1.0 : 0.6; });
  const auto old = make_estimator("elm", nominal, settings), young = make_estimator("elm", nominal, settings);
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const Sample k =
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
    old->update(k);
    if (static_cast<double>(i) * dt >= 6.0) young->update(k);
  }
  const std::vector<double> slips = {-0.3, -0.1, 0.1, 0.3};
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const auto a = curve(*old, axle, slips), b = curve(*young, axle, slips);
    // The middle of a step is placed with the curve of that moment, hence not to the last digit.
    for (std::size_t i = 0; i < slips.size(); ++i) EXPECT_NEAR(a[i], b[i], 2e-3);
  }
}

TEST(Elm, PseudoInverseWithoutARidgeLearnsTyres) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal, {{"solver", 1}, {"ridge", 0}, {"window", 200}});
  learn(*elm, nominal, drive_bends(8, 3, fresh));
  const TrueCar truth;
  const std::vector<double> slips = {-0.15, -0.05, 0.05, 0.15};
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const auto force = curve(*elm, axle, slips);
    for (std::size_t i = 0; i < slips.size(); ++i)
      EXPECT_NEAR(force[i], truth.force(axle, slips[i]), 0.015) << slips[i];
  }
}

TEST(Elm, RecoversFromASuddenDrop) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  TrueCar truth;
  learn(*elm, nominal, drive_bends(24, 3, [](double t) { return t < 14.3 ? 1.0 : 0.658; }));
  truth.factor = 0.658;
  EXPECT_NEAR(total_mu(elm->belief(), truth.car), truth.mu(), 0.05);
}

TEST(Elm, SeedDecidesTheHiddenLayerAndNothingElseDoes) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(8, 3, fresh);
  const auto one = make_estimator("elm", nominal, {}, 5), same = make_estimator("elm", nominal, {}, 5),
             other = make_estimator("elm", nominal, {}, 6);
  for (const auto* elm : {&one, &same, &other}) learn(**elm, nominal, drive);
  const std::vector<double> slips = {-0.2, 0.3, 0.9};
  EXPECT_EQ(curve(*one, Axle::front, slips), curve(*same, Axle::front, slips));
  EXPECT_NE(curve(*one, Axle::front, slips), curve(*other, Axle::front, slips));
  EXPECT_NEAR(one->belief().mu_front, other->belief().mu_front, 0.03);
}

TEST(Elm, JacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  const Drive drive = drive_bends(8, 3, fresh);
  learn(*elm, nominal, drive);
  CorrectedModel model = corrected(nominal, *elm);
  for (std::size_t i = 50; i < drive.steps(); i += 37) {
    if (drive.x[i].vx < 0.35) continue;  // below, the guard's kink is where a difference must not straddle
    // Small differences: the table's second derivative jumps at its knots.
    EXPECT_LT(jacobian_error(model, drive.x[i], drive.u[i], 3e-7), 1e-6) << i;
  }
}

TEST(Elm, StandsStillWithoutHarm) {
  Nominal nominal("ekinematic");
  const auto elm = make_estimator("elm", nominal);
  State rest;
  for (int i = 0; i < 100; ++i) elm->update(make_sample(nominal.prediction(), i, rest, {0, 0}, rest));
  std::vector<double> force(1);
  EXPECT_FALSE(elm->tyre_force(Axle::front, std::vector<double>{0.1}, force, {})) << "standing teaches nothing";
  learn(*elm, nominal, drive_bends(4, 3, fresh));
  CorrectedModel model = corrected(nominal, *elm);
  for (const double vx : {0.0, -0.5, 1e-9}) {
    State x;
    x.vx = vx;
    x.vy = 0.3;
    x.omega = 5;
    const State next = model.advance(x, {1.0, 5.0}, {});
    EXPECT_TRUE(std::isfinite(next.vx + next.vy + next.omega)) << vx;
  }
}

TEST(Elm, StepAllocatesNothing) {
  if (!counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  const long at_first = allocations;
  Nominal nominal("ekinematic");
  EXPECT_GT(allocations, at_first);  // it does count
  const Drive drive = drive_bends(8, 3, fresh);
  for (const double solver : {0.0, 1.0}) {
    const auto elm = make_estimator("elm", nominal, {{"solver", solver}, {"window", 100}});
    long counted = 0;
    for (std::size_t i = 0; i < drive.steps(); ++i) {
      const Sample k =
          make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
      const long before = allocations;
      elm->update(k);
      if (i > 10) counted += allocations - before;
    }
    EXPECT_EQ(counted, 0) << "solver " << solver;
  }
}

TEST(Elm, NeedsANominalModel) {
  const PluginEntry& entry = registry().find(gripline::abi::Kind::estimator, "elm");
  PluginContext context;
  context.car = small_car();
  EXPECT_THROW(create<Estimator>(entry, context, values_of(entry, {})), PluginError);
}

class ElmLogs : public testing_support::WithReference {};

TEST_F(ElmLogs, OfflineTrainingExplainsAnotherTrack) {
  const Drive mobil = read_log("run_bayesrace_pp_ethzMobil.csv");
  const Drive ethz = read_log("run_bayesrace_nmpc_true_ethz.csv", 8.08);
  for (const double solver : {0.0, 1.0}) {
    Nominal nominal("ekinematic");
    const auto elm = make_estimator("elm", nominal, {{"solver", solver}, {"window", 500}});
    learn(*elm, nominal, mobil);
    for (const double r2 : validate(nominal, *elm, ethz).r2) EXPECT_GT(r2, 0.95) << "solver " << solver;
  }
}

TEST_F(ElmLogs, MuAndResistanceOnTheAuthorsRun) {
  Nominal nominal("ekinematic");
  Drive log = read_log("run_apacrace_ethz_varspeeds.csv");
  log.factor = read_columns(reference("friction_schedules.csv"))["apac_ethz_decay"];
  const auto elm = make_estimator("elm", nominal);
  EXPECT_LT(visited_error(*elm, nominal, log, 24.0), 0.03);
  EXPECT_LT(resistance_error(nominal, *elm), 0.05);
}

}  // namespace test_elm
}  // namespace gripline
