#include "limit/true_plant.hpp"

#include <algorithm>
#include <limits>

#include "car/instant.hpp"
#include "world/world.hpp"

namespace gripline {
namespace {

/// A friction schedule with the patches of a world and nothing else.
FrictionSchedule patches_of(const WorldSpec& spec) {
  FrictionSpec friction;
  friction.patches = spec.friction.patches;
  return {friction, spec.dt};
}

}  // namespace

TruePlant::TruePlant(const WorldSpec& spec, double factor, bool patches)
    : car_(spec.car.car),
      factor_(factor),
      patches_(patches ? patches_of(spec) : FrictionSchedule()),
      vehicle_(spec.vehicle, plugin_context(spec), &friction_),
      model_(vehicle_.car_without_memory()) {
  const World world(spec, 1);
  const Truth& truth = world.truth();
  const double both = truth.mu(Axle::front) * car_.lr + truth.mu(Axle::rear) * car_.lf;
  double least = factor;
  for (const FrictionSpec::Patch& patch : spec.friction.patches)
    least = std::min({least, factor_at(patch.from_s), factor_at(patch.to_s)});
  mu_ = least * both / (car_.lf + car_.lr) / truth.factor();
}

double TruePlant::factor_at(double station) const {
  return factor_ * patches_.factor(0, std::numeric_limits<double>::infinity(), station);
}

template <class T>
void TruePlant::rates(std::span<const T> motion, std::span<const ActingCommand<T>> command, std::span<const Place> at,
                      std::span<T> rate) const {
  const std::size_t n = command.size();
  // Commands have always been what they are now, for effects that read past ones.
  std::vector<CommandSample<T>> samples;
  std::vector<History<T>> history;
  samples.reserve(n);
  history.reserve(n);
  for (const ActingCommand<T>& u : command) samples.push_back({u.d, u.delta});
  for (const CommandSample<T>& sample : samples) history.push_back(always(sample, 1.0, Hold::zoh));
  for (std::size_t first = 0, end = 0; first < n; first = end) {
    const double factor = factor_at(at[first].s);
    for (end = first + 1; end < n && factor_at(at[end].s) == factor;) ++end;
    CarBatch<T> batch;
    batch.n = end - first;
    batch.motion = motion.data() + first * motion_size;
    batch.command = command.data() + first;
    batch.at = at.data() + first;
    batch.history = history.data() + first;
    batch.motion_rate = rate.data() + first * motion_size;
    rates_at_factor(factor, batch);
  }
}

template <class T>
void TruePlant::rates_at_factor(double factor, CarBatch<T> batch) const {
  const std::span<const double> values = model_.params();
  std::vector<T> params(values.begin(), values.end());
  if (vehicle_.has_stage(Stage::tyre)) params[model_.param_offset(0)] = factor;
  batch.params = params.data();
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
