// What holds of every effect plugin, in whatever file it is.
#include <gmock/gmock.h>

#include "support/effect_bench.hpp"

namespace gripline {
namespace {

using test::EffectBench;

std::vector<double> numbers_of(const Quantities<double>& q) {
  const auto* const first = reinterpret_cast<const double*>(&q);
  return {first, first + sizeof q / sizeof(double)};
}

/// The values at which an effect vanishes; none where it says none, or where they are beyond its ranges, as of lags.
std::vector<double> neutral_values(const PluginEntry& entry) {
  std::vector<double> values;
  bool fitted = false, within = true;
  for (const abi::ParamDecl& p : entry.params()) {
    fitted = fitted || p.fit;
    values.push_back(p.fit ? p.neutral : p.default_value);
    within = within && p.lo <= values.back() && values.back() <= p.hi;
  }
  return fitted && within ? values : std::vector<double>{};
}

/// Forwards, at rest and backwards.
TEST(Effects, ChangeNothingAtTheirNeutralValues) {
  int asked = 0;
  for (const PluginEntry& entry : test::plugins().entries()) {
    const std::vector<double> neutral = neutral_values(entry);
    if (entry.decl->kind != abi::Kind::effect || neutral.empty()) continue;
    EffectBench bench(entry.decl->id);
    if (bench.effect().stage() == Stage::reading) continue;
    bench.memory.assign(static_cast<std::size_t>(bench.effect().memory()), 0.3);
    // A ramp that is now, at its second sample, what acts on the bench.
    for (const double ahead : {-0.02, 0.0, 0.02})
      bench.commands.push_back({bench.q.d, bench.q.delta + ahead * bench.q.delta_rate});
    bench.now = bench.dt;
    for (const double vx : {4.0, 0.0, -4.0}) {
      bench.q.vx = vx;
      EXPECT_THAT(numbers_of(bench.apply(neutral)), testing::Pointwise(testing::DoubleNear(1e-12), numbers_of(bench.q)))
          << entry.decl->id << " at " << vx << " m/s";
    }
    ++asked;
  }
  EXPECT_GE(asked, 20);
}

}  // namespace
}  // namespace gripline
