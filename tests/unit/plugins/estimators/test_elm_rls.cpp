#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/allocation_counter.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_elm_rls {

using namespace rig;

double fresh(double) { return 1.0; }
double fading(double t) { return t > 14.4 ? std::pow(1.0 - 1.0 / 2200, (t - 14.4) / dt) : 1.0; }
double dropping(double t) { return t < 14.3 ? 1.0 : 0.658; }

/// Teaches a drive as noisy sensors read it, and calls `each(step)` after every update.
template <class Each>
void learn_noisily(Estimator& estimator, Nominal& nominal, const Drive& drive, std::uint64_t seed, const Each& each) {
  Noise noise(seed);
  State sensed = drive.x[0];
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const State next = noise.read(drive.x[i + 1]);
    estimator.update(make_sample(nominal.prediction(), static_cast<std::int64_t>(i), sensed, drive.u[i], next));
    sensed = next;
    each(i);
  }
}

/// Belief against the truth along a drive.
struct Tracking {
  double rms = 0;                    // of mu against mu_true from `from` on
  double covered = 0;                // share of steps in which both axles lie within two standard deviations
  double after_drop = std::nan("");  // error of mu one second after the drop at 14.3 s; NaN: no step was there
  double sigma_front_at_end = 0;
};
Tracking track(Estimator& estimator, Nominal& nominal, const Drive& drive, double from, bool noisy = false) {
  TrueCar truth;
  Noise noise(11);
  Tracking out;
  State sensed = drive.x[0];
  int n = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const State next = noisy ? noise.read(drive.x[i + 1]) : drive.x[i + 1];
    estimator.update(make_sample(nominal.prediction(), static_cast<std::int64_t>(i), sensed, drive.u[i], next));
    sensed = next;
    truth.factor = drive.factor[i];
    const Belief belief = estimator.belief();
    const double t = static_cast<double>(i) * dt, error = total_mu(belief, truth.car) - truth.mu();
    if (std::abs(t - 15.3) < dt / 2) out.after_drop = std::abs(error);
    if (t < from) continue;
    out.rms += error * error;
    const double L = truth.car.lf + truth.car.lr, weight = truth.car.m * gravity;
    const double front = truth.factor * truth.Df * L / (weight * truth.car.lr);
    const double rear = truth.factor * truth.Dr * L / (weight * truth.car.lf);
    if (std::abs(belief.mu_front - front) < 2 * belief.sigma_front &&
        std::abs(belief.mu_rear - rear) < 2 * belief.sigma_rear)
      out.covered += 1;
    ++n;
  }
  out.rms = std::sqrt(out.rms / n);
  out.covered /= n;
  out.sigma_front_at_end = estimator.belief().sigma_front;
  return out;
}

TEST(ElmRls, ExpectsAnotherFrictionThanIsPlannedFor) {
  Nominal nominal("ekinematic");
  const Belief belief = make_estimator("elm_rls", nominal, {{"friction", 1.3}})->belief();
  EXPECT_NEAR(belief.mu_front, 1.3, 1e-9);
  EXPECT_NEAR(belief.mu_rear, 1.3, 1e-9);
}

TEST(ElmRls, StartsFromWhatItWasTold) {
  Nominal nominal("ekinematic");
  const Belief belief = make_estimator("elm_rls", nominal)->belief();
  EXPECT_NEAR(belief.mu_front, 1.0, 1e-9);
  EXPECT_NEAR(belief.mu_rear, 1.0, 1e-9);
  EXPECT_GT(belief.sigma_front, 0.2);
  EXPECT_LT(belief.sigma_front, 0.4);
}

TEST(ElmRls, FindsTheTruePeakNobodyVisited) {
  Nominal nominal("ekinematic");
  for (const unsigned seed : {3u, 4u, 5u}) {
    const auto rls = make_estimator("elm_rls", nominal);
    const Tracking tracking = track(*rls, nominal, drive_bends(20, seed, fresh), 8.0);
    EXPECT_LT(tracking.rms, 0.03) << seed;
    EXPECT_GT(tracking.covered, 0.9) << seed;
    EXPECT_LT(tracking.sigma_front_at_end, 0.06) << seed;
    EXPECT_LT(resistance_error(nominal, *rls), 0.02);
  }
}

TEST(ElmRls, DoesNotDependOnTheSeed) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(16, 3, fresh);
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const auto rls = make_estimator("elm_rls", nominal, {}, seed);
    EXPECT_LT(track(*rls, nominal, drive, 8.0).rms, 0.03) << seed;
  }
}

TEST(ElmRls, FollowsFadingFriction) {
  Nominal nominal("ekinematic");
  EXPECT_LT(track(*make_estimator("elm_rls", nominal), nominal, drive_bends(36, 3, fading), 8.0).rms, 0.03);
}

TEST(ElmRls, KnowsOneSecondAfterADrop) {
  Nominal nominal("ekinematic");
  for (const unsigned seed : {3u, 4u, 5u, 6u}) {
    const Drive drive = drive_bends(20, seed, dropping);
    EXPECT_LT(track(*make_estimator("elm_rls", nominal), nominal, drive, 16.0).after_drop, 0.05) << seed;
    EXPECT_LT(track(*make_estimator("elm_rls", nominal), nominal, drive, 16.0, true).after_drop, 0.08) << seed;
  }
}

/// Until the drop is noticed the readings' noise is made to account for it, more in every step. Were that kept, the
/// first sample afterwards would say that hardly any grip is left.
TEST(ElmRls, ADropUnderNoiseIsNotTakenForTheLossOfAllGrip) {
  Nominal nominal("ekinematic");
  const TrueCar truth;
  const double after_drop = 0.658 * truth.mu();
  for (const unsigned seed : {3u, 4u, 5u, 6u}) {
    const Drive drive = drive_bends(16, seed, dropping);
    for (const std::uint64_t draw : {1, 2, 3, 4, 5}) {
      const auto rls = make_estimator("elm_rls", nominal);
      double least = 1.0;
      learn_noisily(*rls, nominal, drive, draw, [&](std::size_t i) {
        if (static_cast<double>(i) * dt > 14.3) least = std::min(least, total_mu(rls->belief(), truth.car));
      });
      EXPECT_GT(least, 0.6 * after_drop) << seed << ' ' << draw;
    }
  }
}

TEST(ElmRls, WorksUnderSensorNoise) {
  Nominal nominal("ekinematic");
  for (const unsigned seed : {3u, 4u, 5u}) {
    const auto rls = make_estimator("elm_rls", nominal);
    const Tracking tracking = track(*rls, nominal, drive_bends(30, seed, fresh), 10.0, true);
    EXPECT_LT(tracking.rms, 0.03) << seed;
    EXPECT_GT(tracking.covered, 0.8) << seed;
  }
}

TEST(ElmRls, SamplesOfASlowCarTeachNothingWhereTold) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(6, 3, fresh);
  const double slowest = 1.6;  // [m/s]
  const auto rls = make_estimator("elm_rls", nominal, {{"slowest", slowest}});
  double force = 0;
  int slow = 0, fast = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const bool is_slow = std::min(drive.x[i].vx, drive.x[i + 1].vx) < slowest;
    const double before = force, slip = 0.1;
    rls->update(
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]));
    rls->tyre_force(Axle::front, {&slip, 1}, {&force, 1}, {});
    if (i == 0) continue;
    (is_slow ? slow : fast) += 1;
    EXPECT_EQ(is_slow, force == before) << i;
  }
  EXPECT_GT(slow, 30);
  EXPECT_GT(fast, 30);
}

TEST(ElmRls, WhatIsCommonToBothAxlesKeepsThemTogether) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(4, 3, fresh);
  const auto largest_difference = [&](double common) {
    const auto rls = make_estimator("elm_rls", nominal, {{"common", common}});
    double largest = 0;
    learn_noisily(*rls, nominal, drive, 11, [&](std::size_t) {
      largest = std::max(largest, std::abs(rls->belief().mu_front - rls->belief().mu_rear));
    });
    return largest;
  };
  EXPECT_LT(largest_difference(0.95), 0.5 * largest_difference(0.0));
}

/// What is believed of the true car after eight seconds of a slalom, half of it driven, in steps of 20 ms over `parts`
/// under the same commands.
Belief learned_in_short_steps(int parts, const Settings& settings) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, settings);
  const TrueCar truth;
  const auto moved = [](State x, const State& rates, double by) {
    x.vx += by * rates.vx;
    x.vy += by * rates.vy;
    x.omega += by * rates.omega;
    return x;
  };
  State x;
  x.vx = 2.0;
  for (int i = 0; i < 400 * parts; ++i) {
    const int held = i / parts;
    Sample k;
    k.dt = dt / parts;
    k.x = x;
    k.u.d = held % 50 < 25 ? 0.25 : 0.0;
    x.delta = 0.25 * std::sin(8.0 * held * dt);
    constexpr double h = dt / 20;
    for (int j = 0; j < 20 / parts; ++j) x = moved(x, truth.rates(moved(x, truth.rates(x, k.u.d), 0.5 * h), k.u.d), h);
    k.x_next = x;
    rls->update(k);
  }
  return rls->belief();
}

// Where readings have next to no noise, what the equations leave out limits how well friction is known.
TEST(ElmRls, IsNoSurerAtShorterSteps) {
  const Settings exact = {{"sigma_v", 1e-3}, {"sigma_omega", 0.01}, {"misfit", 0.2}};
  Settings sharing = {{"sharing_spread", 1}, {"sharing_lasts", 9}, {"ellipse", 0.4}, {"drive_front", 0.5}};
  sharing.insert(exact.begin(), exact.end());
  for (const Settings& settings : {exact, sharing}) {
    const Belief usual = learned_in_short_steps(1, settings);
    for (const int parts : {2, 4}) {
      const Belief often = learned_in_short_steps(parts, settings);
      EXPECT_NEAR(often.sigma_front, usual.sigma_front, 0.04 * usual.sigma_front) << parts;
      EXPECT_NEAR(often.sigma_rear, usual.sigma_rear, 0.04 * usual.sigma_rear) << parts;
    }
  }
}

TEST(ElmRls, CurveIsOddAndItsDeviationGrowsBeyondWhatWasSeen) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal);
  learn(*rls, nominal, drive_bends(16, 3, fresh));
  const TrueCar truth;
  const std::vector<double> slips = {-1.2, -0.2, 0.2, 1.2};
  std::vector<double> force(4), sigma(4);
  for (const Axle axle : {Axle::front, Axle::rear}) {
    ASSERT_TRUE(rls->tyre_force(axle, slips, force, sigma));
    EXPECT_NEAR(force[0], -force[3], 1e-12);
    EXPECT_NEAR(force[1], -force[2], 1e-12);
    EXPECT_NEAR(force[2], truth.force(axle, 0.2), 1e-3);
    EXPECT_GT(sigma[3], 3 * sigma[2]);
  }
}

TEST(ElmRls, SuddenlyWetMakesItLessSure) {
  Nominal nominal("ekinematic");
  const auto with = make_estimator("elm_rls", nominal), without = make_estimator("elm_rls", nominal, {{"change", 0}});
  // One more sample after the drop is all it gets.
  const Drive drive = drive_bends(14.3 + 3 * dt, 3, dropping);
  learn(*with, nominal, drive);
  learn(*without, nominal, drive);
  EXPECT_LT(with->belief().mu_front, without->belief().mu_front - 0.02);
}

TEST(ElmRls, JacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"arm_spread", 0.01}, {"drive_spread", 0.1}});
  const Drive drive = drive_bends(8, 3, fresh);
  learn(*rls, nominal, drive);
  CorrectedModel model = corrected(nominal, *rls);
  for (std::size_t i = 50; i < drive.steps(); i += 37) {
    if (drive.x[i].vx < 0.35) continue;  // below, the guard's kink is where a difference must not straddle
    // Small differences: the table's second derivative jumps at its knots.
    EXPECT_LT(jacobian_error(model, drive.x[i], drive.u[i], 3e-7), 1e-6) << i;
  }
}

TEST(ElmRls, SurvivesSamplesThatNoTyreExplains) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal);
  Drive drive = drive_bends(16, 3, fresh);
  for (std::size_t i = 100; i < 200; ++i) {  // a car that is thrown about
    drive.x[i].omega += i % 7 < 3 ? 40.0 : -40.0;
    drive.x[i].vy += i % 11 < 5 ? 2.0 : -2.0;
  }
  learn(*rls, nominal, drive);
  EXPECT_NEAR(total_mu(rls->belief(), small_car()), TrueCar().mu(), 0.08);
}

/// No innovation is evidence of a sudden change in the first second: until then it makes no difference at which score
/// friction is taken to have changed.
TEST(ElmRls, SettlesInASecondAtAnyStep) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(4, 3, [](double t) { return t < 0.5 ? 1.0 : 0.5; });
  for (const std::size_t every : {1u, 2u}) {
    const auto eager = make_estimator("elm_rls", nominal, {{"alarm", 1}});
    const auto deaf = make_estimator("elm_rls", nominal, {{"alarm", 100}});
    std::size_t same = 0;  // updates after which both believe the same
    for (; (same + 1) * every <= drive.steps(); ++same) {
      const std::size_t begin = same * every, end = begin + every;
      Sample k = make_sample(nominal.prediction(), static_cast<std::int64_t>(same), drive.x[begin], drive.u[begin],
                             drive.x[end]);
      k.dt = static_cast<double>(every) * dt;
      eager->update(k);
      deaf->update(k);
      if (eager->belief().mu_front != deaf->belief().mu_front) break;
    }
    EXPECT_GE(same, 50 / every);
    EXPECT_LT(same, 150 / every) << "an alarm in the next two seconds";
  }
}

// Were what it learned discarded for being so much more, it would begin again for ever.
TEST(ElmRls, LearnsAFrictionFarAboveTheOneItExpects) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"friction", 0.2}, {"friction_spread", 1.0}});
  learn(*rls, nominal, drive_bends(20, 3, fresh));
  EXPECT_NEAR(total_mu(rls->belief(), small_car()), TrueCar().mu(), 0.1);
}

// A state that is no number, as of a sensor that fails, is forgotten with all that came of it.
TEST(ElmRls, LearnsAgainAfterASampleThatIsNoNumber) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"sharing_spread", 1.0}});
  const Drive drive = drive_bends(16, 3, fresh);
  learn(*rls, nominal, drive);
  Drive broken = drive_bends(1, 3, fresh);
  broken.x[20].vy = broken.x[20].omega = std::numeric_limits<double>::quiet_NaN();
  learn(*rls, nominal, broken);
  learn(*rls, nominal, drive);
  EXPECT_NEAR(total_mu(rls->belief(), small_car()), TrueCar().mu(), 0.05);
}

TEST(ElmRls, SameSamplesSameBytes) {
  Nominal nominal("ekinematic");
  const Drive drive = drive_bends(6, 3, fresh);
  const auto one = make_estimator("elm_rls", nominal), two = make_estimator("elm_rls", nominal);
  learn(*one, nominal, drive);
  learn(*two, nominal, drive);
  EXPECT_EQ(one->belief().mu_front, two->belief().mu_front);
  EXPECT_EQ(one->belief().sigma_rear, two->belief().sigma_rear);
}

TEST(ElmRls, StepAllocatesNothing) {
  if (!counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"arm_spread", 0.01}, {"drive_spread", 0.1}});
  const Drive drive = drive_bends(4, 3, dropping);
  long counted = 0;
  for (std::size_t i = 0; i < drive.steps(); ++i) {
    const Sample k =
        make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
    const long before = allocations;
    rls->update(k);
    if (i > 10) counted += allocations - before;
  }
  EXPECT_EQ(counted, 0);
}

/// After a contact that its equations do not cover, what was learned is discarded.
TEST(ElmRls, StartingOverAllocatesNothing) {
  if (!counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal);
  const double at_first = rls->belief().mu_front;
  const Drive drive = drive_bends(4, 3, dropping);
  const auto sample = [&](std::size_t i) {
    return make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
  };
  for (std::size_t i = 0; i < drive.steps(); ++i) rls->update(sample(i));
  ASSERT_NE(rls->belief().mu_front, at_first);
  Sample hit = sample(drive.steps() - 1);
  hit.x_next.vy += 40.0;
  hit.x_next.omega -= 400.0;
  const long before = allocations;
  for (int i = 0; i < 50 && rls->belief().mu_front != at_first; ++i) rls->update(hit);
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(rls->belief().mu_front, at_first);
}

class ElmRlsLogs : public testing_support::WithReference {};

TEST_F(ElmRlsLogs, MuOnTheAuthorsRun) {
  Nominal nominal("ekinematic");
  Drive log = read_log("run_apacrace_ethz_varspeeds.csv");
  log.factor = read_columns(reference("friction_schedules.csv"))["apac_ethz_decay"];
  const auto rls = make_estimator("elm_rls", nominal);
  EXPECT_LT(track(*rls, nominal, log, 8.0).rms, 0.03);
  EXPECT_LT(resistance_error(nominal, *rls), 0.02);
}

TEST_F(ElmRlsLogs, OfflineTrainingExplainsAnotherTrack) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal);
  learn(*rls, nominal, read_log("run_bayesrace_pp_ethzMobil.csv"));
  for (const double r2 : validate(nominal, *rls, read_log("run_bayesrace_nmpc_true_ethz.csv", 8.08)).r2)
    EXPECT_GT(r2, 0.95);
}

}  // namespace test_elm_rls
}  // namespace gripline
