#include "car/vehicle.hpp"

#include <algorithm>

#include "car/stated_drive.hpp"
#include "util/child_process.hpp"

namespace gripline {
namespace {

Instance<Effect> create_effect(const PluginSpec& spec, const PluginContext& context) {
  return create<Effect>(*spec.entry, context, spec.values);
}

Integration read_integration(ObjectReader& reader, const char* fallback) {
  std::vector<std::string> names;
  for (const Tableau& tableau : tableaux()) names.emplace_back(tableau.name);
  Integration integration;
  integration.tableau = find_tableau(reader.choice("integrator", names, std::string(fallback)));
  integration.substeps = static_cast<int>(reader.integer("substeps", {1, 1000}, 1));
  return integration;
}

/// Reports effects on a stage that this model lacks or that nothing reads, while their place in the file is known.
/// Constructors are called in a process of their own: those that throw, or end their process, are reported by the run.
void check_effects(const VehicleSpec& spec, const Car& car, std::span<const Node> nodes, Readings readings,
                   Errors& errors) {
  constexpr double timeout_s = 10.0;
  PluginContext context;
  context.car = car;
  const auto try_all = [&](const SendMessage& send) {
    const auto model = create<VehicleModel>(*spec.model.entry, context, spec.model.values);
    StagedCar staged(*model, spec.model.numbers());
    std::vector<Instance<Effect>> effects;
    for (const PluginSpec& effect : spec.effects) {
      effects.push_back(create_effect(effect, context));
      std::string problem;
      if (readings == Readings::unread && effects.back()->stage() == Stage::reading)
        problem = "effect \"" + effect.id() + "\" changes what sensors show, and nothing here reads that; it belongs " +
                  "into a world's plant";
      try {
        staged.add(*effects.back(), effect.numbers(), effect.id());
      } catch (const std::invalid_argument& refused) {
        problem = refused.what();
      }
      send(problem);
    }
  };
  if (spec.effects.empty()) return;
  const ChildResult result = run_in_child(timeout_s, try_all);
  for (std::size_t i = 0; i < result.messages.size(); ++i)
    if (!result.messages[i].empty()) errors.add(nodes[i].origin, result.messages[i]);
}

}  // namespace

void read_known_params(ObjectReader& car, KnownParams& known, Errors& errors) {
  if (!car.has("known_params")) return;
  ObjectReader params = car.object("known_params");
  for (const Member* member : params.members()) {
    if (member->value.is_number())
      known[member->key] = member->value.number();
    else
      errors.add(member->value.origin, "expected a number in SI");
  }
}

void check_known_params(const Node& car, const Registry& registry, Errors& errors) {
  const Node* const params = car.is_object() ? car.find("known_params") : nullptr;
  if (params == nullptr || !params->is_object()) return;
  std::vector<std::string> names;
  for (const PluginEntry& entry : registry.entries())
    if (entry.decl->kind == abi::Kind::vehicle || entry.decl->kind == abi::Kind::plant)
      for (const abi::ParamDecl& param : entry.params()) names.emplace_back(param.name);
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  for (const Member& member : params->object())
    if (member.key != "note" && !std::ranges::binary_search(names, member.key))
      errors.add(member.key_origin(), "no vehicle model and no plant has a parameter \"" + member.key + '"' +
                                          did_you_mean(member.key, names));
}

CarFile read_car(const Node& node, Errors& errors) {
  // No car is heavier or longer; with such numbers a slip of units is told at its place.
  constexpr double heaviest = 1e7, longest = 1e3;
  const std::size_t before = errors.added();
  ObjectReader r(node, errors);
  const auto positive = NumberRange::positive();
  const auto length = NumberRange::at_most(longest);
  CarFile file;
  Car& car = file.car;
  car.m = r.number("m", "kg", {0.0, heaviest, true, true});
  car.Iz = r.number("Iz", "kg m2", positive);
  car.lf = r.number("lf", "m", length);
  car.lr = r.number("lr", "m", length);
  car.length = r.number("length", "m", length);
  car.width = r.number("width", "m", length);
  car.d_min = r.number("d_min", "1", NumberRange::closed(-1, 0));
  car.d_max = r.number("d_max", "1", NumberRange::at_most(1));
  car.delta_max = r.number("delta_max", "rad", NumberRange::at_most(1.5));
  car.ddelta_max = r.number("ddelta_max", "rad/s", positive);
  car.v_ref = r.number("v_ref", "m/s", positive);
  car.v_min = r.number("v_min", "m/s", positive);
  file.known = {{"m", car.m}, {"Iz", car.Iz}, {"lf", car.lf}, {"lr", car.lr}};
  file.substeps_by_error = r.boolean("substeps_by_error", true);
  read_known_params(r, file.known, errors);
  r.finish();
  const Node* const known = node.find("known_params");
  if (errors.added() == before)
    file.known_at = known != nullptr ? known->origin : child_of(node.origin, "known_params");
  return file;
}

namespace {

/// Effects whose id the list has more than once are told by their index.
void number_repeated(std::vector<PluginSpec>& effects) {
  for (std::size_t i = 0; i < effects.size(); ++i)
    if (std::ranges::count(effects, effects[i].id(), &PluginSpec::id) > 1) effects[i].index_in_list = i;
}

}  // namespace

VehicleSpec read_vehicle(const Node& node, const Registry& registry, const CarFile& car, const char* integrator,
                         Errors& errors, Readings readings) {
  VehicleSpec spec;
  const std::size_t before = errors.added();  // before the reader, which refuses what is no object
  ObjectReader r(node, errors);
  spec.model = read_plugin(r, abi::Kind::vehicle, registry, car.known);
  const std::span<const Node> effects = r.array("effects", false);
  if (const Node* const list = node.find("effects"); list != nullptr) spec.effects_read = *list;
  for (const Node& one : effects) {
    ObjectReader effect(one, errors);
    spec.effects.push_back(read_plugin(effect, abi::Kind::effect, registry));
    effect.finish();
  }
  number_repeated(spec.effects);
  spec.integration = read_integration(r, integrator);
  r.finish();
  if (errors.added() == before) {
    check_effects(spec, car.car, effects, readings, errors);
    check_drive(spec.model, car, errors);
  }
  return spec;
}

Vehicle::Vehicle(const VehicleSpec& spec, const PluginContext& context, const Effect* first)
    : spec_(&spec),
      model_(create<VehicleModel>(*spec.model.entry, context, spec.model.values)),
      first_(first != nullptr && has_stage(first->stage()) ? first : nullptr),
      car_(*model_, spec.model.numbers()),
      memoryless_(car_) {
  if (first_ != nullptr) car_.add(*first_, {1.0}, "world");
  for (const PluginSpec& one : spec.effects) {
    effects_.push_back(create_effect(one, context));
    car_.add(*effects_.back(), one.numbers(), one.id());
  }
  memoryless_ = car_of([](const Effect& effect) { return effect.memory() == 0; });
}

StagedCar Vehicle::car_of(const std::function<bool(const Effect&)>& wanted) const {
  StagedCar car(*model_, spec_->model.numbers());
  if (first_ != nullptr) car.add(*first_, {1.0}, "world");
  for (std::size_t i = 0; i < effects_.size(); ++i)
    if (wanted(*effects_[i])) car.add(*effects_[i], spec_->effects[i].numbers(), spec_->effects[i].id());
  return car;
}

StagedCar Vehicle::car_with(std::size_t effects) const {
  StagedCar car(*model_, spec_->model.numbers());
  for (std::size_t i = 0; i < std::min(effects, effects_.size()); ++i)
    car.add(*effects_[i], spec_->effects[i].numbers(), spec_->effects[i].id());
  return car;
}

}  // namespace gripline
