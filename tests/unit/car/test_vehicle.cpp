#include "car/vehicle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/host_support.hpp"
#include "world/friction_factor.hpp"

namespace gripline {
namespace test_vehicle {

using testing::HasSubstr;
using namespace testing_support;

CarFile car_of(std::string_view patch = "{}") {
  const Node base = json(R"({"m": "41 g", "Iz": 27.8e-6, "lf": "29 mm", "lr": "33 mm", "length": 0.06, "width": 0.03,
    "d_min": -0.1, "d_max": 1, "delta_max": "20 deg", "ddelta_max": 5, "v_ref": "7.2 km/h", "v_min": 0.3,
    "known_params": {"Cm1": 0.287}})");
  Errors errors;
  const CarFile car = read_car(merge(base, json(patch)), errors);
  errors.throw_if_any();
  return car;
}
VehicleSpec vehicle_of(const char* text) {
  Errors errors;
  VehicleSpec spec = read_vehicle(json(text), plugins(), car_of(), "rk4", errors);
  errors.throw_if_any();
  return spec;
}
std::string why_car(const char* patch) {
  return refusal([&] { car_of(patch); });
}

TEST(CarFile, IsReadWithUnits) {
  const CarFile file = car_of();
  EXPECT_DOUBLE_EQ(file.car.m, 0.041);
  EXPECT_DOUBLE_EQ(file.car.lf, 0.029);
  EXPECT_NEAR(file.car.delta_max, 20 * std::numbers::pi / 180, 1e-15);
  EXPECT_DOUBLE_EQ(file.car.v_ref, 2);
  EXPECT_EQ(file.known.at("m"), 0.041);
  EXPECT_EQ(file.known.at("lr"), 0.033);
  EXPECT_EQ(file.known.at("Cm1"), 0.287);
}

TEST(CarFile, RefusalsSayWhatAndWhere) {
  EXPECT_THAT(why_car(R"({"m": null})"), HasSubstr("/m: missing, expected a mass [kg]"));
  EXPECT_THAT(why_car(R"({"m": 0})"), HasSubstr("/m: 0 is out of range"));
  EXPECT_THAT(why_car(R"({"lf": "29 kg"})"), HasSubstr("\"29 kg\" is a mass, expected a length [m]"));
  EXPECT_THAT(why_car(R"({"d_min": 0.1})"), HasSubstr("/d_min: 0.1 is out of range"));
  EXPECT_THAT(why_car(R"({"delta_max": 2})"), HasSubstr("/delta_max: 2 is out of range"));
  EXPECT_THAT(why_car(R"({"wheels": 4})"), HasSubstr("unknown key \"wheels\""));
  EXPECT_THAT(why_car(R"({"known_params": {"Cm1": "much"}})"), HasSubstr("/known_params/Cm1: expected a number in SI"));
}

TEST(CarFile, WhatNoCarCanBeIsRefused) {
  EXPECT_THAT(why_car(R"({"m": 1e300})"),
              HasSubstr("/m: 1e+300 is out of range: expected a mass [kg] above 0 kg and below"));
  EXPECT_THAT(why_car(R"({"m": "10000 t"})"), HasSubstr("/m: "));
  EXPECT_THAT(why_car(R"({"lf": 1050})"), HasSubstr("/lf: 1050 is out of range"));
}

TEST(CarFile, KnownParametersAreThoseOfModels) {
  const auto why_known = [](const char* text) {
    Errors errors;
    check_known_params(json(text), plugins(), errors);
    return refusal([&] { errors.throw_if_any(); });
  };
  EXPECT_EQ(why_known(R"({"known_params": {"note": "its drive", "Cm1": 0.287, "Df": 0.2}})"), "nothing");
  EXPECT_EQ(why_known(R"({"m": 3})"), "nothing");
  EXPECT_THAT(why_known(R"({"known_params": {"Cm3": 0.287}})"),
              testing::AllOf(HasSubstr("/known_params/Cm3: no vehicle model and no plant has a parameter \"Cm3\""),
                             HasSubstr("did you mean \"Cm")));
}

TEST(Vehicle, IsAModelItsEffectsAndAnIntegrator) {
  const VehicleSpec spec =
      vehicle_of(R"({"plugin": "dynamic", "params": {"Df": 0.2}, "integrator": "rk6", "substeps": 3,
    "effects": [{"plugin": "steer_lag", "params": {"tau": "40 ms"}}, {"plugin": "aero_drag", "params": {"a": 0.4}},
                {"plugin": "relaxation"}]})");
  EXPECT_EQ(spec.model.id(), "dynamic");
  EXPECT_EQ(spec.integration.tableau->name, "rk6");
  EXPECT_EQ(spec.integration.substeps, 3);
  PluginContext context;
  context.car = car_of().car;
  const Vehicle vehicle(spec, context);
  EXPECT_EQ(vehicle.car().effects(), 3u);
  EXPECT_EQ(vehicle.car().memory(), 3);
  EXPECT_EQ(vehicle.car().params()[vehicle.car().param_offset(0)], 0.04);
  EXPECT_EQ(vehicle.car().params()[vehicle.car().param_offset(1)], 0.4);
  EXPECT_EQ(vehicle.car_without_memory().effects(), 1u);
  EXPECT_EQ(vehicle.car_without_memory().memory(), 0);
  EXPECT_EQ(vehicle.car_without_memory().params().back(), 0.4);
  EXPECT_TRUE(vehicle.has_stage(Stage::tyre));
}

TEST(Vehicle, ACarOfSomeEffectsKeepsTheFirstOne) {
  const VehicleSpec spec = vehicle_of(R"({"plugin": "dynamic", "effects": [
    {"plugin": "steer_gain", "params": {"k": 0.1}}, {"plugin": "aero_drag", "params": {"a": 0.4}}]})");
  PluginContext context;
  context.car = car_of().car;
  const FrictionFactor friction;
  const Vehicle vehicle(spec, context, &friction);
  const StagedCar car = vehicle.car_of([](const Effect& effect) { return effect.stage() == Stage::body; });
  EXPECT_EQ(car.effects(), 2u);
  EXPECT_EQ(car.params()[car.param_offset(0)], 1.0);
  EXPECT_EQ(car.params()[car.param_offset(1)], 0.4);
}

TEST(Vehicle, WithoutAWordTheIntegratorIsTheCallersChoice) {
  EXPECT_EQ(vehicle_of(R"({"plugin": "ekinematic"})").integration.tableau->name, "rk4");
  EXPECT_EQ(vehicle_of(R"({"plugin": "ekinematic"})").integration.substeps, 1);
}

TEST(Vehicle, AnEffectOnAStageTheModelLacksIsRefusedWithThatReason) {
  EXPECT_THAT(
      refusal([] {
        vehicle_of(R"({"plugin": "ekinematic", "effects": [{"plugin": "aero_drag"}, {"plugin": "friction_scale"}]})");
      }),
      HasSubstr("/effects/1: effect \"friction_scale\" acts on the tyre stage, which this model does not have"));
}

/// Text where an object is asked, or no name: an error with a place, also where an earlier reader found the same one.
TEST(Vehicle, ASlipIsAnErrorAndNothingElse) {
  for (const char* text : {R"("dynamic")", R"({"plugin": ""})", R"({"plugin": "dynamic", "effects": [""]})",
                           R"({"plugin": "dynamic", "effects": [{"plugin": ""}]})", R"({"plugin": 3})", "[]", "null"}) {
    Errors errors;
    const Node node = json(text);
    for (int again = 0; again < 2; ++again) read_vehicle(node, plugins(), car_of(), "rk4", errors);
    EXPECT_FALSE(errors.empty()) << text;
    for (const Diagnostic& one : errors.sorted()) EXPECT_THAT(one.text(), testing::StartsWith("test:1:")) << text;
  }
}

/// An effect whose constructor ends its process is the run's affair: reading the file ends nothing.
TEST(Vehicle, AConstructorThatCrashesDoesNotEndTheReader) {
  EXPECT_EQ(vehicle_of(R"({"plugin": "dynamic", "effects": [{"plugin": "fault.crashes_at_start"}]})").effects.size(),
            1u);
}

TEST(Vehicle, RefusalsSayWhatAndWhere) {
  const auto why = [](const char* text) { return refusal([&] { vehicle_of(text); }); };
  EXPECT_THAT(why(R"({"plugin": "dynamic", "integrator": "rk5"})"),
              HasSubstr("/integrator: expected \"euler\", \"heun\", \"rk4\", \"rkf5\" or \"rk6\", found \"rk5\""));
  EXPECT_THAT(why(R"({"plugin": "dynamic", "substeps": 0})"), HasSubstr("/substeps: expected a whole number"));
  EXPECT_THAT(why(R"({"plugin": "dynamic", "effects": {}})"), HasSubstr("/effects: expected an array"));
  EXPECT_THAT(why(R"({"plugin": "dynamic", "effects": [{"plugin": "aero_drag", "parms": {}}]})"),
              HasSubstr("/effects/0/parms: unknown key \"parms\"; did you mean \"params\"?"));
  EXPECT_THAT(why(R"({"plugin": "dynamic", "efects": []})"),
              HasSubstr("unknown key \"efects\"; did you mean \"effects\"?"));
  EXPECT_THAT(why(R"({"plugin": "aero_drag"})"),
              HasSubstr("no vehicle plugin \"aero_drag\"; \"aero_drag\" is of kind effect"));
}

}  // namespace test_vehicle
}  // namespace gripline
