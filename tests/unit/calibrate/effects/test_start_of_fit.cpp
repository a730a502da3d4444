#include "calibrate/effects/start_of_fit.hpp"

#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_start_of_fit {

constexpr const char* offset_pointer = "/plant/effects/yawrate_bias/params/b";

/// A world whose yaw rate is off by an amount that it does not know.
struct OffsetWorld {
  explicit OffsetWorld(std::string_view patch = "{}")
      : tree(merge(test::small_car_world(R"({
          "plant": {"effects": [{"plugin": "yawrate_bias", "params": {"b": 0.05}}]},
          "unknowns": {"/plant/effects/yawrate_bias/params/b": {"sigma": 0.1}}})"),
                   testing_support::json(patch))),
        world(test::CalibrateRig::read(tree), test::CalibrateRig::options(test::CalibrateRig::read(tree))) {}
  StartOfFit start(const measured::LogMap& map, const std::optional<measured::YawRateOffset>& by_yaw = {},
                   const std::vector<std::string>& chosen = {}) const {
    return start_of_fit(tree, world, map, {}, by_yaw, chosen);
  }
  std::size_t delay() const { return world.forecaster.index(ForecastParameter::delay_position); }

  Node tree;
  Trial world;
};

const Unknown* find(const StartOfFit& start, const std::string& pointer) {
  const auto at = std::ranges::find(start.unknowns, pointer, &Unknown::pointer);
  return at == start.unknowns.end() ? nullptr : &*at;
}

TEST(StartOfFit, IsTheWorldWhereNothingIsReadOffTheLogs) {
  const OffsetWorld offset;
  const StartOfFit start = offset.start(measured::gripline_map());
  EXPECT_EQ(start.values, start.given);
  EXPECT_TRUE(start.limited.empty());
  ASSERT_NE(find(start, offset_pointer), nullptr);
  EXPECT_EQ(find(start, offset_pointer)->prior, 0.05);
}

TEST(StartOfFit, TakesADelayFromTheMapAndFitsItNoMore) {
  const OffsetWorld offset;
  measured::LogMap map = measured::gripline_map();
  map.file = "map.json";
  for (auto& channel : map.channel)
    if (channel) channel->delay = 0.1;
  const StartOfFit start = offset.start(map);
  EXPECT_EQ(start.given[offset.delay()], 0.0) << "as the world has it";
  EXPECT_EQ(start.values[offset.delay()], 0.1);
  EXPECT_EQ(find(start, "/calibration/delays/position"), nullptr);
}

/// Of delays that are one unknown those that are stated leave it, and the others stay fitted.
TEST(StartOfFit, ADelayThatIsToBeFoundIsFittedThoughTheOneItIsTiedToIsStated) {
  const OffsetWorld offset(R"({"unknowns": {
      "/calibration/delays/yaw": {"same_as": "/calibration/delays/position"},
      "/calibration/delays/velocity": {"same_as": "/calibration/delays/position"}}})");
  measured::LogMap map = measured::gripline_map();
  map.file = "map.json";
  map.find_delay(2, 0.3);
  const StartOfFit start = offset.start(map);
  EXPECT_EQ(find(start, "/calibration/delays/position"), nullptr);
  const Unknown* const velocity = find(start, "/calibration/delays/velocity");
  ASSERT_NE(velocity, nullptr);
  EXPECT_TRUE(velocity->same.empty());
  EXPECT_EQ(velocity->prior, 0.3);
  EXPECT_EQ(start.values[offset.delay() + 2], 0.3);
  EXPECT_EQ(start.values[offset.delay()], 0.0);
}

TEST(StartOfFit, KeepsAnOffsetOfTheYawRateToWhatYawSays) {
  const OffsetWorld offset;
  const StartOfFit start = offset.start(measured::gripline_map(), measured::YawRateOffset{0.001, 0.001, 400});
  ASSERT_EQ(start.limited.size(), 1U);
  EXPECT_EQ(start.limited.front().pointer, offset_pointer);
  const std::size_t index = start.limited.front().index;
  EXPECT_EQ(start.given[index], 0.05);
  EXPECT_EQ(start.values[index], 0.001);
}

TEST(StartOfFit, KeepsTheUnknownsThatAreChosen) {
  const OffsetWorld offset;
  EXPECT_EQ(offset.start(measured::gripline_map(), {}, {offset_pointer}).unknowns.size(), 1U);
}

TEST(StartOfFit, RefusesUnknownsThatTheWorldHasNot) {
  const OffsetWorld offset(R"({"unknowns": {"/plant/params/no_such_parameter": {"sigma": 0.1}}})");
  EXPECT_THROW(offset.start(measured::gripline_map()), InputError);
}

}  // namespace test_start_of_fit
}  // namespace gripline::calibrate
