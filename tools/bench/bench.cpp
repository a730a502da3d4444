#include "bench/bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/json_file.hpp"
#include "race/assembly.hpp"
#include "util/clock.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

constexpr int longest_horizon = 50;
constexpr int replays = 3;

double thread_cpu_us() { return 1e6 * thread_cpu_s(); }

StackSpec stack_with(const std::string& estimator, int horizon, const WorldSpec& world, const Registry& registry) {
  const std::string text = R"({"model": {"plugin": "ekinematic", "params": {"yaw_gain": 0.003844}},
    "estimator": {"plugin": ")" +
                           estimator + R"("}, "planner": {"plugin": "friction_speed"},
    "controller": {"plugin": "mpc_sqp", "params": {"horizon": )" +
                           std::to_string(horizon) +
                           R"(, "q_yaw": 0.01, "r_ddelta": 0.01, "r_d": 1e-4}}, "adapt_after": 2})";
  Errors errors;
  StackSpec spec = read_stack("bench", parse_text(text), registry, world.car, errors);
  errors.throw_if_any();
  return spec;
}

/// A recorded control step, solved again by each controller.
struct RecordedStep {
  Observation now;
  std::vector<RefPoint> horizon;
  Sample sample;  // of the step before
};

/// A race, and data shared by all cases of the frozen model.
struct Recording {
  RaceAssembly race;
  std::vector<Sample> learned;  // everything the estimator saw
  std::vector<RecordedStep> steps;
};

/// The stack learns during the lead-in and is frozen afterwards.
void record(Recording& recording, int lead_in, int count) {
  Simulation& simulation = recording.race.simulation();
  simulation.start();
  for (int i = 0; i < lead_in; ++i) {
    simulation.step();
    recording.learned.push_back(simulation.sample());
  }
  simulation.stop_learning();
  for (int i = 0; i < count; ++i) {
    simulation.step();
    const auto horizon = simulation.horizon();
    recording.steps.push_back({simulation.now(), {horizon.begin(), horizon.end()}, simulation.sample()});
  }
}

PluginSpec controller_spec(const std::string& id, int horizon, const std::string& more, const Registry& registry) {
  Errors errors;
  const Node node = parse_text(R"({"plugin": ")" + id + R"(", "params": {"horizon": )" + std::to_string(horizon) +
                               R"(, "q_yaw": 0.01, "r_ddelta": 0.01, "r_d": 1e-4)" + more + "}}");
  ObjectReader reader(node, errors);
  PluginSpec spec = read_plugin(reader, abi::Kind::controller, registry);
  errors.throw_if_any();
  return spec;
}

struct Replay {
  std::vector<double> times, iterations;
  std::vector<Input> inputs;
  int failures = 0;
  double allocations = 0;
};

/// Progress of the bench in pieces of very different length.
class BenchProgress {
 public:
  BenchProgress(const ProgressCallback& callback, double cost, std::size_t rows)
      : callback_(callback), cost_(cost), rows_(rows) {}
  /// Begins a piece with its approximate cost, in any unit.
  void begin(std::string what, double cost) {
    done_ += now_;
    now_ = cost;
    what_ = std::move(what);
    at(0);
  }
  void at(double share) const {
    const auto rows = static_cast<double>(rows_);
    if (callback_) callback_(std::min(rows, rows * (done_ + share * now_) / cost_), rows_, what_);
  }

 private:
  const ProgressCallback& callback_;
  double cost_, done_ = 0, now_ = 0;
  std::size_t rows_;
  std::string what_;
};

/// Approximate cost of a replay: Ipopt's time grows faster than the horizon, the QP's is small beside it.
double replay_cost(const std::string& controller, int horizon) {
  return controller == "mpc_ipopt" ? horizon * horizon : horizon;
}

/// Every instance in turn to a fresh controller; with a learner, its update counts too.
Replay replay(Recording& recording, const WorldSpec& world, const PluginSpec& controller, int horizon,
              Estimator* learner, AllocationCount allocations, const BenchProgress& progress) {
  constexpr std::size_t told_every = 20;
  const gripline::Instance<Controller> instance =
      create<Controller>(*controller.entry, plugin_context(world), controller.values);
  CorrectedModel& model = *recording.race.stack().belief(recording.race.simulation().now().t).model;
  Replay out;
  const std::size_t warm = recording.steps.size() / 10;
  std::int64_t allocated = 0;
  for (std::size_t i = 0; i < recording.steps.size(); ++i) {
    const RecordedStep& one = recording.steps[i];
    const std::int64_t before = allocations();
    const double begin = thread_cpu_us();
    if (learner != nullptr) learner->update(one.sample);
    const Command command =
        instance->control(one.now, std::span(one.horizon).first(static_cast<std::size_t>(horizon) + 1), model);
    const double spent = thread_cpu_us() - begin;
    if (i >= warm) allocated += allocations() - before;
    out.times.push_back(spent);
    out.iterations.push_back(command.iterations);
    out.inputs.push_back(command.u);
    if (!command.solved) ++out.failures;
    if (i % told_every == 0) progress.at(static_cast<double>(i) / static_cast<double>(recording.steps.size()));
  }
  out.allocations = static_cast<double>(allocated) / static_cast<double>(recording.steps.size() - warm);
  return out;
}

double input_error(const Input& a, const Input& b, const Car& car) {
  return std::max(std::abs(a.d - b.d) / (car.d_max - car.d_min), std::abs(a.ddelta - b.ddelta) / (2 * car.ddelta_max));
}

BenchRow summarize(const std::string& name, const Replay& best, const std::vector<Input>* reference, const Car& car) {
  BenchRow row;
  row.name = name;
  row.median_us = nearest_rank_quantile(best.times, 0.5);
  row.p95_us = nearest_rank_quantile(best.times, 0.95);
  row.p99_us = nearest_rank_quantile(best.times, 0.99);
  row.max_us = *std::max_element(best.times.begin(), best.times.end());
  row.allocations_per_step = best.allocations;
  row.iterations_median = nearest_rank_quantile(best.iterations, 0.5);
  row.failures = best.failures;
  row.ratio_to_mpc_ipopt = row.first_input_error_p95 = row.first_input_error_max = not_a_number;
  if (reference == nullptr) return row;
  std::vector<double> errors;
  for (std::size_t i = 0; i < best.inputs.size(); ++i)
    errors.push_back(input_error(best.inputs[i], (*reference)[i], car));
  row.first_input_error_max = *std::max_element(errors.begin(), errors.end());
  row.first_input_error_p95 = nearest_rank_quantile(std::move(errors), 0.95);
  return row;
}

gripline::Instance<Estimator> copy_that_learns(const Recording& recording, const WorldSpec& world,
                                               const Registry& registry, CorrectedModel& nominal) {
  Errors errors;
  const Node node = parse_text(R"({"plugin": "elm"})");
  ObjectReader reader(node, errors);
  const PluginSpec spec = read_plugin(reader, abi::Kind::estimator, registry);
  errors.throw_if_any();
  PluginContext context = plugin_context(world);
  context.nominal = &nominal;
  gripline::Instance<Estimator> learner = create<Estimator>(*spec.entry, context, spec.values);
  for (const Sample& sample : recording.learned) learner->update(sample);
  return learner;
}

/// Each step at its least time: the replays do the same work.
void keep_least_times(Replay& best, const Replay& other) {
  for (std::size_t i = 0; i < best.times.size(); ++i) best.times[i] = std::min(best.times[i], other.times[i]);
}

/// The cases of one horizon, controllers in turn so that all see the same load of the machine.
void bench_horizon(int horizon, std::span<const std::string> controllers, Recording& recording, const WorldSpec& world,
                   const Registry& registry, CorrectedModel& nominal, AllocationCount allocations,
                   BenchProgress& progress, std::vector<BenchRow>& rows) {
  const std::string suffix = "_n" + std::to_string(horizon) + "_elm40";
  const PluginSpec exact =
      controller_spec("mpc_ipopt", horizon, R"(, "tolerance": 1e-10, "max_iterations": 1000)", registry);
  progress.begin("exact solutions" + suffix, replay_cost("mpc_ipopt", horizon));
  const std::vector<Input> reference = replay(recording, world, exact, horizon, nullptr, allocations, progress).inputs;
  std::vector<Replay> best(controllers.size());
  for (int i = 0; i < replays; ++i) {
    for (std::size_t c = 0; c < controllers.size(); ++c) {
      progress.begin(controllers[c] + suffix, replay_cost(controllers[c], horizon));
      const PluginSpec spec = controller_spec(controllers[c], horizon, "", registry);
      const auto learner = copy_that_learns(recording, world, registry, nominal);
      Replay one = replay(recording, world, spec, horizon, learner.get(), allocations, progress);
      if (i == 0)
        best[c] = std::move(one);
      else
        keep_least_times(best[c], one);
    }
  }
  double ipopt_median = not_a_number;
  for (std::size_t c = 0; c < controllers.size(); ++c)
    if (controllers[c] == "mpc_ipopt") ipopt_median = nearest_rank_quantile(best[c].times, 0.5);
  for (std::size_t c = 0; c < controllers.size(); ++c) {
    BenchRow row = summarize(controllers[c] + suffix, best[c], &reference, world.car.car);
    row.ratio_to_mpc_ipopt = row.median_us / ipopt_median;
    rows.push_back(std::move(row));
  }
}

/// Times the estimator's update alone, on the recorded samples: the case elm_update.
BenchRow bench_update(const Recording& recording, const WorldSpec& world, const Registry& registry,
                      CorrectedModel& nominal, AllocationCount allocations) {
  const auto learner = copy_that_learns(recording, world, registry, nominal);
  Replay out;
  const std::int64_t before = allocations();
  out.times.reserve(recording.steps.size());
  const std::int64_t reserved = allocations() - before;
  for (const RecordedStep& one : recording.steps) {
    const double begin = thread_cpu_us();
    learner->update(one.sample);
    out.times.push_back(thread_cpu_us() - begin);
  }
  out.allocations =
      static_cast<double>(allocations() - before - reserved) / static_cast<double>(recording.steps.size());
  return summarize("elm_update", out, nullptr, world.car.car);
}

/// A stack with a Gaussian process over its full window, as it races: update, plan and solve.
BenchRow bench_gp(const WorldSpec& world, const Registry& registry, AllocationCount allocations, int lead_in,
                  int count) {
  const StackSpec stack = stack_with("gp_own_mu", 20, world, registry);
  RaceAssembly race(world, stack);
  Simulation& simulation = race.simulation();
  simulation.start();
  for (int i = 0; i < lead_in; ++i) simulation.step();
  Replay out;
  const std::int64_t before = allocations();
  for (int i = 0; i < count; ++i) {
    simulation.step();
    const StepTiming& spent = simulation.timing();
    out.times.push_back(1e3 * (spent.update_ms + spent.plan_ms + spent.solve_ms));
    out.iterations.push_back(simulation.command().iterations);
    if (!simulation.command().solved) ++out.failures;
  }
  out.allocations = static_cast<double>(allocations() - before) / count;
  return summarize("gp_410", out, nullptr, world.car.car);
}

}  // namespace

std::vector<BenchRow> run_bench(const WorldSpec& world, const Registry& registry, AllocationCount allocations,
                                const BenchOptions& options, const ProgressCallback& callback) {
  constexpr int lead_in = 600;
  constexpr std::array horizons = {50, 20};
  double cost = 0;
  for (const int horizon : horizons) {
    cost += replay_cost("mpc_ipopt", horizon);
    for (const std::string& id : options.controllers) cost += replays * replay_cost(id, horizon);
  }
  const double drives = 0.02 * cost;
  const std::size_t cases = horizons.size() * options.controllers.size() + 2;
  BenchProgress progress(callback, cost + 2 * drives, cases);
  progress.begin("recording", drives);
  const StackSpec spec = stack_with("elm", longest_horizon, world, registry);
  Recording recording{RaceAssembly(world, spec), {}, {}};
  record(recording, lead_in, options.instances);
  const Vehicle vehicle(spec.model, plugin_context(world));
  CorrectedModel nominal(vehicle.car(), {world.dt, world.hold, spec.model.integration});
  std::vector<BenchRow> rows;
  for (const int horizon : horizons)
    bench_horizon(horizon, options.controllers, recording, world, registry, nominal, allocations, progress, rows);
  progress.begin("gp_410", drives);
  rows.push_back(bench_gp(world, registry, allocations, lead_in, options.instances));
  rows.push_back(bench_update(recording, world, registry, nominal, allocations));
  return rows;
}

void write_bench(const std::filesystem::path& file, std::span<const BenchRow> rows) {
  CsvWriter csv(file,
                "case,median_us,p95_us,p99_us,max_us,allocations_per_step,iterations_median,first_input_error_p95,"
                "first_input_error_max,failures,ratio_to_mpc_ipopt");
  for (const BenchRow& row : rows) {
    csv << row.name << row.median_us << row.p95_us << row.p99_us << row.max_us << row.allocations_per_step
        << row.iterations_median << row.first_input_error_p95 << row.first_input_error_max << row.failures
        << row.ratio_to_mpc_ipopt;
    csv.end_row();
  }
}

}  // namespace gripline
