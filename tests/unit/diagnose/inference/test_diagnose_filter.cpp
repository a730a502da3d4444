#include <gtest/gtest.h>

#include "measured/rollout.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

double cost_of(const DiagnoseRig& rig, Problem& problem, const ModelSpec& model, const Noise& noise) {
  (void)rig;
  const StagedCar car = problem.catalogue->build(model);
  return filter(linearise(car, problem.traces.front(), 3), noise, {}).cost;
}

/// The filter's gradient holds its gains fixed, as Gauss-Newton does; at the truth, with the process variances small,
/// the gains hardly depend on the parameters and finite differences agree.
TEST(Filter, GradientByParametersAgreesWithDifferences) {
  DiagnoseRig rig;
  for (const auto& [id, value] :
       {std::pair("aero_drag", 0.3), std::pair("rear_grip", 0.06), std::pair("vx_scale", 0.02),
        std::pair("steer_lag", 0.04), std::pair("relaxation", 0.05)}) {
    const ModelSpec truth = rig.with(id, {value});
    Problem problem = rig.problem({rig.simulate(truth, {10, 3, 1})});
    const Noise noise = rig.noise(problem, 0.02);
    Fit at_truth;
    at_truth.model = truth;
    at_truth.noise = noise;
    renew_reference(problem, rig.road(), at_truth);
    const double moved = value * 1.01;
    const ModelSpec model = rig.with(id, {moved});
    const Trace& trace = problem.traces.front();
    const auto [lm, directions, work] = linearise_own(rig.catalogue(), model, trace, 3);
    const std::vector<const Direction*> list{&directions.front()};
    FilterWants wants;
    wants.directions = &list;
    const Likelihood l = filter(lm, noise, wants);
    const double step = 1e-3 * value;
    const double slope = (cost_of(rig, problem, rig.with(id, {moved + step}), noise) -
                          cost_of(rig, problem, rig.with(id, {moved - step}), noise)) /
                         (2.0 * step);
    EXPECT_NEAR(-l.g.front(), slope, 0.05 * std::abs(slope) + 0.02 * std::sqrt(l.N.front())) << id;
  }
}

TEST(Filter, SlopeByProcessVarianceIsExact) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {6, 5, 1})});
  const LinearModel lm = linearise(rig.catalogue().build(rig.catalogue().bare()), problem.traces.front(), 2);
  const Noise noise = rig.noise(problem, 1.0);
  FilterWants wants;
  wants.process_slope = true;
  const Likelihood l = filter(lm, noise, wants);
  for (std::size_t i = 0; i < noise_states; ++i) {
    Noise up = noise, down = noise;
    const double step = 1e-4 * noise.process[i];
    up.process[i] += step;
    down.process[i] -= step;
    const double slope = (filter(lm, up, {}).cost - filter(lm, down, {}).cost) / (2.0 * step);
    EXPECT_NEAR(l.slope[i], slope, 1e-4 * std::abs(slope) + 1e-6 * l.information[i][i] * noise.process[i]) << i;
  }
}

TEST(Filter, SmoothingComesCloserToTheTruthThanTheSensors) {
  DiagnoseRig rig;
  const ModelSpec bare = rig.catalogue().bare();
  const Measured clean = rig.simulate(bare, {10, 7, 0});
  Problem problem = rig.problem({rig.simulate(bare, {10, 7, 1})});
  Fit f;
  f.model = bare;
  f.noise = rig.noise(problem, 0.1);
  renew_reference(problem, rig.road(), f);
  renew_reference(problem, rig.road(), f);
  for (std::size_t c = 0; c < channels; ++c) {
    double sum = 0.0;
    const Trace& trace = problem.traces.front();
    for (std::size_t k = 0; k < trace.size(); ++k) {
      const double off = (trace.motion[k * channels + c] - clean.reading[k * channels + c]) / problem.sensor[c];
      sum += off * off;
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(trace.size())), 0.4) << "channel " << c;
  }
}

TEST(Filter, BlocksAddUp) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {6, 9, 1})});
  const LinearModel lm = linearise(rig.catalogue().build(rig.catalogue().bare()), problem.traces.front(), 2);
  const Noise noise = rig.noise(problem, 0.5);
  FilterWants wants;
  wants.block = 50;
  const Likelihood l = filter(lm, noise, wants);
  double sum = 0.0;
  for (const double c : l.block_cost) sum += c;
  EXPECT_NEAR(sum, filter(lm, noise, {}).cost, 1e-9 * std::abs(sum));
  EXPECT_EQ(l.blocks, 7U);
}

TEST(Filter, MissingReadingsAreNotRead) {
  DiagnoseRig rig;
  Measured log = rig.simulate(rig.catalogue().bare(), {6, 9, 1});
  for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + 4] = std::nan("");
  Problem problem = rig.problem({log});
  const Likelihood l = filter(linearise(rig.catalogue().build(rig.catalogue().bare()), problem.traces.front(), 2),
                              rig.noise(problem, 0.5), {});
  EXPECT_EQ(l.rows, 5 * log.size());
  EXPECT_TRUE(std::isfinite(l.cost));
}

/// An effect, and a drive in which it shows without throwing the car off or bringing it to rest, where the equations of
/// the tyres are stiffer than a step: a car that spins multiplies the error of
/// every integration step (with combined slip and the full weave it turns at 25 rad/s, and 4 substeps are 0.02 sigma
/// from 16 where 8 are 0.002).
struct Shown {
  const char* id;
  std::vector<double> values;
  DiagnoseRig::Drive drive = {8, 11, 0};
};

/// The same log predicted with the car that drove it: nothing is left. With memory, delay and sensor errors too.
TEST(Rollout, TheTrueCarPredictsItsOwnLog) {
  DiagnoseRig rig;
  const std::vector<Shown> effects = {{"aero_drag", {0.4}},        {"steer_lag", {0.03}},
                                      {"motor_lag", {0.08}},       {"input_delay", {0.033}},
                                      {"vx_scale", {0.03}},        {"yawrate_bias", {0.1}},
                                      {"relaxation", {0.05}},      {"brake_fade", {2.0}, {8, 11, 0, 0.5, 0.4}},
                                      {"friction_drift", {-0.1}},  {"comb_slip", {0.6}, {8, 11, 0, 0.5}},
                                      {"plane_tilt", {0.02, 0.01}}};
  for (const auto& [id, values, drive] : effects) {
    const ModelSpec truth = rig.with(id, values);
    Trace trace;
    trace.log = rig.simulate(truth, drive);
    const StagedCar car = rig.catalogue().build(truth);
    trace.set_motion(trace.log.reading, rig.road());
    trace.set_motion(states_of_readings(car, trace.log.reading, trace.at), rig.road());
    RolloutOptions options;
    options.substeps = 4;
    Channels sigma{};
    for (std::size_t c = 0; c < channels; ++c) sigma[c] = rig.world().sensors.channels[c].sigma;
    const double with_effect = rms(roll_out(car, trace, rig.road(), options), sigma);
    EXPECT_LT(with_effect, 0.01) << id;
    Trace nominal = trace;
    nominal.set_motion(trace.log.reading, rig.road());
    const StagedCar bare = rig.catalogue().build(rig.catalogue().bare());
    EXPECT_GT(rms(roll_out(bare, nominal, rig.road(), options), sigma), 0.1) << id;
  }
}

/// Steps of the steering for single samples that the log lost: the filter must not call their traces a missing effect.
TEST(Filter, GuessedCommandsExplainNothing) {
  DiagnoseRig rig;
  diagnose::Measured log = rig.simulate(rig.catalogue().bare(), {20, 71, 1});
  for (std::size_t k = 40; k + 1 < log.size(); k += 50) {
    // What the driver did there is not what the log's neighbours suggest.
    log.command[k].delta += 0.15;
    for (std::size_t c = 0; c < 6; ++c) log.reading[k * 6 + c] = std::nan("");
  }
  const auto cost_of = [&](bool told) {
    if (told) log.guessed.assign(log.size(), false);
    for (std::size_t k = 40; told && k + 1 < log.size(); k += 50) log.guessed[k] = true;
    Problem p = rig.problem({log});
    Noise noise = rig.noise(p, 0.003);
    return fit(p, rig.catalogue().bare(), noise, 8).noise.process[2];
  };
  const double blind = cost_of(false), told = cost_of(true);
  EXPECT_GT(blind, 100.0 * told);
}

}  // namespace
}  // namespace gripline::diagnose
