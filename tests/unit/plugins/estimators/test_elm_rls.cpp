#include <Eigen/Dense>

#include "common/learning/difference_rls.hpp"
#include "common/learning/friction_ellipse.hpp"
#include "common/learning/generic_tyres.hpp"
#include "support/allocation_counter.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_elm_rls {

using namespace learning;
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
  double rms = 0;         // of mu against mu_true from `from` on
  double covered = 0;     // share of steps in which both axles lie within two standard deviations
  double after_drop = 0;  // error of mu one second after the drop at 14.3 s
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

TEST(DifferenceRls, EqualsGeneralisedLeastSquaresWithTheNoisesTrueCovariance) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const int p = 3, steps = 25;
  const double sigma = 0.3, misfit = 0.05, h = 0.1;
  const Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(steps, p, [&] { return normal(random); });
  const Eigen::VectorXd y = Eigen::VectorXd::NullaryExpr(steps, [&] { return normal(random); });

  DifferenceRls rls(p, 1);
  rls.covariance().setIdentity();
  rls.break_sequence(&sigma);
  for (int k = 0; k < steps; ++k) {
    rls.begin_step(&sigma);
    rls.update(rls.innovation(0, rows.row(k).transpose(), y[k], h, misfit));
  }

  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(steps, steps);  // of differences of white noise: tridiagonal
  for (int k = 0; k < steps; ++k) {
    noise(k, k) = 2 * sigma * sigma / (h * h) + misfit * misfit;
    if (k > 0) noise(k, k - 1) = noise(k - 1, k) = -sigma * sigma / (h * h);
  }
  const Eigen::MatrixXd weighted = noise.llt().solve(rows);
  const Eigen::MatrixXd covariance = (rows.transpose() * weighted + Eigen::MatrixXd::Identity(p, p)).inverse();
  const Eigen::VectorXd estimate = covariance * (weighted.transpose() * y);
  EXPECT_LT((rls.theta() - estimate).norm(), 1e-10);
  EXPECT_LT((rls.covariance() - covariance).norm(), 1e-10);
}

TEST(GenericTyres, PriorIsTheMixtureItClaims) {
  SplitMix64 random(1);
  const TyrePrior prior;
  const GenericTyres tyres(40, prior, random);
  std::vector<double> h(40, 0.0), slope(40, 0.0), lo(40, 0.0), hi(40, 0.0);
  tyres.add(0.3, 1.0, h);
  tyres.add_slope(0.3, 1.0, slope);
  tyres.add(0.3 - 1e-6, 1.0, lo);
  tyres.add(0.3 + 1e-6, 1.0, hi);
  const Eigen::MatrixXd covariance = tyres.prior_covariance();
  double mean = 0, square = 0, implied = 0;
  for (int a = 0; a < 40; ++a) {
    EXPECT_NEAR(slope[a], (hi[a] - lo[a]) / 2e-6, 1e-6);
    EXPECT_GT(h[a], 0.0);
    EXPECT_LE(h[a], 1.0);
    mean += prior.friction * h[a] / 40;
    square += prior.friction * prior.friction * (1 + 0.09) * h[a] * h[a] / 40;
    for (int b = 0; b < 40; ++b) implied += h[a] * covariance(a, b) * h[b];
  }
  EXPECT_NEAR(implied, square - mean * mean, 1e-12);
}

TEST(FrictionEllipse, TakesFromTheSideWhatDriveAndBrakesUse) {
  const FrictionEllipse none;
  EXPECT_EQ(none.side_share(Axle::front, 5000.0, 1.0, 6000.0), 1.0);
  const FrictionEllipse ellipse{1.1, 0.4, 0.6};
  // Drive: 0.4 in front, 0.6 behind; brakes the other way round. The load stretches the ellipse.
  EXPECT_NEAR(ellipse.side_share(Axle::front, 5000.0, 1.0, 6000.0), std::sqrt(1 - square(2000 / 6600.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, 5000.0, 1.0, 6000.0), std::sqrt(1 - square(3000 / 6600.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::front, -5000.0, 1.2, 6000.0), std::sqrt(1 - square(3000 / 7920.0)), 1e-12);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, -5000.0, 0.8, 6000.0), std::sqrt(1 - square(2000 / 5280.0)), 1e-12);
  EXPECT_DOUBLE_EQ(ellipse.side_share(Axle::rear, 1e6, 1.0, 6000.0), 0.2);
  Dual8 force(5000.0);
  force.d[0] = 1.0;
  const double h = 1e-3;
  const double slope = (ellipse.side_share(Axle::rear, 5000.0 + h, 1.0, 6000.0) -
                        ellipse.side_share(Axle::rear, 5000.0 - h, 1.0, 6000.0)) /
                       (2 * h);
  EXPECT_NEAR(ellipse.side_share(Axle::rear, force, Dual8(1.0), 6000.0).d[0], slope, 1e-9);
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

TEST(ElmRls, SamplesUnderDriveTeachNothingOfTheTyresWhereTold) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"most_drive", 0.0}});
  Drive drive = drive_bends(6, 3, fresh);
  learn(*rls, nominal, drive);
  EXPECT_NEAR(rls->belief().mu_front, 1.0, 1e-9);
  EXPECT_NEAR(rls->belief().mu_rear, 1.0, 1e-9);
  EXPECT_GT(rls->belief().sigma_front, 0.2);
}

/// The true car's way through a slalom, begun at `speed`, with the wheels turned by up to `angle`; `pedal` and `factor`
/// of step i.
template <class Pedal, class Factor>
Drive slalom(int steps, double speed, double angle, const Pedal& pedal, const Factor& factor, TrueCar car = {}) {
  Drive drive;
  State x;
  x.vx = speed;
  drive.x.push_back(x);
  for (int i = 0; i < steps; ++i) {
    car.factor = factor(i);
    drive.u.push_back({pedal(i), (angle * std::sin(8.0 * i * dt) - x.delta) / dt});
    x = car.step(x, drive.u.back());
    drive.x.push_back(x);
    drive.factor.push_back(car.factor);
  }
  return drive;
}

/// What 1.2 s of a slalom teach at one position of the pedal, where any drive is too much (`most_drive`), if friction
/// is 0.91 in place of the expected 1.0. This car's brakes are weak: even an ellipse of 0.3 takes two per cent off the
/// side forces that the true car has.
Belief learned_at_pedal(double d, double sharing_spread, double angle = 0.3) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"most_drive", 0.0},
                                   {"sharing_spread", sharing_spread},
                                   {"ellipse", 0.3},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  learn(*rls, nominal,
        slalom(
            60, 3.5, angle, [d](int) { return d; }, [](int) { return 1.0; }));
  return rls->belief();
}

TEST(ElmRls, BrakingTeachesAsFarAsTheSharingOfFrictionIsKnown) {
  const TrueCar truth;
  const Belief untold = learned_at_pedal(-0.1, 0.0), told = learned_at_pedal(-0.1, 1.0);
  const Belief unsure = learned_at_pedal(-0.1, 50.0), driven = learned_at_pedal(0.5, 1.0);
  EXPECT_NEAR(total_mu(untold, truth.car), 1.0, 1e-9);
  EXPECT_NEAR(total_mu(driven, truth.car), 1.0, 1e-9);
  EXPECT_NEAR(total_mu(told, truth.car), truth.mu(), 0.05);
  EXPECT_LT(told.sigma_front, 0.5 * untold.sigma_front);
  EXPECT_GT(unsure.sigma_front, 1.2 * told.sigma_front);
}

// Of a car that brakes hard and hardly turns, what brakes leave of small side forces would pass for the tyres'
// friction.
TEST(ElmRls, BrakingStraightAheadTeachesNothingOfTheTyres) {
  const Belief straight = learned_at_pedal(-0.1, 1.0, 0.02);
  EXPECT_NEAR(straight.mu_front, 1.0, 1e-9);
  EXPECT_NEAR(straight.mu_rear, 1.0, 1e-9);
}

/// What is believed after a slalom under little drive, which teaches, and some steps of another under much, which does
/// not: there friction is `factor` of what it was.
Belief belief_after_drive(double factor, int driven, double sharing_lasts) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"most_drive", 0.15},
                                   {"sigma_v", 0.002},
                                   {"sigma_omega", 0.005},
                                   {"sharing_spread", 1.0},
                                   {"sharing_lasts", sharing_lasts},
                                   {"ellipse", 1.0},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  constexpr int taught = 80;  // steps
  learn(*rls, nominal,
        slalom(
            taught + driven, 2.5, 0.2, [](int i) { return i < taught ? 0.3 : 0.6; },
            [factor](int i) { return i < taught ? 1.0 : factor; }));
  return rls->belief();
}
double believed_after_drive(double factor, int driven = 30, double sharing_lasts = 1) {
  return total_mu(belief_after_drive(factor, driven, sharing_lasts), TrueCar().car);
}

TEST(ElmRls, ADropUnderDriveIsNoticed) {
  const double before = believed_after_drive(1.0, 0), kept = believed_after_drive(1.0),
               fell = believed_after_drive(0.7);
  EXPECT_NEAR(kept, before, 0.01 * before);
  EXPECT_LT(fell, 0.85 * before);
  EXPECT_GT(fell, 0.6 * before);
}

// What the tyres' share is then is known no better than before, and a drift goes on.
TEST(ElmRls, DriveTeachesOfTyresForHalfASecondAfterADrop) {
  const auto sigma = [](int driven) { return belief_after_drive(0.7, driven, 1).sigma_front; };
  EXPECT_LT(sigma(29), 0.9 * sigma(17));  // it is noticed after 16 steps
  EXPECT_GT(sigma(76), sigma(44));
}

TEST(ElmRls, ADropUnderDriveIsNoticedWhereTheSharingErrsForLong) {
  const double before = believed_after_drive(1.0, 0, 9), fell = believed_after_drive(0.7, 30, 9);
  EXPECT_LT(fell, 0.85 * before);
  EXPECT_GT(fell, 0.6 * before);
}

/// Mean relative error of the learned side forces at a visited slip, of a car whose tyres lose nothing to drive, behind
/// an ellipse that says they do, after a slalom half of which is driven.
double force_error(double sharing_lasts) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"sharing_spread", 1.0},
                                   {"sharing_lasts", sharing_lasts},
                                   {"ellipse", 0.4},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  learn(*rls, nominal,
        slalom(
            400, 2.0, 0.25, [](int i) { return i % 50 < 25 ? 0.25 : 0.0; }, [](int) { return 1.0; }));
  const TrueCar truth;
  double sum = 0;
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const double slip = 0.15;
    double force = 0, sigma = 0;
    EXPECT_TRUE(rls->tyre_force(axle, {&slip, 1}, {&force, 1}, {&sigma, 1}));
    sum += force / truth.force(axle, slip) - 1.0;
  }
  return 0.5 * sum;
}

TEST(ElmRls, AWrongSharingThatLastsTeachesLittleOfTheTyres) {
  const double averaged = force_error(1.0), lasting = force_error(25.0);
  EXPECT_GT(averaged, 0.025);
  EXPECT_LT(std::abs(lasting), 0.75 * averaged);
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

/// Largest error of vx' straight ahead, with full throttle to full brake, of the 1:43 car behind a nominal model that
/// is told `share` of its motor and brakes.
double straight_error(double spread, double share) {
  const TrueCar truth;
  Nominal told("ekinematic", {{"Cm1", share * truth.Cm1}, {"Cm2", share * truth.Cm2}});
  const auto rls = make_estimator("elm_rls", told, {{"drive_spread", spread}, {"brake_spread", spread}});
  learn(*rls, told, drive_bends(20, 3, fresh));
  CorrectedModel model = corrected(told, *rls);
  double largest = 0;
  for (const double vx : {1.0, 2.0})
    for (const double d : {-0.1, 0.3, 1.0}) {
      State straight;
      straight.vx = vx;
      largest = std::max(largest, std::abs(model.rates(straight, {d, 0.0}, {}).vx - truth.rates(straight, d).vx));
    }
  return largest;
}

TEST(ElmRls, LearnsByHowMuchDriveAndBrakesDifferFromWhatItWasTold) {
  for (const double share : {0.85, 1.15}) {
    const double unlearned = straight_error(0.0, share), learned = straight_error(0.1, share);
    EXPECT_GT(unlearned, 0.3);
    EXPECT_LT(learned, 0.25 * unlearned) << share << ": " << learned << " of " << unlearned;
  }
  EXPECT_LT(straight_error(0.1, 1.0), 0.05);
}

/// What is learned of a car that drive turns at 8 mm: relative errors of the side forces at a visited slip, and the
/// error of omega' in a driven turn [rad/s2].
struct ArmErrors {
  double front = 0, rear = 0, turning = 0;
};
ArmErrors arm_errors(double spread) {
  TrueCar truth;
  truth.arm = 8e-3;
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"arm_spread", spread}});
  learn(*rls, nominal,
        slalom(
            300, 2.0, 0.25, [](int i) { return i % 50 < 35 ? 0.5 : 0.0; }, [](int) { return 1.0; }, truth));
  const auto force_error = [&](Axle axle) {
    const double slip = 0.15;
    double force = 0, sigma = 0;
    EXPECT_TRUE(rls->tyre_force(axle, {&slip, 1}, {&force, 1}, {&sigma, 1}));
    return force / truth.force(axle, slip) - 1.0;
  };
  State turn;
  turn.vx = 2.0;
  turn.omega = 3.0;
  turn.delta = 0.15;
  CorrectedModel model = corrected(nominal, *rls);
  return {force_error(Axle::front), force_error(Axle::rear),
          model.rates(turn, {0.5, 0.0}, {}).omega - truth.rates(turn, 0.5).omega};
}

TEST(ElmRls, LearnsTheArmAtWhichDriveTurnsTheCar) {
  const ArmErrors unlearned = arm_errors(0.0), learned = arm_errors(0.01);
  EXPECT_LT(unlearned.turning, -2.0);
  EXPECT_LT(std::abs(learned.turning), 0.1 * std::abs(unlearned.turning));
  // Unlearned, what turns the car passes for grip of the front tyres, and for a lack of it at the rear.
  EXPECT_GT(unlearned.front, 0.02);
  EXPECT_LT(unlearned.rear, -0.01);
  EXPECT_LT(std::abs(learned.front), 0.005);
  EXPECT_LT(std::abs(learned.rear), 0.005);
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

TEST(ElmRls, SettlesInASecondAtAnyStep) {
  Nominal nominal("ekinematic");
  State x;
  x.vx = 2.0;
  for (const auto& [step, samples] : {std::pair(0.02, 50), {0.04, 25}}) {
    const auto rls = make_estimator("elm_rls", nominal);
    Sample k = make_sample(nominal.prediction(), 0, x, {}, x);
    k.dt = step;
    for (int i = 0; i < samples; ++i) {
      EXPECT_FALSE(rls->belief().trusted) << step << ' ' << i;
      rls->update(k);
    }
    EXPECT_TRUE(rls->belief().trusted) << step;
  }
}

// Were what it learned discarded for being so much more, it would begin again for ever.
TEST(ElmRls, LearnsAFrictionFarAboveTheOneItExpects) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"friction", 0.2}, {"friction_spread", 1.0}});
  learn(*rls, nominal, drive_bends(20, 3, fresh));
  EXPECT_TRUE(rls->belief().trusted);
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
  const Drive drive = drive_bends(4, 3, dropping);
  const auto sample = [&](std::size_t i) {
    return make_sample(nominal.prediction(), static_cast<std::int64_t>(i), drive.x[i], drive.u[i], drive.x[i + 1]);
  };
  for (std::size_t i = 0; i < drive.steps(); ++i) rls->update(sample(i));
  ASSERT_TRUE(rls->belief().trusted);
  Sample hit = sample(drive.steps() - 1);
  hit.x_next.vy += 40.0;
  hit.x_next.omega -= 400.0;
  const long before = allocations;
  for (int i = 0; i < 50 && rls->belief().trusted; ++i) rls->update(hit);
  EXPECT_EQ(allocations, before);
  EXPECT_FALSE(rls->belief().trusted);
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
