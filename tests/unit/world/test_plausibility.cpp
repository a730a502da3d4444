#include "world/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_plausibility {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;

WorldSpec patched(const char* patch, const char* file = "worlds/ethz.json") {
  Node tree = load_world(source_dir() / file);
  Errors errors;
  WorldSpec world = read_world(merge(std::move(tree), json(patch)), plugins(), errors);
  errors.throw_if_any();
  return world;
}

std::vector<std::string> warnings_of(const char* patch, const char* file = "worlds/ethz.json") {
  return plausibility_warnings(patched(patch, file));
}

TEST(Plausibility, NoneOfTheShippedWorlds) {
  int asked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_dir() / "worlds")) {
    if (entry.path().extension() != ".json") continue;
    Errors errors;
    const WorldSpec world = read_world(load_world(entry.path()), plugins(), errors, RoadRule::optional);
    errors.throw_if_any();
    EXPECT_THAT(plausibility_warnings(world), IsEmpty()) << entry.path();
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
  EXPECT_THAT(plausibility_warnings(high), IsEmpty());
  high.points.push_back({1.0, 3.1});
  EXPECT_THAT(plausibility_warnings(high), SizeIs(1));
}

TEST(Plausibility, ARoadOfAnotherScaleThanTheCar) {
  const WorldSpec full_size = patched("{}", "worlds/full_size.json");
  WorldSpec world = patched("{}");
  world.track = full_size.track;  // 1176 m long and 9 m wide, the car 6 cm and 3 cm
  EXPECT_THAT(plausibility_warnings(world),
              ElementsAre(AllOf(HasSubstr("a lap of the road is 1176 m, 19"),
                                HasSubstr(" lengths of the car (0.06 m), more than 10000: are both of one scale? "
                                          "gripline track --scale makes roads smaller or larger")),
                          HasSubstr("the road is at least 9 m wide, 300 widths of the car (0.03 m), more than 40: ")));
  world.car.car.length = world.track->length() / 9999.0;
  world.car.car.width = world.track->narrowest() / 39.0;
  EXPECT_THAT(plausibility_warnings(world), IsEmpty());
}

/// Without a process to ask the plant in, what else there is to say is said.
TEST(Plausibility, WhatCannotBeAskedEndsNothing) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers look at memory through pipes of their own";
#endif
  const WorldSpec world = patched(R"({"car": {"Iz": 27.8e-3}})");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);  // no pipe can be made
  const std::vector<std::string> warnings = plausibility_warnings(world);
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

TEST(Plausibility, LengthsThatNoCarHas) {
  Car car = world_of("{}").car.car;
  EXPECT_THAT(plausibility_warnings(car), IsEmpty());
  car.lf *= 1000.0;
  car.Iz *= 1000.0;
  EXPECT_THAT(plausibility_warnings(car), Contains(HasSubstr("more than the car is long")));
  car.length = 0.004;
  car.width = 60.0;
  EXPECT_THAT(plausibility_warnings(car), AllOf(Contains("length is 0.004 m; cars have 0.01 to 30 m"),
                                                Contains("width is 60 m; cars have 0.01 to 30 m")));
}

}  // namespace test_plausibility
}  // namespace gripline
