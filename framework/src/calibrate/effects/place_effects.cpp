#include "calibrate/effects/place_effects.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "car/instant.hpp"

namespace gripline::calibrate {
namespace {

/// A car in a bend; every quantity is 1, so that factors and sums show.
Quantities<double> in_a_bend() {
  Quantities<double> q;
  constexpr std::size_t count = sizeof(Quantities<double>) / sizeof(double);
  static_assert(sizeof(Quantities<double>) % sizeof(double) == 0);
  double ones[count];
  std::fill(std::begin(ones), std::end(ones), 1.0);
  std::memcpy(&q, ones, sizeof q);
  return q;
}

/// Quantities as they are compared: what is no number is equal to itself.
using Bits = std::array<std::uint64_t, sizeof(Quantities<double>) / sizeof(double)>;

Place somewhere(double lap_fraction) {
  Place at;
  at.t = 1.0;
  at.lap_fraction = lap_fraction;
  at.s = 100.0 * lap_fraction;
  at.n = lap_fraction;
  at.yaw_line = lap_fraction;
  at.kappa = lap_fraction;
  return at;
}

}  // namespace

bool depends_on_place(const Effect& effect, std::span<const double> params) {
  if (effect.stage() == Stage::reading) return false;
  const auto m = static_cast<std::size_t>(effect.memory());
  const Quantities<double> before = in_a_bend();
  Bits first{};
  std::vector<double> memory(m, 0.5), first_rate(m), rate(m);
  for (const double f : {0.03, 0.17, 0.31, 0.45, 0.52, 0.68, 0.83, 0.97}) {
    Quantities<double> q = before;
    const Place at = somewhere(f);
    InstantPoints instant({1.0, 0.1}, at, params.data());
    instant.points.q = &q;
    instant.points.memory = memory.data();
    instant.points.memory_rate = rate.data();
    instant.points.memory_stride = m;
    effect.apply(instant.points);
    const auto bits = std::bit_cast<Bits>(q);
    if (f == 0.03) {
      first = bits;
      first_rate = rate;
    } else if (bits != first || rate != first_rate) {
      return true;
    }
  }
  return false;
}

std::vector<std::string> leave_out_place_effects(VehicleSpec& vehicle, const Car& car) {
  std::vector<std::string> gone;
  PluginContext context;
  context.car = car;
  std::erase_if(vehicle.effects, [&](const PluginSpec& spec) {
    const auto effect = create<Effect>(*spec.entry, context, spec.values);
    // At its neutral parameters an effect does nothing anywhere: it is asked at a strength that shows.
    std::vector<double> params = spec.numbers();
    for (std::size_t i = 0; i < params.size(); ++i)
      if (params[i] == 0.0)
        params[i] =
            std::clamp(0.1 + 0.01 * static_cast<double>(i), spec.entry->params()[i].lo, spec.entry->params()[i].hi);
    const bool by_place = depends_on_place(*effect, params);
    if (by_place) gone.push_back(spec.id());
    return by_place;
  });
  return gone;
}

}  // namespace gripline::calibrate
