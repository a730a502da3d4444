#include "calibrate/effects/effect_trial.hpp"

#include <algorithm>
#include <cmath>

#include "car/effect_order.hpp"

namespace gripline::calibrate {

Stage stage_of(const PluginSpec& effect, const PluginContext& context) {
  return create<Effect>(*effect.entry, context, effect.values)->stage();
}

namespace {

/// Where a further effect acts in a world: in its order, but behind effects that the world has twice, as these are
/// named by their index.
std::size_t place_in(const WorldSpec& world, const CandidateEffect& effect) {
  const auto& effects = world.vehicle.effects;
  const auto is_twice = [](const PluginSpec& one) { return one.index_in_list.has_value(); };
  if (std::ranges::any_of(effects, is_twice)) return effects.size();
  const PluginContext context = Trial::context_of(world);
  std::vector<EffectOrder> chain;
  for (const PluginSpec& one : effects) chain.push_back({stage_of(one, context), one.entry->decl->precedence});
  return place_in_chain(order_of(*effect.effect, *effect.entry), chain);
}

}  // namespace

std::string pointer_of(const std::string& effect, const char* parameter) {
  return "/plant/effects/" + effect + "/params/" + parameter;
}

Addition added_effect(const std::string& id, SteeringAsymmetry asymmetry) {
  return {id, pointer_of(id, ""), false, asymmetry};
}

Addition addition_of(const CandidateEffect& candidate, const Trial& base) {
  if (!candidate.listed) return added_effect(candidate.id(), candidate.asymmetry);
  const auto at = std::ranges::find(base.places, *candidate.listed, &ParameterPlace::index);
  return {candidate.id() + "." + candidate.entry->params()[candidate.open.front()].name, at->pointer, true,
          candidate.asymmetry};
}

std::vector<CandidateEffect> candidates_beside(const Trial& base, const Registry& registry,
                                               std::span<const FittedParameter> known) {
  const bool road = base.spec.track != nullptr;
  auto candidates = candidate_effects(base.spec.vehicle, base.spec.car.car, registry, road);
  const auto is = [](const Unknown& u, const std::string& pointer) {
    return u.pointer == pointer || std::ranges::find(u.same, pointer, &Unknown::Same::pointer) != u.same.end();
  };
  for (CandidateEffect& one : idle_parameters(base.spec.vehicle, base.spec.car.car, road)) {
    const std::string pointer = addition_of(one, base).pointer;
    if (std::ranges::any_of(base.unknowns, [&](const Unknown& u) { return is(u, pointer); }) ||
        std::ranges::any_of(known, [&](const FittedParameter& p) { return is(p.unknown, pointer); }))
      continue;
    candidates.push_back(std::move(one));
  }
  return candidates;
}

void take_over_unknowns(Trial& to, const Trial& from) {
  for (Unknown u : from.unknowns) {
    std::vector<Unknown::Same> all{{u.pointer, u.index}};
    all.insert(all.end(), u.same.begin(), u.same.end());
    u.same.clear();
    for (const Unknown::Same& one : all)
      if (const ParameterPlace* const at = to.find(one.pointer); at != nullptr)
        u.same.push_back({one.pointer, at->index});
    if (u.same.empty()) continue;
    u.pointer = u.same.front().pointer;
    u.index = u.same.front().index;
    u.same.erase(u.same.begin());
    to.unknowns.push_back(std::move(u));
  }
}

void take_over(Trial& to, const Trial& from) {
  for (const ParameterPlace& p : from.places)
    if (const ParameterPlace* const at = to.find(p.pointer); at != nullptr) to.params[at->index] = from.params[p.index];
  take_over_unknowns(to, from);
}

WorldSpec with_effect(WorldSpec world, const CandidateEffect& effect) {
  if (effect.listed) return world;
  PluginSpec spec;
  spec.entry = effect.entry;
  for (const double value : effect.numbers) spec.values.push_back({value, Table{}});
  spec.tables.resize(spec.values.size());
  auto& effects = world.vehicle.effects;
  effects.insert(effects.begin() + static_cast<std::ptrdiff_t>(place_in(world, effect)), std::move(spec));
  return world;
}

WorldSpec without_effect(WorldSpec world, const std::string& id) {
  std::erase_if(world.vehicle.effects, [&](const PluginSpec& e) { return e.id() == id; });
  return world;
}

Unknown open_parameter(const ParameterPlace& place, double neutral) {
  Unknown u = unknown_at(place, neutral);
  u.sigma = 0.25 * (place.high - place.low);
  return u;
}

Node with_effects(Node world, const WorldSpec& found, std::span<const Addition> added) {
  for (std::size_t i = 0; i < found.vehicle.effects.size(); ++i) {
    const PluginSpec& effect = found.vehicle.effects[i];
    const auto is_it = [&](const Addition& one) { return !one.opened && one.name == effect.id(); };
    if (std::ranges::none_of(added, is_it)) continue;
    Node one = Node::empty_object(), params = Node::empty_object();
    one.set("plugin", Node(effect.id()));
    for (std::size_t p = 0; p < effect.values.size(); ++p)
      params.set(effect.entry->params()[p].name, param_node(effect.entry->params()[p], effect.values[p]));
    one.set("params", std::move(params));
    Node& plant = *world.find("plant");
    if (plant.find("effects") == nullptr) plant.set("effects", Node(Node::Array{}));
    Node::Array& list = plant.find("effects")->array();
    // Before the effect that follows it in the chain.
    auto at = list.end();
    for (std::size_t next = i + 1; next < found.vehicle.effects.size() && at == list.end(); ++next)
      at = std::ranges::find_if(list, [&](const Node& e) {
        const Node* const id = e.find("plugin");
        return id != nullptr && id->is_text() && id->text() == found.vehicle.effects[next].id();
      });
    list.insert(at, std::move(one));
  }
  return world;
}

void open_parameters(Node& world, std::span<const Addition> added, std::span<const FittedParameter> parameters,
                     std::size_t sessions) {
  if (Node* const listed = world.find("unknowns"); listed != nullptr)
    for (const Addition& one_more : added)
      for (const FittedParameter& p : parameters) {
        if (!one_more.owns(p.unknown.pointer)) continue;
        Node one = Node::empty_object();
        one.set("group", Node(p.unknown.group));
        one.set("prior", Node(p.unknown.prior));
        one.set("sigma", Node(p.unknown.sigma));
        if (std::isfinite(p.unknown.low)) one.set("low", Node(p.unknown.low));
        if (std::isfinite(p.unknown.high)) one.set("high", Node(p.unknown.high));
        const double width = p.interval.sigma * std::sqrt(static_cast<double>(sessions));
        if (p.status == FittedParameter::Status::determined && width > 0.0)
          one.set("session", Node(std::min(width, p.unknown.sigma)));
        listed->set(p.unknown.pointer, std::move(one));
      }
}

}  // namespace gripline::calibrate
