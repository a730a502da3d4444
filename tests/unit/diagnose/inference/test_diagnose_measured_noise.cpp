#include "diagnose/inference/measured_noise.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_measured_noise {

using test::DiagnoseRig;

/// With more unknowns a measurement explains at least as much, unless it ended on a lesser peak. Where both explain
/// about the same, what was asked for counts.
TEST(MeasuredNoise, OfTwoPeaksTheHigherIsTaken) {
  MeasuredNoise all, fewer;
  all.noise.command.moving[1] = 0.2;
  fewer.noise.sensor.fill(0.7);
  fewer.noise.colour.fill(0.9);
  const auto assumed = [&](double gain, double gain_of_fewer) {
    all.gain = gain;
    fewer.gain = gain_of_fewer;
    const MeasuredNoise one = higher_peak(all, fewer);
    const bool is_fewer = one.noise.command == UnknownCommands{};
    const MeasuredNoise& whole = is_fewer ? fewer : all;
    EXPECT_EQ(one.gain, whole.gain);
    EXPECT_EQ(one.noise.sensor, whole.noise.sensor);
    EXPECT_EQ(one.noise.colour, whole.noise.colour);
    return is_fewer ? "fewer" : "all";
  };
  constexpr double least = thresholds::noise_gain;
  for (const double gain : {-200.0, 0.0, 130.0}) {
    EXPECT_STREQ(assumed(gain, gain + 1.01 * least), "fewer") << gain;
    EXPECT_STREQ(assumed(gain, gain + 0.99 * least), "all") << gain;
    EXPECT_STREQ(assumed(gain, gain), "all") << gain;
    EXPECT_STREQ(assumed(gain, gain - 5.0 * least), "all") << gain;
  }
}

/// Less than what is assumed: something gone and nothing new. Levels and times are no such things.
TEST(MeasuredNoise, TellsWhetherLessIsAssumed) {
  const DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 2, .seed = 722})});
  MeasuredNoise white;
  white.noise.sensor = problem.sensor;
  white.noise_time = 2.0 * problem.noise_time;
  EXPECT_FALSE(is_simpler(problem, white)) << "there was nothing to leave";
  problem.colour[5] = 0.13;
  EXPECT_TRUE(is_simpler(problem, white));
  MeasuredNoise other = white;
  other.bend[0] = -0.1;
  EXPECT_FALSE(is_simpler(problem, other)) << "a bend has come for the colour";
  problem.bend[0] = -0.15;
  EXPECT_TRUE(is_simpler(problem, other));
  problem.command.moving[1] = 0.1;
  other.noise.command.steady[1] = 0.01;
  EXPECT_FALSE(is_simpler(problem, other));
}

/// Small differences are no other noise; larger ones are, of a level, a colour, a time, or of commands.
TEST(MeasuredNoise, IsOtherWhereItDiffersByMoreThanALittle) {
  const DiagnoseRig rig;
  const Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 2, .seed = 722})});
  const auto differs_with = [&](auto change) {
    MeasuredNoise m;
    m.noise.sensor = problem.sensor;
    m.noise.colour = problem.colour;
    m.noise.command = problem.command;
    m.noise_time = problem.noise_time;
    m.bend = problem.bend;
    change(m);
    return differs_from_assumed(problem, m);
  };
  using thresholds::other_noise_factor;
  EXPECT_FALSE(differs_with([](MeasuredNoise&) {}));
  EXPECT_FALSE(differs_with([](MeasuredNoise& m) { m.noise.sensor[3] *= 0.99 * other_noise_factor; }));
  EXPECT_TRUE(differs_with([](MeasuredNoise& m) { m.noise.sensor[3] /= 1.01 * other_noise_factor; }));
  EXPECT_TRUE(differs_with([](MeasuredNoise& m) { m.noise_time *= 1.01 * other_noise_factor; }));
  EXPECT_FALSE(differs_with([](MeasuredNoise& m) { m.noise.colour[5] -= 0.99 * thresholds::other_colour; }));
  EXPECT_TRUE(differs_with([](MeasuredNoise& m) { m.noise.colour[5] -= 1.01 * thresholds::other_colour; }));
  EXPECT_TRUE(differs_with([](MeasuredNoise& m) { m.bend[0] -= 1.01 * thresholds::other_bend; }));
  EXPECT_TRUE(differs_with([](MeasuredNoise& m) { m.noise.command.moving[1] = 0.1; }));
}

}  // namespace test_diagnose_measured_noise
}  // namespace gripline::diagnose
