#include <Eigen/Dense>

#include "estimators/gp/kernel.hpp"
#include "estimators/gp/sliding_gp.hpp"
#include "estimators/gp/slip_bins.hpp"
#include "support/allocation_counter.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_gp {

using namespace rig;
using gp::InputRow;
using gp::Kernel;

double fresh(double) { return 1.0; }

struct Problem {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
};
Problem problem(int n, unsigned seed, double noise) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Problem out{Eigen::MatrixXd::NullaryExpr(n, gp::inputs, [&] { return normal(random); }), Eigen::VectorXd(n)};
  for (int i = 0; i < n; ++i)
    out.y[i] = std::sin(1.5 * out.x(i, 0)) + 0.3 * out.x(i, 1) * out.x(i, 2) + noise * normal(random);
  return out;
}

double covariance(const Kernel& kernel, const InputRow& a, const InputRow& b) {
  double distance = 0;
  for (int d = 0; d < gp::inputs; ++d) distance += std::pow((a[d] - b[d]) / kernel.length[d], 2);
  return kernel.signal * std::exp(-0.5 * distance) + kernel.constant;
}

/// The textbook's mean, from scratch.
double dense_mean(const Kernel& kernel, const Problem& data, int begin, int end, const InputRow& at) {
  const int n = end - begin;
  Eigen::MatrixXd K(n, n);
  Eigen::VectorXd k(n);
  for (int i = 0; i < n; ++i) {
    k[i] = covariance(kernel, at, data.x.row(begin + i));
    for (int j = 0; j < n; ++j) K(i, j) = covariance(kernel, data.x.row(begin + i), data.x.row(begin + j));
    K(i, i) += kernel.noise;
  }
  return k.dot(K.ldlt().solve(data.y.segment(begin, n)));
}

Kernel some_kernel() {
  Kernel kernel;
  kernel.length = {1.0, 2.0, 1.5, 3.0, 4.0, 2.5};
  kernel.signal = 2.0;
  kernel.constant = 0.4;
  kernel.noise = 0.01;
  return kernel;
}

TEST(SlidingGp, EqualsAFreshFitAfterEverySlide) {
  const int window = 30;
  const Problem data = problem(150, 1, 0.05);
  const Kernel kernel = some_kernel();
  gp::SlidingGp process(window);
  process.reset(kernel, data.x.topRows(20), data.y.head(20));
  const InputRow at = InputRow::Constant(0.3);
  for (int i = 20; i < 150; ++i) {
    process.slide(data.x.row(i), data.y[i]);
    const int begin = std::max(0, i + 1 - window);
    ASSERT_EQ(process.count(), i + 1 - begin);
    ASSERT_NEAR(process.mean(at).value, dense_mean(kernel, data, begin, i + 1, at), 1e-9) << i;
  }
  EXPECT_NEAR(process.mean_at_sample(7), process.mean(data.x.row(120 + 7)).value, 1e-9);
}

TEST(SlidingGp, GradientAgreesWithDifferences) {
  const Problem data = problem(100, 2, 0.05);
  gp::SlidingGp process(100);
  process.reset(some_kernel(), data.x, data.y);
  for (int i = 0; i < 5; ++i) {
    const InputRow at = 0.7 * data.x.row(i);
    for (int d = 0; d < gp::inputs; ++d) {
      InputRow hi = at, lo = at;
      hi[d] += 1e-6;
      lo[d] -= 1e-6;
      EXPECT_NEAR(process.mean(at).gradient[d], (process.mean(hi).value - process.mean(lo).value) / 2e-6, 1e-6);
    }
  }
}

TEST(Kernel, LikelihoodsGradientAgreesWithDifferences) {
  const Problem data = problem(40, 3, 0.1);
  gp::HyperVector gradient;
  gp::log_likelihood(some_kernel(), data.x, data.y, &gradient);
  for (int j = 0; j < gp::hyper_count; ++j) {
    double value[2];
    for (const int side : {0, 1}) {
      Kernel moved = some_kernel();
      double* const variables[] = {&moved.length[0], &moved.length[1], &moved.length[2],
                                   &moved.length[3], &moved.length[4], &moved.length[5],
                                   &moved.signal,    &moved.constant,  &moved.noise};
      *variables[j] *= std::exp(side == 0 ? -1e-5 : 1e-5);
      value[side] = gp::log_likelihood(moved, data.x, data.y, nullptr);
    }
    EXPECT_NEAR(gradient[j], (value[1] - value[0]) / 2e-5, 1e-4 * std::max(1.0, std::abs(gradient[j]))) << j;
  }
}

TEST(Kernel, FitFindsTheRelevantInputsAndTheNoise) {
  const Problem data = problem(120, 4, 0.1);
  const Kernel kernel = gp::fit_kernel({}, data.x, data.y, 100);
  for (const int irrelevant : {3, 4, 5}) EXPECT_GT(kernel.length[irrelevant], 3 * kernel.length[0]) << irrelevant;
  EXPECT_NEAR(std::sqrt(kernel.noise), 0.1, 0.05);
  gp::HyperVector gradient;
  EXPECT_GT(gp::log_likelihood(kernel, data.x, data.y, &gradient),
            gp::log_likelihood(Kernel{}, data.x, data.y, nullptr));
  EXPECT_LT(gradient.head(3).norm(), 1.0);
}

TEST(SlipBins, HoldTheLargestMeanForceAtThePresentFriction) {
  gp::SlipBins axle;
  EXPECT_EQ(axle.peak(), 0.0);
  for (int i = 0; i < 40; ++i)
    for (const double side : {-1.0, 1.0}) {
      axle.add(side * 0.12, side * 0.8);
      axle.add(side * 0.22, side * 1.0);
    }
  EXPECT_NEAR(axle.peak(), 1.0, 1e-9);
  EXPECT_NEAR(axle.deviation(), 0.0, 1e-9);
  for (int i = 0; i < 200; ++i) axle.add(0.12, 0.4);
  EXPECT_NEAR(axle.peak(), 0.5, 0.08) << "of the larger slip too, which nobody visited since";
}

/// Where slip is small and noisy, and when it has just changed sign, forces oppose it.
TEST(SlipBins, SamplesThatOpposeTheSlipTellNothing) {
  gp::SlipBins axle;
  for (int i = 0; i < 10; ++i) axle.add(0.06, -0.3);
  EXPECT_EQ(axle.peak(), 0.0);
  for (int i = 0; i < 100; ++i) {
    axle.add(0.06, i % 10 == 0 ? -0.3 : 0.3);
    axle.add(-0.22, i % 10 == 0 ? 1.0 : -1.0);
  }
  EXPECT_NEAR(axle.peak(), 1.0, 1e-9);
  EXPECT_NEAR(axle.deviation(), 0.0, 1e-9);
}

/// Such as of an axle whose learned force is none.
TEST(SlipBins, StayFiniteWhereThereIsNoForce) {
  gp::SlipBins axle;
  for (int i = 0; i < 10; ++i) axle.add(0.12, 0.0);
  for (int i = 0; i < 10; ++i) axle.add(0.12, 1.0);
  EXPECT_NEAR(axle.peak(), 1.0, 1e-9);
  EXPECT_NEAR(axle.deviation(), 0.0, 1e-9);
}

TEST(Gp, ExplainsTheResidualItLearnedFrom) {
  Nominal nominal("ekinematic");
  const auto process = make_estimator("gp_own_mu", nominal);
  const Drive drive = drive_bends(20, 3, fresh);
  learn(*process, nominal, drive);
  Drive last;
  last.x.assign(drive.x.end() - 300, drive.x.end());
  last.u.assign(drive.u.end() - 299, drive.u.end());
  for (const double r2 : validate(nominal, *process, last).r2) EXPECT_GT(r2, 0.98);
}

/// A car that drives straight ahead shows what drive its nominal model lacks, also where it then steers by a hair.
TEST(Gp, AnInputThatStoodStillMayMoveALittle) {
  const TrueCar truth;
  Nominal nominal("ekinematic", {{"Cm1", 0.2}});
  const auto process = make_estimator("gp_own_mu", nominal, {{"window", 100}, {"tune_at", 50}});
  Drive drive;
  State x;
  x.vx = 2.0;
  drive.x.push_back(x);
  for (int i = 0; i < 60; ++i) {
    drive.u.push_back({0.35 + 0.3 * std::sin(0.4 * i), 0.0});
    drive.x.push_back(truth.step(drive.x.back(), drive.u.back()));
  }
  learn(*process, nominal, drive);
  CorrectedModel model = corrected(nominal, *process);
  State aside;
  aside.vx = 2.05;
  aside.delta = 1e-4;
  for (const double d : {0.1, 0.35, 0.6})
    EXPECT_NEAR(model.rates(aside, {d, 0.0}, {}).vx, truth.rates(aside, d).vx, 0.15) << d;
}

TEST(Gp, OwnMuComesFromTheForcesItLearned) {
  Nominal nominal("ekinematic");
  const auto process = make_estimator("gp_own_mu", nominal);
  EXPECT_EQ(process->belief().mu_front, 1.0);
  const Drive drive = drive_bends(20, 3, fresh);
  learn(*process, nominal, drive);
  const TrueCar truth;
  Visited visited;
  for (const State& x : drive.x) visited.see(truth, x);
  EXPECT_NEAR(total_mu(process->belief(), truth.car), visited.mu(truth), 0.03);
}

TEST(Gp, WindowSlidesAcrossADrop) {
  Nominal nominal("ekinematic");
  const auto process = make_estimator("gp_own_mu", nominal);
  const Drive drive = drive_bends(20, 3, [](double t) { return t < 8 ? 1.0 : 0.658; });
  learn(*process, nominal, drive);
  TrueCar truth;
  truth.factor = 0.658;
  EXPECT_LT(total_mu(process->belief(), truth.car), truth.mu() + 0.02);
  EXPECT_GT(total_mu(process->belief(), truth.car), truth.mu() - 0.12);
}

TEST(Gp, JacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  const auto process = make_estimator("gp_own_mu", nominal);
  const Drive drive = drive_bends(10, 3, fresh);
  learn(*process, nominal, drive);
  CorrectedModel model = corrected(nominal, *process);
  for (std::size_t i = 50; i < drive.steps(); i += 67)
    // Large weights of both signs: differences of 1e-6 would drown in rounding.
    EXPECT_LT(jacobian_error(model, drive.x[i], drive.u[i], 1e-5), 1e-6) << i;
}

TEST(Gp, StepsBetweenFitsAllocateNothing) {
  if (!counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  Nominal nominal("ekinematic");
  const auto process = make_estimator("gp_own_mu", nominal, {{"window", 100}, {"tune_at", 50}});
  const Drive drive = drive_bends(8, 3, fresh);
  long counted = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const Sample k =
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
    const long before = allocations;
    process->update(k);
    if (i > 150) counted += allocations - before;  // the last fit is when the window fills
  }
  EXPECT_EQ(counted, 0);
}

TEST(Gp, DeclaresThatItNeedsTruthAndRefusesToDoWithout) {
  EXPECT_TRUE(registry().find(gripline::abi::Kind::estimator, "gp").needs_truth());
  EXPECT_FALSE(registry().find(gripline::abi::Kind::estimator, "gp_own_mu").needs_truth());
  Nominal nominal("ekinematic");
  EXPECT_THROW(make_estimator("gp", nominal), PluginError);
}

}  // namespace test_gp
}  // namespace gripline
