// A world with an effect more or less: tried while effects are looked for, and written in the end.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/effects/candidate_effects.hpp"
#include "calibrate/fit/calibrated_world.hpp"
#include "calibrate/fit/forecast_errors.hpp"
#include "calibrate/forecast/forecaster.hpp"
#include "plugin/registry.hpp"
#include "util/numbers.hpp"
#include "world/world_spec.hpp"

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
  double cost = not_a_number;  // of `params`; NaN: not evaluated
  ForecastErrors validation;   // on time that was not fitted
};

/// What a trial has more than the world that it began from: an effect, or a parameter that was not to be fitted.
struct Addition {
  std::string name;     // of the effect, or of both: "steer_map.a"
  std::string pointer;  // of the parameter, or of the effect's parameters, without their names
  bool opened = false;  // whether it is a parameter
  SteeringAsymmetry asymmetry = SteeringAsymmetry::none;
  bool owns(const std::string& parameter) const {
    return opened ? parameter == pointer : parameter.starts_with(pointer);
  }
};
/// A whole effect more.
Addition added_effect(const std::string& id, SteeringAsymmetry asymmetry = SteeringAsymmetry::none);
/// What fitting a candidate adds to a trial for whose car it was made.
Addition addition_of(const CandidateEffect& candidate, const Trial& base);

/// Effects that a trial's car lacks, and idle parameters of those that it has, unless the trial fits them or they are
/// among `known`.
std::vector<CandidateEffect> candidates_beside(const Trial& base, const Registry& registry,
                                               std::span<const FittedParameter> known);

/// Gives `to` the unknowns of `from` whose parameters it has too.
void take_over_unknowns(Trial& to, const Trial& from);
/// Gives `to` the values of `from` and its unknowns, of the parameters that it has too.
void take_over(Trial& to, const Trial& from);

std::string pointer_of(const std::string& effect, const char* parameter);
Stage stage_of(const PluginSpec& effect, const PluginContext& context);
/// The world with a candidate's effect at its numbers; as it is where the candidate is listed.
WorldSpec with_effect(WorldSpec world, const CandidateEffect& effect);
WorldSpec without_effect(WorldSpec world, const std::string& id);
/// What is not known of an effect's parameter before any log is read: a quarter of its range.
Unknown open_parameter(const ParameterPlace& place, double neutral);

/// A world's tree with those effects of `found` that were added.
Node with_effects(Node world, const WorldSpec& found, std::span<const Addition> added);
/// Lists the parameters of what was added among a tree's unknowns, with their ranges. What the logs determine gets a
/// width from session to session: its standard error (of the blocks drawn, few blocks widening it) times the root of
/// the number of sessions fitted, which is how far apart the values of single sessions may lie; at most its `sigma`.
void open_parameters(Node& world, std::span<const Addition> added, std::span<const FittedParameter> parameters,
                     std::size_t sessions);

}  // namespace gripline::calibrate
