#include "calibrate/fit/unknowns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_unknowns {

using test::CalibrateRig;
using test::small_car_world;
using testing::AllOf;
using testing::HasSubstr;

std::vector<Unknown> read(const char* patch, Errors& errors, std::vector<std::string> chosen = {}) {
  const CalibrateRig rig(small_car_world(patch));
  const auto values = parameters_of(rig.tree, rig.forecaster, errors);
  return read_unknowns(rig.tree, parameter_places(rig.spec, rig.forecaster), values, chosen, errors);
}

std::string why(const char* patch, std::vector<std::string> chosen = {}) {
  Errors errors;
  read(patch, errors, std::move(chosen));
  return errors.empty() ? "nothing" : errors.sorted().front().text();
}

TEST(Unknowns, AreReadWithTheirPriors) {
  Errors errors;
  const auto all =
      read(R"({"unknowns": {"/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log", "high": 40},
      "/plant/effects/steer_offset/params/d0": {"group": "steer", "sigma": "1 deg"},
      "/calibration/delays/yaw": {"group": "clock", "sigma": "50 ms", "low": 0}},
      "calibration": {"delays": {"yaw": 0.02}}})",
           errors);
  ASSERT_TRUE(errors.empty());
  EXPECT_EQ(all[0].prior, 5.0);
  EXPECT_TRUE(all[0].log);
  EXPECT_EQ(all[0].high, 40.0);
  EXPECT_NEAR(all[1].sigma, 0.0174533, 1e-6);
  EXPECT_EQ(all[2].prior, 0.02);
  EXPECT_EQ(all[2].low, 0.0);
  EXPECT_EQ(all.size(), 2u + forecast_parameter_count);  // delays and observer belong to it always
}

TEST(Unknowns, AWorldThatListsNoneLeavesOpenWhatCanBeAGuess) {
  Errors errors;
  std::vector<std::string> pointers;
  for (const Unknown& u : read("{}", errors)) pointers.push_back(u.pointer);
  EXPECT_THAT(pointers, testing::Contains("/plant/params/Bf"));
  EXPECT_THAT(pointers, testing::Contains("/plant/effects/steer_offset/params/d0"));
  EXPECT_THAT(pointers, testing::Not(testing::Contains("/plant/params/m")));
}

/// Above 2 the side force changes its sign at large slip.
TEST(Unknowns, AShapeFactorThatNoWorldListsStaysThatOfATyreOrReachesToItsOwnValue) {
  const auto shape = [](const char* patch) {
    Errors errors;
    const auto all = read(patch, errors, {"/plant/params/Cf"});
    EXPECT_TRUE(errors.empty());
    return all.at(0);
  };
  EXPECT_EQ(shape("{}").low, 1.0);
  EXPECT_EQ(shape("{}").high, 2.0);
  const Unknown sharp = shape(R"({"plant": {"params": {"Cf": 2.5}}})"),
                blunt = shape(R"({"plant": {"params": {"Cf": 0.8}}})");
  EXPECT_EQ(sharp.low, 1.0);
  EXPECT_EQ(sharp.high, 2.5);
  EXPECT_EQ(blunt.low, 0.8);
  EXPECT_EQ(blunt.high, 2.0);
  EXPECT_EQ(shape(R"({"unknowns": {"/plant/params/Cf": {"sigma": 1}}})").high, 10.0);  // the plugin's own range
}

TEST(Unknowns, GroupsAndPointersChoose) {
  Errors errors;
  const auto some = read(R"({"unknowns": {"/plant/params/Bf": {"group": "tyres", "sigma": 1}}})", errors,
                         {"tyres", "/calibration/delays/yaw"});
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some[1].pointer, "/calibration/delays/yaw");
  EXPECT_THAT(why("{}", {"/plant/params/Bff"}), HasSubstr("did you mean \"/plant/params/Bf\"?"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {"group": "tyres", "sigma": 1}}})", {"tires"}),
              HasSubstr("did you mean \"tyres\"?"));
}

TEST(Unknowns, AParameterThatIsNotFittedIsToldWhy) {
  EXPECT_THAT(why("{}", {"/plant/params/m"}),
              AllOf(HasSubstr("the parameter \"/plant/params/m\" is not fitted: a data sheet gives it"),
                    testing::Not(HasSubstr("did you mean"))));
  EXPECT_THAT(
      why(R"({"unknowns": {"/plant/params/Bf": {"sigma": 1}}})", {"/plant/params/Br"}),
      AllOf(HasSubstr("the parameter \"/plant/params/Br\" is not fitted: the world's \"unknowns\" do not list it"),
            testing::Not(HasSubstr("did you mean"))));
}

TEST(Unknowns, WhatIsTheSameMovesTogether) {
  Errors errors;
  auto all = read(R"({"unknowns": {"/calibration/delays/yaw": {"same_as": "/calibration/delays/position"},
      "/calibration/delays/velocity": {"same_as": "/calibration/delays/position"}}})",
                  errors);
  ASSERT_TRUE(errors.empty());
  ASSERT_EQ(all.size(), forecast_parameter_count - 2u);
  const auto leader = std::find_if(all.begin(), all.end(),
                                   [](const Unknown& u) { return u.pointer == "/calibration/delays/position"; });
  ASSERT_NE(leader, all.end());
  ASSERT_EQ(leader->same.size(), 2u);
  std::vector<double> values(leader->same[1].index + 1, 0.25);
  values[leader->index] = 0.5;
  unite(values, all = {*leader});
  EXPECT_EQ(values[all[0].same[0].index], 0.5);
  assign(values, all[0], 0.125);
  EXPECT_EQ(values[all[0].same[1].index], 0.125);
}

/// What is fitted is written to both: the plugin would refuse it.
TEST(Unknowns, WhatIsTheSameHasValuesThatBothCanHave) {
  const auto tied = [](const std::string& leader) {
    return R"({"plant": {"effects": [{"plugin": "throttle_dead_zone"}]}, "unknowns": {"/plant/params/Cf": {)" + leader +
           R"(}, "/plant/effects/throttle_dead_zone/params/z": {"same_as": "/plant/params/Cf"}}})";
  };
  EXPECT_THAT(why(tied(R"("sigma": 0.1)").c_str()),
              AllOf(HasSubstr("the value 1.4 of /plant/params/Cf lies outside of "),
                    HasSubstr("the range of /plant/effects/throttle_dead_zone/params/z, ")));
  Errors errors;
  const auto all = read(tied(R"("sigma": 0.1, "prior": 0.1, "low": 0.01)").c_str(), errors);
  ASSERT_TRUE(errors.empty());
  EXPECT_EQ(all[0].low, 0.01);
  EXPECT_LT(all[0].high, 1.0);
}

TEST(Unknowns, AFollowersNameChoosesItsLeader) {
  Errors errors;
  const auto some = read(R"({"unknowns": {"/calibration/delays/yaw": {"same_as": "/calibration/delays/position"}}})",
                         errors, {"/calibration/delays/yaw"});
  ASSERT_EQ(some.size(), 1u);
  EXPECT_EQ(some[0].pointer, "/calibration/delays/position");
}

TEST(Unknowns, APriorMayLieElsewhereThanTheValue) {
  Errors errors;
  const auto all = read(R"({"unknowns": {"/plant/params/Bf": {"sigma": 1, "prior": 9}}})", errors);
  EXPECT_EQ(all[0].prior, 9.0);  // the world's value is 5
}

TEST(Unknowns, MistakesAreToldAtTheirPlace) {
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {"same_as": "/plant/params/Br"}}})"),
              HasSubstr("not an unknown of this world"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {"sigma": 1},
                                   "/plant/params/Df": {"same_as": "/plant/params/Bf"}}})"),
              HasSubstr("cannot be the same as"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bg": {"sigma": 1}}})"),
              HasSubstr("did you mean \"/plant/params/Bf\"?"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {}}})"), HasSubstr("sigma"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {"sigma": "1 kg"}}})"), HasSubstr("1 kg"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Cd": {"sigma": 1, "scale": "log"}}})"), HasSubstr("above 0"));
  EXPECT_THAT(why(R"({"unknowns": {"/plant/params/Bf": {"sigma": 1, "low": 6}}})"), HasSubstr("lies outside"));
  EXPECT_THAT(why(R"({"calibration": {"delays": {"yaw": 7}}})"), HasSubstr("/calibration/delays/yaw"));
}

TEST(Unknowns, ValuesAreWrittenByIdAndIndexAndIntoWhatIsNotThereYet) {
  Node world = small_car_world();
  set_value(world, "/plant/effects/steer_offset/params/d0", 0.5);
  set_value(world, "/plant/effects/0/params/other", 1);
  set_value(world, "/calibration/observer/gain_yaw", 0.25);
  EXPECT_EQ(find_pointer(world, "/plant/effects/0/params/d0")->number(), 0.5);
  EXPECT_EQ(find_pointer(world, "/plant/effects/0/params/other")->number(), 1.0);
  EXPECT_EQ(find_pointer(world, "/calibration/observer/gain_yaw")->number(), 0.25);
  EXPECT_THROW(set_value(world, "/plant/effects/absent/params/d0", 1), std::invalid_argument);
}

}  // namespace test_unknowns
}  // namespace gripline::calibrate
