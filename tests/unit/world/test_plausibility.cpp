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

std::vector<std::string> warnings_of(const char* patch, const char* file = "worlds/ethz.json") {
  Node tree = load_world(source_dir() / file);
  Errors errors;
  const WorldSpec world = read_world(merge(std::move(tree), json(patch)), plugins(), errors);
  errors.throw_if_any();
  return plausibility_warnings(world);
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
  EXPECT_THAT(warnings_of(R"({"friction": {"points": [{"t": 0, "factor": 70}]}})", "worlds/full_size.json"), SizeIs(2));
}

/// Without a process to ask the plant in, what else there is to say is said.
TEST(Plausibility, WhatCannotBeAskedEndsNothing) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers look at memory through pipes of their own";
#endif
  Node tree = load_world(source_dir() / "worlds/ethz.json");
  Errors errors;
  const WorldSpec world = read_world(merge(std::move(tree), json(R"({"car": {"Iz": 27.8e-3}})")), plugins(), errors);
  errors.throw_if_any();
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
