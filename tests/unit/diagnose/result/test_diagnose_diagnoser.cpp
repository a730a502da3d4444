#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/inference/preparation.hpp"
#include "diagnose/result/diagnoser.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_diagnoser {

using test::DiagnoseRig;

/// What the filter has no room for is said where the world lists it, and not in the middle of a search.
TEST(Diagnoser, RefusesAWorldOfTooManyHiddenStatesAtItsPlace) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [
    {"plugin": "steer_lag", "params": {"tau": 0.02}}, {"plugin": "motor_lag", "params": {"tau": 0.06}},
    {"plugin": "aero_drag", "params": {"a": 0.1}}, {"plugin": "brake_fade", "params": {"k": 0.1}},
    {"plugin": "relaxation", "params": {"sigma": 0.02}}]}})");
  try {
    Diagnoser(rig.world(), rig.registry(), {});
    FAIL() << "not refused";
  } catch (const InputError& refused) {
    EXPECT_STREQ(refused.what(),
                 "patch:1:23: /plant/effects: these effects have 5 hidden states (steer_lag 1, motor_lag 1, brake_fade "
                 "1, relaxation 2); diagnose takes at most 4");
  }
}

/// What was met once may belong to the place or to the time.
TEST(Diagnoser, IsLessSureOfAPlacePassedOnce) {
  DiagnoseRig rig;
  const auto confidence = [&](const ModelSpec& truth) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(rig.simulate(truth, {30, 61, 1}));
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    return d.named.empty() ? std::pair(std::string("nothing"), 0.0)
                           : std::pair(d.named.front().effect, d.named.front().confidence);
  };
  // The rig's car weaves about on the spot and never completes a lap.
  const auto [place, patch] = confidence(rig.with("friction_patch", {-0.3, 0.32, 0.1}));
  EXPECT_EQ(place, "friction_patch");
  EXPECT_LE(patch, 0.9);
  const auto [drive, gain] = confidence(rig.with("drive_gain", {0.12}));
  EXPECT_EQ(drive, "drive_gain");
  EXPECT_GT(gain, 0.95);
}

/// More drive and less back-EMF do nearly the same: on a rough road a small one of them could be either. The set holds
/// the truth, and the reader is told what to drive.
TEST(Diagnoser, ListsTwinsThatANoisyLogCannotTellApart) {
  DiagnoseRig rig;
  int sets = 0;
  for (const std::uint64_t seed : {301, 302, 303}) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(
        rig.simulate(rig.with("drive_gain", {0.03}), {.seconds = 20, .seed = seed, .rough = {1, 1, 1}}));
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    if (d.verdict != Verdict::indistinguishable) continue;
    ++sets;
    EXPECT_GT(d.equivalent.size(), 1u);
    EXPECT_EQ(std::count(d.equivalent.begin(), d.equivalent.end(), std::vector<std::string>{"drive_gain"}), 1) << seed;
    EXPECT_FALSE(d.manoeuvre.empty());
    for (const NamedEffect& n : d.named) EXPECT_LT(n.confidence, 0.95);
  }
  EXPECT_GE(sets, 2);
}

/// What a parameter that is refitted takes up is not seen: grip to within 2 % hides a loss of grip of that size.
TEST(Diagnoser, SeesLessBesideRefittedParameters) {
  DiagnoseRig rig;
  LogFile log;
  log.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {30, 35, 1}));
  const auto seen_at = [&](const CaseOptions& options) {
    Diagnoser diagnoser(rig.world(), rig.registry(), options);
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    EXPECT_EQ(d.verdict, Verdict::nothing_missing);
    for (const DetectionLimit& limit : d.detection_limits)
      if (limit.effect == "front_grip") return limit.size;
    return 0.0;
  };
  CaseOptions wrong;
  wrong.uncertainty = {{"Df", 0.02}};
  EXPECT_LT(seen_at({}), 0.01);
  EXPECT_GT(seen_at(wrong), 0.06);
}

/// The noise is measured first where the effect is still missing, and again with it: what it was mistaken for by a
/// tenth in one channel is worth hundreds of units, and passes for accelerations that are not there.
TEST(Diagnoser, MeasuresCorrelatedNoiseAgainBesideWhatIsFound) {
  DiagnoseRig rig;
  measured::Channels colour;
  colour.fill(0.9);
  for (const std::uint64_t seed : {922, 924}) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(
        rig.simulate(rig.with("diff_yaw", {4.0}), {.seconds = 30, .seed = seed, .colour = colour, .unsteady = 1}));
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    EXPECT_EQ(d.verdict, Verdict::named) << seed;
    ASSERT_EQ(d.named.size(), 1U);
    EXPECT_EQ(d.named.front().effect, "diff_yaw");
  }
}

/// A parameter that may be off by 4 % takes the first 4 % of an effect. What is left shows clearly, and names it.
TEST(Diagnoser, NamesWhatAParameterAtItsLimitLeavesOver) {
  DiagnoseRig rig;
  CaseOptions options;
  options.uncertainty = {{"Dr", 0.02}};
  Diagnoser diagnoser(rig.world(), rig.registry(), options);
  LogFile log;
  log.stretches.push_back(rig.simulate(rig.with("rear_grip", {-0.055}), {.seconds = 60, .seed = 62}));
  const Diagnosis d = diagnoser.run({&log, 1}, {});
  ASSERT_FALSE(d.named.empty()) << d.sentence;
  EXPECT_NE(d.verdict, Verdict::unknown);
  EXPECT_TRUE(d.named.front().effect == "rear_grip" ||
              std::ranges::count(d.equivalent, std::vector<std::string>{"rear_grip"}) == 1)
      << d.sentence;
}

/// Noise that is measured with the model would take up an error of a channel that no effect explains, whatever its
/// size.
TEST(Diagnoser, AWrongChannelIsNoNoise) {
  DiagnoseRig rig;
  const auto diagnosed = [&](const std::function<void(double* reading)>& wrong) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 71}));
    measured::Log& stretch = log.stretches.front();
    for (std::size_t k = 0; k < stretch.size(); ++k) wrong(&stretch.reading[k * measured::channels]);
    return diagnoser.run({&log, 1}, {});
  };
  EXPECT_EQ(diagnosed([](double*) {}).verdict, Verdict::nothing_missing);
  const Diagnosis turned = diagnosed([](double* r) { r[measured::Channel::vy] *= -1.0; });
  EXPECT_EQ(turned.verdict, Verdict::unknown) << turned.sentence;
  ASSERT_TRUE(turned.wrong_channel) << turned.sentence;
  EXPECT_EQ(turned.unknown->where, Where::reading);
  EXPECT_GT(turned.wrong_channel->ratio(), 3.0);
  // The lateral speed contradicts the place: either of them may take the blame.
  EXPECT_THAT(turned.unknown->quantity, testing::AnyOf("x", "y", "vy"));
  EXPECT_THAT(turned.sentence, testing::HasSubstr("it shows in the readings: those of " + turned.unknown->quantity +
                                                  " disagree with the others by"));
}

/// What is measured in standard deviations of a noise that is not there means nothing, and the reader is told.
TEST(Diagnoser, TellsThatALogHasNoNoise) {
  DiagnoseRig rig;
  const auto told = [&](double noise) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(rig.simulate(rig.with("drive_gain", {0.12}), {20, 59, noise}));
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    return std::any_of(d.health.begin(), d.health.end(),
                       [](const measured::Finding& h) { return h.found.starts_with("none measured"); });
  };
  EXPECT_TRUE(told(0.0));
  EXPECT_FALSE(told(1.0));
}

Diagnosis diagnose_log(const DiagnoseRig& rig, Log log) {
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  LogFile file;
  file.stretches.push_back(std::move(log));
  return diagnoser.run({&file, 1}, {});
}

/// What the driver did at samples that a recorder left out is noise, and no effect; effects are found beside it.
TEST(Diagnoser, TakesWhatALogLeavesOutForNoise) {
  DiagnoseRig rig;
  const DiagnoseRig::Drive drive{.seconds = 40, .seed = 62, .unsteady = 1};
  const Diagnosis nothing = diagnose_log(rig, DiagnoseRig::thinned(rig.simulate(rig.catalogue().null_model(), drive)));
  EXPECT_EQ(nothing.verdict, Verdict::nothing_missing) << nothing.sentence;
  EXPECT_EQ(nothing.gap.closure, 0.0);
  EXPECT_TRUE(std::ranges::any_of(nothing.health,
                                  [](const measured::Finding& h) { return h.check == "commands between samples"; }));
  const Diagnosis lag = diagnose_log(rig, DiagnoseRig::thinned(rig.simulate(rig.with("steer_lag", {0.05}), drive)));
  ASSERT_EQ(lag.verdict, Verdict::named) << lag.sentence;
  ASSERT_EQ(lag.named.size(), 1U) << lag.sentence;
  EXPECT_EQ(lag.named.front().effect, "steer_lag");
  EXPECT_NEAR(lag.named.front().params.front().value, 0.05, 0.01);
  EXPECT_GT(lag.gap.closure, 0.9);
}

/// A log of the nominal car with the yaw rate six samples late.
Log with_late_yaw_rate(const DiagnoseRig& rig, std::uint64_t seed) {
  Log log = rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = seed, .unsteady = 1});
  const std::vector<double> on_time = log.reading;
  for (std::size_t k = 6; k < log.size(); ++k) log.reading[k * channels + 5] = on_time[(k - 6) * channels + 5];
  return log;
}

/// A channel that is late is named as one, in plain words, and not as an effect of the car.
TEST(Diagnoser, NamesALateChannel) {
  DiagnoseRig rig;
  const Diagnosis d = diagnose_log(rig, with_late_yaw_rate(rig, 63));
  EXPECT_EQ(d.verdict, Verdict::named) << d.sentence;
  EXPECT_TRUE(d.named.empty()) << d.sentence;
  ASSERT_EQ(d.delays.size(), 1U);
  EXPECT_EQ(d.delays.front().effect, "yaw_rate_delay");
  EXPECT_TRUE(d.delays.front().measurement);
  EXPECT_NEAR(d.delays.front().params.front().value, 0.12, 0.01);
  EXPECT_TRUE(d.delays.front().rollout.helps());
  EXPECT_GT(d.gap.closure, 0.9);
  EXPECT_THAT(d.sentence, testing::StartsWith("The yaw-rate channel is 0.12 s late"));
}

/// Against a late pose speeds and yaw rate seem to come too early, which no sensor does.
TEST(Diagnoser, NamesALatePose) {
  DiagnoseRig rig;
  Log log = rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 65, .unsteady = 1});
  const std::vector<double> on_time = log.reading;
  for (std::size_t k = 6; k < log.size(); ++k)
    for (const std::size_t channel : {Channel::x, Channel::y, Channel::yaw})
      log.reading[k * channels + channel] = on_time[(k - 6) * channels + channel];
  const Diagnosis d = diagnose_log(rig, log);
  EXPECT_TRUE(d.named.empty()) << d.sentence;
  ASSERT_EQ(d.delays.size(), 2U) << d.sentence;
  EXPECT_EQ(d.delays[0].effect, "position_delay");
  EXPECT_EQ(d.delays[1].effect, "yaw_delay");
  for (const NamedEffect& delay : d.delays) EXPECT_NEAR(delay.params.front().value, 0.12, 0.0005);
  EXPECT_GT(d.gap.closure, 0.9);
}

/// Where on the car, and turned how, something is measured is an error of measurement, not of the car.
TEST(Diagnoser, NamesWhereTheMeasuringUnitsSit) {
  DiagnoseRig rig;
  for (const auto& [id, values] : {std::pair("pose_yaw", std::vector{0.03}),
                                   {"velocity_yaw", {-0.03}},
                                   {"pose_lever", {0.02, 0.0}},
                                   {"velocity_lever", {0.02, 0.01}}}) {
    const Diagnosis d =
        diagnose_log(rig, rig.simulate(rig.with(id, values), {.seconds = 40, .seed = 69, .unsteady = 1}));
    EXPECT_EQ(d.verdict, Verdict::named) << d.sentence;
    ASSERT_EQ(d.named.size(), 1U) << id << ": " << d.sentence;
    EXPECT_EQ(d.named.front().effect, id);
    EXPECT_TRUE(d.named.front().measurement);
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(d.named.front().params[i].value, values[i], 0.002) << id;
  }
}

/// For logs whose case states the noise.
Diagnoser with_stated_noise(const DiagnoseRig& rig, const Channels& sigma) {
  CaseOptions options;
  options.noise_sigma = sigma;
  return Diagnoser(rig.world(), rig.registry(), options);
}

/// A car with its place late by some of a sample, and noise as stated.
LogFile with_late_place(const DiagnoseRig& rig, std::uint64_t seed, double samples, const Channels& sigma,
                        const ModelSpec& truth, double seconds = 60, double pedals = 1) {
  Log log = rig.simulate(
      truth, {.seconds = seconds, .seed = seed, .noise = 0, .braking = 0.25 * (pedals - 1), .unsteady = pedals});
  const std::vector<double> on_time = log.reading;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto back = static_cast<std::size_t>(std::ceil(samples));
  for (std::size_t k = 0; k < log.size(); ++k)
    for (std::size_t c = 0; c < channels; ++c) {
      double& r = log.reading[k * channels + c];
      if (c < 2 && k >= back)
        r = std::lerp(on_time[(k - back) * channels + c], on_time[(k - back + 1) * channels + c],
                      static_cast<double>(back) - samples);
      r += sigma[c] * normal(random);
    }
  // It begins where the place is late already.
  log.command.erase(log.command.begin(), log.command.begin() + static_cast<std::ptrdiff_t>(back));
  log.reading.erase(log.reading.begin(), log.reading.begin() + static_cast<std::ptrdiff_t>(back * channels));
  LogFile file;
  file.stretches.push_back(std::move(log));
  return file;
}
LogFile with_late_place(const DiagnoseRig& rig, std::uint64_t seed, double samples, const Channels& sigma) {
  return with_late_place(rig, seed, samples, sigma, rig.catalogue().null_model());
}

/// In a log too short for the delay to be measured by itself a place that is late looks like one on a lever, until both
/// are fitted. A lever is no delay.
TEST(Diagnoser, ALatePlaceIsNoLever) {
  DiagnoseRig rig;
  const Channels sigma{0.005, 0.005, 0.005, 0.02, 0.02, 0.05};
  Diagnoser diagnoser = with_stated_noise(rig, sigma);
  const LogFile late = with_late_place(rig, 91, 3.3, sigma, rig.with("drive_gain", {0.12}), 12);
  const Diagnosis d = diagnoser.run({&late, 1}, {});
  EXPECT_EQ(d.verdict, Verdict::named) << d.sentence;
  ASSERT_EQ(d.delays.size(), 1U) << d.sentence;
  EXPECT_EQ(d.delays.front().effect, "position_delay");
  EXPECT_NEAR(d.delays.front().params.front().value, 0.066, 0.002);
  ASSERT_EQ(d.named.size(), 1U) << d.sentence;
  EXPECT_EQ(d.named.front().effect, "drive_gain");
  const LogFile lever = with_late_place(rig, 92, 0.0, sigma, rig.with("pose_lever", {-0.1, 0.0}), 12);
  const Diagnosis other = diagnoser.run({&lever, 1}, {});
  EXPECT_TRUE(other.delays.empty()) << other.sentence;
  ASSERT_EQ(other.named.size(), 1U) << other.sentence;
  EXPECT_EQ(other.named.front().effect, "pose_lever");
}

/// At one speed, in noise that hides which of the two it is, the lever stays: a delay would be named as nearly certain.
TEST(Diagnoser, ALeverInNoiseIsNoLatePlace) {
  DiagnoseRig rig;
  const Channels sigma{0.12, 0.12, 0.005, 0.02, 0.02, 0.05};
  Diagnoser diagnoser = with_stated_noise(rig, sigma);
  for (const std::uint64_t seed : {101, 102, 103, 104, 105, 106}) {
    const LogFile lever = with_late_place(rig, seed, 0.0, sigma, rig.with("pose_lever", {-0.2, 0.0}), 16, 0);
    const Diagnosis d = diagnoser.run({&lever, 1}, {});
    EXPECT_TRUE(d.delays.empty()) << seed << ": " << d.sentence;
  }
}

/// A place that is a tenth of a sample earlier or later than was taken off would be an error that no effect explains.
/// In a place as noisy as a heavy car's the changes of speed drown.
TEST(Diagnoser, NamesALatePlace) {
  for (const auto& [samples, noise] : {std::pair(4.0, 1.0), {4.37, 1.0}, {4.37, 8.0}}) {
    DiagnoseRig rig;
    const Channels sigma{0.005 * noise, 0.005 * noise, 0.005, 0.02, 0.02, 0.05};
    const LogFile file = with_late_place(rig, 66, samples, sigma);
    Diagnoser diagnoser = with_stated_noise(rig, sigma);
    const Diagnosis d = diagnoser.run({&file, 1}, {});
    EXPECT_EQ(d.verdict, Verdict::named) << d.sentence;
    EXPECT_TRUE(d.named.empty()) << d.sentence;
    EXPECT_TRUE(d.nominal_fit.empty());
    ASSERT_EQ(d.delays.size(), 1U) << d.sentence;
    EXPECT_EQ(d.delays.front().effect, "position_delay");
    const auto& seconds = d.delays.front().params.front();
    EXPECT_NEAR(seconds.value, 0.02 * samples, noise > 1.0 ? 0.003 : 0.0005);
    EXPECT_LT(seconds.high - seconds.low, noise > 1.0 ? 0.008 : 0.002);
    EXPECT_GT(d.gap.closure, 0.9) << d.sentence;
    // A log on time is searched without what was left of the last one's delay.
    const LogFile on_time = with_late_place(rig, 67, 0.0, sigma);
    const Diagnosis next = diagnoser.run({&on_time, 1}, {});
    EXPECT_EQ(next.verdict, Verdict::nothing_missing) << next.sentence;
    EXPECT_FALSE(diagnoser.catalogue().pose_is_late());
  }
}

/// Every second row of what a world drove whose commands are held from step to step: the world says what was left out.
TEST(Diagnoser, KnowsForHowLongTheWorldHoldsCommands) {
  DiagnoseRig rig;
  LogFile log;
  log.stretches.push_back(DiagnoseRig::thinned(
      rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 76, .unsteady = 0.3, .held = true})));
  WorldSpec world = rig.world();
  world.hold = Hold::zoh;
  Diagnoser diagnoser(world, rig.registry(), {});
  const Diagnosis d = diagnoser.run({&log, 1}, {});
  EXPECT_EQ(d.verdict, Verdict::nothing_missing) << d.sentence;
  EXPECT_EQ(diagnoser.problem().hold(), measured::CommandHold{.halves = true});
}

/// Delays are taken off the logs held out as well, and the gap that is closed there is theirs.
TEST(Diagnoser, TakesDelaysOffLogsHeldOut) {
  DiagnoseRig rig;
  LogFile log, other;
  log.stretches.push_back(with_late_yaw_rate(rig, 63));
  other.stretches.push_back(with_late_yaw_rate(rig, 68));
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  const Diagnosis d = diagnoser.run({&log, 1}, {&other, 1});
  ASSERT_EQ(d.delays.size(), 1U) << d.sentence;
  EXPECT_TRUE(d.delays.front().rollout.helps());
  EXPECT_GT(d.gap.closure, 0.9) << d.sentence;
}

/// What a recorder rounded off is no part of what a late channel costs: the error before is that of the commands that
/// are expected, as the error after is, and not of those that were written.
TEST(Diagnoser, RoundingIsNotCreditedToALateChannel) {
  DiagnoseRig rig;
  const Log log = DiagnoseRig::rounded(
      rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 64, .unsteady = 1}), 0.03);
  LogFile late;
  late.stretches.push_back(log);
  for (std::size_t k = 2; k < log.size(); ++k)
    late.stretches.front().reading[k * channels + 5] = log.reading[(k - 2) * channels + 5];
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  const Diagnosis d = diagnoser.run({&late, 1}, {});
  ASSERT_EQ(d.delays.size(), 1U) << d.sentence;
  ASSERT_TRUE(diagnoser.problem().unrounded);
  Fit nominal = d.null_model;
  nominal.model = rig.catalogue().null_model();
  nominal.evaluation.reset();
  const auto error = [&](bool expected) {
    Problem problem = prepare(diagnoser.catalogue(), diagnoser.road(), {&late, 1}, d.sensor).problem;
    problem.sensor = d.sensor;
    if (expected) problem.unround_commands();
    constexpr std::array<double, 1> second = {1.0};
    return HoldOut(problem, diagnoser.road(), {}).predict(nominal, second).front().rms();
  };
  EXPECT_GT(std::abs(error(true) - error(false)), 0.01 * error(false));
  EXPECT_NEAR(d.gap.before, error(true), 1e-3 * error(true));
}

}  // namespace test_diagnose_diagnoser
}  // namespace gripline::diagnose
