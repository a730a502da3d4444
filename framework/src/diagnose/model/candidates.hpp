// The nominal car and every effect that may be missing from it, as instances ready to be combined.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "car/effect_order.hpp"
#include "car/staged_car.hpp"
#include "car/vehicle.hpp"
#include "diagnose/model/pose_latency.hpp"
#include "plugin/registry.hpp"

namespace gripline::diagnose {

/// An effect plugin with at least one parameter to fit.
struct Candidate {
  std::string id;
  const PluginEntry* entry = nullptr;
  Instance<Effect> effect{nullptr, nullptr};
  std::vector<double> defaults;     // every parameter; those to fit at their start
  std::vector<std::size_t> fitted;  // indices of the parameters to fit
  bool excluded = false;            // must not be named
  /// It has memory or a delay: its derivative at the neutral value is a limit, approximated by a secant.
  bool dynamic = false;
  /// Which fitted parameters only shape what the others do: at neutral values nothing depends on them, wherever the car
  /// is and however it drives (shape_parameters.hpp).
  std::vector<std::size_t> shapes;
  std::size_t strength = 0;  // the first fitted parameter that is not a shape
  const abi::ParamDecl& decl(std::size_t fit) const { return entry->decl->params[fitted[fit]]; }
};

/// A parameter of the nominal model that is known only to within a standard deviation.
struct Nuisance {
  std::string name;       // of the model's parameter
  std::size_t index = 0;  // among the built car's
  double nominal = 0, sigma = 0;
  /// What is left of a delay that was taken off a pose, in place of a parameter of the car: its channels' group
  /// (measured::delay_names).
  std::optional<std::size_t> delay{};
};

/// Which effects are in the model and with what values.
struct ModelSpec {
  std::vector<std::size_t> members;         // candidates, in chain order
  std::vector<std::vector<double>> values;  // all parameters of each member
  std::vector<double> nuisance;             // values of the nuisance parameters

  std::size_t position(std::size_t candidate) const;  // among members; members.size() when absent
  bool has(std::size_t candidate) const { return position(candidate) < members.size(); }
};

/// The nominal car of a world, its own effects included, and all candidates. Immutable after construction.
class Catalogue {
 public:
  /// `exclude`: ids of effects that must not be named; unknown ids are ignored. The registry must outlive it.
  Catalogue(const VehicleSpec& nominal, const Car& car, const Registry& registry, std::span<const std::string> exclude);

  std::span<const Candidate> candidates() const { return candidates_; }
  std::size_t find(std::string_view id) const;  // candidates().size() when unknown
  const Car& car() const { return car_; }
  const VehicleModel& model() const { return *model_; }

  void set_nuisances(std::vector<Nuisance> nuisances) { nuisances_ = std::move(nuisances); }
  /// From now on place (group 0) or heading (1) are later by this than was taken off the logs, known to within a
  /// standard deviation [s]. Each group once.
  void allow_for_late_pose(std::size_t group, double seconds, double sigma);
  /// As it was before.
  void forget_late_pose();
  std::span<const Nuisance> nuisances() const { return nuisances_; }
  /// Value of a parameter of the nominal model by name; NaN when it has none of that name.
  double nominal(std::string_view name, std::size_t* index = nullptr) const;

  /// The model without any candidate, nuisances at their nominal values.
  ModelSpec null_model() const;
  /// The model with one more effect at its start values.
  ModelSpec with(const ModelSpec& model, std::size_t candidate) const;
  ModelSpec without(const ModelSpec& model, std::size_t candidate) const;
  /// Ids of the world's own effects that have hidden states, as the world lists them, and how many.
  std::vector<std::pair<std::string, std::size_t>> own_states() const;
  /// Hidden states of a model's car: those of the world's own effects and of the members.
  std::size_t hidden_states(const ModelSpec& model) const;
  /// Whether a model with these candidates beside its members has no more hidden states than the filter takes
  /// (max_memory). Sets that do not fit cannot be linearised and are not tried.
  bool fits_filter(const ModelSpec& model, std::initializer_list<std::size_t> beside = {}) const;
  /// The car of a model; holds pointers into this catalogue. Parameter order: the nominal model's, then the effects' in
  /// the order of the chain.
  StagedCar build(const ModelSpec& model) const;
  /// An effect of a model: one of the world's own, or a member.
  struct Link {
    bool own = false;
    std::size_t index = 0;  // among the own effects, as the world lists them, or among the members
  };
  /// All effects of a model in the order in which they act within a stage: own ones as the world lists them, members
  /// where they belong among these (car/effect_order.hpp).
  std::vector<Link> chain(const ModelSpec& model) const;
  /// Number of a member among the effects of a built car.
  std::size_t effect_number(const ModelSpec& model, std::size_t member) const;
  /// Whether a nuisance acts on readings.
  bool pose_is_late() const {
    return std::ranges::any_of(nuisances_, [](const Nuisance& n) { return n.delay.has_value(); });
  }
  /// Whether states of the world's own effects depend on the nominal model from its first stage on: one has memory
  /// and acts at a later one.
  bool own_states_depend_on_model() const;
  /// Whether states of the own effects depend on a candidate: one has memory and acts after it.
  bool own_states_depend_on(std::size_t candidate) const;
  std::string name(const ModelSpec& model) const;
  /// Whether candidate a acts earlier in the chain of stages than candidate b.
  bool before(std::size_t a, std::size_t b) const;

 private:
  std::size_t first_own_after(std::size_t candidate) const;
  bool own_has_delay() const;
  Car car_;
  VehicleSpec nominal_;  // keeps the tables alive that instances point into
  Instance<VehicleModel> model_;
  const PluginEntry* model_entry_;
  std::vector<double> model_params_;
  struct Own {
    Instance<Effect> effect;
    std::vector<double> params;
    std::string id;
  };
  std::vector<Own> own_;
  std::vector<EffectOrder> own_order_;
  PoseLatency pose_latency_;  // the first effect, while one of its parameters is a nuisance
  std::vector<Candidate> candidates_;
  std::vector<Nuisance> nuisances_;
};

}  // namespace gripline::diagnose
