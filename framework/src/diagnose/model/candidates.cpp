#include "diagnose/model/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnose/model/shape_parameters.hpp"
#include "diagnose/model/states.hpp"
#include "measured/session/log_map.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

std::vector<abi::ParamValue> default_values(const PluginEntry& entry) {
  std::vector<abi::ParamValue> values;
  for (const abi::ParamDecl& p : entry.params()) values.push_back({p.fit ? p.start : p.default_value, Table{}});
  return values;
}

/// An effect is a candidate when something of it can be fitted, nothing of it is a table, and it needs no truth.
bool can_be_fitted(const PluginEntry& entry) {
  const auto params = entry.params();
  return entry.decl->kind == abi::Kind::effect && !entry.needs_truth() &&
         std::any_of(params.begin(), params.end(), [](const abi::ParamDecl& p) { return p.fit; }) &&
         std::none_of(params.begin(), params.end(),
                      [](const abi::ParamDecl& p) { return p.type == abi::ParamType::table; });
}

}  // namespace

std::size_t ModelSpec::position(std::size_t candidate) const {
  return static_cast<std::size_t>(std::find(members.begin(), members.end(), candidate) - members.begin());
}

Catalogue::Catalogue(const VehicleSpec& nominal, const Car& car, const Registry& registry,
                     std::span<const std::string> exclude)
    : car_(car),
      nominal_(nominal),
      model_(nullptr, nullptr),
      model_entry_(nominal.model.entry),
      model_params_(nominal.model.numbers()) {
  PluginContext context;
  context.car = car;
  model_ = create<VehicleModel>(*nominal.model.entry, context, nominal.model.values);
  for (const PluginSpec& one : nominal.effects) {
    own_.push_back({create<Effect>(*one.entry, context, one.values), one.numbers(), one.id()});
    own_order_.push_back(order_of(*own_.back().effect, *one.entry));
  }
  for (const PluginEntry& entry : registry.entries()) {
    if (!can_be_fitted(entry)) continue;
    Candidate c;
    c.id = entry.decl->id;
    c.entry = &entry;
    const auto values = default_values(entry);
    c.effect = create<Effect>(entry, context, values);
    if ((model_->stages() & stage_bit(c.effect->stage())) == 0) continue;
    for (std::size_t i = 0; i < values.size(); ++i) {
      c.defaults.push_back(values[i].number);
      if (entry.decl->params[i].fit) c.fitted.push_back(i);
    }
    c.excluded = std::find(exclude.begin(), exclude.end(), c.id) != exclude.end();
    const bool delays = c.effect->look_back(c.defaults) > 0.0;
    // A delay puts an earlier command in place of what acts, and would undo a delay that the world has.
    if (delays && own_has_delay()) continue;
    c.dynamic = c.effect->memory() > 0 || delays;
    if (!c.dynamic) c.shapes = shape_parameters(c);
    if (c.shapes.size() == c.fitted.size()) c.shapes.clear();  // none of them has a strength to shape
    while (std::ranges::count(c.shapes, c.strength) > 0) ++c.strength;
    candidates_.push_back(std::move(c));
  }
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) { return a.id < b.id; });
}

std::size_t Catalogue::find(std::string_view id) const {
  const auto found =
      std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return c.id == id; });
  return static_cast<std::size_t>(found - candidates_.begin());
}

double Catalogue::nominal(std::string_view name, std::size_t* index) const {
  const auto params = model_entry_->params();
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (name != params[i].name) continue;
    if (index != nullptr) *index = i;
    return model_params_[i];
  }
  return not_a_number;
}

ModelSpec Catalogue::null_model() const {
  ModelSpec model;
  for (const Nuisance& n : nuisances_) model.nuisance.push_back(n.nominal);
  return model;
}

bool Catalogue::before(std::size_t a, std::size_t b) const {
  const Candidate& x = candidates_[a];
  const Candidate& y = candidates_[b];
  const auto key = [](const Candidate& c) {
    return std::tuple(c.effect->stage(), c.entry->decl->precedence, std::string_view(c.id));
  };
  return key(x) < key(y);
}

bool Catalogue::own_has_delay() const {
  return std::ranges::any_of(own_, [](const Own& own) { return own.effect->look_back(own.params) > 0.0; });
}

bool Catalogue::own_states_depend_on_model() const {
  return std::ranges::any_of(
      own_, [](const Own& own) { return own.effect->memory() > 0 && own.effect->stage() > Stage::command; });
}

bool Catalogue::own_states_depend_on(std::size_t candidate) const {
  const Stage stage = candidates_[candidate].effect->stage();
  const std::size_t first = first_own_after(candidate);
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Stage own = own_[i].effect->stage();
    if (own_[i].effect->memory() > 0 && (own > stage || (own == stage && i >= first))) return true;
  }
  return false;
}

std::size_t Catalogue::first_own_after(std::size_t candidate) const {
  const Candidate& c = candidates_[candidate];
  return place_in_chain(order_of(*c.effect, *c.entry), own_order_);
}

std::vector<Catalogue::Link> Catalogue::chain(const ModelSpec& model) const {
  std::vector<Link> links;
  for (std::size_t own = 0; own <= own_.size(); ++own) {
    for (std::size_t i = 0; i < model.members.size(); ++i)
      if (first_own_after(model.members[i]) == own) links.push_back({false, i});
    if (own < own_.size()) links.push_back({true, own});
  }
  return links;
}

std::size_t Catalogue::effect_number(const ModelSpec& model, std::size_t member) const {
  const auto links = chain(model);
  const auto found = std::ranges::find_if(links, [&](const Link& one) { return !one.own && one.index == member; });
  return static_cast<std::size_t>(found - links.begin()) + (pose_is_late() ? 1 : 0);
}

ModelSpec Catalogue::with(const ModelSpec& model, std::size_t candidate) const {
  ModelSpec more = model;
  const auto at = std::upper_bound(more.members.begin(), more.members.end(), candidate,
                                   [&](std::size_t a, std::size_t b) { return before(a, b); });
  const auto offset = at - more.members.begin();
  more.members.insert(at, candidate);
  more.values.insert(more.values.begin() + offset, candidates_[candidate].defaults);
  return more;
}

ModelSpec Catalogue::without(const ModelSpec& model, std::size_t candidate) const {
  ModelSpec less = model;
  const auto offset = static_cast<std::ptrdiff_t>(model.position(candidate));
  less.members.erase(less.members.begin() + offset);
  less.values.erase(less.values.begin() + offset);
  return less;
}

std::vector<std::pair<std::string, std::size_t>> Catalogue::own_states() const {
  std::vector<std::pair<std::string, std::size_t>> states;
  for (const Own& own : own_)
    if (own.effect->memory() > 0) states.emplace_back(own.id, static_cast<std::size_t>(own.effect->memory()));
  return states;
}

std::size_t Catalogue::hidden_states(const ModelSpec& model) const {
  std::size_t sum = 0;
  for (const Own& own : own_) sum += static_cast<std::size_t>(own.effect->memory());
  for (const std::size_t member : model.members) sum += static_cast<std::size_t>(candidates_[member].effect->memory());
  return sum;
}

bool Catalogue::fits_filter(const ModelSpec& model, std::initializer_list<std::size_t> beside) const {
  std::size_t states = hidden_states(model);
  for (const std::size_t candidate : beside)
    states += static_cast<std::size_t>(candidates_[candidate].effect->memory());
  return states <= max_memory;
}

void Catalogue::allow_for_late_pose(std::size_t group, double seconds, double sigma) {
  for (const Nuisance& n : nuisances_)
    if (n.delay == group) throw std::logic_error("this group is late already");
  Nuisance n;
  n.name = measured::delay_effect(group);
  n.index = model_params_.size() + group;
  n.nominal = seconds;
  n.sigma = sigma;
  n.delay = group;
  nuisances_.push_back(std::move(n));
}

void Catalogue::forget_late_pose() {
  std::erase_if(nuisances_, [](const Nuisance& n) { return n.delay.has_value(); });
}

StagedCar Catalogue::build(const ModelSpec& model) const {
  StagedCar car(*model_, model_params_);
  if (pose_is_late()) car.add(pose_latency_, {0.0, 0.0}, "pose_latency");
  for (std::size_t i = 0; i < nuisances_.size(); ++i) car.params()[nuisances_[i].index] = model.nuisance[i];
  for (const Link& link : chain(model)) {
    if (link.own) {
      car.add(*own_[link.index].effect, own_[link.index].params, own_[link.index].id);
      continue;
    }
    const Candidate& c = candidates_[model.members[link.index]];
    car.add(*c.effect, model.values[link.index], c.id);
  }
  return car;
}

std::string Catalogue::name(const ModelSpec& model) const {
  std::string text;
  for (const std::size_t member : model.members) text += (text.empty() ? "" : "+") + candidates_[member].id;
  return text.empty() ? "none" : text;
}

}  // namespace gripline::diagnose
