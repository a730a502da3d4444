// What holds of every effect plugin, in whatever file it is.
#include <gmock/gmock.h>

#include <random>
#include <set>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects {

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

/// Turns left and right round: y, yaw, vy, omega, steering and all that goes with them.
void mirror(Quantities<double>& q) {
  for (double* one : {&q.yaw, &q.vy, &q.omega, &q.delta, &q.delta_rate, &q.slip_front, &q.slip_rear, &q.force_front,
                      &q.force_rear, &q.ay, &q.aw, &q.bank})
    *one = -*one;
}

/// Parameters that turn round with left and right, by effect; of all others the mirrored value is the value.
const std::set<std::string> sided = {"steer_offset.d0", "steer_map.a",    "wind.wy",
                                     "plane_tilt.ty",   "yawrate_bias.b", "pose_yaw.a",
                                     "velocity_yaw.a",  "pose_lever.py",  "velocity_lever.py"};

double mirrored_value(const PluginEntry& entry, const abi::ParamDecl& p, double value) {
  const std::string id = entry.decl->id;
  return id == "bank" || sided.contains(id + "." + p.name) ? -value : value;
}

/// Seeded states of any kind: at rest, slow, fast, forwards, backwards, sliding.
Quantities<double> wild_quantities(std::mt19937_64& random) {
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  const double sizes[] = {0.0, 1e-6, 0.01, 0.3, 8.0};
  Quantities<double> q = test::bench_quantities();
  q.yaw = uniform(-3, 3);
  q.vx = uniform(-1, 1) * sizes[random() % 5];
  q.vy = uniform(-1, 1) * sizes[random() % 5];
  q.omega = uniform(-1, 1) * sizes[random() % 5];
  q.d = uniform(-1, 1), q.delta = uniform(-0.5, 0.5), q.delta_rate = uniform(-3, 3);
  q.drive_force = uniform(-20, 20);
  for (double* one : {&q.slip_front, &q.slip_rear, &q.force_front, &q.force_rear, &q.ax, &q.ay, &q.aw, &q.bank})
    *one = uniform(-2, 2);
  return q;
}

/// Parameters somewhere in the middle of their ranges and not symmetric about 0, within 1 where ranges are wider.
std::vector<double> usual_numbers(const PluginEntry& entry) {
  std::vector<double> values;
  for (const abi::ParamDecl& p : entry.params())
    values.push_back(std::clamp(0.3 + 0.05 * static_cast<double>(values.size()), p.lo, p.hi));
  return values;
}

/// Puts an effect on the bench, with memory and a ramp of commands that `side` (1 or -1) turns round.
void prepare(EffectBench& bench, double side) {
  const std::string id = bench.entry().decl->id;
  const bool turns = id == "relaxation" || id == "steer_lag" || id == "steer_rate_limit";
  bench.memory.assign(static_cast<std::size_t>(bench.effect().memory()), turns ? 0.3 * side : 0.3);
  bench.at.lap_fraction = 0.37, bench.at.t = 20;
  bench.commands.clear();
  for (const double now : {0.1, 0.25, 0.2}) bench.commands.push_back({now, side * now});
  bench.now = 0.03;
}

TEST(Effects, OfMirroredCarsAreMirrored) {
  int asked = 0;
  for (const PluginEntry& entry : test::plugins().entries()) {
    if (entry.decl->kind != abi::Kind::effect) continue;
    EffectBench left(entry.decl->id), right(entry.decl->id);
    if (left.effect().stage() == Stage::reading) continue;
    const std::vector<double> values = usual_numbers(entry);
    std::vector<double> mirrored;
    for (std::size_t i = 0; i < values.size(); ++i)
      mirrored.push_back(mirrored_value(entry, entry.params()[i], values[i]));
    prepare(left, 1.0);
    prepare(right, -1.0);
    std::mt19937_64 random(3);
    for (int k = 0; k < 500; ++k) {
      left.q = right.q = wild_quantities(random);
      mirror(right.q);
      Quantities<double> back = right.apply(mirrored);
      mirror(back);
      EXPECT_THAT(numbers_of(back), testing::Pointwise(testing::DoubleNear(1e-12), numbers_of(left.apply(values))))
          << entry.decl->id << " at vx " << left.q.vx << ", vy " << left.q.vy << ", omega " << left.q.omega;
      const double side = left.memory == right.memory ? 1.0 : -1.0;
      for (std::size_t i = 0; i < left.memory_rate.size(); ++i)
        EXPECT_NEAR(left.memory_rate[i], side * right.memory_rate[i], 1e-9) << entry.decl->id;
    }
    ++asked;
  }
  EXPECT_GE(asked, 30);
}

/// What takes speed takes it from cars that roll backwards, slide or turn too: m (vx vx' + vy vy') + Iz omega omega'
/// never grows.
TEST(Effects, ResistancesNeverAddEnergy) {
  for (const char* id : {"aero_drag", "rolling_res", "diff_yaw", "cornering_drag", "turning_drag"}) {
    EffectBench bench(id);
    std::mt19937_64 random(5);
    for (int k = 0; k < 2000; ++k) {
      bench.q = wild_quantities(random);
      const Quantities<double> q = bench.apply({0.4});
      const double power =
          q.m * (q.vx * (q.ax - bench.q.ax) + q.vy * (q.ay - bench.q.ay)) + q.Iz * q.omega * (q.aw - bench.q.aw);
      EXPECT_LE(power, 1e-12) << id << " at vx " << q.vx << ", vy " << q.vy << ", omega " << q.omega;
    }
  }
}

/// At the ends of their ranges, whatever the state, loads and peaks stay what they are: not below 0, numbers.
TEST(Effects, LoadsAndPeaksNeverFallBelowZero) {
  int effects = 0;
  for (const PluginEntry& entry : test::plugins().entries()) {
    if (entry.decl->kind != abi::Kind::effect) continue;
    EffectBench bench(entry.decl->id);
    const Stage stage = bench.effect().stage();
    if (stage != Stage::load && stage != Stage::tyre) continue;
    ++effects;
    std::mt19937_64 random(9);
    for (int k = 0; k < 1000; ++k) {
      std::vector<double> values;
      for (const abi::ParamDecl& p : entry.params()) values.push_back(random() % 2 == 0 ? p.lo : p.hi);
      bench.at.t = 30.0 * static_cast<double>(random() % 20);
      bench.q = wild_quantities(random);
      if (random() % 4 == 0) bench.q.peak_front = bench.q.peak_rear = random() % 2 == 0 ? 0.0 : 1e-300;
      const Quantities<double> q = bench.apply(values);
      for (const double one : {q.load_front, q.load_rear, q.peak_front, q.peak_rear})
        EXPECT_GE(one, 0.0) << entry.decl->id << " with " << values[0] << " at vx " << q.vx << ", t " << bench.at.t;
      EXPECT_GT(std::min(q.lf, q.lr), 0.0) << entry.decl->id;
    }
  }
  EXPECT_GT(effects, 0);
}

}  // namespace test_effects
}  // namespace gripline
