#include "diagnose/scoring/score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "config/json_file.hpp"
#include "config/reader.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "geometry/track_file.hpp"
#include "util/clock.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;
const double none = std::nan("");

std::string joined(const Names& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : "+") + n;
  return text.empty() ? "-" : text;
}

/// What answer.json says.
struct Answer {
  std::string kind, condition = "white";
  Names names;
  std::vector<Names> right;  // sets that count as right
  std::vector<std::pair<std::string, std::map<std::string, double>>> effects;
  std::map<std::string, double> nuisance;
  bool unknown = false;
  std::vector<std::string> where;
  std::optional<std::pair<double, double>> interval;
};

Names read_names(const Node& list, Errors& errors) {
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
    for (const Node& set : reader.array("equivalent", false)) a.right.push_back(read_names(set, errors));
    if (reader.find("process_noise") != nullptr) a.condition = "process_noise";
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
    // Whatever else an answer tells of its case is not asked here.
    (void)reader.members();
  }
  errors.throw_if_any();
  return a;
}

/// The model of the answer; empty when one of its effects is not in the catalogue.
std::optional<ModelSpec> true_model(const Catalogue& catalogue, const Answer& a) {
  ModelSpec model = catalogue.bare();
  for (const auto& [id, params] : a.effects) {
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

/// E of framework/doc/diagnose-cases.md, "Scores".
double rollout_error(const Catalogue& catalogue, const ModelSpec& model, const Measured& held, const Road& road,
                     const Channels& sigma) {
  const StagedCar car = catalogue.build(model);
  Trace trace;
  trace.log = held;
  trace.set_motion(held.reading, road);
  trace.set_motion(states_of_readings(car, held.reading, trace.at), road);
  RolloutOptions options;
  options.substeps = 4;
  return rms(roll_out(car, trace, road, options), sigma);
}

/// Minus log likelihood with free starts every second and no unknown accelerations.
double windowed_cost(const Problem& problem, const ModelSpec& model) {
  Noise noise;
  noise.sensor = problem.sensor;
  for (std::size_t i = 0; i < noise_states; ++i) noise.process[i] = std::pow(1e-4 * problem.process_unit[i], 2);
  const StagedCar car = problem.catalogue->build(model);
  double cost = 0.0;
  for (const Trace& trace : problem.traces) {
    FilterWants wants;
    wants.restart = static_cast<std::size_t>(std::round(1.0 / trace.log.dt));
    cost += filter(linearise(car, trace, problem.substeps), noise, wants).cost;
  }
  return cost;
}

void compare_params(const Answer& a, const Diagnosis& d, CaseScore& s) {
  double errors = 0.0, size = 0.0, inside = 0.0, count = 0.0;
  for (const auto& [id, truth] : a.effects)
    for (const NamedEffect& n : d.named) {
      if (n.effect != id) continue;
      for (const NamedEffect::Value& v : n.params) {
        const auto found = truth.find(v.name);
        if (found == truth.end()) continue;
        double off = v.value - found->second;
        double shift = 0.0;
        if (v.name == "s0") shift = std::round(off);
        off -= shift;
        errors += off * off;
        size += found->second * found->second;
        inside += v.low - shift <= found->second && found->second <= v.high - shift ? 1.0 : 0.0;
        count += 1.0;
      }
    }
  if (count == 0.0) return;
  s.parameter_error = std::sqrt(errors / size);
  s.covered = inside / count;
}

double judge(const Answer& a, const Diagnosis& d, const Names& named) {
  if (a.unknown) return d.verdict == Verdict::unknown ? 1.0 : 0.0;
  if (a.names.empty()) return d.verdict == Verdict::nothing_missing ? 1.0 : 0.0;
  const auto right = [&](const Names& set) { return std::find(a.right.begin(), a.right.end(), set) != a.right.end(); };
  if (d.verdict == Verdict::named) return right(named) ? 1.0 : 0.0;
  if (d.verdict == Verdict::indistinguishable)
    for (const auto& set : d.equivalent)
      if (right(Names(set.begin(), set.end()))) return a.right.size() >= d.equivalent.size() ? 1.0 : 0.5;
  return 0.0;
}

double judge_place(const Answer& a, const Diagnosis& d) {
  if (!d.unknown) return 0.0;
  const std::string where = where_names[static_cast<std::size_t>(d.unknown->where)];
  if (std::find(a.where.begin(), a.where.end(), where) == a.where.end()) return 0.0;
  if (!a.interval) return 1.0;
  double off = 0.5 * (d.unknown->from + d.unknown->to) - 0.5 * (a.interval->first + a.interval->second);
  if (where == "position") off -= std::round(off);
  return std::abs(off) <= (where == "position" ? 0.05 : 1.0) ? 1.0 : 0.0;
}

std::string cell(double v) {
  if (std::isnan(v)) return "";
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.6g", v);
  return buffer;
}

}  // namespace

std::vector<fs::path> case_folders(const fs::path& folder) {
  std::vector<fs::path> cases;
  for (const auto& one : fs::directory_iterator(folder))
    if (fs::is_regular_file(one.path() / "case.json")) cases.push_back(one.path());
  std::sort(cases.begin(), cases.end());
  return cases;
}

CaseScore score_case(const fs::path& folder, const Registry& registry, const WorldOf& world_of, const fs::path& out) {
  CaseFile file = read_case(folder / "case.json");
  const Answer a = read_answer(folder / "answer.json");  // first: without it the rest is in vain
  const fs::path world_file = world_of(file.vehicle);
  const Node node = load_world(world_file, file.track);
  Errors errors;
  if (const Node* u = node.find("nominal_uncertainty"); u != nullptr && file.options.uncertainty.empty())
    read_uncertainty(*u, file.options, errors);
  const WorldSpec world = read_world(node, registry, errors);
  errors.throw_if_any();

  CaseScore s;
  s.id = folder.filename().string();
  s.vehicle = file.vehicle;
  const double begin = process_cpu_s();
  Diagnoser diagnoser(world, registry, file.options);
  const LogExpectations expected{world.car.car.v_ref, &diagnoser.road()};
  const std::vector<LogFile> logs{read_log_file(folder / "measured.csv", expected)};
  const Diagnosis d = diagnoser.run(logs, {});
  s.cpu_s = process_cpu_s() - begin;
  if (!out.empty()) write_diagnosis(out, d, diagnoser, world, world_file, file.track);

  const Catalogue& catalogue = diagnoser.catalogue();
  s.kind = a.kind;
  s.condition = a.condition;
  s.truth = joined(a.names);
  s.verdict = verdict_names[static_cast<std::size_t>(d.verdict)];
  Names named;
  s.confidence = 1.0;
  for (const NamedEffect& n : d.named) {
    named.insert(n.effect);
    s.confidence = std::min(s.confidence, n.confidence);
  }
  s.named = joined(named);
  s.right = judge(a, d, named);
  s.class_size = d.verdict == Verdict::indistinguishable ? static_cast<double>(d.equivalent.size()) : none;
  s.located = a.unknown ? judge_place(a, d) : none;
  s.parameter_error = s.covered = s.closure = s.error_true = s.lambda = s.lambda_least = none;
  if (s.right > 0.0 && !a.unknown) compare_params(a, d, s);
  Channels sigma{};
  for (std::size_t c = 0; c < channels; ++c) sigma[c] = world.sensors.channels[c].sigma;
  const LogFile held = read_log_file(folder / "heldout.csv", LogExpectations{world.car.car.v_ref, nullptr});
  const Measured& log = held.stretches.front();
  s.error_before = rollout_error(catalogue, catalogue.bare(), log, diagnoser.road(), sigma);
  s.error_after = rollout_error(catalogue, d.fit.model, log, diagnoser.road(), sigma);
  const auto truth = true_model(catalogue, a);
  if (truth) {
    s.error_true = rollout_error(catalogue, *truth, log, diagnoser.road(), sigma);
    if (!a.names.empty() && s.error_before > s.error_true + 1e-6)
      s.closure = (s.error_before - s.error_after) / (s.error_before - s.error_true);
    ModelSpec without = catalogue.bare();
    without.nuisance = truth->nuisance;
    if (!a.names.empty()) {
      const double true_cost = windowed_cost(diagnoser.problem(), *truth);
      s.lambda = 2.0 * (windowed_cost(diagnoser.problem(), without) - true_cost);
      s.lambda_least = s.lambda;
      for (const std::size_t member : truth->members)
        if (truth->members.size() > 1)
          s.lambda_least =
              std::min(s.lambda_least,
                       2.0 * (windowed_cost(diagnoser.problem(), catalogue.without(*truth, member)) - true_cost));
    }
  }
  return s;
}

std::string score_csv(std::span<const CaseScore> scores) {
  std::string text =
      "case,kind,vehicle,condition,truth,verdict,named,right,lambda,lambda_least,confidence,closure,parameter_error,"
      "covered,"
      "error_before,error_after,error_true,located,class_size,cpu_s\n";
  for (const CaseScore& s : scores)
    text += s.id + "," + s.kind + "," + s.vehicle + "," + s.condition + "," + s.truth + "," + s.verdict + "," +
            s.named + "," + cell(s.right) + "," + cell(s.lambda) + "," + cell(s.lambda_least) + "," +
            cell(s.confidence) + "," + cell(s.closure) + "," + cell(s.parameter_error) + "," + cell(s.covered) + "," +
            cell(s.error_before) + "," + cell(s.error_after) + "," + cell(s.error_true) + "," + cell(s.located) + "," +
            cell(s.class_size) + "," + cell(s.cpu_s) + "\n";
  return text;
}

namespace {

/// A line of the scorecard over the cases a rule picks.
struct Line {
  const char* name;
  std::function<bool(const CaseScore&)> picks;
};

}  // namespace

std::string scorecard(std::span<const CaseScore> scores) {
  const auto detectable = [](const CaseScore& s) { return s.lambda_least >= 100.0; };
  const std::vector<Line> lines = {
      {"one effect, white noise",
       [&](const CaseScore& s) { return s.kind == "single" && s.condition == "white" && detectable(s); }},
      {"one effect, weak (25..100)",
       [&](const CaseScore& s) {
         return s.kind == "single" && s.condition == "white" && s.lambda >= 25.0 && s.lambda < 100.0;
       }},
      {"one effect, process noise",
       [&](const CaseScore& s) { return s.kind == "single" && s.condition == "process_noise" && detectable(s); }},
      {"one effect, wrong nominal",
       [&](const CaseScore& s) { return s.kind == "single" && s.condition == "wrong_nominal" && detectable(s); }},
      {"one effect, white, lambda >= 1000",
       [&](const CaseScore& s) { return s.kind == "single" && s.condition == "white" && s.lambda >= 1000.0; }},
      {"two effects, white",
       [&](const CaseScore& s) { return s.kind == "pair" && s.condition == "white" && detectable(s); }},
      {"two effects, process noise",
       [&](const CaseScore& s) { return s.kind == "pair" && s.condition == "process_noise" && detectable(s); }},
      {"three effects", [&](const CaseScore& s) { return s.kind == "triple"; }},
      {"nothing missing, white", [](const CaseScore& s) { return s.kind == "none" && s.condition == "white"; }},
      {"nothing missing, other", [](const CaseScore& s) { return s.kind == "none" && s.condition != "white"; }},
      {"unknown", [](const CaseScore& s) { return !std::isnan(s.located); }},
      {"all", [](const CaseScore&) { return true; }},
  };
  std::string text =
      "condition                          cases  right   wrong name  closure median / tenth   error*sqrt(lambda)  "
      "covered  "
      "located  cpu s\n";
  for (const Line& line : lines) {
    std::vector<double> right, closure, scaled, covered, located, cpu;
    std::size_t wrong = 0;
    for (const CaseScore& s : scores) {
      if (!line.picks(s)) continue;
      right.push_back(s.right);
      cpu.push_back(s.cpu_s);
      wrong += s.right == 0.0 && s.verdict == "named";
      if (!std::isnan(s.closure)) closure.push_back(s.closure);
      if (!std::isnan(s.parameter_error)) scaled.push_back(s.parameter_error * std::sqrt(std::max(0.0, s.lambda)));
      if (!std::isnan(s.covered)) covered.push_back(s.covered);
      if (!std::isnan(s.located)) located.push_back(s.located);
    }
    if (right.empty()) continue;
    const auto mean = [](const std::vector<double>& v) {
      double sum = 0.0;
      for (const double x : v) sum += x;
      return v.empty() ? none : sum / static_cast<double>(v.size());
    };
    const auto shown = [](double v, const char* format) {
      char buffer[40];
      std::snprintf(buffer, sizeof buffer, format, v);
      return std::isnan(v) ? std::string("-") : std::string(buffer);
    };
    char row[240];
    std::snprintf(
        row, sizeof row, "%-34s %5zu  %5.1f%%  %10zu  %8s / %8s     %8s            %5s    %5s   %5.2f\n", line.name,
        right.size(), 100.0 * mean(right), wrong, shown(linear_quantile(closure, 0.5), "%.4f").c_str(),
        shown(linear_quantile(closure, 0.1), "%.4f").c_str(), shown(linear_quantile(scaled, 0.5), "%.3f").c_str(),
        shown(mean(covered), "%.2f").c_str(), shown(mean(located), "%.2f").c_str(), mean(cpu));
    text += row;
  }
  double sure = 0, sure_right = 0, sure_detectable = 0, all = 0, worse = 0, brier = 0, judged = 0;
  for (const CaseScore& s : scores) {
    if (s.error_after > 1.02 * s.error_before) worse += 1;
    if (s.verdict != "named") continue;
    judged += 1;
    brier += std::pow(s.confidence - s.right, 2);
    if (s.confidence < 0.95) continue;
    sure += 1;
    sure_right += s.right;
    sure_detectable += s.kind != "none" && std::isnan(s.located) && detectable(s);
  }
  for (const CaseScore& s : scores) all += s.kind != "none" && std::isnan(s.located) && detectable(s);
  char row[240];
  std::snprintf(
      row, sizeof row,
      "confidence >= 0.95: %.0f answers, right %.1f%%; %.0f of %.0f detectable cases got one; Brier %.4f; worse than "
      "nominal %.0f of %zu\n",
      sure, sure > 0 ? 100.0 * sure_right / sure : 0.0, sure_detectable, all, judged > 0 ? brier / judged : 0.0, worse,
      scores.size());
  return text + row;
}

}  // namespace gripline::diagnose
