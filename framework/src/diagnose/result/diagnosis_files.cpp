#include "diagnose/result/diagnosis_files.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "config/errors.hpp"
#include "config/file_kind.hpp"
#include "config/json_file.hpp"
#include "config/reader.hpp"

namespace gripline::diagnose {
namespace {

namespace fs = std::filesystem;

Node object() { return Node(Node::Object{}); }

Node number(double value) { return std::isfinite(value) ? Node(value) : Node::null(); }

/// A vehicle plugin or effect as a world writes it.
Node plugin_node(const PluginSpec& spec) {
  Node node = object();
  node.set("plugin", Node(spec.id()));
  Node params = object();
  for (std::size_t i = 0; i < spec.values.size(); ++i) {
    const abi::ParamDecl& p = spec.entry->params()[i];
    if (p.type == abi::ParamType::table) continue;
    if (p.type == abi::ParamType::boolean)
      params.set(p.name, Node(spec.values[i].number != 0.0));
    else
      params.set(p.name, number(spec.values[i].number));
  }
  node.set("params", std::move(params));
  return node;
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out) throw InputError("cannot write " + file.string());
}

}  // namespace

Node diagnosis_json(const Diagnosis& d) {
  Node out = object();
  out.set("verdict", Node(verdict_names[static_cast<std::size_t>(d.verdict)]));
  Node::Array named;
  for (const NamedEffect& n : d.named) {
    Node one = object();
    one.set("effect", Node(n.effect));
    Node params = object(), ci = object();
    for (const NamedEffect::Value& v : n.params) {
      params.set(v.name, number(v.value));
      ci.set(v.name, Node(Node::Array{number(v.low), number(v.high)}));
    }
    one.set("params", std::move(params));
    one.set("ci95", std::move(ci));
    one.set("confidence", number(n.confidence));
    named.push_back(std::move(one));
  }
  out.set("named", Node(std::move(named)));
  Node::Array equivalent;
  for (const auto& set : d.equivalent) {
    Node::Array ids;
    for (const std::string& id : set) ids.emplace_back(id);
    equivalent.emplace_back(std::move(ids));
  }
  out.set("equivalent", Node(std::move(equivalent)));
  if (d.unknown) {
    Node unknown = object();
    unknown.set("where", Node(where_names[static_cast<std::size_t>(d.unknown->where)]));
    const bool along =
        (d.unknown->where == Where::position || d.unknown->where == Where::time) && d.unknown->quantity.empty();
    unknown.set("interval", along ? Node(Node::Array{number(d.unknown->from), number(d.unknown->to)}) : Node::null());
    out.set("unknown", std::move(unknown));
  } else {
    out.set("unknown", Node::null());
  }
  Node fitted = d.nominal_fit.empty() ? Node::null() : object();
  for (const auto& [name, value] : d.nominal_fit) fitted.set(name, number(value));
  out.set("nominal_fit", std::move(fitted));
  Node gap = object();
  gap.set("horizon_s", number(d.gap.horizon));
  gap.set("before", number(d.gap.before));
  gap.set("after", number(d.gap.after));
  gap.set("closure", number(d.gap.closure));
  out.set("gap", std::move(gap));
  Node::Array ranking;
  for (const Ranked& r : d.ranking) {
    Node one = object();
    one.set("effect", Node(r.effect));
    one.set("gain", number(r.gain));
    one.set("held_out", number(r.held_out));
    one.set("selected_fraction", number(r.selected_fraction));
    ranking.push_back(std::move(one));
  }
  out.set("ranking", Node(std::move(ranking)));
  out.set("manoeuvre", d.manoeuvre.empty() ? Node::null() : Node(d.manoeuvre));
  if (d.verdict == Verdict::nothing_missing) {
    Node::Array floors;
    for (const Floor& f : d.floors) {
      Node one = object();
      one.set("effect", Node(f.effect));
      one.set("param", Node(f.param));
      one.set("unit", Node(f.unit));
      one.set("size", number(f.size));
      floors.push_back(std::move(one));
    }
    out.set("seen_at", Node(std::move(floors)));
  }
  out.set("sentence", Node(d.sentence));
  return out;
}

Node world_patch(const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world) {
  const Catalogue& catalogue = diagnoser.catalogue();
  Node plant = object();
  if (!d.nominal_fit.empty()) {
    Node params = object();
    for (const auto& [name, value] : d.nominal_fit) params.set(name, number(value));
    plant.set("params", std::move(params));
  }
  Node::Array effects;
  for (const PluginSpec& own : world.vehicle.effects) effects.push_back(plugin_node(own));
  for (std::size_t i = 0; i < d.fit.model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[d.fit.model.members[i]];
    Node one = object();
    one.set("plugin", Node(c.id));
    Node params = object();
    for (std::size_t p = 0; p < c.entry->decl->param_count; ++p)
      params.set(c.entry->decl->params[p].name, number(d.fit.model.values[i][p]));
    one.set("params", std::move(params));
    effects.push_back(std::move(one));
  }
  plant.set("effects", Node(std::move(effects)));
  Node patch = object();
  patch.set("plant", std::move(plant));
  return patch;
}

void read_uncertainty(const Node& node, CaseOptions& options, Errors& errors) {
  if (node.is_null()) return;
  ObjectReader r(node, errors);
  for (const Member* member : r.members())
    options.uncertainty[member->key] = read_number(member->value, "1", NumberRange::non_negative(), errors);
}

CaseFile read_case(const fs::path& file) {
  const Node node = load_json(file);
  constexpr std::array<const char*, 7> keys = {"vehicle",     "track",   "direction",          "sample_time_s",
                                               "noise_sigma", "exclude", "nominal_uncertainty"};
  // The wrong file altogether is one fault, not one for each of its keys.
  if (!node.is_object() ||
      !std::any_of(keys.begin(), keys.end(), [&](const char* k) { return node.find(k) != nullptr; }))
    throw InputError(file.string() +
                     ": is no case; expected an object with some of vehicle, track, noise_sigma, "
                     "exclude, nominal_uncertainty");
  if (const FileKind kind = kind_of(node); kind == FileKind::world || kind == FileKind::experiment)
    throw InputError(file.string() + ": is " + std::string(kind_text(kind)) + ", expected a case");
  Errors errors;
  CaseFile out;
  {
    ObjectReader r(node, errors);
    out.vehicle = r.text("vehicle", std::string());
    (void)r.find("direction");
    (void)r.find("sample_time_s");
    for (const Node& id : r.array("exclude", false)) out.options.exclude.push_back(read_text(id, errors));
    if (const Node* uncertainty = r.find("nominal_uncertainty"); uncertainty != nullptr)
      read_uncertainty(*uncertainty, out.options, errors);
    if (r.has("noise_sigma")) {
      ObjectReader sigma = r.object("noise_sigma");
      constexpr std::array<std::pair<const char*, const char*>, channels> names = {{{"x_m", "m"},
                                                                                    {"y_m", "m"},
                                                                                    {"yaw_rad", "rad"},
                                                                                    {"vx_mps", "m/s"},
                                                                                    {"vy_mps", "m/s"},
                                                                                    {"yaw_rate_radps", "rad/s"}}};
      Channels values{};
      for (std::size_t c = 0; c < channels; ++c)
        values[c] = sigma.number(names[c].first, names[c].second, NumberRange::non_negative(), 0.0);
      out.options.noise_sigma = values;
    }
    if (r.has("track")) {
      const std::string name = r.text("track");
      const fs::path folder = file.parent_path();
      for (const fs::path& place :
           {folder / name, folder / ".." / ".." / "tracks" / name, folder / ".." / "tracks" / name})
        if (!out.track && fs::is_regular_file(place)) out.track = place;
      if (!out.track) r.error_at("track", "no file \"" + name + "\" beside the case or in ../../tracks");
    }
  }
  errors.throw_if_any();
  return out;
}

void write_diagnosis(const fs::path& folder, const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world,
                     const fs::path& world_file, const std::optional<fs::path>& track) {
  fs::create_directories(folder);
  write_text(folder / "diagnosis.json", to_json_text(diagnosis_json(d)));
  Node augmented = object();
  augmented.set("note", Node(d.sentence));
  const fs::path base = fs::absolute(folder);
  augmented.set("extends", Node(fs::absolute(world_file).lexically_relative(base).generic_string()));
  if (track) augmented.set("track", Node(fs::absolute(*track).lexically_relative(base).generic_string()));
  const Node patch = world_patch(d, diagnoser, world);
  augmented.set("plant", *patch.find("plant"));
  write_text(folder / "augmented_world.json", to_json_text(augmented));
}

}  // namespace gripline::diagnose
