// A car composed in JSON: a vehicle model and its effects, as a world's plant or a stack's nominal model.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "car/corrected_model.hpp"
#include "plugin/plugin_spec.hpp"

namespace gripline {

/// What a car file says: constants for everybody, and model parameters that are known of this car (its drive, never its
/// tyres). Model parameters called m, Iz, lf, lr are known from the constants.
struct CarFile {
  Car car;
  KnownParams known;
  bool substeps_by_error = true;   // of a world's control step (World); false: exactly as many as stated
  std::optional<Origin> known_at;  // where `known` is written, or would be; empty where the car was not read well
};
CarFile read_car(const Node& node, Errors& errors);
/// Adds what stands under "known_params" of that object, if anything does: numbers in SI by name.
void read_known_params(ObjectReader& car, KnownParams& known, Errors& errors);
/// Refuses "known_params" that no vehicle model and no plant of the registry declares: nothing would read them.
void check_known_params(const Node& car, const Registry& registry, Errors& errors);

/// {"plugin", "params", "effects": [{"plugin", "params"}...], "integrator", "substeps"}.
struct VehicleSpec {
  PluginSpec model;
  std::vector<PluginSpec> effects;
  Node effects_read;  // their list as it is written, whatever becomes of `effects`; null where there is none
  Integration integration;
};
/// What becomes of readings of this car: a world's sensors show them; a stack predicts states with its model and asks
/// for no readings, so that an effect of Stage::reading would do nothing there and is refused.
enum class Readings { shown, unread };
/// Refuses also a model that does not get its car going because nobody stated its drive (check_drive).
/// `integrator`: the method when the JSON names none.
VehicleSpec read_vehicle(const Node& node, const Registry& registry, const CarFile& car, const char* integrator,
                         Errors& errors, Readings readings = Readings::shown);

/// Owns the instances behind a StagedCar.
class Vehicle {
 public:
  /// The spec must outlive the vehicle. `first`, which may be null, is an effect with one parameter, initially 1; it
  /// acts before the vehicle's own effects if the model has its stage.
  Vehicle(const VehicleSpec& spec, const PluginContext& context, const Effect* first = nullptr);
  const StagedCar& car() const { return car_; }
  /// The car without those of its effects that have memory.
  const StagedCar& car_without_memory() const { return memoryless_; }
  /// The model with its first `effects` effects.
  StagedCar car_with(std::size_t effects) const;
  /// The model with `first` and those of its own effects that are wanted.
  StagedCar car_of(const std::function<bool(const Effect&)>& wanted) const;
  bool has_stage(Stage stage) const { return (model_->stages() & stage_bit(stage)) != 0; }

 private:
  const VehicleSpec* spec_;
  Instance<VehicleModel> model_;
  const Effect* first_;
  std::vector<Instance<Effect>> effects_;
  StagedCar car_, memoryless_;
};

}  // namespace gripline
