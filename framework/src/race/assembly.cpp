#include "race/assembly.hpp"

namespace gripline {

StackContext stack_context(const WorldSpec& spec, std::uint64_t seed) {
  StackContext context;
  context.car = spec.car.car;
  context.dt = spec.dt;
  context.hold = spec.hold;
  context.seed = seed;
  return context;
}

StackContext stack_context(const World& world, const RaceSetup& setup) {
  StackContext context = stack_context(world.spec(), setup.seed);
  context.course = &world.course();
  context.truth = &world.truth();
  context.cache_dir = setup.cache_dir.string();
  context.on_preparing = setup.on_preparing;
  return context;
}

namespace {

std::optional<Recorder> recorder_in(const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  std::filesystem::create_directories(folder);
  return Recorder(folder);
}

}  // namespace

RaceAssembly::RaceAssembly(const WorldSpec& world, const StackSpec& stack, const RaceSetup& setup)
    : world_(world, setup.seed),
      stack_(stack, stack_context(world_, setup), world_.observe()),
      recorder_(recorder_in(setup.folder)),
      metrics_(world_, stack, setup.seed),
      simulation_(world_, stack_, metrics_, recorder_ ? &*recorder_ : nullptr) {}

RunSummary RaceAssembly::run() {
  RunSummary summary = simulation_.run();
  if (recorder_) recorder_->finish();
  return summary;
}

}  // namespace gripline
