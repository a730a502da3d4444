#include "experiment/validation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <gripline/slip.hpp>

#include "config/file_kind.hpp"
#include "config/json_file.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"
#include "util/csv_writer.hpp"

namespace gripline {
namespace {

constexpr std::array<const char*, 5> channel_names = {"e_vx", "e_vy", "e_omega", "force_front", "force_rear"};
constexpr std::array<const char*, 5> channel_units = {"m/s2", "m/s2", "rad/s2", "N", "N"};

/// Truth and prediction of one channel along a lap.
struct ChannelTrace {
  std::vector<double> t, truth, predicted, slip;
  void add(double time, double is, double said, double slip_angle = NAN) {
    t.push_back(time);
    truth.push_back(is);
    predicted.push_back(said);
    slip.push_back(slip_angle);
  }
};
using ChannelTraces = std::array<ChannelTrace, channel_names.size()>;

ChannelScore score(const std::string& estimator, std::size_t channel, const ChannelTrace& trace) {
  ChannelScore s = {estimator, channel_names[channel], channel_units[channel], trace.truth.size(), 0, 0};
  double mean = 0.0, residual = 0.0, total = 0.0;
  for (const double e : trace.truth) mean += e / static_cast<double>(s.n);
  for (std::size_t i = 0; i < s.n; ++i) {
    residual += (trace.truth[i] - trace.predicted[i]) * (trace.truth[i] - trace.predicted[i]);
    total += (trace.truth[i] - mean) * (trace.truth[i] - mean);
  }
  s.r2 = total > 0.0 ? 1.0 - residual / total : NAN;
  s.rmse = s.n > 0 ? std::sqrt(residual / static_cast<double>(s.n)) : NAN;
  return s;
}

/// Collects scores and writes both files.
class ValidationFiles {
 public:
  explicit ValidationFiles(const std::filesystem::path& out)
      : scores_(out / "validation.csv", "estimator,channel,unit,n,r2,rmse"),
        traces_(out / "validation_traces.csv", "estimator,channel,t_s,truth,predicted,slip_rad") {}
  void add(const std::string& estimator, const ChannelTraces& traces, std::vector<ChannelScore>& all) {
    for (std::size_t channel = 0; channel < traces.size(); ++channel) {
      const ChannelTrace& trace = traces[channel];
      if (trace.t.empty()) continue;
      const ChannelScore s = score(estimator, channel, trace);
      all.push_back(s);
      scores_ << s.estimator << s.channel << s.unit << static_cast<std::int64_t>(s.n) << s.r2 << s.rmse;
      scores_.end_row();
      for (std::size_t i = 0; i < trace.t.size(); ++i) {
        traces_ << estimator << channel_names[channel] << trace.t[i] << trace.truth[i] << trace.predicted[i]
                << trace.slip[i];
        traces_.end_row();
      }
    }
  }

 private:
  CsvWriter scores_, traces_;
};

/// What the model of a step leaves unexplained, as rates of vx, vy, omega.
std::array<double, 3> unexplained(const State& after, const State& predicted, double dt) {
  return {(after.vx - predicted.vx) / dt, (after.vy - predicted.vy) / dt, (after.omega - predicted.omega) / dt};
}

/// A drive as samples of true states.
class SampleRecorder final : public StepObserver {
 public:
  explicit SampleRecorder(CorrectedModel nominal) : nominal_(std::move(nominal)) {}
  void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack&) override {
    const Observation from = {at.t, world.step() - 1, before, at, 0.0};
    const Observation to = {world.time(), world.step(), world.state(), world.place(), u.d};
    samples_.push_back(residual_sample(nominal_, from, u, to));
  }
  std::vector<Sample> take() { return std::move(samples_); }

 private:
  CorrectedModel nominal_;
  std::vector<Sample> samples_;
};

/// One of several simulations that the progress counts.
struct PartOfWork {
  const ProgressCallback& callback;
  std::size_t index, count;
  std::string what;
  void follow(Simulation& simulation) {
    if (!callback) return;
    simulation.on_progress(
        [](void* context, double fraction) {
          const auto& part = *static_cast<const PartOfWork*>(context);
          part.callback(static_cast<double>(part.index) + fraction, part.count, part.what);
        },
        this);
  }
};

/// One drive of the driver in a world, kept in a scratch folder inside OUT.
std::vector<Sample> drive(const WorldSpec& spec, const StackSpec& driver, std::uint64_t seed,
                          const std::filesystem::path& folder, PartOfWork part) {
  RaceAssembly race(spec, driver, {.seed = seed, .folder = folder, .cache_dir = plugin_cache_folder()});
  PluginContext context;
  context.car = spec.car.car;
  context.dt = spec.dt;
  const Vehicle vehicle(driver.model, context);
  SampleRecorder samples(CorrectedModel(vehicle.car(), {spec.dt, spec.hold, driver.model.integration}));
  race.simulation().observe_with(&samples);
  part.follow(race.simulation());
  const RunSummary summary = race.run();
  if (summary.status != Status::finished)
    throw std::runtime_error(folder.filename().string() + ": the driver did not finish: " + summary.message);
  return samples.take();
}

struct OfflineSpec {
  WorldSpec train, test;
  StackSpec driver;
  std::vector<std::pair<std::string, PluginSpec>> estimators;
  std::uint64_t seed = 1;
};

WorldSpec read_drive_world(ObjectReader& r, const char* key, const Registry& registry, Errors& errors) {
  ObjectReader drive = r.object(key);
  WorldSpec world;
  if (const Node* node = drive.require("world", "a world file or an object"); node != nullptr) {
    Node whole = *node;
    inline_file_of(whole, FileKind::world);
    inline_world_files(whole);
    world = read_world(whole, registry, errors);
  }
  world.laps = static_cast<int>(drive.integer("laps", {1, 1000}, 1));
  drive.finish();
  return world;
}

OfflineSpec read_offline(const Node& tree, const Registry& registry) {
  Errors errors;
  OfflineSpec spec;
  {
    ObjectReader r(tree, errors);
    r.find("kind");
    spec.train = read_drive_world(r, "train", registry, errors);
    spec.test = read_drive_world(r, "test", registry, errors);
    spec.seed = static_cast<std::uint64_t>(r.integer("seed", {0, 1'000'000'000}, 1));
    Node driver{Node::Object{}};
    if (const Node* model = r.require("model", "a vehicle model"); model != nullptr) driver.set("model", *model);
    if (const Node* roles = r.require("driver", "a planner and a controller"); roles != nullptr && roles->is_object())
      for (const Member& member : roles->object()) driver.set(member.key, member.value);
    spec.driver = read_stack("driver", driver, registry, spec.train.car, errors);
    ObjectReader estimators = r.object("estimators");
    for (const Member* member : estimators.members()) {
      ObjectReader one(member->value, errors);
      spec.estimators.emplace_back(member->key, read_plugin(one, abi::Kind::estimator, registry));
      one.finish();
    }
    r.finish();
  }
  errors.throw_if_any();
  return spec;
}

/// Shows an estimator the training samples, then compares its correction with the test's.
ChannelTraces predict_offline(const OfflineSpec& spec, const PluginSpec& plugin, const std::vector<Sample>& train,
                              const std::vector<Sample>& test) {
  PluginContext context;
  context.car = spec.train.car.car;
  context.dt = spec.train.dt;
  context.seed = spec.seed;
  const Vehicle vehicle(spec.driver.model, context);
  const StepOptions options = {spec.train.dt, spec.train.hold, spec.driver.model.integration};
  CorrectedModel nominal(vehicle.car(), options);
  context.nominal = &nominal;
  const Instance<Estimator> estimator = create<Estimator>(*plugin.entry, context, plugin.values);
  for (const Sample& sample : train) estimator->update(sample);
  StagedCar car = vehicle.car();
  car.add(*estimator, {}, plugin.id());
  CorrectedModel corrected(std::move(car), options);
  ChannelTraces traces;
  for (const Sample& sample : test) {
    // Near standstill the tyres' equations are stiff for the control step: the residual is mostly integration error.
    if (sample.x.vx < context.car.v_min) continue;
    const State without = nominal.advance(sample.x, sample.u, sample.at);
    const auto said = unexplained(corrected.advance(sample.x, sample.u, sample.at), without, sample.dt);
    const double truth[] = {sample.e_vx, sample.e_vy, sample.e_omega};
    for (std::size_t i = 0; i < 3; ++i) traces[i].add(sample.t, truth[i], said[i]);
  }
  return traces;
}

/// Compares the predictions of a racing stack with the truth, each before it learns from the step, over the first full
/// lap after it trusts what it learned.
class LapEvaluation final : public StepObserver {
 public:
  LapEvaluation(const Vehicle& vehicle, const StackSpec& spec, const WorldSpec& world)
      : nominal_(vehicle.car(), {world.dt, world.hold, spec.model.integration}),
        adapt_after_(std::max(spec.adapt_after, spec.careful_until)) {}

  void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack& stack) override {
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
  const ChannelTraces& traces() const { return traces_; }

 private:
  static State predict(CorrectedModel& model, const State& x, const Input& u, const Place& at) {
    std::vector<double> row(static_cast<std::size_t>(model.states())), next(row.size());
    model.start(x, row);
    const double input[] = {u.d, u.ddelta};
    model.step(1, row, input, std::span(&at, 1), next, {}, {});
    return {next[0], next[1], next[2], next[3], next[4], next[5], next[6]};
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
    const double slips[] = {front_slip(std::abs(q.vx), q.vy, q.omega, q.delta, q.lf),
                            rear_slip(std::abs(q.vx), q.vy, q.omega, q.lr)};
    const World::Acting acting = world.acting();
    const double truth[] = {acting.force_front, acting.force_rear};
    for (std::size_t i = 0; i < 2; ++i) traces_[3 + i].add(t, truth[i], said[i], slips[i]);
  }

  CorrectedModel nominal_;
  double adapt_after_;
  int lap_ = -1;
  ChannelTraces traces_;
};

}  // namespace

void check_offline(const Node& tree, const Registry& registry) { read_offline(tree, registry); }

std::vector<ChannelScore> validate_offline(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                           const ProgressCallback& progress) {
  const OfflineSpec spec = read_offline(tree, registry);
  const std::size_t parts = 2 + spec.estimators.size();
  const auto train = drive(spec.train, spec.driver, spec.seed, out / "train", {progress, 0, parts, "training drive"});
  const auto test = drive(spec.test, spec.driver, spec.seed, out / "test", {progress, 1, parts, "test drive"});
  ValidationFiles files(out);
  std::vector<ChannelScore> all;
  std::size_t part = 2;
  for (const auto& [name, plugin] : spec.estimators) {
    if (progress) progress(static_cast<double>(part++), parts, name);
    files.add(name, predict_offline(spec, plugin, train, test), all);
  }
  return all;
}

std::vector<ChannelScore> validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                                          const std::filesystem::path& out, const ProgressCallback& progress) {
  ValidationFiles files(out);
  std::vector<ChannelScore> all;
  const auto asked = [&](const StackSpec& spec) {
    return !spec.estimator.empty() && std::find(rows.begin(), rows.end(), spec.name) != rows.end();
  };
  const auto count = static_cast<std::size_t>(std::count_if(race.stacks.begin(), race.stacks.end(), asked));
  std::size_t index = 0;
  for (const StackSpec& spec : race.stacks) {
    if (!asked(spec)) continue;
    PartOfWork part{progress, index++, count, spec.name};
    const RaceSetup setup = {.seed = race.seeds.front(), .folder = out / spec.name, .cache_dir = plugin_cache_folder()};
    RaceAssembly assembly(race.world, spec, setup);
    PluginContext context;
    context.car = race.world.car.car;
    context.dt = race.world.dt;
    const Vehicle vehicle(spec.model, context);
    LapEvaluation evaluation(vehicle, spec, race.world);
    assembly.simulation().observe_with(&evaluation);
    part.follow(assembly.simulation());
    assembly.run();
    files.add(spec.name, evaluation.traces(), all);
  }
  return all;
}

}  // namespace gripline
