#include "experiment/force_validation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gripline/slip.hpp>

#include "experiment/simulation_progress.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"

namespace gripline {
namespace {

/// Compares the predictions of a racing stack with the truth, each before it learns from the step, over the first full
/// lap after it trusts what it learned.
class LapEvaluation final : public StepObserver {
 public:
  LapEvaluation(const Vehicle& vehicle, const StackSpec& spec, const WorldSpec& world)
      : nominal_(vehicle.car(), {world.dt, world.hold, spec.model.integration}),
        adapt_after_(std::max(spec.adapt_after, spec.careful_until)) {}

  void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack& stack) override {
    laps_driven_ = world.laps();
    if (world.step() == 1) nominal_.reset(before, 0.0, at);
    const State without = nominal_.advance(before, u, at);
    if (at.t <= adapt_after_) return;
    if (lap_ < 0) lap_ = world.laps() + 1;
    if (world.laps() != lap_) return;
    const auto truth = unexplained(world.state(), without, world.spec().dt);
    StackBelief belief = stack.belief(at.t);
    const auto said = unexplained(predict(*belief.model, before, u, at), without, world.spec().dt);
    for (std::size_t i = 0; i < 3; ++i) traces_[i].add(at.t, truth[i], said[i]);
    add_forces(*belief.model, before, at.t, u, at, world);
  }
  /// Whether that lap was driven to its end.
  bool judged() const { return !traces_.front().t.empty() && laps_driven_ > lap_; }
  const ChannelTraces& traces() const { return traces_; }
  int laps_driven() const { return laps_driven_; }

 private:
  static State predict(CorrectedModel& model, const State& x, const Input& u, const Place& at) {
    std::vector<double> row(static_cast<std::size_t>(model.states())), next(row.size());
    model.start(x, row);
    const double input[] = {u.d, u.ddelta};
    model.step(1, row, input, std::span(&at, 1), next, {}, {});
    return state_of(next.data());
  }
  /// The true forces are those at the start of the step. The model's are solved from its accelerations there:
  /// m (vy' + vx omega) = Ff cos(delta) + Fr and Iz omega' = Ff lf cos(delta) - Fr lr, Ff and Fr positive to the left.
  /// They include loads, lags and whatever else the model has, for every estimator alike.
  void add_forces(CorrectedModel& model, const State& before, double t, const Input& u, const Place& at,
                  const World& world) {
    const Quantities<double> q = model.quantities(before, u, at);
    const double side = q.m * (q.ay + q.vx * q.omega);
    const double moment = q.Iz * q.aw;
    const double wheelbase = q.lf + q.lr;
    const double said[] = {(q.lr * side + moment) / (wheelbase * std::cos(q.delta)),
                           (q.lf * side - moment) / wheelbase};
    const double slips[] = {front_slip(std::abs(q.vx), q.vy, q.omega, steered_along_motion(q.vx, q.delta), q.lf),
                            rear_slip(std::abs(q.vx), q.vy, q.omega, q.lr)};
    const World::Acting acting = world.acting();
    const double truth[] = {acting.force_front, acting.force_rear};
    for (std::size_t i = 0; i < 2; ++i) traces_[3 + i].add(t, truth[i], said[i], slips[i]);
  }

  CorrectedModel nominal_;
  double adapt_after_;
  int lap_ = -1, laps_driven_ = 0;
  ChannelTraces traces_;
};

void add_unjudged(ForceScores& all, const std::string& row, int laps_driven, const RunSummary& run) {
  const bool finished = run.status == Status::finished;
  all.too_short = all.too_short || finished;
  all.unjudged += (all.unjudged.empty() ? "" : ", ") + row + " (" + std::to_string(laps_driven) + " laps driven" +
                  (finished ? "" : ": " + run.message) + ")";
}

}  // namespace

std::string no_lap_to_judge(const ForceScores& found) {
  return "no full lap to judge after the stack trusts what it learned (adapt_after): " + found.unjudged +
         (found.too_short ? "; a world of more laps, or an earlier adapt_after, gives one" : "");
}

ForceScores validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                            const std::filesystem::path& out, const ProgressCallback& progress) {
  ValidationFiles files;
  ForceScores all;
  const auto asked = [&](const StackSpec& spec) {
    return !spec.estimator.empty() && std::find(rows.begin(), rows.end(), spec.name) != rows.end();
  };
  const auto count = static_cast<std::size_t>(std::count_if(race.stacks.begin(), race.stacks.end(), asked));
  std::size_t index = 0;
  for (const StackSpec& spec : race.stacks) {
    if (!asked(spec)) continue;
    SimulationProgress part{progress, index++, count, spec.name};
    const RaceSetup setup = {.seed = race.seeds.front(), .folder = out / spec.name, .cache_dir = plugin_cache_folder()};
    WorldSpec world = race.world;
    StackSpec stack = spec;
    perturb(race.perturb, setup.seed, world, stack);
    RaceAssembly assembly(world, stack, setup);
    const Vehicle vehicle(spec.model, plugin_context(spec, stack_context(race.world, setup.seed)));
    LapEvaluation evaluation(vehicle, spec, race.world);
    assembly.simulation().observe_with(&evaluation);
    part.follow(assembly.simulation());
    const RunSummary run = assembly.run();
    if (evaluation.judged())
      files.add(spec.name, evaluation.traces(), all.scores);
    else
      add_unjudged(all, spec.name, evaluation.laps_driven(), run);
  }
  if (all.scores.empty() && !all.unjudged.empty()) throw std::runtime_error(no_lap_to_judge(all));
  files.write(out);
  return all;
}

}  // namespace gripline
