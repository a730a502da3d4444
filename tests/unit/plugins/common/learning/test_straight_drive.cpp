#include "common/learning/straight_drive.hpp"

#include <gtest/gtest.h>

#include "support/learning_rig.hpp"

namespace gripline {
namespace test_straight_drive {

using namespace rig;

learning::StraightDrive straight_drive(CorrectedModel& nominal) {
  PluginContext context;
  context.car = small_car();
  context.dt = dt;
  context.hold = Hold::zoh;
  context.nominal = &nominal;
  return learning::StraightDrive(context);
}
bool has_tyres(CorrectedModel& nominal) { return straight_drive(nominal).model_has_tyres(); }

TEST(StraightDrive, TyresAreSeenByWhatTheyDo) {
  Nominal dynamic("dynamic"), ekinematic("ekinematic"), kinematic("kinematic");
  EXPECT_TRUE(has_tyres(dynamic.prediction()));
  EXPECT_FALSE(has_tyres(ekinematic.prediction()));
  EXPECT_FALSE(has_tyres(kinematic.prediction()));
}

// What a slope does to loads is counted once, whether the model has it or not: loads are the model's, as they are in the
// prediction, and on_road() takes the road's in their place.
TEST(StraightDrive, ASlopeLoadsAxlesOnce) {
  Place banked;
  banked.bank = 0.2;
  banked.kappa = 0.5;
  for (const char* const id : {"dynamic", "ekinematic"}) {
    Nominal nominal(id);
    const auto rates = straight_drive(nominal.prediction()).at(2.0, 0.3, banked);
    State x;
    x.vx = 2.0;
    EXPECT_EQ(rates.load_front, nominal.prediction().rates(x, {0.3, 0.0}, banked).load_front) << id;
    EXPECT_NEAR(rates.on_road(1.1).load_rear, 1.1, 1e-15) << id;
    EXPECT_NEAR(rates.on_road(1.1).on_road(0.9).load_rear, 0.9, 1e-15) << id;
  }
}

// Its side speed fades by itself. Were that taken for a tyre, a correction would take off forces that no model
// computed.
TEST(StraightDrive, AYawResponseIsNoTyre) {
  const OneEffect effect("yaw_response", {});
  const Nominal nominal("ekinematic");
  StagedCar car = nominal.car();
  effect.add_to(car);
  CorrectedModel model(std::move(car), Nominal::options("rk4"));
  State sliding;
  sliding.vx = 2.0;
  sliding.vy = 0.2;
  ASSERT_LT(model.rates(sliding, {}, {}).vy, -0.1);
  EXPECT_FALSE(has_tyres(model));
}

// Samples say which throttle acts. A model that took it for a command would make a dead zone of it again, and steer by
// its offset.
TEST(StraightDrive, IsWhereTheThrottleActsAndTheWheelsPointStraightAhead) {
  const OneEffect dead_zone("throttle_dead_zone", {{"z", 0.2}}), curve("throttle_curve", {{"p", 1.5}});
  const OneEffect gain("steer_gain", {{"k", 0.3}}), offset("steer_offset", {{"d0", 0.05}});
  for (const char* const id : {"dynamic", "ekinematic"}) {
    Nominal nominal(id);
    StagedCar car = nominal.car();
    for (const OneEffect* effect : {&dead_zone, &curve, &gain, &offset}) effect->add_to(car);
    CorrectedModel mapped(std::move(car), Nominal::options("rk4"));
    const learning::StraightDrive plain = straight_drive(nominal.prediction()), behind = straight_drive(mapped);
    for (const double d : {-0.1, -0.03, 0.0, 0.1, 0.5, 0.97}) {
      const auto expected = plain.at(2.0, d, {}), found = behind.at(2.0, d, {});
      EXPECT_NEAR(found.drive_force, expected.drive_force, 1e-12) << id << ' ' << d;
      EXPECT_NEAR(found.forward, expected.forward, 1e-10) << id << ' ' << d;
      EXPECT_NEAR(found.side, 0.0, 1e-10) << id << ' ' << d;
    }
  }
}

}  // namespace test_straight_drive
}  // namespace gripline
