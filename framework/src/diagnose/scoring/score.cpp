#include "diagnose/scoring/score.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "config/json_file.hpp"
#include "diagnose/inference/problem.hpp"
#include "diagnose/result/case_file.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "diagnose/scoring/answer.hpp"
#include "measured/replay/rollout.hpp"
#include "util/clock.hpp"
#include "util/numbers.hpp"
#include "world/world_spec.hpp"

namespace gripline::diagnose {
namespace {

namespace fs = std::filesystem;

std::string joined(const Names& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : "+") + n;
  return text.empty() ? "-" : text;
}

/// E of framework/doc/diagnose-cases.md, "Scores".
double rollout_error(const Catalogue& catalogue, const ModelSpec& model, const Log& held_out, const Road& road,
                     const Channels& sigma) {
  const StagedCar car = catalogue.build(model);
  Trace trace;
  trace.log = held_out;
  trace.set_motion(held_out.reading, road);
  trace.set_motion(measured::states_of_readings(car, held_out.reading, trace.at), road);
  measured::RolloutOptions options;
  options.substeps = 4;
  return rms(roll_out(car, trace, road, options), sigma);
}

/// Minus log likelihood with free starts every second and no unknown accelerations.
double windowed_cost(const Problem& problem, const ModelSpec& model) {
  Noise noise;
  noise.sensor = problem.sensor;
  noise.colour = problem.colour;
  noise.command = problem.command;
  for (std::size_t i = 0; i < noise_states; ++i) noise.process[i] = std::pow(1e-4 * problem.process_unit[i], 2);
  const StagedCar car = problem.catalogue->build(model);
  double cost = 0.0;
  for (const Trace& trace : problem.traces) {
    FilterOptions options;
    options.restart = static_cast<std::size_t>(std::round(1.0 / trace.log.dt));
    cost += filter(linearise(car, trace, problem.stepping()), noise, options).cost;
  }
  return cost;
}

/// Whether values of an effect's parameter a whole number apart mean the same.
bool is_periodic(const Catalogue& catalogue, const std::string& effect, const std::string& param) {
  const std::size_t found = catalogue.find(effect);
  if (found == catalogue.candidates().size()) return false;
  const auto params = catalogue.candidates()[found].entry->params();
  return std::any_of(params.begin(), params.end(),
                     [&](const abi::ParamDecl& p) { return p.name == param && p.periodic; });
}

void compare_params(const Catalogue& catalogue, const Answer& a, const Diagnosis& d, CaseScore& s) {
  double errors = 0.0, size = 0.0, inside = 0.0, count = 0.0;
  for (const auto& [id, truth] : a.effects)
    for (const NamedEffect& n : d.named) {
      if (n.effect != id) continue;
      for (const NamedEffect::Value& v : n.params) {
        const auto found = truth.find(v.name);
        if (found == truth.end()) continue;
        double off = v.value - found->second;
        double shift = 0.0;
        if (is_periodic(catalogue, id, v.name)) shift = std::round(off);
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

/// A case's files, its world and its diagnosis.
struct Diagnosed {
  CaseFile file;
  fs::path world_file;
  WorldSpec world;
  std::unique_ptr<Diagnoser> diagnoser;
  Diagnosis diagnosis;
  double cpu_s = 0;
};
/// Diagnoses the log of a case whose case.json is read.
void diagnose_case(const fs::path& folder, const Registry& registry, const WorldOf& world_of, Diagnosed& out) {
  out.world_file = world_of(out.file.vehicle);
  const Node node = load_world(out.world_file, out.file.track);
  Errors errors;
  CaseOptions& options = out.file.options;
  read_uncertainty_of_world(node, options, errors);
  out.world = read_world(node, registry, errors);
  errors.throw_if_any();
  const double begin = process_cpu_s();
  out.diagnoser = std::make_unique<Diagnoser>(out.world, registry, options);
  const measured::LogExpectations expected{out.world.car.car.v_ref, &out.diagnoser->road(),
                                           out.world.car.car.delta_max};
  const std::vector<LogFile> logs{read_log_file(folder / "measured.csv", expected)};
  out.diagnosis = out.diagnoser->run(logs, {});
  out.cpu_s = process_cpu_s() - begin;
}

/// What the diagnosis says, beside what is true.
void compare_names(const Answer& a, const Diagnosis& d, CaseScore& s) {
  s.kind = a.kind;
  s.condition = a.condition;
  s.truth = joined(a.names);
  s.verdict = verdict_names[static_cast<std::size_t>(d.verdict)];
  Names named;
  s.confidence = 1.0;
  for (const NamedEffect& n : d.delays) named.insert(n.effect);
  for (const NamedEffect& n : d.named) {
    named.insert(n.effect);
    s.confidence = std::min(s.confidence, n.confidence);
  }
  s.named = joined(named);
  s.right = judge(a, d);
  s.class_size = d.verdict == Verdict::indistinguishable ? static_cast<double>(d.equivalent.size()) : not_a_number;
  s.located = a.unknown ? judge_place(a, d) : not_a_number;
}

/// Likelihood ratios of the truth over nothing, and over itself without its least effect.
void measure_lambda(const Catalogue& catalogue, const Problem& problem, const ModelSpec& truth, CaseScore& s) {
  ModelSpec without = catalogue.null_model();
  without.nuisance = truth.nuisance;
  const double true_cost = windowed_cost(problem, truth);
  s.lambda = 2.0 * (windowed_cost(problem, without) - true_cost);
  s.lambda_least = s.lambda;
  for (const std::size_t member : truth.members)
    if (truth.members.size() > 1)
      s.lambda_least =
          std::min(s.lambda_least, 2.0 * (windowed_cost(problem, catalogue.without(truth, member)) - true_cost));
}

/// The model of a log whose channels are on time.
ModelSpec on_time(const Catalogue& catalogue, ModelSpec model) {
  for (std::size_t i = 0; i < model.nuisance.size(); ++i)
    if (catalogue.nuisances()[i].delay) model.nuisance[i] = 0.0;
  return model;
}

/// Errors of rollouts on the case's noise-free log by the nominal, the found and the true model.
void measure_errors(const fs::path& folder, const Diagnosed& one, const Answer& a, CaseScore& s) {
  const Catalogue& catalogue = one.diagnoser->catalogue();
  const Road& road = one.diagnoser->road();
  Channels sigma{};
  for (std::size_t c = 0; c < channels; ++c) sigma[c] = one.world.sensors.channels[c].sigma;
  LogFile held_out = read_log_file(
      folder / "heldout.csv", measured::LogExpectations{one.world.car.car.v_ref, nullptr, one.world.car.car.delta_max});
  measured::hold_commands(held_out.stretches.front(), one.diagnoser->problem().hold());
  const auto error = [&](const ModelSpec& model) {
    return rollout_error(catalogue, model, held_out.stretches.front(), road, sigma);
  };
  s.error_before = error(catalogue.null_model());
  s.error_after = error(on_time(catalogue, one.diagnosis.fit.model));
  auto truth = true_model(catalogue, a);
  if (!truth) return;
  s.error_true = error(*truth);
  if (a.names.empty()) return;
  if (s.error_before > s.error_true + 1e-6)
    s.closure = (s.error_before - s.error_after) / (s.error_before - s.error_true);
  if (!catalogue.fits_filter(*truth)) return;  // its likelihood is not known
  // The log that was searched is late by what is left of the delays taken off.
  for (std::size_t i = 0; i < truth->nuisance.size(); ++i)
    if (catalogue.nuisances()[i].delay) truth->nuisance[i] = one.diagnosis.null_model.model.nuisance[i];
  measure_lambda(catalogue, one.diagnoser->problem(), *truth, s);
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
  Diagnosed one;
  one.file = read_case(folder / "case.json");
  const Answer a = read_answer(folder / "answer.json");  // before the work, which without it is in vain
  diagnose_case(folder, registry, world_of, one);
  if (!out.empty()) write_diagnosis(out, one.diagnosis, *one.diagnoser, one.world, one.world_file, one.file.track);
  CaseScore s;
  s.id = folder.filename().string();
  s.vehicle = one.file.vehicle;
  s.cpu_s = one.cpu_s;
  compare_names(a, one.diagnosis, s);
  s.parameter_error = s.covered = s.closure = s.error_true = s.lambda = s.lambda_least = not_a_number;
  if (s.right > 0.0 && !a.unknown) compare_params(one.diagnoser->catalogue(), a, one.diagnosis, s);
  measure_errors(folder, one, a, s);
  return s;
}

}  // namespace gripline::diagnose
