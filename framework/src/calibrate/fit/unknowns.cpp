#include "calibrate/fit/unknowns.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <stdexcept>

#include "config/units.hpp"
#include "plugin/plugin_spec.hpp"

namespace gripline::calibrate {
namespace {

constexpr std::array<const char*, stage_count> stage_groups = {"command", "drive", "load",  "tyre",
                                                               "force",   "body",  "frames"};
constexpr std::array<const char*, 4> known_of_car = {"m", "lf", "lr", "yaw_gain"};
/// Of the Magic Formula, sin(C atan(B slip)): below C = 1 the force never falls back, above 2 it changes its sign at
/// large slip, which other logs may show though the fitted ones do not.
constexpr std::array<const char*, 2> shape_factors = {"Cf", "Cr"};
constexpr double least_shape = 1.0, most_shape = 2.0;

std::string name_of(const ParameterPlace& place) { return place.pointer.substr(place.pointer.rfind('/') + 1); }

/// Of the forecast's parameters, by their number.
bool is_delay(std::size_t parameter) {
  return parameter >= static_cast<std::size_t>(ForecastParameter::delay_position);
}

std::string pointer_to(std::size_t parameter) {
  const std::string name = forecast_parameter_infos()[parameter].name;
  return is_delay(parameter) ? "/calibration/delays/" + name.substr(std::string("delay_").size())
                             : "/calibration/observer/" + name;
}

}  // namespace

std::vector<ParameterPlace> parameter_places(const WorldSpec& world, const Forecaster& forecaster) {
  std::vector<ParameterPlace> places;
  const auto add = [&](const abi::ParamDecl& p, std::string pointer, std::string group) {
    places.push_back({std::move(pointer), p.unit, std::move(group), places.size(), p.lo, p.hi});
  };
  for (const abi::ParamDecl& p : world.vehicle.model.entry->params())
    add(p, std::string("/plant/params/") + p.name, "model");
  for (const PluginSpec& effect : world.vehicle.effects) {
    PluginContext context;
    context.car = world.car.car;
    const auto stage = create<Effect>(*effect.entry, context, effect.values)->stage();
    for (const abi::ParamDecl& p : effect.entry->params())
      add(p, "/plant/effects/" + effect.name_in_list() + "/params/" + p.name,
          stage_groups[static_cast<std::size_t>(stage)]);
  }
  for (std::size_t e = 0; e < forecast_parameter_count; ++e) {
    const ForecastParameterInfo& info = forecast_parameter_infos()[e];
    places.push_back(
        {pointer_to(e), info.unit, is_delay(e) ? "delays" : "observer", forecaster.car_params() + e, info.lo, info.hi});
  }
  return places;
}

std::vector<double> parameters_of(const Node& world, const Forecaster& forecaster, Errors& errors) {
  std::vector<double> values = forecaster.defaults();
  const Node* const calibration = world.find("calibration");
  if (calibration == nullptr) return values;
  for (std::size_t e = 0; e < forecast_parameter_count; ++e) {
    const Node* const value = find_pointer(world, pointer_to(e));
    if (value == nullptr) continue;
    const ForecastParameterInfo& info = forecast_parameter_infos()[e];
    values[forecaster.car_params() + e] = read_number(*value, info.unit, NumberRange::closed(info.lo, info.hi), errors);
  }
  return values;
}

Unknown unknown_at(const ParameterPlace& place, double prior) {
  Unknown u;
  u.pointer = place.pointer;
  u.group = place.group;
  u.index = place.index;
  u.prior = prior;
  u.low = place.low;
  u.high = place.high;
  u.observer = place.group == "observer";
  return u;
}

namespace {

Unknown forecast_unknown(const ParameterPlace& place, double prior, std::size_t parameter) {
  Unknown u = unknown_at(place, prior);
  const ForecastParameterInfo& info = forecast_parameter_infos()[parameter];
  u.log = info.log;
  u.sigma = info.sigma;
  return u;
}

bool is_shape_factor(const ParameterPlace& place) {
  return place.group == "model" && place.unit == "1" &&
         std::ranges::find(shape_factors, name_of(place)) != shape_factors.end();
}

/// Where a world lists nothing: half of what a value is, or a share of its plugin's range where it is 0. A shape factor
/// stays where those of tyres are, or as far from there as the world has it.
Unknown guess(const ParameterPlace& place, double prior) {
  Unknown u = unknown_at(place, prior);
  if (is_shape_factor(place)) {
    u.low = std::max(u.low, std::min(least_shape, prior));
    u.high = std::min(u.high, std::max(most_shape, prior));
  }
  u.log = prior > 0.0 && place.low >= 0.0;
  u.sigma = u.log ? 0.5 : prior != 0.0 ? 0.5 * std::abs(prior) : std::min(0.01 * (place.high - place.low), 1.0);
  return u;
}

Unknown read_one(const Node& node, const ParameterPlace& place, double prior, Errors& errors) {
  Unknown u = unknown_at(place, prior);
  ObjectReader r(node, errors);
  prior = u.prior = r.number("prior", place.unit, NumberRange::any(), prior);
  u.log = r.choice<bool>("scale", {{"log", true}, {"linear", false}}, false);
  if (u.log && !(prior > 0.0))
    r.error("its scale is \"log\", its value " + number_text(prior) + "; expected one above 0");
  u.sigma = r.number("sigma", u.log ? "1" : place.unit, NumberRange::positive());
  u.session = r.number("session", u.log ? "1" : place.unit, NumberRange::non_negative(), 0.0);
  u.low = std::max(u.low, r.number("low", place.unit, NumberRange::any(), u.low));
  u.high = std::min(u.high, r.number("high", place.unit, NumberRange::any(), u.high));
  u.group = r.text("group", u.group);
  if (!(u.low < u.high) || prior < u.low || prior > u.high)
    r.error("its value " + number_text(prior) + " lies outside of " + number_text(u.low) + " to " +
            number_text(u.high));
  r.finish();
  return u;
}

/// "A is the same as B", as written.
struct Tie {
  const ParameterPlace* place;
  std::string leader;
  Origin origin;
};

/// Why a parameter cannot have the values of an unknown; empty where it can.
std::string why_not_same(const Unknown& u, const ParameterPlace& place) {
  const std::string range =
      "the range of " + place.pointer + ", " + number_text(place.low) + " to " + number_text(place.high);
  if (u.prior < place.low || u.prior > place.high)
    return "the value " + number_text(u.prior) + " of " + u.pointer + " lies outside of " + range;
  if (std::max(u.low, place.low) < std::min(u.high, place.high)) return "";
  return range + ", leaves no room between " + number_text(u.low) + " and " + number_text(u.high) + ", the bounds of " +
         u.pointer;
}

/// Hands every parameter that is said to be the same as another to that one's unknown.
void join(std::vector<Unknown>& all, std::span<const Tie> ties, std::span<const ParameterPlace> places,
          Errors& errors) {
  std::vector<std::string> leaders;
  leaders.reserve(all.size());
  for (const Unknown& u : all) leaders.push_back(u.pointer);
  for (const Tie& tie : ties) {
    const auto leader = std::find(leaders.begin(), leaders.end(), tie.leader);
    if (leader == leaders.end()) {
      errors.add(tie.origin, "\"" + tie.leader + "\" is not an unknown of this world that is fitted by itself" +
                                 did_you_mean(tie.leader, leaders));
      continue;
    }
    Unknown& u = all[static_cast<std::size_t>(leader - leaders.begin())];
    const std::string& unit = places[u.index].unit;
    if (tie.place->unit != unit) {
      errors.add(tie.origin, tie.place->pointer + " [" + tie.place->unit + "] cannot be the same as " + u.pointer +
                                 " [" + unit + "]");
      continue;
    }
    if (const std::string why = why_not_same(u, *tie.place); !why.empty()) {
      errors.add(tie.origin, why);
      continue;
    }
    u.low = std::max(u.low, tie.place->low);
    u.high = std::min(u.high, tie.place->high);
    u.same.push_back({tie.place->pointer, tie.place->index});
  }
}

bool is_called(const Unknown& u, const std::string& name) {
  return name == u.group || name == u.pointer ||
         std::any_of(u.same.begin(), u.same.end(), [&](const Unknown::Same& s) { return s.pointer == name; });
}

/// What a world's "unknowns" say.
struct Listed {
  std::vector<Unknown> unknowns;
  std::vector<Tie> ties;
  std::set<std::string> seen;  // pointers
};

Listed read_listed(const Node& node, std::span<const ParameterPlace> places, std::span<const std::string> pointers,
                   std::span<const double> values, Errors& errors) {
  Listed out;
  ObjectReader r(node, errors);
  for (const Member* member : r.members()) {
    const auto at = std::find(pointers.begin(), pointers.end(), member->key);
    if (at == pointers.end()) {
      errors.add(member->key_origin(),
                 "\"" + member->key + "\" is not a parameter of this world" + did_you_mean(member->key, pointers));
      continue;
    }
    const ParameterPlace& place = places[static_cast<std::size_t>(at - pointers.begin())];
    out.seen.insert(member->key);
    if (const Node* const leader = member->value.find("same_as"); leader != nullptr) {
      ObjectReader tie(member->value, errors);
      out.ties.push_back({&place, tie.text("same_as"), leader->origin});
      tie.finish();
      continue;
    }
    out.unknowns.push_back(read_one(member->value, place, values[place.index], errors));
  }
  return out;
}

bool is_of_data_sheet(const ParameterPlace& place) {
  return place.group == "model" && std::ranges::find(known_of_car, name_of(place)) != known_of_car.end();
}

/// Of a world that lists none: all parameters of the model and its effects that a data sheet does not give.
std::vector<Unknown> guess_unknowns(std::span<const ParameterPlace> places, std::span<const double> values) {
  std::vector<Unknown> all;
  for (const ParameterPlace& place : places) {
    if (!is_of_data_sheet(place) && place.high > place.low) all.push_back(guess(place, values[place.index]));
  }
  return all;
}

/// Why no unknown is what --fit names: what is no parameter, and what is one that is not fitted.
std::string why_not_fitted(const std::string& name, std::span<const Unknown> all,
                           std::span<const ParameterPlace> places, bool listed) {
  const auto place = std::ranges::find(places, name, &ParameterPlace::pointer);
  if (place != places.end()) {
    const std::string start = "the parameter \"" + name + "\" is not fitted: ";
    if (listed) return start + "the world's \"unknowns\" do not list it";
    if (is_of_data_sheet(*place)) return start + "a data sheet gives it; \"unknowns\" in the world may list it";
    return start + "its range is " + number_text(place->low) + " to " + number_text(place->high);
  }
  std::set<std::string> groups;
  for (const Unknown& u : all) groups.insert(u.group);
  std::vector<std::string> known(groups.begin(), groups.end());
  for (const ParameterPlace& one : places) known.push_back(one.pointer);
  return "no group or parameter \"" + name + "\"" + did_you_mean(name, known);
}

/// Those of the groups or with the pointers that --fit names.
std::vector<Unknown> choose(std::span<const Unknown> all, std::span<const ParameterPlace> places,
                            std::span<const std::string> chosen, bool listed, Errors& errors) {
  std::vector<Unknown> kept;
  for (const Unknown& u : all)
    if (std::any_of(chosen.begin(), chosen.end(), [&](const std::string& c) { return is_called(u, c); }))
      kept.push_back(u);
  for (const std::string& c : chosen)
    if (std::none_of(all.begin(), all.end(), [&](const Unknown& u) { return is_called(u, c); }))
      errors.add(Diagnostic{"--fit", 0, 0, "", why_not_fitted(c, all, places, listed), {}});
  return kept;
}

}  // namespace

void assign(std::span<double> params, const Unknown& unknown, double value) {
  params[unknown.index] = value;
  for (const Unknown::Same& s : unknown.same) params[s.index] = value;
}

void unite(std::span<double> params, std::span<const Unknown> unknowns) {
  for (const Unknown& u : unknowns) assign(params, u, params[u.index]);
}

std::vector<Unknown> read_unknowns(const Node& world, std::span<const ParameterPlace> places,
                                   std::span<const double> values, std::span<const std::string> chosen,
                                   Errors& errors) {
  std::vector<std::string> pointers;
  for (const ParameterPlace& place : places) pointers.push_back(place.pointer);
  const std::size_t of_car = places.size() - forecast_parameter_count;
  const Node* const listed = world.find("unknowns");
  Listed out = listed != nullptr ? read_listed(*listed, places, pointers, values, errors)
                                 : Listed{guess_unknowns(places.first(of_car), values), {}, {}};
  for (std::size_t e = 0; e < forecast_parameter_count; ++e) {
    const ParameterPlace& place = places[of_car + e];
    if (!out.seen.contains(place.pointer)) out.unknowns.push_back(forecast_unknown(place, values[place.index], e));
  }
  join(out.unknowns, out.ties, places, errors);
  return chosen.empty() ? out.unknowns : choose(out.unknowns, places, chosen, listed != nullptr, errors);
}

namespace {

/// An effect in a world's list by its id, else by its index.
Node* effect_in(Node& list, const std::string& name) {
  for (Node& one : list.array())
    if (const Node* const id = one.find("plugin"); id != nullptr && id->is_text() && id->text() == name) return &one;
  std::size_t index = 0;
  const auto [stop, code] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool number = code == std::errc() && stop == name.data() + name.size();
  return number && index < list.array().size() ? &list.array()[index] : nullptr;
}

}  // namespace

void set_value(Node& world, const std::string& pointer, double value) {
  const std::vector<std::string> names = split_pointer(pointer);
  Node* at = &world;
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    if (at->is_array()) {
      at = effect_in(*at, names[i]);
      if (at == nullptr) throw std::invalid_argument(pointer + ": no such effect in the world");
      continue;
    }
    Node* const next = at->find(names[i]);
    at = next != nullptr ? next : &at->set(names[i], Node::empty_object());
  }
  at->set(names.back(), Node(value));
}

}  // namespace gripline::calibrate
