#include "calibrate/effects/yaw_limit.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/effects/effect_trial.hpp"
#include "car/instant.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace {

/// What an effect of Stage::reading with one parameter makes of a reading.
Reading<double> shown_by(const Effect& effect, double value, Reading<double> reading, const Place& at) {
  InstantPoints instant({0.2, 0.1}, at, &value);
  instant.points.reading = &reading;
  effect.apply(instant.points);
  return reading;
}

bool nearly_same(const Reading<double>& a, const Reading<double>& b) {
  const auto same = [](double one, double other) { return std::abs(one - other) < 1e-12; };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.yaw, b.yaw) && same(a.vx, b.vx) && same(a.vy, b.vy) &&
         same(a.omega, b.omega);
}

}  // namespace

bool offsets_yaw_rate(const PluginEntry& entry, const Effect& effect) {
  if (effect.stage() != Stage::reading || effect.memory() > 0 || entry.params().size() != 1) return false;
  const abi::ParamDecl& p = entry.params().front();
  if (p.type != abi::ParamType::number || !(p.lo < p.hi)) return false;
  Place here, there;
  there.t = 7.0;
  there.s = 1.3;
  there.n = 0.1;
  there.lap_fraction = 0.13;
  const Reading<double> slow{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, fast{-3.0, 2.0, -1.5, 9.0, -0.7, -2.5};
  for (const double part : {0.3, 0.6}) {
    const double value = std::lerp(std::max(p.lo, -1.0), std::min(p.hi, 1.0), part);
    for (const auto& [reading, at] : {std::pair(slow, here), {slow, there}, {fast, here}, {fast, there}}) {
      Reading<double> expected = reading;
      expected.omega += value;
      if (!nearly_same(shown_by(effect, value, reading, at), expected)) return false;
    }
  }
  return true;
}

std::optional<measured::YawRateOffset> offset_by_yaw(const std::list<measured::SessionFile>& files) {
  std::vector<const Session*> sessions;
  for (const measured::SessionFile& file : files) sessions.push_back(&file.session);
  return measured::yaw_rate_offset(sessions);
}

std::optional<measured::YawRateOffset> offset_by_yaw(std::list<measured::SessionFile> files,
                                                     const HeldOutTimes& held_out) {
  for (measured::SessionFile& file : files) {
    Session& s = file.session;
    for (std::size_t row = 0; row < s.rows(); ++row)
      if (held_out.holds(s.t[row] - s.t.front())) s.reading[row * channels + measured::Channel::yaw] = not_a_number;
  }
  return offset_by_yaw(files);
}

void limit_to_yaw(std::span<CandidateEffect> candidates, const std::optional<measured::YawRateOffset>& by_yaw) {
  if (!by_yaw) return;
  const auto [low, high] = by_yaw->range();
  for (CandidateEffect& c : candidates) {
    if (!offsets_yaw_rate(*c.entry, *c.effect)) continue;
    const double nothing = c.numbers.front();
    c.low.front() = std::clamp(std::min(nothing, low), c.low.front(), nothing);
    c.high.front() = std::clamp(std::max(nothing, high), nothing, c.high.front());
  }
}

std::vector<Unknown> limit_to_yaw(const WorldSpec& world, std::span<const ParameterPlace> places,
                                  const std::optional<measured::YawRateOffset>& by_yaw, std::span<double> values,
                                  std::span<Unknown> unknowns) {
  std::vector<Unknown> all;
  if (!by_yaw) return all;
  const PluginContext context = Trial::context_of(world);
  const auto [low, high] = by_yaw->range();
  // Places are in the order of the world: its model, then its effects.
  std::size_t index = world.vehicle.model.entry->params().size();
  for (const PluginSpec& spec : world.vehicle.effects) {
    const std::size_t first = index;
    index += spec.entry->params().size();
    if (!offsets_yaw_rate(*spec.entry, *create<Effect>(*spec.entry, context, spec.values))) continue;
    for (Unknown& u : unknowns) {
      const auto is_it = [&](const Unknown::Same& s) { return s.index == places[first].index; };
      if (u.index != places[first].index && std::ranges::none_of(u.same, is_it)) continue;
      if (low > u.high || high < u.low) continue;
      u.low = std::max(u.low, low);
      u.high = std::min(u.high, high);
      // Not to the nearer end: a fit goes back to the prior where it ends at a bound.
      const double own = std::clamp(by_yaw->value, u.low, u.high);
      const auto is_outside = [&](double value) { return value < u.low || value > u.high; };
      if (is_outside(u.prior)) u.prior = own;
      assign(values, u, is_outside(values[u.index]) ? own : values[u.index]);
      all.push_back(u);
    }
  }
  return all;
}

}  // namespace gripline::calibrate
