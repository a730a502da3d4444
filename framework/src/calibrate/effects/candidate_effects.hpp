// Effects that a world's car lacks, and a score test of what each would take off the prediction errors.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/fit/prediction_errors.hpp"

namespace gripline::calibrate {

/// How an effect of the commands makes the wheels' angle differ between left and right.
enum class SteeringAsymmetry {
  none,
  offset,  // it turns wheels that point straight ahead
  curve,   // not those, but others further to one side than to the other
};

/// An effect that is not in the car, at values at which it does nothing; or a parameter of one that is, which does
/// nothing at the value it has there.
struct CandidateEffect {
  const PluginEntry* entry = nullptr;
  Instance<Effect> effect{nullptr, nullptr};
  std::vector<double> numbers;      // of all its parameters
  std::vector<double> low, high;    // how far each of them may go
  std::vector<std::size_t> tested;  // parameters whose derivatives there say something
  std::vector<std::size_t> open;    // parameters that a fit may move
  /// Of a parameter of an effect in the car: where it stands among the car's. A trial opens it and adds no effect.
  std::optional<std::size_t> listed;
  SteeringAsymmetry asymmetry = SteeringAsymmetry::none;
  std::string id() const { return entry->decl->id; }
};

/// Every effect of the registry that the car lacks, that its model has a stage for and that has a value at which it
/// does nothing. Left out: effects that need truth, tables, effects with memory (none of their values is neutral),
/// delays of commands (all channels later together are the same), what changes the car's mass or centre of gravity,
/// which are known, and, without a road, effects of place.
std::vector<CandidateEffect> candidate_effects(const VehicleSpec& vehicle, const Car& car, const Registry& registry,
                                               bool road);

/// Parameters of effects in the car that do nothing at the values they have there, and something elsewhere when the
/// effect's others do nothing, each a candidate by itself: those of the effects that candidate_effects() would give if
/// the car had them not, and that it has once. Their effects are as the car has them.
std::vector<CandidateEffect> idle_parameters(const VehicleSpec& vehicle, const Car& car, bool road);

/// What one effect more would do, to first order, the fitted parameters moving along.
struct EffectScore {
  std::size_t candidate = 0;
  double gain = 0;            // relative decrease of the squared errors
  double score = 0;           // in standard deviations over blocks
  double apart = 0;           // share of its information that the fitted parameters do not stand for
  std::vector<double> value;  // of its tested parameters, inside their ranges
  Eigen::VectorXd move;       // of the fitted ones, in their own units
};

/// One per candidate that the fitted parameters do not already stand for. `params`: all of a forecaster of `car`;
/// `fitted`: those of them that move.
std::vector<EffectScore> score_candidates(const StagedCar& car, std::span<const CandidateEffect> candidates,
                                          const ForecastOptions& forecast, std::vector<FitLog>& logs,
                                          std::span<const double> params, std::span<const Unknown> fitted,
                                          const Weighing& weighing);

}  // namespace gripline::calibrate
