#include "experiment/offline_validation.hpp"

#include <array>
#include <bit>

#include "config/file_kind.hpp"
#include "config/json_file.hpp"
#include "experiment/experiment.hpp"
#include "experiment/simulation_progress.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"

namespace gripline {
namespace {

/// A drive as samples of true states, from its start on.
class SampleRecorder final : public StepObserver {
 public:
  explicit SampleRecorder(CorrectedModel nominal) : nominal_(std::move(nominal)) {}
  void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack&) override {
    if (samples_.empty()) nominal_.reset(before, 0.0, at);
    const Observation from = {at.t, world.step() - 1, before, at, 0.0};
    const Observation to = {world.time(), world.step(), world.state(), world.place(), u.d};
    samples_.push_back(residual_sample(nominal_, from, u, to));
  }
  std::vector<Sample> take() { return std::move(samples_); }

 private:
  CorrectedModel nominal_;
  std::vector<Sample> samples_;
};

/// One drive of the driver in a world, kept in a scratch folder inside OUT.
std::vector<Sample> drive(const WorldSpec& spec, const StackSpec& driver, std::uint64_t seed,
                          const std::filesystem::path& folder, SimulationProgress part) {
  RaceAssembly race(spec, driver, {.seed = seed, .folder = folder, .cache_dir = plugin_cache_folder()});
  const Vehicle vehicle(driver.model, plugin_context(driver, stack_context(spec, seed)));
  SampleRecorder samples(CorrectedModel(vehicle.car(), {spec.dt, spec.hold, driver.model.integration}));
  race.simulation().observe_with(&samples);
  part.follow(race.simulation());
  const RunSummary summary = race.run();
  if (summary.status != Status::finished)
    throw std::runtime_error(folder.filename().string() + ": the driver did not finish: " + summary.message);
  if (summary.steps == 0)
    throw std::runtime_error(folder.filename().string() + ": the drive has no step; the world's duration is too short");
  return samples.take();
}

struct OfflineSpec {
  WorldSpec train, test;
  StackSpec driver;
  std::vector<std::pair<std::string, PluginSpec>> estimators;
  std::uint64_t seed = 1;
};

struct DriveWorld {
  WorldSpec spec;
  Node tree;  // null where the drive has none
};

DriveWorld read_drive_world(ObjectReader& r, const char* key, const Registry& registry, Errors& errors) {
  ObjectReader drive = r.object(key);
  DriveWorld world;
  if (const Node* node = drive.require("world", "a world file or an object"); node != nullptr) {
    world.tree = *node;
    inline_file_of(world.tree, FileKind::world);
    inline_world_files(world.tree);
    world.spec = read_world(world.tree, registry, errors);
  }
  world.spec.laps = static_cast<int>(drive.integer("laps", {1, 1000}, 1));
  drive.finish();
  return world;
}

bool same_car(const CarFile& a, const CarFile& b) {
  using Numbers = std::array<double, sizeof(Car) / sizeof(double)>;
  return std::bit_cast<Numbers>(a.car) == std::bit_cast<Numbers>(b.car) && a.known == b.known;
}

/// What was learned of the steps of one car says nothing of other steps or of another car.
void check_alike(const DriveWorld& train, const DriveWorld& test, Errors& errors) {
  const auto require_same = [&](const char* key, bool same) {
    if (same) return;
    const Node* at = test.tree.find(key);
    if (at == nullptr) at = train.tree.find(key);
    errors.add((at != nullptr ? *at : test.tree).origin,
               "the worlds of \"train\" and \"test\" differ in \"" + std::string(key) +
                   "\"; expected the same dt, input_hold and car: what is learned in one is asked about the other");
  };
  require_same("dt", train.spec.dt == test.spec.dt);
  require_same("input_hold", train.spec.hold == test.spec.hold);
  require_same("car", same_car(train.spec.car, test.spec.car));
}

OfflineSpec read_offline(const Node& tree, const Registry& registry) {
  Errors errors;
  OfflineSpec spec;
  {
    ObjectReader r(tree, errors);
    r.find("kind");
    DriveWorld train = read_drive_world(r, "train", registry, errors);
    DriveWorld test = read_drive_world(r, "test", registry, errors);
    if (errors.empty()) check_alike(train, test, errors);
    spec.train = std::move(train.spec);
    spec.test = std::move(test.spec);
    spec.seed = static_cast<std::uint64_t>(r.integer("seed", {0, largest_seed}, 1));
    Node driver(Node::Object{}, child_of(tree.origin, "driver"));
    if (const Node* model = r.require("model", "a vehicle model"); model != nullptr) driver.set("model", *model);
    if (const Node* roles = r.require("driver", "a planner and a controller"); roles != nullptr && roles->is_object())
      for (const Member& member : roles->object()) driver.set(member.key, member.value);
    spec.driver = read_stack("driver", driver, registry, spec.train.car, errors);
    for (const WorldSpec* world : {&spec.train, &spec.test}) check_sensors(spec.driver, world->sensors, errors);
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

/// Shows an estimator the training samples, then compares its correction with the test's. Both drives began without
/// throttle; models are led along all of them, whatever is judged, for what they remember.
ChannelTraces predict_offline(const OfflineSpec& spec, const PluginSpec& plugin, const std::vector<Sample>& train,
                              const std::vector<Sample>& test) {
  PluginContext context = plugin_context(spec.driver, stack_context(spec.train, spec.seed));
  const Vehicle vehicle(spec.driver.model, context);
  const StepOptions options = {spec.train.dt, spec.train.hold, spec.driver.model.integration};
  CorrectedModel nominal(vehicle.car(), options);
  context.nominal = &nominal;
  const Instance<Estimator> estimator = create<Estimator>(*plugin.entry, context, plugin.values);
  nominal.reset(train.front().x, 0.0, train.front().at);
  for (const Sample& sample : train) {
    nominal.advance(sample.x, sample.u, sample.at);
    estimator->update(sample);
  }
  StagedCar car = vehicle.car();
  car.add(*estimator, {}, plugin.id());
  CorrectedModel corrected(std::move(car), options);
  for (CorrectedModel* model : {&nominal, &corrected}) model->reset(test.front().x, 0.0, test.front().at);
  ChannelTraces traces;
  for (const Sample& sample : test) {
    const State without = nominal.advance(sample.x, sample.u, sample.at);
    const State with = corrected.advance(sample.x, sample.u, sample.at);
    // Near standstill the tyres' equations are stiff for the control step: the residual is mostly integration error.
    if (sample.x.vx < context.car.v_min) continue;
    const auto said = unexplained(with, without, sample.dt);
    const double truth[] = {sample.e_vx, sample.e_vy, sample.e_omega};
    for (std::size_t i = 0; i < 3; ++i) traces[i].add(sample.t, truth[i], said[i]);
  }
  return traces;
}

}  // namespace

void check_offline(const Node& tree, const Registry& registry) { read_offline(tree, registry); }

std::vector<ChannelScore> validate_offline(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                           const ProgressCallback& progress) {
  const OfflineSpec spec = read_offline(tree, registry);
  const std::size_t parts = 2 + spec.estimators.size();
  const auto train = drive(spec.train, spec.driver, spec.seed, out / "train", {progress, 0, parts, "training drive"});
  const auto test = drive(spec.test, spec.driver, spec.seed, out / "test", {progress, 1, parts, "test drive"});
  ValidationFiles files;
  std::vector<ChannelScore> all;
  std::size_t part = 2;
  for (const auto& [name, plugin] : spec.estimators) {
    if (progress) progress(static_cast<double>(part++), parts, name);
    files.add(name, predict_offline(spec, plugin, train, test), all);
  }
  files.write(out);
  return all;
}

}  // namespace gripline
