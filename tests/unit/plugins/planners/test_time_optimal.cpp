#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "common/planning/car_limits.hpp"
#include "planners/time_optimal/lap_dynamics.hpp"
#include "planners/time_optimal/tyre_fit.hpp"
#include "support/paths.hpp"
#include "support/planner_support.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_time_optimal {

using namespace planning;
using namespace time_optimal;
using namespace testing_support;
using Changes = std::vector<std::pair<std::string, double>>;

// True tyres of the 1:43 car, forces over mass; for tests only, no planner is given them.
AxleTyres true_tyres() { return {{2.579, 1.2, 0.192 / 0.041}, {3.3852, 1.2691, 0.1737 / 0.041}}; }

TEST(CubicSpline, ReproducesParabolas) {
  std::vector<double> values;
  for (int i = 0; i <= 10; ++i) values.push_back(3 - 2 * (0.4 * i) + 0.7 * square(0.4 * i));
  const CubicSpline curve(0, 4, values);
  for (double x = 0.05; x < 4; x += 0.31) {
    EXPECT_NEAR(curve.at(x).f, 3 - 2 * x + 0.7 * x * x, 1e-12);
    EXPECT_NEAR(curve.at(x).slope, -2 + 1.4 * x, 1e-11);
    EXPECT_NEAR(curve.at(x).curvature, 1.4, 1e-10);
  }
  EXPECT_NEAR(curve.at(5).f, 3 - 8 + 0.7 * 16 + (-2 + 1.4 * 4), 1e-11);  // on along the last tangent
}

// Gradient and Hessian of every rate against central differences, at seeded states.
TEST(LapDynamics, SecondDerivativesAreThoseOfTheRates) {
  const Car car = car_1_43();
  std::vector<double> coast;
  for (int i = 0; i <= 10; ++i) coast.push_back(-1.2 - 0.01 * i * i);
  const CubicSpline curve(0, 4.2, coast);
  const LapPlace place{1.7, 0.05, -0.03, -0.2};
  std::mt19937 random(7);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  for (int trial = 0; trial < 20; ++trial) {
    const double at[lap_variables] = {uniform(-0.1, 0.1), uniform(-0.4, 0.4), uniform(0.8, 3), uniform(-0.5, 0.5),
                                      uniform(-6, 6),     uniform(-0.3, 0.3), uniform(-1, 4),  uniform(-5, 5)};
    const auto evaluate = [&](const double(&z)[lap_variables]) {
      const LapRates<double> r = lap_rates(car, true_tyres(), curve, place, z);
      return std::vector<double>{r.time,     r.state[0],   r.state[1],  r.state[2], r.state[3], r.state[4],
                                 r.state[5], r.slip_front, r.slip_rear, r.front,    r.rear};
    };
    SecondOrderDual<lap_variables> z[lap_variables];
    Dual8 zd[lap_variables];
    for (int i = 0; i < lap_variables; ++i) {
      z[i] = SecondOrderDual<lap_variables>::variable(at[i], i);
      zd[i] = Dual8::variable(at[i], i);
    }
    const auto r = lap_rates(car, true_tyres(), curve, place, z);
    const auto d = lap_rates(car, true_tyres(), curve, place, zd);
    const SecondOrderDual<lap_variables>* second[] = {&r.time,      &r.state[0], &r.state[1], &r.state[2],
                                                      &r.state[3],  &r.state[4], &r.state[5], &r.slip_front,
                                                      &r.slip_rear, &r.front,    &r.rear};
    const Dual8* dual[] = {&d.time,     &d.state[0],   &d.state[1],  &d.state[2], &d.state[3], &d.state[4],
                           &d.state[5], &d.slip_front, &d.slip_rear, &d.front,    &d.rear};
    const auto moved = [&](int i, double by, int j, double by_j) {
      double y[lap_variables];
      std::copy(std::begin(at), std::end(at), std::begin(y));
      y[i] += by;
      y[j] += by_j;
      return evaluate(y);
    };
    const double h = 1e-4;
    for (int i = 0; i < lap_variables; ++i) {
      const auto up = moved(i, h, i, 0), down = moved(i, -h, i, 0);
      for (std::size_t c = 0; c < up.size(); ++c) {
        const double scale = 1 + std::abs(second[c]->v) + std::abs(second[c]->g[i]);
        EXPECT_NEAR(second[c]->g[i], (up[c] - down[c]) / (2 * h), 1e-5 * scale);
        EXPECT_NEAR(dual[c]->d[i], second[c]->g[i], 1e-12 * scale);
        EXPECT_NEAR(dual[c]->v, second[c]->v, 1e-12 * scale);
      }
      for (int j = 0; j <= i; ++j) {
        const auto pp = moved(i, h, j, h), pm = moved(i, h, j, -h), mp = moved(i, -h, j, h), mm = moved(i, -h, j, -h);
        for (std::size_t c = 0; c < pp.size(); ++c) {
          const double numeric = (pp[c] - pm[c] - mp[c] + mm[c]) / (4 * h * h);
          const double exact = second[c]->h[SecondOrderDual<lap_variables>::entry(i, j)];
          EXPECT_NEAR(exact, numeric, 2e-4 * (1 + std::abs(exact) + std::abs(second[c]->v)))
              << c << " " << i << " " << j;
        }
      }
    }
  }
}

// On a crest of radius R the road presses by m v^2 / R less, in a dip by as much more, on a slope by its cosine.
TEST(LapDynamics, CrestsTakeLoadOffAndDipsAddIt) {
  const Car car = car_1_43();
  const CubicSpline curve(0, 4.2, std::vector<double>{-1, -1, -1, -1});
  const double z[lap_variables] = {0.05, 0.1, 2.1, -0.3, 4.0, 0.2, 0.0, 1.5};
  const auto on = [&](const LapPlace& place) { return lap_rates(car, true_tyres(), curve, place, z); };
  const LapRates<double> flat = on({0.5, 0, 0, 0});
  EXPECT_EQ(flat.load, 1.0);
  for (const double radius : {1.5, 4.0, -2.0}) {
    const LapRates<double> r = on({0.5, 0, 0, -1.0 / radius});
    const double less = 2.1 * 2.1 / radius / gravity;
    EXPECT_NEAR(r.load, 1.0 - less, 1e-12);
    EXPECT_NEAR(r.front, flat.front * (1.0 - less), 1e-12);
    EXPECT_NEAR(r.rear, flat.rear * (1.0 - less), 1e-12);
  }
  EXPECT_NEAR(on({0.5, 0.1, 0, 0}).load, std::cos(0.1), 1e-12);
  EXPECT_NEAR(on({0.5, 0, -0.2, 0}).load, std::cos(0.2), 1e-12);
  EXPECT_GT(on({0.5, 0, 0, -10.0}).front / flat.front, 0.0);  // it would fly
}

// The car of the program is the car of the `dynamic` plugin.
TEST(LapDynamics, RatesAreThoseOfTheDynamicModel) {
  const Registry registry = plugins();
  DynamicCar plant(registry, 0.02);
  const Car car = car_1_43();
  const DriveLimits limits(plant.prediction(), car, 0, 0);
  std::vector<double> coast;
  for (int i = 0; i <= 40; ++i) coast.push_back(limits.coast(limits.top_speed() * i / 40));
  const CubicSpline curve(0, limits.top_speed(), coast);
  State x;
  x.vx = 2.1;
  x.vy = -0.3;
  x.omega = 4.0;
  x.delta = 0.2;
  const double d = 0.6, n = 0.05, xi = 0.1, kappa = 2.0;
  const double a = (0.287 - 0.0545 * x.vx) * d / car.m;
  const double z[lap_variables] = {n, xi, x.vx, x.vy, x.omega, x.delta, a, 1.5};
  const LapRates<double> r = lap_rates(car, true_tyres(), curve, {kappa, 0, 0}, z);
  const Prediction::Rates expected = plant.prediction().rates(x, {d, 0}, {});
  EXPECT_NEAR(r.state[lap_vx] / r.time, expected.vx, 1e-3);
  EXPECT_NEAR(r.state[lap_vy] / r.time, expected.vy, 1e-9);
  EXPECT_NEAR(r.state[lap_omega] / r.time, expected.omega, 1e-6);
  EXPECT_NEAR(r.state[lap_delta] / r.time, 1.5, 1e-12);
  EXPECT_NEAR(r.state[lap_n] / r.time, x.vx * std::sin(xi) + x.vy * std::cos(xi), 1e-12);
  EXPECT_NEAR(1 / r.time, (x.vx * std::cos(xi) - x.vy * std::sin(xi)) / (1 - n * kappa), 1e-12);
}

std::vector<double> slips(double range) {
  std::vector<double> slip;
  for (int i = 1; i <= 24; ++i) slip.push_back(range * i / 24);
  return slip;
}
std::vector<double> forces(const MagicFormula& axle, const std::vector<double>& slip) {
  std::vector<double> force;
  for (const double one : slip) force.push_back(axle.force(one));
  return force;
}

TEST(TyreFit, FindsTheCurveFromTheSlipsVisited) {
  const AxlePrior prior{{4.0, 1.3, 6.0}, 0.3};
  for (const MagicFormula& truth : {true_tyres().front, true_tyres().rear}) {
    const std::vector<double> slip = slips(0.5);
    const MagicFormula fit = fit_axle(slip, forces(truth, slip), {}, prior);
    for (const double one : slip) EXPECT_NEAR(fit.force(one), truth.force(one), 0.015 * truth.D);
    EXPECT_NEAR(fit.force(0.6), truth.force(0.6), 0.03 * truth.D);
    EXPECT_NEAR(fit.D, truth.D, 0.06 * truth.D);
  }
}

TEST(TyreFit, StaysNearTheBeliefWhereNothingWasLearned) {
  const AxlePrior prior{{4.0, 1.3, 6.0}, 0.08};
  const std::vector<double> slip = slips(0.5), force(24, 0.0), sigma(24, 100.0);
  const MagicFormula fit = fit_axle(slip, force, sigma, prior);
  EXPECT_NEAR(fit.D, 6.0, 0.05);
  EXPECT_NEAR(fit.B, 4.0, 0.05);
}

// front_C and rear_C may be up to 3.
TEST(TyreFit, KeepsAShapeBeyondTwoThatItIsTold) {
  const AxlePrior prior{{3.0, 2.6, 6.0}, 0.3};
  const MagicFormula truth{3.0, 2.6, 5.4};
  const std::vector<double> slip = slips(0.4);
  const MagicFormula fit = fit_axle(slip, forces(truth, slip), {}, prior);
  EXPECT_NEAR(fit.C, 2.6, 0.05);
  for (const double one : slip) EXPECT_NEAR(fit.force(one), truth.force(one), 0.015 * truth.D);
  const AxlePrior usual{{4.0, 1.3, 6.0}, 0.3};
  EXPECT_LE(fit_axle(slip, forces(truth, slip), {}, usual).C, 2.0);
}

TEST(TyreFit, DifferenceIsRelativeToThePeak) {
  AxleTyres weaker = true_tyres();
  weaker.rear.D *= 0.9;
  EXPECT_NEAR(difference(true_tyres(), weaker, 0.6), 0.1 * std::sin(1.2691 * std::atan(3.3852 * 0.6)), 1e-9);
  EXPECT_EQ(difference(true_tyres(), true_tyres(), 0.6), 0.0);
}

TEST(SlipRange, IgnoresWhatIsRare) {
  SlipRange range;
  for (int i = 0; i < 1000; ++i) range.add(i % 2 == 0 ? 0.305 : -0.1);
  range.add(1.1);
  EXPECT_NEAR(range.visited(), 0.31, 1e-9);
}

// Tyres that the planner can ask about.
class Curve final : public TyreCurve {
 public:
  explicit Curve(const AxleTyres& tyres) : tyres_(tyres) {}
  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    const MagicFormula& shape = axle == Axle::front ? tyres_.front : tyres_.rear;
    for (std::size_t i = 0; i < slip.size(); ++i) force[i] = 0.041 * shape.force(slip[i]);
    std::fill(sigma.begin(), sigma.end(), 0.0);
    return true;
  }

 private:
  AxleTyres tyres_;
};

class TimeOptimalTest : public ::testing::Test, protected PlannerRig {
 protected:
  Instance<SpeedPlanner> make(const Track& track, Changes changes, const char* cache = nullptr, double dt = 0.02) {
    PluginContext context = context_on(track);
    context.dt = dt;
    context.cache_dir = cache;
    context.progress = [](void* context, const char*, double fraction) {
      static_cast<std::vector<double>*>(context)->push_back(fraction);
    };
    context.progress_context = &progress_;
    const PluginEntry& entry = registry_.find(abi::Kind::planner, "time_optimal");
    return create<SpeedPlanner>(entry, context, values_of(entry, changes));
  }
  /// Few members, coarse nodes: what the planner does with laps, not how good they are.
  static Changes coarse(Changes more = {}) {
    Changes changes{{"mu_lo", 0.6}, {"mu_hi", 0.9}, {"mu_step", 0.3}, {"spacing", 0.12}};
    changes.insert(changes.end(), more.begin(), more.end());
    return changes;
  }
  static Belief believe(double mu, double sigma = 0.0, bool trusted = true) { return {mu, mu, sigma, sigma, trusted}; }

  static Observation on(const RefPoint& r, double t) {
    Observation now;
    now.t = t;
    now.x = {r.x, r.y, r.yaw - r.beta, r.v, r.v * std::tan(r.beta), 0.0, 0.0};
    now.at = r.at;
    return now;
  }
  Observation at_line(SpeedPlanner& planner, std::size_t i) const {
    const LinePoint& p = planner.line()[i];
    Observation now;
    now.x = {p.x, p.y, p.yaw, 2.0, 0.0, 0.0, 0.0};
    now.at.s = p.station;
    return now;
  }

  /// Drives the references exactly, as a perfect car would, and returns the time of the second lap [s].
  double flying_lap(SpeedPlanner& planner, const Belief& belief) {
    std::vector<RefPoint> horizon(2);
    Observation now = at_line(planner, 0);
    double covered = 0, laps[2] = {0, 0}, t = 0;
    const double length = course_->length();
    double station = now.at.s;
    for (int lap = 0; lap < 2;) {
      planner.plan(now, belief, nullptr, horizon);
      now = on(horizon[1], t += 0.02);
      covered += std::remainder(now.at.s - station, length);
      station = now.at.s;
      if (covered >= length * (lap + 1)) {
        // Back to the moment of the crossing; what is left over belongs to the next lap.
        const double speed = std::remainder(horizon[1].at.s - horizon[0].at.s, length) / 0.02;
        ++lap;
        laps[lap - 1] = t - (covered - length * lap) / speed;
      }
    }
    return laps[1] - laps[0];
  }

  std::vector<double> progress_;
};

// worlds/limits has the laps of another program, gripline limit of the host, to 0.1 %. How far a lap may slide decides:
// with slips up to 0.6 rad this planner's laps, on its coarser nodes, lie between 2 % below and 3 % above that table;
// up to 1.2 rad they brake by drifting, as this car's weak brakes invite them to, and are faster.
TEST_F(TimeOptimalTest, ReproducesThePaceTableWithTheTrueTyres) {
  const auto lap = [&](const Track& track, double factor, double slip_max) {
    const double mu = factor * (0.192 + 0.1737) / (0.041 * gravity);
    const auto planner = make(track, {{"margin", 0},
                                      {"factor", 1},
                                      {"mu_lo", mu},
                                      {"mu_hi", mu},
                                      {"front_B", 2.579},
                                      {"front_C", 1.2},
                                      {"rear_B", 3.3852},
                                      {"rear_C", 1.2691},
                                      {"balance", 0.192 * 0.029 / (0.1737 * 0.033)},
                                      {"slip_max", slip_max},
                                      {"start", mu}});
    return flying_lap(*planner, believe(mu));
  };
  struct Row {
    const char* name;
    const Track* track;
    double factor;
  };
  for (const Row& row : {Row{"ethz", &ethz_, 1}, Row{"ethz", &ethz_, 0.65}, Row{"ethz", &ethz_, 0.55},
                         Row{"mobil", &mobil_, 1}, Row{"mobil", &mobil_, 0.65}}) {
    const CsvTable limits = read_csv(source_dir() / "worlds" / "limits" / (std::string(row.name) + ".csv"));
    double limit = 0;
    for (std::size_t i = 0; i < limits.rows(); ++i)
      if (limits.column("factor")[i] == row.factor && limits.column("body")[i] == 0) limit = limits.column("lap_s")[i];
    ASSERT_GT(limit, 0) << row.name << " " << row.factor;
    const double bounded = lap(*row.track, row.factor, 0.6), free = lap(*row.track, row.factor, 1.2);
    EXPECT_GT(bounded, 0.98 * limit) << row.name << " " << row.factor;
    EXPECT_LT(bounded, 1.03 * limit) << row.name << " " << row.factor;
    EXPECT_LT(free, limit) << row.name << " " << row.factor;
    std::cout << row.name << " factor " << row.factor << ": " << bounded << " s with slips up to 0.6 rad, " << free
              << " s up to 1.2 rad, limit " << limit << " s\n";
  }
}

TEST_F(TimeOptimalTest, LineKeepsItsMarginAndReferencesKeepTheLimits) {
  const auto planner = make(ethz_, {{"factor", 1.0}, {"mu_lo", 0.9}, {"mu_hi", 0.9}, {"start", 0.9}});
  std::vector<RefPoint> horizon(400);
  planner->plan(at_line(*planner, 0), believe(0.9), nullptr, horizon);
  for (int i = 0; i < 300; ++i) planner->plan(on(horizon[1], 0), believe(0.9), nullptr, horizon);
  for (const RefPoint& r : horizon) {
    const CoursePoint c = course_->locate(r.x, r.y, r.at.s);
    EXPECT_GT(std::min(c.left - c.n, c.right + c.n), 0.4 * car_.width - 4e-3);
    EXPECT_NEAR(r.at.n, c.n, 1e-9);
    const double speed = r.v / std::cos(r.beta);
    EXPECT_LT(speed * speed * std::abs(r.kappa), 1.15 * 0.9 * gravity);
    EXPECT_LT(std::abs(r.beta), 0.7);
  }
  for (std::size_t k = 1; k < horizon.size(); ++k) {
    const double way = std::hypot(horizon[k].x - horizon[k - 1].x, horizon[k].y - horizon[k - 1].y);
    const double speed =
        0.5 * (horizon[k].v / std::cos(horizon[k].beta) + horizon[k - 1].v / std::cos(horizon[k - 1].beta));
    EXPECT_NEAR(way, 0.02 * speed, 0.06 * 0.02 * speed);
  }
}

TEST_F(TimeOptimalTest, LessFrictionIsAnotherLineAndSlower) {
  const auto planner = make(mobil_, coarse({{"rise", 100}}));
  const double fast = flying_lap(*planner, believe(0.9));
  const std::vector<LinePoint> line(planner->line().begin(), planner->line().end());
  const double slow = flying_lap(*planner, believe(0.65));
  EXPECT_GT(slow, 1.08 * fast);
  double moved = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    moved = std::max(moved, std::hypot(line[i].x - planner->line()[i].x, line[i].y - planner->line()[i].y));
  EXPECT_GT(moved, 0.01);
}

TEST_F(TimeOptimalTest, DrivesMoreSlowlyBelowTheLeastFrictionOfItsLibrary) {
  const auto planner = make(mobil_, coarse({{"factor", 1.0}, {"start", 0.6}}));
  std::vector<RefPoint> horizon(2);
  const Observation here = at_line(*planner, 100);
  const auto speed = [&](double mu) {
    planner->plan(here, believe(mu), nullptr, horizon);
    return horizon[0].v / std::cos(horizon[0].beta);
  };
  const double least = speed(0.6);
  EXPECT_NEAR(speed(0.15), 0.5 * least, 1e-9);
}

TEST_F(TimeOptimalTest, ExploresFromTheSafeSide) {
  // Speed of the reference at one place: how fast the planned friction is.
  const auto planner = make(mobil_, coarse({{"factor", 1.0}, {"start", 0.6}, {"rise", 0.1}}));
  std::vector<RefPoint> horizon(2);
  const Observation here = at_line(*planner, 100);
  const auto speed = [&](const Belief& belief) {
    planner->plan(here, belief, nullptr, horizon);
    return horizon[0].v;
  };
  const double start = speed(believe(1.0, 0, false));
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(speed(believe(1.0, 0, false)), start, 1e-9);  // not trusted: no rise
  const double first = speed(believe(0.9));
  for (int i = 0; i < 149; ++i) speed(believe(0.9));
  const double risen = speed(believe(0.9));
  for (int i = 0; i < 500; ++i) speed(believe(0.9));
  const double full = speed(believe(0.9));
  EXPECT_LT(first, start + 0.02 * (full - start));
  EXPECT_NEAR((risen - start) / (full - start), 1.0, 0.05);          // 0.3 at 0.1 per second took 3 s
  EXPECT_LT(speed(believe(0.9, 0.1)), full - 0.2 * (full - start));  // uncertain: slower at once
  EXPECT_NEAR(speed(believe(0.6)), start, 1e-9);                     // slippery: at once
}

TEST_F(TimeOptimalTest, UncertaintyTakesRoomFromTheController) {
  const auto planner = make(mobil_, coarse({{"tighten", 0.2}, {"tighten_sigma", 0.5}}));
  std::vector<RefPoint> horizon(10);
  const Observation now = at_line(*planner, 100);
  planner->plan(now, believe(0.6), nullptr, horizon);
  const double certain = horizon[0].left;
  const CoursePoint c = course_->locate(horizon[0].x, horizon[0].y, horizon[0].at.s);
  EXPECT_NEAR(certain, (c.left - c.n) / std::cos(horizon[0].yaw - c.yaw) - 0.2 * 0.03, 1e-6);
  planner->plan(now, believe(0.6, 0.06), nullptr, horizon);
  const CoursePoint later = course_->locate(horizon[0].x, horizon[0].y, horizon[0].at.s);
  EXPECT_NEAR(horizon[0].left, (later.left - later.n) / std::cos(horizon[0].yaw - later.yaw) - 0.03 * (0.2 + 0.5 * 0.1),
              1e-6);
}

TEST_F(TimeOptimalTest, IsSolvedAgainForTheLearnedTyres) {
  const auto drive = [&](const TyreCurve& curve, int steps) {
    const auto planner = make(mobil_, coarse({{"latency", 10}, {"factor", 1.0}, {"start", 0.75}}));
    std::vector<RefPoint> horizon(2);
    std::vector<double> speeds;
    for (int i = 0; i < steps; ++i) {
      Observation now = at_line(*planner, 150);
      now.x.vy = i % 2 == 0 ? 0.5 : -0.5;  // slips up to some 0.25 rad are visited
      planner->plan(now, believe(0.75), &curve, horizon);
      speeds.push_back(horizon[0].v);
    }
    return speeds;
  };
  AxleTyres weak_rear = true_tyres();
  weak_rear.rear.D *= 0.9;
  weak_rear.front.D += 0.1 * true_tyres().rear.D;
  const std::vector<double> even = drive(Curve(true_tyres()), 80), weak = drive(Curve(weak_rear), 80);
  EXPECT_NE(even.back(), even.front());
  EXPECT_NE(weak.back(), even.back());
  EXPECT_EQ(even, drive(Curve(true_tyres()), 80));  // to the last bit
  EXPECT_NEAR(even[79], even[78], 1e-9);            // settled
}

/// A lap solved for what was learned is driven when its counted work is done at the stated rate, whatever this machine
/// takes, and never before the latency.
TEST_F(TimeOptimalTest, ASolvedLapIsDrivenWhenItsWorkIsDone) {
  constexpr int latency = 10;
  std::vector<double> stated;  // by the planner at each step of the last drive
  const auto drive = [&](double rate) {
    const auto planner =
        make(mobil_, coarse({{"latency", latency}, {"solver_rate", rate}, {"factor", 1.0}, {"start", 0.75}}));
    const Curve learned(true_tyres());
    std::vector<RefPoint> horizon(2);
    std::vector<double> speeds;
    stated.clear();
    for (int i = 0; i < 160; ++i) {
      Observation now = at_line(*planner, 150);
      now.x.vy = i % 2 == 0 ? 0.5 : -0.5;
      planner->plan(now, believe(0.75), &learned, horizon);
      speeds.push_back(horizon[0].v);
      stated.push_back(planner->latency());
    }
    return speeds;
  };
  const std::vector<double> never = drive(100);
  const auto steps_until_driven = [&](double rate) {
    const std::vector<double> speeds = drive(rate);
    const auto driven = std::mismatch(speeds.begin(), speeds.end(), never.begin()).first - speeds.begin();
    const auto step = static_cast<std::size_t>(driven);
    EXPECT_GT(step, 0u);
    EXPECT_LT(step, stated.size()) << "nothing was driven";
    if (step == 0 || step >= stated.size()) return -1;
    EXPECT_EQ(stated[step - 1], 0);
    EXPECT_NEAR(stated[step], 0.02 * static_cast<double>(step), 0.021) << "ordered in the first or second step";
    return static_cast<int>(driven);
  };
  EXPECT_EQ(stated.back(), 0) << "nothing that was ordered was driven";
  const int at_once = steps_until_driven(1e9), slow = steps_until_driven(2000), slower = steps_until_driven(1000);
  EXPECT_GE(at_once, latency);
  EXPECT_GT(slow, at_once + 2 * latency);
  EXPECT_LT(slower, 160);
  EXPECT_NEAR(slower - slow, slow - at_once + latency, 2);  // ordered in one step, the work done twice as slowly
}

// Steps of the latency are those of 20 ms, whatever a control step is, and so are those of the change to the new lap.
TEST_F(TimeOptimalTest, ASolvedLapWaitsAndComesAsLongAtAnyStep) {
  constexpr int latency = 10;
  const Curve learned(true_tyres());
  const auto speed_after = [&](double seconds, double dt) {
    const auto planner = make(
        mobil_, coarse({{"latency", latency}, {"solver_rate", 1e9}, {"factor", 1.0}, {"start", 0.75}}), nullptr, dt);
    std::vector<RefPoint> horizon(2);
    for (int i = 0; i <= static_cast<int>(std::lround(seconds / dt)); ++i) {
      Observation now = at_line(*planner, 150);
      now.x.vy = i % 2 == 0 ? 0.5 : -0.5;
      planner->plan(now, believe(0.75), &learned, horizon);
    }
    const bool is_solved = seconds > 0.02 * latency;
    EXPECT_NEAR(planner->latency(), is_solved ? 0.02 * latency + dt : 0.0, 1e-9) << dt;
    return horizon[0].v;
  };
  const auto share_of_change = [&](double dt) {
    const double before = speed_after(0.2, dt), on_the_way = speed_after(0.32, dt), after = speed_after(0.4, dt);
    EXPECT_GT(after - before, 0.05) << dt;
    return (on_the_way - before) / (after - before);
  };
  const double usual = share_of_change(0.02);
  EXPECT_NEAR(usual, 0.6, 0.05);
  for (const double dt : {0.01, 0.04}) EXPECT_NEAR(share_of_change(dt), usual, 0.01) << dt;
}

TEST_F(TimeOptimalTest, LibraryIsKeptByContent) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "gripline_time_optimal";
  std::filesystem::remove_all(folder);
  const auto files = [&] {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) found.push_back(entry.path());
    return found;
  };
  const double computed = flying_lap(*make(mobil_, coarse(), folder.c_str()), believe(0.8));
  EXPECT_THAT(progress_, ::testing::ElementsAre(0.5, 1.0));
  ASSERT_EQ(files().size(), 1u);
  progress_.clear();
  EXPECT_EQ(flying_lap(*make(mobil_, coarse(), folder.c_str()), believe(0.8)), computed);
  EXPECT_TRUE(progress_.empty());
  make(mobil_, coarse({{"slip_max", 0.5}}), folder.c_str());
  EXPECT_EQ(files().size(), 2u);
  // A damaged file is not believed.
  for (const auto& path : files()) std::ofstream(path, std::ios::trunc) << "0.1\n0.2\n";
  EXPECT_EQ(flying_lap(*make(mobil_, coarse(), folder.c_str()), believe(0.8)), computed);
  std::filesystem::remove_all(folder);
}

/// One number that somebody or a bad disk changed, in a file that is otherwise whole: noticed and healed.
TEST_F(TimeOptimalTest, ADamagedNumberInTheLibraryIsNotDriven) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "gripline_time_optimal_damaged";
  std::filesystem::remove_all(folder);
  const double computed = flying_lap(*make(mobil_, coarse(), folder.c_str()), believe(0.8));
  const std::filesystem::path file = std::filesystem::directory_iterator(folder)->path();
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  ASSERT_GT(lines.size(), 1000u);
  for (const char* damage : {"5.0518", "nan", "inf"}) {
    std::ofstream out(file, std::ios::trunc);
    for (std::size_t i = 0; i < lines.size(); ++i) out << (i == 501 ? damage : lines[i]) << '\n';
    out.close();
    progress_.clear();
    EXPECT_EQ(flying_lap(*make(mobil_, coarse(), folder.c_str()), believe(0.8)), computed) << damage;
    EXPECT_FALSE(progress_.empty()) << damage;  // computed anew
  }
  progress_.clear();
  make(mobil_, coarse(), folder.c_str());
  EXPECT_TRUE(progress_.empty());  // and kept
  std::filesystem::remove_all(folder);
}

TEST_F(TimeOptimalTest, RefusesWhatCannotBe) {
  EXPECT_THROW(make(mobil_, {{"mu_lo", 1.0}, {"mu_hi", 0.5}}), PluginError);
  const PluginEntry& entry = registry_.find(abi::Kind::planner, "time_optimal");
  EXPECT_THROW(create<SpeedPlanner>(entry, PluginContext{}, values_of(entry)), PluginError);
}

}  // namespace test_time_optimal
}  // namespace gripline
