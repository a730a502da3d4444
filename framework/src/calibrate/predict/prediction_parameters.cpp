#include "calibrate/predict/prediction_parameters.hpp"

#include "calibrate/fit/calibrated_world.hpp"
#include "config/errors.hpp"

namespace gripline::calibrate {

ForecastOptions prediction_options(const WorldSpec& world) {
  ForecastOptions options = forecast_options(world);
  options.lanes = 1;  // lanes that move together take the steps of the slowest: later rows would touch a rounding
  return options;
}

PredictionParameters prediction_parameters(const Node& tree, const WorldSpec& world, const measured::LogMap& map,
                                           const Forecaster& forecaster) {
  Errors errors;
  PredictionParameters out;
  std::vector<double>& values = out.values = parameters_of(tree, forecaster, errors);
  if (const auto weighing = session_weighing(tree); weighing && tree.find("unknowns") != nullptr) {
    const auto places = parameter_places(world, forecaster);
    out.moving = session_unknowns(read_unknowns(tree, places, values, {}, errors));
    out.weighing = *weighing;
  }
  errors.throw_if_any();
  if (tree.find("calibration") != nullptr) return out;
  values[forecaster.index(ForecastParameter::gain_force)] = 0.0;
  values[forecaster.index(ForecastParameter::gain_steer)] = 0.0;
  for (std::size_t g = 0; g < measured::delay_groups; ++g)
    if (const auto stated = map.delay(g)) values[forecaster.index(ForecastParameter::delay_position) + g] = *stated;
  return out;
}

}  // namespace gripline::calibrate
