// A world with an effect more or less: tried while effects are looked for, and written in the end.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "calibrate/effects/candidate_effects.hpp"
#include "calibrate/fit/calibrated_world.hpp"
#include "calibrate/fit/forecast_errors.hpp"

namespace gripline::calibrate {

/// A world with its forecaster and where its parameters stand.
struct Trial {
  Trial(WorldSpec world, const ForecastOptions& options)
      : spec(std::move(world)),
        vehicle(spec.vehicle, context_of(spec)),
        forecaster(vehicle.car(), options),
        places(parameter_places(spec, forecaster)),
        params(forecaster.defaults()) {}
  static PluginContext context_of(const WorldSpec& spec) {
    PluginContext context;
    context.car = spec.car.car;
    return context;
  }
  const ParameterPlace* find(const std::string& pointer) const {
    const auto at = std::ranges::find(places, pointer, &ParameterPlace::pointer);
    return at == places.end() ? nullptr : &*at;
  }

  WorldSpec spec;
  Vehicle vehicle;
  Forecaster forecaster;
  std::vector<ParameterPlace> places;
  std::vector<double> params;
  std::vector<Unknown> unknowns;
  double cost = std::numeric_limits<double>::quiet_NaN();  // of `params`; NaN while nobody has asked
  ForecastErrors validation;                               // on time that was not fitted
};

/// Gives `to` the unknowns of `from` whose parameters it has too.
void take_over_unknowns(Trial& to, const Trial& from);
/// Gives `to` the values of `from` and its unknowns, of the parameters that it has too.
void take_over(Trial& to, const Trial& from);

std::string pointer_of(const std::string& effect, const char* parameter);
Stage stage_of(const PluginSpec& effect, const PluginContext& context);
WorldSpec with_effect(WorldSpec world, const CandidateEffect& effect);
WorldSpec without_effect(WorldSpec world, const std::string& id);
/// What is not known of an effect's parameter before any log is read: a quarter of its range.
Unknown open_parameter(const ParameterPlace& place, double neutral);

/// A world's tree with those effects of `found` that were added.
Node with_effects(Node world, const WorldSpec& found, std::span<const std::string> added);
/// Lists the parameters of effects that were added among a tree's unknowns.
void open_parameters(Node& world, std::span<const std::string> added, std::span<const FittedParameter> parameters);

}  // namespace gripline::calibrate
