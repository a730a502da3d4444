#include "diagnose/real_logs/real_files.hpp"

#include <array>
#include <cmath>

#include "config/json_file.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "measured/health/session_health.hpp"
#include "util/whole_file.hpp"

namespace gripline::diagnose {
namespace {

Node interval_node(double low, double high) { return Node(Node::Array{number_or_null(low), number_or_null(high)}); }

Node change_node(const calibrate::ForecastChange& c) {
  Node out = Node::empty_object();
  out.set("change", number_or_null(c.change));
  out.set("ci95", interval_node(c.low, c.high));
  return out;
}

/// The understeer gradient by the logs, and of the worlds.
Node understeer_node(const Cornering& corners) {
  if (!corners.by_log) return Node::null();
  const auto of = [](const std::optional<double>& gradient) { return number_or_null(gradient.value_or(NAN)); };
  Node out = Node::empty_object();
  out.set("gradient", number_or_null(corners.by_log->gradient));
  out.set("ci95", interval_node(corners.by_log->low, corners.by_log->high));
  out.set("unit", Node("rad s2/m"));
  out.set("given", of(corners.given));
  out.set("found", of(corners.found));
  return out;
}

/// What effects do to each log that figures are of.
Node sessions_node(std::span<const SessionChange> sessions) {
  Node::Array out;
  for (const SessionChange& one : sessions) {
    Node row = Node::empty_object();
    row.set("log", Node(std::filesystem::path(one.log).filename().string()));
    row.set("calibrated", number_or_null(one.calibrated));
    row.set("after", number_or_null(one.found));
    const Node change = change_node(one.change);
    for (const Member& m : change.object()) row.set(m.key, m.value);
    out.push_back(std::move(row));
  }
  return Node(std::move(out));
}

/// What calibration made of the world's own parameters that the logs determine.
Node calibrated_node(const MissingEffects& found) {
  Node::Array out;
  for (const calibrate::FittedParameter& p : found.own_parameters()) {
    Node row = Node::empty_object();
    row.set("param", Node(p.unknown.pointer));
    row.set("given", number_or_null(p.unknown.prior));
    row.set("found", number_or_null(p.value));
    row.set("ci95", interval_node(p.interval.low, p.interval.high));
    out.push_back(std::move(row));
  }
  return Node(std::move(out));
}

/// What effects are, in the words of their plugins.
Node words_of_effects(const Registry& registry) {
  Node out = Node::empty_object();
  for (const PluginEntry& entry : registry.entries()) {
    if (entry.decl->kind != abi::Kind::effect) continue;
    Node params = Node::empty_object();
    for (const abi::ParamDecl& p : entry.params()) {
      Node one = Node::empty_object();
      one.set("words", Node(std::string(p.doc)));
      one.set("unit", Node(std::string(p.unit)));
      params.set(p.name, std::move(one));
    }
    Node effect = Node::empty_object();
    effect.set("words", Node(std::string(entry.decl->summary)));
    effect.set("params", std::move(params));
    out.set(entry.decl->id, std::move(effect));
  }
  return out;
}

}  // namespace

Node real_diagnosis_json(const Diagnosis& d, const MissingEffects& found, const Cornering& corners) {
  Node json = diagnosis_json(d);
  Node& gap = *json.find("gap");
  gap.set("calibrated", number_or_null(found.calibrated));
  gap.set("noise", number_or_null(found.noise > 0.0 ? found.noise : NAN));
  gap.set("at_noise", Node(found.at_noise()));
  gap.set("noise_too_large", Node(found.noise_too_large()));
  gap.set("judged", number_or_null(found.validation));
  gap.set("calibration", change_node(found.calibration));
  gap.set("effects", found.named.empty() ? Node::null() : change_node(found.change));
  gap.set("sessions", found.named.empty() ? Node::null() : sessions_node(found.sessions));
  json.set("understeer", understeer_node(corners));
  json.set("understeer_reason", corners.why_not.empty() ? Node::null() : Node(corners.why_not));
  return json;
}

void write_real_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const MissingEffects& found,
                          const Cornering& corners) {
  write_file(folder / "diagnosis.json", to_json_text(real_diagnosis_json(d, found, corners)));
  Node augmented = found.world;
  augmented.set("note", Node(d.sentence));
  write_file(folder / "augmented_world.json", to_json_text(augmented));
}

Node real_report(const Diagnosis& d, const MissingEffects& found, const std::string& world_file,
                 const Registry& registry, const std::list<measured::SessionFile>& files) {
  Node out = Node::empty_object();
  out.set("sentence", Node(d.sentence));
  std::string logs;
  Node::Array health;
  constexpr std::array<const char*, 3> levels = {"good", "note", "bad"};
  for (const measured::SessionFile& file : files) {
    const std::string name = std::filesystem::path(file.session.name).filename().string();
    logs += (logs.empty() ? "" : ", ") + name;
    for (const measured::Finding& f : measured::health_of(file)) {
      Node row = Node::empty_object();
      row.set("check", Node(name + ": " + f.check));
      row.set("found", Node(f.found));
      row.set("done", Node(f.done));
      row.set("level", Node(levels[static_cast<std::size_t>(f.level)]));
      health.push_back(std::move(row));
    }
  }
  out.set("log", Node(logs));
  out.set("world", Node(world_file));
  out.set("effects", words_of_effects(registry));
  out.set("calibrated", calibrated_node(found));
  out.set("health", Node(std::move(health)));
  return out;
}

}  // namespace gripline::diagnose
