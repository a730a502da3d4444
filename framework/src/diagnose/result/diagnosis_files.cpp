#include "diagnose/result/diagnosis_files.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "config/json_file.hpp"
#include "util/whole_file.hpp"

namespace gripline::diagnose {
namespace {

namespace fs = std::filesystem;

/// An effect that the world has, as it is written there. A file's name holds beside the world's file only: tables are
/// written by their rows.
Node own_node(const Node& written, const PluginSpec& spec) {
  Node node = written;
  Node* const params = node.find("params");
  for (std::size_t p = 0; params != nullptr && p < spec.values.size(); ++p) {
    const abi::ParamDecl& decl = spec.entry->params()[p];
    if (Node* const value = params->find(decl.name); value != nullptr && decl.type == abi::ParamType::table)
      *value = param_node(decl, spec.values[p]);
  }
  return node;
}

/// An effect that was found, with its values.
Node member_node(const Catalogue& catalogue, const ModelSpec& model, std::size_t member) {
  const Candidate& c = catalogue.candidates()[model.members[member]];
  Node one = Node::empty_object(), params = Node::empty_object();
  one.set("plugin", Node(c.id));
  for (std::size_t p = 0; p < c.entry->params().size(); ++p) {
    const abi::ParamDecl& decl = c.entry->params()[p];
    params.set(decl.name, param_node(decl, {model.values[member][p], Table{}}));
  }
  one.set("params", std::move(params));
  return one;
}

/// What predictions of hold-out data say of an effect.
Node rollout_node(const ErrorChange& c) {
  Node out = Node::empty_object();
  out.set("change", number_or_null(c.change));
  out.set("ci95", Node(Node::Array{number_or_null(c.low), number_or_null(c.high)}));
  out.set("says", Node(std::string(c.in_words())));
  return out;
}

Node named_node(const Diagnosis& d) {
  Node::Array named;
  const std::size_t delays = d.delays.size();
  std::vector<NamedEffect> all = d.delays;
  all.insert(all.end(), d.named.begin(), d.named.end());
  for (const NamedEffect& n : all) {
    Node one = Node::empty_object();
    one.set("effect", Node(n.effect));
    one.set("class", Node(std::string(n.measurement ? "measurement" : "physics")));
    Node params = Node::empty_object(), units = Node::empty_object(), ci = Node::empty_object(),
         ends = Node::empty_object();
    for (const NamedEffect::Value& v : n.params) {
      params.set(v.name, number_or_null(v.value));
      units.set(v.name, Node(v.unit));
      ci.set(v.name, Node(Node::Array{number_or_null(v.low), number_or_null(v.high)}));
      if (!v.at_end.empty()) ends.set(v.name, Node(v.at_end));
    }
    one.set("params", std::move(params));
    one.set("units", std::move(units));
    one.set("ci95", std::move(ci));
    if (!ends.object().empty()) one.set("at_end", std::move(ends));
    one.set("confidence", number_or_null(n.confidence));
    // On logs of real cars nothing is predicted without a delay, which says nothing against it.
    if (named.size() >= delays || n.rollout.measured()) one.set("rollout", rollout_node(n.rollout));
    named.push_back(std::move(one));
  }
  return Node(std::move(named));
}

Node equivalent_node(const Diagnosis& d) {
  Node::Array equivalent;
  for (const auto& set : d.equivalent) {
    Node::Array ids;
    for (const std::string& id : set) ids.emplace_back(id);
    equivalent.emplace_back(std::move(ids));
  }
  return Node(std::move(equivalent));
}

Node unknown_node(const Diagnosis& d) {
  if (!d.unknown) return Node::null();
  const ResidualTest& test = *d.unknown;
  Node unknown = Node::empty_object();
  unknown.set("where", Node(where_names[static_cast<std::size_t>(test.where)]));
  if (test.where == Where::reading) unknown.set("channel", Node(test.quantity));
  const bool along = (test.where == Where::position || test.where == Where::time) && test.quantity.empty();
  unknown.set("interval", along ? Node(Node::Array{number_or_null(test.from), number_or_null(test.to)}) : Node::null());
  return unknown;
}

Node gap_node(const Gap& g) {
  Node gap = Node::empty_object();
  gap.set("horizon_s", number_or_null(g.horizon));
  gap.set("before", number_or_null(g.before));
  gap.set("after", number_or_null(g.after));
  gap.set("closure", number_or_null(g.closure));
  gap.set("closure_ci95", Node(Node::Array{number_or_null(g.closure_low), number_or_null(g.closure_high)}));
  return gap;
}

Node ranking_node(const Diagnosis& d) {
  Node::Array ranking;
  for (const RankedEffect& r : d.ranking) {
    Node one = Node::empty_object();
    one.set("effect", Node(r.effect));
    if (r.gain) one.set("gain", number_or_null(*r.gain));
    if (r.less_error) one.set("less_error", number_or_null(*r.less_error));
    one.set("held_out", number_or_null(r.held_out));
    one.set("selected_fraction", number_or_null(r.selected_fraction));
    one.set("rollout", rollout_node(r.rollout));
    ranking.push_back(std::move(one));
  }
  return Node(std::move(ranking));
}

Node detection_limits_node(const Diagnosis& d) {
  Node::Array limits;
  for (const DetectionLimit& l : d.detection_limits) {
    Node one = Node::empty_object();
    one.set("effect", Node(l.effect));
    one.set("param", Node(l.param));
    one.set("unit", Node(l.unit));
    one.set("size", number_or_null(l.size));
    limits.push_back(std::move(one));
  }
  return Node(std::move(limits));
}

}  // namespace

Node diagnosis_json(const Diagnosis& d) {
  Node out = Node::empty_object();
  out.set("verdict", Node(verdict_names[static_cast<std::size_t>(d.verdict)]));
  out.set("named", named_node(d));
  out.set("equivalent", equivalent_node(d));
  out.set("unknown", unknown_node(d));
  Node fitted = d.nominal_fit.empty() ? Node::null() : Node::empty_object();
  for (const auto& [name, value] : d.nominal_fit) fitted.set(name, number_or_null(value));
  out.set("nominal_fit", std::move(fitted));
  out.set("gap", gap_node(d.gap));
  out.set("ranking", ranking_node(d));
  out.set("manoeuvre", d.manoeuvre.empty() ? Node::null() : Node(d.manoeuvre));
  if (d.verdict == Verdict::nothing_missing) out.set("seen_at", detection_limits_node(d));
  out.set("sentence", Node(d.sentence));
  return out;
}

Node world_patch(const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world) {
  const Catalogue& catalogue = diagnoser.catalogue();
  const Node& read = world.vehicle.effects_read;
  if ((read.is_array() ? read.array().size() : 0) != world.vehicle.effects.size())
    throw std::logic_error("a patch is of a world with all effects of its file; this one has others");
  Node plant = Node::empty_object();
  if (!d.nominal_fit.empty()) {
    Node params = Node::empty_object();
    for (const auto& [name, value] : d.nominal_fit) params.set(name, number_or_null(value));
    plant.set("params", std::move(params));
  }
  Node::Array effects;
  for (const Catalogue::Link& link : catalogue.chain(d.fit.model))
    effects.push_back(link.own ? own_node(read.array()[link.index], world.vehicle.effects[link.index])
                               : member_node(catalogue, d.fit.model, link.index));
  plant.set("effects", Node(std::move(effects)));
  Node patch = Node::empty_object();
  patch.set("plant", std::move(plant));
  const bool commands_held = diagnoser.problem().hold() != measured::CommandHold{};
  if (commands_held != (world.hold == Hold::zoh))
    patch.set("input_hold", Node(std::string(commands_held ? "zoh" : "foh")));
  if (d.delays.empty()) return patch;
  Node delays = Node::empty_object(), calibration = Node::empty_object();
  for (const NamedEffect& delay : d.delays)
    delays.set(delay.effect.substr(0, delay.effect.rfind("_delay")), number_or_null(delay.params.front().value));
  calibration.set("delays", std::move(delays));
  patch.set("calibration", std::move(calibration));
  return patch;
}

void write_diagnosis(const fs::path& folder, const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world,
                     const fs::path& world_file, const std::optional<fs::path>& track) {
  fs::create_directories(folder);
  write_file(folder / "diagnosis.json", to_json_text(diagnosis_json(d)));
  Node augmented = Node::empty_object();
  augmented.set("note", Node(d.sentence));
  const fs::path base = fs::absolute(folder);
  augmented.set("extends", Node(fs::absolute(world_file).lexically_relative(base).generic_string()));
  if (track) augmented.set("track", Node(fs::absolute(*track).lexically_relative(base).generic_string()));
  const Node patch = world_patch(d, diagnoser, world);
  for (const char* const key : {"plant", "calibration", "input_hold"})
    if (const Node* const part = patch.find(key); part != nullptr) augmented.set(key, *part);
  write_file(folder / "augmented_world.json", to_json_text(augmented));
}

}  // namespace gripline::diagnose
