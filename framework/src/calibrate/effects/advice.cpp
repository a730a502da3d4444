#include "calibrate/effects/advice.hpp"

#include <algorithm>

#include "calibrate/effects/yaw_limit.hpp"

namespace gripline::calibrate {

std::vector<Advice> advise(const WorldSpec& world, const Registry& registry, const ForecastOptions& forecast,
                           std::vector<FitLog>& logs, const FitResult& found,
                           const std::optional<measured::YawRateOffset>& by_yaw) {
  constexpr double sure = 2.0;  // standard deviations over blocks
  PluginContext context;
  context.car = world.car.car;
  const Vehicle vehicle(world.vehicle, context);
  auto candidates = candidate_effects(world.vehicle, world.car.car, registry, world.track != nullptr);
  limit_to_yaw(candidates, by_yaw);
  // Those that are kept at their priors too: an effect that does what they do is another name of them.
  std::vector<Unknown> fitted;
  for (const FittedParameter& p : found.parameters) fitted.push_back(p.unknown);
  std::vector<FitLog> half = thinned(logs, 2);
  std::vector<Advice> advice;
  for (const EffectScore& one :
       score_candidates(vehicle.car(), candidates, forecast, half, found.params, fitted, found.weighing)) {
    const CandidateEffect& c = candidates[one.candidate];
    if (!(one.score > sure)) continue;
    Advice would{c.id(), one.gain, one.score, {}};
    for (std::size_t i = 0; i < c.tested.size(); ++i) {
      const abi::ParamDecl& p = c.entry->params()[c.tested[i]];
      would.values.push_back({p.name, p.unit, c.numbers[c.tested[i]] + one.value[i]});
    }
    advice.push_back(std::move(would));
  }
  std::sort(advice.begin(), advice.end(), [](const Advice& a, const Advice& b) { return a.gain > b.gain; });
  return advice;
}

}  // namespace gripline::calibrate
