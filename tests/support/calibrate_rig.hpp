// A 1:10 car for tests of calibration: its world in JSON, its model, and logs of it.
#pragma once

#include "calibrate/fit/calibrated_world.hpp"
#include "config/merge_patch.hpp"
#include "support/host_support.hpp"
#include "support/weaving_car.hpp"

namespace gripline::test {

inline Node small_car_world(std::string_view patch = "{}") {
  Node world = testing_support::json(R"({
    "car": {"m": 1.6, "Iz": 0.01, "lf": 0.08, "lr": 0.09, "length": 0.25, "width": 0.13, "d_min": -1, "d_max": 1,
            "delta_max": 0.5, "ddelta_max": 10, "v_ref": 2, "v_min": 0.3},
    "dt": "20 ms", "input_hold": "foh",
    "plant": {"plugin": "dynamic",
      "params": {"Bf": 5, "Cf": 1.4, "Df": 6, "Br": 7, "Cr": 1.4, "Dr": 6, "Cm1": 12, "Cm2": 2, "Cr0": 1, "Cd": 0},
      "effects": [{"plugin": "steer_offset", "params": {"d0": 0}}]}})");
  return merge(world, testing_support::json(patch));
}

/// A world read, its car and a forecaster for it.
struct CalibrateRig {
  explicit CalibrateRig(Node world = small_car_world())
      : tree(std::move(world)),
        spec(read(tree)),
        vehicle(spec.vehicle, context(spec)),
        forecaster(vehicle.car(), options(spec)) {}

  static WorldSpec read(const Node& tree) {
    Errors errors;
    WorldSpec spec = read_world(tree, testing_support::plugins(), errors, RoadRule::optional);
    errors.throw_if_any();
    return spec;
  }
  static PluginContext context(const WorldSpec& spec) {
    PluginContext context;
    context.car = spec.car.car;
    return context;
  }
  static calibrate::ForecastOptions options(const WorldSpec& spec) {
    auto options = calibrate::forecast_options(spec);
    options.lanes = 1;
    return options;
  }

  std::vector<double> predict(const measured::Session& session, const std::vector<double>& params,
                              const calibrate::Starts& starts) const {
    std::vector<double> out;
    forecaster.run<double>(session, measured::CommandGrid(session, 0.02), nullptr, params, starts, out);
    return out;
  }

  Node tree;
  WorldSpec spec;
  Vehicle vehicle;
  calibrate::Forecaster forecaster;
};

}  // namespace gripline::test
