#include "diagnose/model/shape_parameters.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <utility>

#include "car/instant.hpp"
#include "diagnose/model/candidates.hpp"

namespace gripline::diagnose {
namespace {

using QuantityBits = std::array<std::uint64_t, sizeof(Quantities<double>) / sizeof(double)>;
using ReadingBits = std::array<std::uint64_t, sizeof(Reading<double>) / sizeof(double)>;

/// Numbers between -1 and 1, the same ones each time.
class Numbers {
 public:
  double next() { return 2.0 * static_cast<double>(random_()) / static_cast<double>(std::mt19937::max()) - 1.0; }

 private:
  std::mt19937 random_{1};
};

/// A car somewhere on a lap, at some motion and under some commands.
struct SomeInstant {
  Quantities<double> q;
  Reading<double> reading;
  Place at;
  CommandSample<double> command;
};

/// With quantities of either sign, or all positive, as masses and forces of real cars are.
SomeInstant instant(Numbers& numbers, double lap_fraction, bool positive) {
  std::array<double, sizeof(Quantities<double>) / sizeof(double)> quantities;
  for (double& one : quantities) one = positive ? 0.5 * (1.1 + numbers.next()) : numbers.next();
  SomeInstant out;
  out.q = std::bit_cast<Quantities<double>>(quantities);
  out.reading = {numbers.next(), numbers.next(), numbers.next(), numbers.next(), numbers.next(), numbers.next()};
  out.at.t = 50.0 * (1.0 + numbers.next());
  out.at.s = lap_fraction;
  out.at.lap_fraction = lap_fraction;
  out.at.n = numbers.next();
  out.at.yaw_line = 3.0 * numbers.next();
  out.at.kappa = numbers.next();
  out.at.grade = 0.1 * numbers.next();
  out.at.bank = 0.1 * numbers.next();
  out.command = {numbers.next(), 0.5 * numbers.next()};
  return out;
}

/// What the effect makes of an instant.
std::pair<QuantityBits, ReadingBits> applied(const Effect& effect, const std::vector<double>& params, SomeInstant at) {
  InstantPoints points(at.command, at.at, params.data());
  if (effect.stage() == Stage::reading)
    points.points.reading = &at.reading;
  else
    points.points.q = &at.q;
  effect.apply(points.points);
  return {std::bit_cast<QuantityBits>(at.q), std::bit_cast<ReadingBits>(at.reading)};
}

}  // namespace

std::vector<std::size_t> shape_parameters(const Candidate& c) {
  constexpr int count = 101;
  std::vector<double> neutral = c.defaults;
  for (std::size_t f = 0; f < c.fitted.size(); ++f) neutral[c.fitted[f]] = c.decl(f).neutral;
  std::vector<bool> acts(c.fitted.size(), false);
  Numbers numbers;
  for (int k = 0; k < count; ++k) {
    const SomeInstant here = instant(numbers, static_cast<double>(k) / count, k % 2 == 0);
    const auto before = applied(*c.effect, neutral, here);
    for (std::size_t f = 0; f < c.fitted.size(); ++f) {
      if (acts[f]) continue;
      const abi::ParamDecl& p = c.decl(f);
      std::vector<double> moved = neutral;
      moved[c.fitted[f]] += p.neutral + p.scale <= p.hi ? p.scale : -p.scale;
      acts[f] = applied(*c.effect, moved, here) != before;
    }
  }
  std::vector<std::size_t> shapes;
  for (std::size_t f = 0; f < acts.size(); ++f)
    if (!acts[f]) shapes.push_back(f);
  return shapes;
}

}  // namespace gripline::diagnose
