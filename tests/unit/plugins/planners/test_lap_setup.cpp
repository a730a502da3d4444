#include "planners/time_optimal/lap_setup.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_lap_setup {

using namespace time_optimal;
using namespace testing_support;

/// What cold guesses of a road are driven at, beside a speed profile from tables of the same tyres.
class LapSetupTest : public ::testing::Test, protected PlannerRig {
 protected:
  AxleTyres tyres(double mu) const { return planning::equal_friction(mu, car_, 4.0, 1.3); }
  std::vector<double> profile(const planning::CornerLimits& corner, double mu) const {
    return planning::speed_profile(setup_.base(), limits_, corner, mu, 0.0);
  }
  std::vector<double> own_profile(const AxleTyres& tyres) const {
    return profile(planning::CornerLimits(car_, tyres, limits_.top_speed()), 1.0);
  }
  /// The largest difference of a guess's speeds from a profile's at the nodes [m/s].
  double difference(const LapSolution& guess, const std::vector<double>& v) const {
    double largest = 0;
    for (std::size_t k = 0; k < guess.z.size(); ++k) {
      const planning::Bracket b = setup_.base().bracket(setup_.nodes().s[k]);
      const double wanted = std::lerp(v[b.first], v[b.second], b.weight);
      const double speed = std::hypot(guess.z[k][lap_vx], guess.z[k][lap_vy]) / 0.95;
      largest = std::max(largest, std::abs(speed - wanted));
    }
    return largest;
  }

  PluginContext context_ = context_on(mobil_);
  LapSetup setup_{
      context_, SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}}, {tyres(0.8), {}}};
  planning::DriveLimits limits_{model_.prediction(), car_, 0.0, 0.0};
};

TEST_F(LapSetupTest, TheTypicalTyresTablesServeEveryFriction) {
  std::vector<double> sum;
  for (const double mu : {0.2, 0.5, 0.8, 1.1, 1.7}) {
    const std::vector<double> own = own_profile(tyres(mu));
    EXPECT_LT(difference(setup_.cold_guess(tyres(mu)), own), 1e-7) << mu;
    sum.push_back(0);
    for (const double v : own) sum.back() += v;
  }
  EXPECT_TRUE(std::is_sorted(sum.begin(), sum.end()));
  EXPECT_GT(sum.back(), 1.5 * sum.front());
}

TEST_F(LapSetupTest, AShareOfTheBrakesIsPlannedWith) {
  SetupOptions options{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}};
  options.brakes = 0.8;
  const LapProblem whole = setup_.problem({tyres(0.8), {}}),
                   part = LapSetup(context_, options, {tyres(0.8), {}}).problem({tyres(0.8), {}});
  ASSERT_FALSE(whole.drive.brake.values().empty());
  for (std::size_t i = 0; i < whole.drive.brake.values().size(); ++i) {
    EXPECT_GT(whole.drive.brake.values()[i], 0.0);
    EXPECT_DOUBLE_EQ(part.drive.brake.values()[i], 0.8 * whole.drive.brake.values()[i]);
    EXPECT_EQ(part.drive.drive.values()[i], whole.drive.drive.values()[i]);
  }
}

// Its line would have millions of samples.
TEST_F(LapSetupTest, ACarFarTooSmallForTheRoadIsRefused) {
  PluginContext context = context_;
  context.car.lf = context.car.lr = 1e-5;
  EXPECT_THROW(LapSetup(context, {.margin = 0.0, .spacing = 0.1, .use = {.slip_bound = 0.7}}, {tyres(0.8), {}}),
               std::invalid_argument);
}

// An axle of another shape, or of another friction than the other one's, turns other corners at other speeds.
TEST_F(LapSetupTest, TyresOfAnotherShapeHaveTheirOwnTables) {
  const planning::CornerLimits typical(car_, tyres(0.8), limits_.top_speed());
  const auto changed = [&](const auto& change) {
    AxleTyres all = tyres(0.6);
    change(all);
    return all;
  };
  const std::array<std::pair<std::string, AxleTyres>, 5> others{{
      {"front B", changed([](AxleTyres& t) { t.front.B = 2.5; })},
      {"rear B", changed([](AxleTyres& t) { t.rear.B = 2.5; })},
      {"front C", changed([](AxleTyres& t) { t.front.C = 1.8; })},
      {"rear C", changed([](AxleTyres& t) { t.rear.C = 1.8; })},
      {"rear D", changed([](AxleTyres& t) { t.rear.D *= 0.9; })},
  }};
  for (const auto& [name, other] : others) {
    const LapSolution guess = setup_.cold_guess(other);
    EXPECT_LT(difference(guess, own_profile(other)), 1e-7) << name;
    EXPECT_GT(difference(guess, profile(typical, 0.6 / 0.8)), 1e-3) << name;
  }
}

}  // namespace test_lap_setup
}  // namespace gripline
