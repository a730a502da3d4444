#include "limit/true_plant.hpp"

#include "world/world.hpp"

namespace gripline {
namespace {

PluginContext context_of(const WorldSpec& spec) {
  PluginContext context;
  context.car = spec.car.car;
  context.dt = spec.dt;
  return context;
}

}  // namespace

TruePlant::TruePlant(const WorldSpec& spec, double factor)
    : car_(spec.car.car), vehicle_(spec.vehicle, context_of(spec), &friction_), model_(vehicle_.car_without_memory()) {
  if (vehicle_.has_stage(Stage::tyre)) model_.params()[model_.param_offset(0)] = factor;
  const World world(spec, 1);
  const Truth& truth = world.truth();
  const double both = truth.mu(Axle::front) * car_.lr + truth.mu(Axle::rear) * car_.lf;
  mu_ = factor * both / (car_.lf + car_.lr) / truth.factor();
}

template <class T>
void TruePlant::rates(std::span<const T> motion, std::span<const ActingCommand<T>> command, std::span<const Place> at,
                      std::span<T> rate) const {
  const std::size_t n = command.size();
  const std::span<const double> values = model_.params();
  const std::vector<T> params(values.begin(), values.end());
  // Commands have always been what they are now, for effects that look back.
  std::vector<CommandSample<T>> samples;
  std::vector<History<T>> history;
  samples.reserve(n);
  for (const ActingCommand<T>& u : command) samples.push_back({u.d, u.delta});
  for (const CommandSample<T>& sample : samples) history.push_back({&sample, 1, 0.0, 1.0, 0.0, Hold::zoh});
  CarBatch<T> batch;
  batch.n = n;
  batch.motion = motion.data();
  batch.command = command.data();
  batch.at = at.data();
  batch.params = params.data();
  batch.history = history.data();
  batch.motion_rate = rate.data();
  model_.rates(batch);
}

template void TruePlant::rates<double>(std::span<const double>, std::span<const ActingCommand<double>>,
                                       std::span<const Place>, std::span<double>) const;
template void TruePlant::rates<Dual8>(std::span<const Dual8>, std::span<const ActingCommand<Dual8>>,
                                      std::span<const Place>, std::span<Dual8>) const;

double TruePlant::acceleration(double v, double d) const {
  const double motion[] = {0, 0, 0, v, 0, 0};
  double rate[motion_size];
  const ActingCommand<double> command = {d, 0, 0};
  const Place at;
  rates<double>(motion, {&command, 1}, {&at, 1}, rate);
  return rate[3];
}

}  // namespace gripline
