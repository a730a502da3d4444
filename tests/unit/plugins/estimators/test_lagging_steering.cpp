// What the learners have in common: where the nominal model knows that the wheels follow their command late, they learn
// from the angle that acts, and learn the same.
#include <gtest/gtest.h>

#include "race/sample.hpp"
#include "support/learning_rig.hpp"

namespace gripline {
namespace test_lagging_steering {

using namespace rig;

constexpr double seconds = 12.0, judged_from = 6.0;

/// An effect with the parameters that are set, and the others as declared.
class OneEffect {
 public:
  OneEffect(const std::string& id, const Settings& settings)
      : entry_(registry().find(abi::Kind::effect, id)),
        values_(values_of(entry_, settings)),
        effect_(create<Effect>(entry_, PluginContext{}, values_)) {}
  void add_to(StagedCar& car) const {
    std::vector<double> params;
    for (const auto& value : values_) params.push_back(value.number);
    car.add(*effect_, params, entry_.decl->id);
  }

 private:
  const PluginEntry& entry_;
  std::vector<abi::ParamValue> values_;
  Instance<Effect> effect_;
};

/// The 1:43 car and its nominal model, both with the steering lag or without, and a learner that drives along.
class LearningDrive {
 public:
  LearningDrive(const std::string& id, bool lags)
      : plant_(car_of(published_, lags), Nominal::options("rk4", 10)),
        nominal_(car_of(no_slip_, lags), Nominal::options("rk4")),
        learner_(make_learner(id)),
        corrected_(corrected_car(lags), Nominal::options("rk4")) {
    State x;
    x.vx = 0.5;
    for (CorrectedModel* model : {&plant_, &nominal_, &corrected_}) model->reset(x, 0.0, {});
    drive(x);
  }
  const Estimator& learner() const { return *learner_; }
  /// Share of the variance of e_vy (1) or e_omega (2) that the correction explained of steps it had not learned yet.
  double explained(std::size_t channel) const {
    const Sums& s = sums_[channel];
    return 1.0 - s.left / (s.squares - s.sum * s.sum / s.count);
  }

 private:
  struct Sums {
    double count = 0, sum = 0, squares = 0, left = 0;
    void add(double e, double rest) {
      count += 1;
      sum += e;
      squares += e * e;
      left += rest * rest;
    }
  };

  StagedCar car_of(const Nominal& model, bool lags) const {
    StagedCar car = model.car();
    if (lags) lag_.add_to(car);
    return car;
  }
  StagedCar corrected_car(bool lags) const {
    StagedCar car = car_of(no_slip_, lags);
    car.add(*learner_, {}, "estimator");
    return car;
  }
  Instance<Estimator> make_learner(const std::string& id) {
    const PluginEntry& entry = registry().find(abi::Kind::estimator, id);
    PluginContext context;
    context.car = small_car();
    context.dt = dt;
    context.nominal = &nominal_;
    const Settings few = {{"models", 2000}};  // of lla's bank
    return create<Estimator>(entry, context, values_of(entry, few));
  }

  void drive(State x) {
    BendDriver driver(3);
    const TrueCar limits;
    for (std::int64_t i = 0; static_cast<double>(i) * dt < seconds; ++i) {
      const double t = static_cast<double>(i) * dt;
      const Input u = driver.drive(x, limits);
      const State next = plant_.advance(x, u, {});
      const Sample k = residual_sample(nominal_, {t, i, x, {}, 0.0}, u, {t + dt, i + 1, next, {}, u.d});
      const State said = corrected_.advance(x, u, {});
      if (t >= judged_from) {
        sums_[1].add(k.e_vy, (next.vy - said.vy) / dt);
        sums_[2].add(k.e_omega, (next.omega - said.omega) / dt);
      }
      learner_->update(k);
      x = next;
    }
  }

  OneEffect lag_{"steer_lag", {{"tau", 0.05}}};
  Nominal published_{"dynamic"}, no_slip_{"ekinematic"};
  CorrectedModel plant_, nominal_;
  Instance<Estimator> learner_;
  CorrectedModel corrected_;
  std::array<Sums, 3> sums_{};
};

class Learner : public testing::TestWithParam<const char*> {};

TEST_P(Learner, LearnsTheSameBehindASteeringLag) {
  const LearningDrive plain(GetParam(), false), lagging(GetParam(), true);
  EXPECT_GT(plain.explained(2), 0.85);
  EXPECT_NEAR(lagging.explained(2), plain.explained(2), 0.1);
  // Which few of its random models lla finds decides how well it explains e_vy.
  if (GetParam() == std::string("lla")) return;
  EXPECT_NEAR(lagging.explained(1), plain.explained(1), 0.1);
}

INSTANTIATE_TEST_SUITE_P(All, Learner, testing::Values("elm", "elm_rls", "gp_own_mu", "lla", "mhe"),
                         [](const auto& one) { return std::string(one.param); });

TEST(LearnedCurve, IsTheSameBehindASteeringLag) {
  const std::vector<double> slips = {-0.2, -0.1, -0.05, 0.05, 0.1, 0.2};
  for (const char* const id : {"elm", "elm_rls"}) {
    const LearningDrive plain(id, false), lagging(id, true);
    for (const Axle axle : {Axle::front, Axle::rear}) {
      std::vector<double> expected(slips.size()), force(slips.size());
      ASSERT_TRUE(plain.learner().tyre_force(axle, slips, expected, {}));
      ASSERT_TRUE(lagging.learner().tyre_force(axle, slips, force, {}));
      for (std::size_t i = 0; i < slips.size(); ++i) EXPECT_NEAR(force[i], expected[i], 0.015) << id << ' ' << slips[i];
    }
  }
}

}  // namespace test_lagging_steering
}  // namespace gripline
