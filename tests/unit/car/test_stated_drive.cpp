#include "car/stated_drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"

namespace gripline {
namespace test_stated_drive {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

/// A full-size car that states no drive, changed by a JSON merge patch.
Node heavy_car(std::string_view patch = "{}") {
  return merge(json(R"({"m": 1265, "Iz": 2093, "lf": 1.34, "lr": 1.3, "length": 4.18, "width": 1.84, "d_min": -1,
    "d_max": 1, "delta_max": 0.35, "ddelta_max": 1, "v_ref": 20, "v_min": 2})"),
               json(patch));
}
CarFile read(const Node& car) {
  Errors errors;
  CarFile file = read_car(car, errors);
  errors.throw_if_any();
  return file;
}
/// What is wrong with this model of that car; "nothing" if it is good.
std::string why(const Node& car, std::string_view model) {
  return refusal([&] {
    Errors errors;
    read_vehicle(json(model), plugins(), read(car), "rk4", errors);
    errors.throw_if_any();
  });
}

TEST(StatedDrive, ACarWithTheDriveOfASmallOneIsRefused) {
  const std::string message = why(heavy_car(), R"({"plugin": "dynamic"})");
  EXPECT_THAT(
      message,
      AllOf(HasSubstr("/known_params: at full throttle this car accelerates by 0.00014 m/s2 at 2 m/s, expected "
                      "at least 0.05"),
            HasSubstr("(Cm1, Cm2); state them here (example: worlds/cars/full_size.json)"), Not(HasSubstr("\n"))));
  for (const char* model : {"kinematic", "ekinematic"})
    EXPECT_EQ(why(heavy_car(), std::string(R"({"plugin": ")") + model + "\"}"), message) << model;
  EXPECT_THAT(why(heavy_car(R"({"known_params": {}})"), R"({"plugin": "dynamic"})"),
              HasSubstr("/known_params: at full throttle"));
}

/// Brakes, resistance and tyres are no drive, and no effect makes one of too little.
TEST(StatedDrive, WhatDoesNotDriveStatesNoDrive) {
  EXPECT_THAT(why(heavy_car(R"({"known_params": {"Cb": 8000, "Cr0": 50, "Cd": 0.5}})"), R"({"plugin": "dynamic"})"),
              HasSubstr("expected at least 0.05"));
  EXPECT_THAT(why(heavy_car(), R"({"plugin": "dynamic", "params": {"Df": 6000, "Dr": 6000},
                                   "effects": [{"plugin": "motor_lag", "params": {"tau": 0.1}}]})"),
              HasSubstr("expected at least 0.05"));
}

TEST(StatedDrive, AStatedOneIsMeant) {
  EXPECT_EQ(why(heavy_car(R"({"known_params": {"Cm1": 7650}})"), R"({"plugin": "dynamic"})"), "nothing");
  EXPECT_EQ(why(heavy_car(), R"({"plugin": "dynamic", "params": {"Cm1": 7650}})"), "nothing");
  EXPECT_EQ(why(heavy_car(), R"({"plugin": "dynamic", "params": {"Cm1": 0}})"), "nothing");
  EXPECT_EQ(why(heavy_car(R"({"known_params": {"Cm1": 0}})"), R"({"plugin": "ekinematic"})"), "nothing");
  EXPECT_EQ(why(load_json(source_dir() / "worlds/cars/full_size.json"), R"({"plugin": "ekinematic"})"), "nothing");
}

/// The defaults are those of a 1:43 car.
TEST(StatedDrive, DefaultsThatDriveTheCarAreGood) {
  EXPECT_EQ(why(heavy_car(R"({"m": 0.041, "Iz": 27.8e-6})"), R"({"plugin": "dynamic"})"), "nothing");
}

/// What is wrong with the car is told, not what would follow from it.
TEST(StatedDrive, OfACarThatIsNotReadNothingIsSaid) {
  Errors errors;
  const CarFile car = read_car(heavy_car(R"({"lf": "3 kg"})"), errors);
  EXPECT_FALSE(car.known_at.has_value());
  const std::size_t before = errors.size();
  read_vehicle(json(R"({"plugin": "dynamic"})"), plugins(), car, "rk4", errors);
  EXPECT_EQ(errors.size(), before);
}

}  // namespace test_stated_drive
}  // namespace gripline
