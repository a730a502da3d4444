#include "world/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "support/host_support.hpp"
#include "support/paths.hpp"
#include "world/friction_file.hpp"

namespace gripline {
namespace test_plausibility {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;

struct Patched {
  Node tree;
  WorldSpec world;
};

Patched patched(const char* patch, const char* file = "worlds/ethz.json") {
  Patched all{merge(load_world(source_dir() / file), json(patch)), {}};
  Errors errors;
  all.world = read_world(all.tree, plugins(), errors);
  errors.throw_if_any();
  return all;
}

std::vector<std::string> messages(const std::vector<Diagnostic>& warnings) {
  std::vector<std::string> texts;
  for (const Diagnostic& one : warnings) texts.push_back(one.message);
  return texts;
}

std::vector<std::string> warnings_of(const char* patch, const char* file = "worlds/ethz.json") {
  const Patched all = patched(patch, file);
  return messages(plausibility_warnings(all.world, all.tree));
}

TEST(Plausibility, NoneOfTheShippedWorlds) {
  int asked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_dir() / "worlds")) {
    if (entry.path().extension() != ".json") continue;
    Errors errors;
    const Node tree = load_world(entry.path());
    const WorldSpec world = read_world(tree, plugins(), errors, RoadRule::optional);
    errors.throw_if_any();
    EXPECT_THAT(messages(plausibility_warnings(world, tree)), IsEmpty()) << entry.path();
    ++asked;
  }
  ASSERT_GT(asked, 0);
}

TEST(Plausibility, AGripThatNoTyreHas) {
  EXPECT_THAT(
      warnings_of(R"({"car": {"m": 41e-6, "Iz": 27.8e-9}})"),
      AllOf(Contains(HasSubstr("the front axle's peak lateral force is")), Contains(HasSubstr("the rear axle's"))));
  EXPECT_THAT(warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 1}, {"t": 9, "factor": 70}]}})"),
              Contains(HasSubstr("at friction factor 70; tyres have about 0.05 to 5")));
  EXPECT_THAT(warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 1}, {"t": 9, "factor": 0.5}]}})"), IsEmpty());
  EXPECT_THAT(warnings_of(R"({"plant": {"params": {"Df": 192, "Dr": 173.7}}})"), SizeIs(2));
  EXPECT_THAT(warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 70}]}})", "worlds/full_size.json"),
              SizeIs(3));  // and one of the factor
}

TEST(Plausibility, AFactorThatNoRoadHas) {
  EXPECT_THAT(
      warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 1}, {"t": 9, "factor": 100}]}})"),
      Contains(
          "the friction factor reaches 100; 1 is the fresh road, and factors above 3 exceed any real road's: is it "
          "in percent?"));
  EXPECT_THAT(warnings_of(R"({"friction": {"patches": [{"from_s": 1, "to_s": 2, "factor": 3.5}]}})"),
              Contains(HasSubstr("the friction factor reaches 3.5;")));
  EXPECT_THAT(warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 1.5}]}})"), IsEmpty());
  FrictionSpec high;
  high.points = {{0.0, 3.0}};
  EXPECT_THAT(plausibility_warnings(high, Node()), IsEmpty());
  high.points.push_back({1.0, 3.1});
  EXPECT_THAT(plausibility_warnings(high, Node()), SizeIs(1));
}

TEST(Plausibility, ARoadOfAnotherScaleThanTheCar) {
  const WorldSpec full_size = patched("{}", "worlds/full_size.json").world;
  auto [tree, world] = patched("{}");
  world.track = full_size.track;  // 1176 m long and 9 m wide, the car 6 cm and 3 cm
  EXPECT_THAT(messages(plausibility_warnings(world, tree)),
              ElementsAre(AllOf(HasSubstr("a lap of the road is 1176 m, 19"),
                                HasSubstr(" lengths of the car (0.06 m), more than 10000: are both of one scale? "
                                          "gripline track --scale makes roads smaller or larger")),
                          HasSubstr("the road is at least 9 m wide, 300 widths of the car (0.03 m), more than 40: ")));
  world.car.car.length = world.track->length() / 9999.0;
  world.car.car.width = world.track->narrowest() / 39.0;
  EXPECT_THAT(plausibility_warnings(world, tree), IsEmpty());
}

/// Without a process to ask the plant in, what else there is to say is said.
TEST(Plausibility, WhatCannotBeAskedEndsNothing) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers look at memory through pipes of their own";
#endif
  const auto [tree, world] = patched(R"({"car": {"Iz": 27.8e-3}})");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);  // no pipe can be made
  const std::vector<std::string> warnings = messages(plausibility_warnings(world, tree));
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_THAT(
      warnings,
      ElementsAre(HasSubstr("within a factor of 10"),
                  HasSubstr("cannot tell whether the axles' peak lateral forces are those of tyres: no pipe: ")));
}

TEST(Plausibility, AnInertiaThatMassAndAxlesCannotHave) {
  EXPECT_THAT(warnings_of(R"({"car": {"Iz": 27.8e-8}})"), ElementsAre(HasSubstr("Iz is 0.007085 times m lf lr")));
  EXPECT_THAT(warnings_of(R"({"car": {"Iz": 27.8e-3}})"), ElementsAre(HasSubstr("within a factor of 10")));
}

TEST(Plausibility, NoiseWiderThanTheRoad) {
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"x": 2e9}}})"), ElementsAre(HasSubstr("sigma of x is 2e+09 m")));
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"x": "2 cm"}}})"), IsEmpty());
}

/// Readings that no sensor of this car shows, mostly degrees that were meant.
TEST(Plausibility, NoiseAndBiasBeyondTheCar) {
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"yaw": 5}}})"),
              ElementsAre("the sensors' sigma of yaw is 5 rad, more than 0.5 rad; degrees are written \"5 deg\""));
  EXPECT_THAT(warnings_of(R"({"sensors": {"bias": {"yaw": "-5 rad"}}})"), ElementsAre(HasSubstr("bias of yaw is -5")));
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"yaw_rate": 6}}})"),
              ElementsAre(AllOf(HasSubstr("sigma of yaw_rate is 6 rad/s, more than a car turns at 1 g"),
                                HasSubstr("(4.905 rad/s); degrees are written \"6 deg/s\""))));
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"vx": 2.5}, "bias": {"vy": -3, "y": 7}}})"),
              ElementsAre(HasSubstr("bias of y is 7 m, more than the road is wide"),
                          HasSubstr("sigma of vx is 2.5 m/s, more than the car's typical speed v_ref (2 m/s)"),
                          HasSubstr("bias of vy is -3 m/s, more than the car's typical speed")));
  EXPECT_THAT(warnings_of(R"({"sensors": {"sigma": {"yaw": "5 deg", "yaw_rate": "5 deg/s", "vx": 0.05, "vy": 0.05},
                                          "bias": {"yaw": "2 deg", "vx": 0.1}}})"),
              IsEmpty());
}

TEST(Plausibility, EachSaysWhereItIsWritten) {
  const auto [tree, world] = patched(R"({
    "car": {"Iz": 27.8e-8}, "sensors": {"sigma": {"yaw": 5}}, "plant": {"params": {"Df": 19, "Dr": 17}},
    "friction": {"points": [{"t": 0, "factor": 1}, {"t": 9, "factor": 4}]}})");
  std::vector<std::string> places;
  for (const Diagnostic& one : plausibility_warnings(world, tree)) places.push_back(one.pointer);
  EXPECT_THAT(places, ElementsAre("/car/Iz", "/friction/points/1/factor", "/plant", "/plant", "/sensors/sigma/yaw"));
  const Node list = json(R"([{"t": 0, "factor": 5}, {"t": 1, "factor": 1}])");
  Errors errors;
  const std::vector<Diagnostic> high = plausibility_warnings(read_friction(list, errors), list);
  ASSERT_THAT(high, SizeIs(1));
  EXPECT_EQ(high[0].pointer, "/0/factor");
  EXPECT_GT(high[0].line, 0);
}

TEST(Plausibility, LengthsThatNoCarHas) {
  Car car = world_of("{}").car.car;
  EXPECT_THAT(plausibility_warnings(car, Node()), IsEmpty());
  car.lf *= 1000.0;
  car.Iz *= 1000.0;
  EXPECT_THAT(messages(plausibility_warnings(car, Node())), Contains(HasSubstr("more than the car is long")));
  car.length = 0.004;
  car.width = 60.0;
  EXPECT_THAT(messages(plausibility_warnings(car, Node())), AllOf(Contains("length is 0.004 m; cars have 0.01 to 30 m"),
                                                                  Contains("width is 60 m; cars have 0.01 to 30 m")));
}

}  // namespace test_plausibility
}  // namespace gripline
