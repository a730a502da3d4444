#include "common/learning/straight_drive.hpp"

#include <gtest/gtest.h>

#include "support/learning_rig.hpp"

namespace gripline {
namespace test_straight_drive {

using namespace rig;

bool has_tyres(CorrectedModel& nominal) {
  PluginContext context;
  context.car = small_car();
  context.dt = dt;
  context.hold = Hold::zoh;
  context.nominal = &nominal;
  return learning::StraightDrive(context).model_has_tyres();
}

TEST(StraightDrive, TyresAreSeenByWhatTheyDo) {
  Nominal dynamic("dynamic"), ekinematic("ekinematic"), kinematic("kinematic");
  EXPECT_TRUE(has_tyres(dynamic.prediction()));
  EXPECT_FALSE(has_tyres(ekinematic.prediction()));
  EXPECT_FALSE(has_tyres(kinematic.prediction()));
}

// Its side speed fades by itself. Were that taken for a tyre, a correction would take off forces that no model
// computed.
TEST(StraightDrive, AYawResponseIsNoTyre) {
  const PluginEntry& entry = registry().find(abi::Kind::effect, "yaw_response");
  const auto values = values_of(entry, {});
  const Instance<Effect> effect = create<Effect>(entry, PluginContext{}, values);
  std::vector<double> params;
  for (const auto& value : values) params.push_back(value.number);
  const Nominal nominal("ekinematic");
  StagedCar car = nominal.car();
  car.add(*effect, params, "yaw_response");
  CorrectedModel model(std::move(car), Nominal::options("rk4"));
  State sliding;
  sliding.vx = 2.0;
  sliding.vy = 0.2;
  ASSERT_LT(model.rates(sliding, {}, {}).vy, -0.1);
  EXPECT_FALSE(has_tyres(model));
}

}  // namespace test_straight_drive
}  // namespace gripline
