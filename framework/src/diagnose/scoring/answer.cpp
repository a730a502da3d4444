#include "diagnose/scoring/answer.hpp"

#include <algorithm>
#include <cmath>

#include "config/json_file.hpp"
#include "config/reader.hpp"
#include "measured/session/log_map.hpp"

namespace gripline::diagnose {

namespace fs = std::filesystem;

namespace {

Names read_effects(const Node& list, Errors& errors) {
  Names ids;
  for (const Node& id : read_array(list, errors)) ids.insert(read_text(id, errors));
  return ids;
}

void read_effects(ObjectReader& reader, Answer& a) {
  for (const Node& one : reader.array("effects")) {
    ObjectReader effect(one, reader.errors());
    const std::string id = effect.text("effect");
    std::map<std::string, double> params;
    ObjectReader values = effect.object("params");
    for (const Member* p : values.members())
      if (p->value.is_number()) params[p->key] = p->value.number();
    a.names.insert(id);
    a.effects.emplace_back(id, params);
  }
}

/// Whether an id names a delay of channels.
bool is_delay(const std::string& id) {
  for (std::size_t group = 0; group < measured::delay_groups; ++group)
    if (id == measured::delay_effect(group)) return true;
  return false;
}

/// Effects that say the same as those named, and the delays that were taken off.
Names with_delays(std::span<const std::string> effects, const Diagnosis& d) {
  Names all(effects.begin(), effects.end());
  for (const NamedEffect& n : d.delays) all.insert(n.effect);
  return all;
}

}  // namespace

Answer read_answer(const fs::path& file) {
  if (!fs::exists(file)) throw InputError(file.string() + ": no such file; a case is scored against its answer");
  const Node node = parse_file(file);
  Errors errors;
  Answer a;
  if (!node.is_object()) throw InputError(node.origin, "expected an object with \"kind\" and \"effects\"");
  {
    ObjectReader reader(node, errors);
    a.kind = reader.text("kind");
    read_effects(reader, a);
    a.right.push_back(a.names);
    for (const Node& set : reader.array("equivalent", false)) a.right.push_back(read_effects(set, errors));
    if (reader.find("process_noise") != nullptr) {
      a.condition = "process_noise";
      ObjectReader noise = reader.object("process_noise");
      if (noise.has("tau_s") && noise.number("tau_s", "s", NumberRange::positive()) != default_noise_time)
        a.condition = "process_time";
      (void)noise.members();
    }
    if (reader.has("noise_correlation")) a.condition = "coloured_noise";
    if (reader.has("thinned")) a.condition = "thinned";
    if (reader.has("late")) a.condition = "late";
    if (reader.find("nuisance") != nullptr) {
      a.condition = "wrong_nominal";
      ObjectReader nuisance = reader.object("nuisance");
      for (const Member* m : nuisance.members())
        a.nuisance[m->key] = read_number(m->value, "1", NumberRange::any(), errors);
    }
    if (reader.find("unknown") != nullptr) {
      a.unknown = true;
      ObjectReader unknown = reader.object("unknown");
      for (const Node& w : unknown.array("where")) a.where.push_back(read_text(w, errors));
      if (unknown.find("interval") != nullptr)
        if (const auto ends = unknown.numbers("interval", "1", NumberRange::any(), 2); ends.size() == 2)
          a.interval = {ends[0], ends[1]};
      unknown.find("note");
    }
    // The other keys of an answer describe the case and are not needed.
    (void)reader.members();
  }
  errors.throw_if_any();
  return a;
}

Answer answer_of(std::vector<Names> right, bool hidden) {
  Answer a;
  a.unknown = right.empty() && hidden;
  if (right.empty()) right.emplace_back();
  a.names = right.front();
  a.right = std::move(right);
  return a;
}

std::optional<ModelSpec> true_model(const Catalogue& catalogue, const Answer& a) {
  ModelSpec model = catalogue.null_model();
  for (const auto& [id, params] : a.effects) {
    if (is_delay(id)) continue;  // of a channel: the car is as it is
    const std::size_t c = catalogue.find(id);
    if (c == catalogue.candidates().size()) return std::nullopt;
    model = catalogue.with(model, c);
    std::vector<double>& values = model.values[model.position(c)];
    for (std::size_t p = 0; p < values.size(); ++p)
      if (const auto found = params.find(catalogue.candidates()[c].entry->decl->params[p].name); found != params.end())
        values[p] = found->second;
  }
  for (std::size_t i = 0; i < catalogue.nuisances().size(); ++i) {
    const Nuisance& n = catalogue.nuisances()[i];
    if (const auto found = a.nuisance.find(n.name); found != a.nuisance.end())
      model.nuisance[i] = n.nominal * (1.0 + found->second);
    if (const auto found = a.nuisance.find(n.name + "_over_m"); found != a.nuisance.end())
      model.nuisance[i] = n.nominal + catalogue.car().m * found->second;
  }
  return model;
}

double judge(const Answer& a, const Diagnosis& d) {
  Names named;
  for (const NamedEffect& n : d.named) named.insert(n.effect);
  for (const NamedEffect& n : d.delays) named.insert(n.effect);
  if (a.unknown) return d.verdict == Verdict::unknown ? 1.0 : 0.0;
  if (a.names.empty()) return d.verdict == Verdict::nothing_missing ? 1.0 : 0.0;
  const auto right = [&](const Names& set) { return std::find(a.right.begin(), a.right.end(), set) != a.right.end(); };
  if (d.verdict == Verdict::named) return right(named) ? 1.0 : 0.0;
  if (d.verdict == Verdict::indistinguishable)
    for (const auto& set : d.equivalent)
      if (right(with_delays(set, d))) return a.right.size() >= d.equivalent.size() ? 1.0 : 0.5;
  return 0.0;
}

double judge_place(const Answer& a, const Diagnosis& d) {
  if (!d.unknown) return 0.0;
  const std::string where = where_names[static_cast<std::size_t>(d.unknown->where)];
  if (std::find(a.where.begin(), a.where.end(), where) == a.where.end()) return 0.0;
  if (!a.interval || (where != "position" && where != "time")) return 1.0;  // an interval is of a lap or of time
  double off = 0.5 * (d.unknown->from + d.unknown->to) - 0.5 * (a.interval->first + a.interval->second);
  if (where == "position") off -= std::round(off);
  return std::abs(off) <= (where == "position" ? 0.05 : 1.0) ? 1.0 : 0.0;
}

}  // namespace gripline::diagnose
