#include <gtest/gtest.h>

#include <span>

#include "diagnose/inference/reference.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_filter {

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
    smooth_reference(problem, rig.road(), at_truth);
    const double moved = value * 1.01;
    const ModelSpec model = rig.with(id, {moved});
    const Trace& trace = problem.traces.front();
    const auto [lm, regressors, work] = linearise_with_regressors(rig.catalogue(), model, trace, 3);
    const std::vector<const Regressor*> list{&regressors.front()};
    FilterOptions options;
    options.regressors = &list;
    const Likelihood l = filter(lm, noise, options);
    const double step = 1e-3 * value;
    const double slope = (cost_of(rig, problem, rig.with(id, {moved + step}), noise) -
                          cost_of(rig, problem, rig.with(id, {moved - step}), noise)) /
                         (2.0 * step);
    EXPECT_NEAR(-l.g.front(), slope, 0.05 * std::abs(slope) + 0.02 * std::sqrt(l.N.front())) << id;
  }
}

TEST(Filter, GradientByProcessVariancesIsExact) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {6, 5, 1})});
  const LinearModel lm = linearise(rig.catalogue().build(rig.catalogue().null_model()), problem.traces.front(), 2);
  const Noise noise = rig.noise(problem, 1.0);
  FilterOptions options;
  options.noise_gradient = true;
  const Likelihood l = filter(lm, noise, options);
  for (std::size_t i = 0; i < noise_states; ++i) {
    Noise up = noise, down = noise;
    const double step = 1e-4 * noise.process[i];
    up.process[i] += step;
    down.process[i] -= step;
    const double slope = (filter(lm, up, {}).cost - filter(lm, down, {}).cost) / (2.0 * step);
    EXPECT_NEAR(l.noise_gradient[i], slope,
                1e-4 * std::abs(slope) + 1e-6 * l.noise_information[i][i] * noise.process[i])
        << i;
  }
}

/// The log less its first rows, with which a lag's past is lost.
Log without_first(const Log& log, std::size_t rows) {
  Log rest = log;
  rest.command.erase(rest.command.begin(), rest.command.begin() + static_cast<std::ptrdiff_t>(rows));
  rest.reading.erase(rest.reading.begin(), rest.reading.begin() + static_cast<std::ptrdiff_t>(rows * channels));
  return rest;
}

/// A log begins while the steering moves, and where it lags behind to is not known: the first innovations scatter as
/// their variances say, which allow for that. As if it were settled, they are larger.
TEST(Filter, ALagMayBeginUnsettled) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("steer_lag", {0.1});
  const Log whole = rig.simulate(truth, {.seconds = 10, .seed = 4, .jumps = 0.2});
  constexpr std::size_t first = 12 * channels;
  double allowed = 0.0, settled = 0.0, readings = 0.0;
  for (std::size_t rows = 25; rows <= 300; rows += 25) {
    Problem problem = rig.problem({without_first(whole, rows)});
    Fit at_truth;
    at_truth.model = truth;
    at_truth.noise = rig.noise(problem, 0.01);
    smooth_reference(problem, rig.road(), at_truth);
    LinearModel lm = linearise(rig.catalogue().build(truth), problem.traces.front(), 3);
    ASSERT_EQ(lm.memory_variance.size(), 1U);
    const auto scatter = [&] {
      FilterOptions options;
      options.innovations = true;
      const Likelihood l = filter(lm, at_truth.noise, options);
      double sum = 0.0;
      for (const Likelihood::Innovation& one : std::span(l.innovations).first(first))
        sum += one.error * one.error / one.variance;
      return sum;
    };
    allowed += scatter();
    lm.memory_variance.front() = 0.0;
    settled += scatter();
    readings += first;
  }
  EXPECT_NEAR(allowed / readings, 1.0, 0.15);
  EXPECT_GT(settled / readings, 1.5);
}

/// The errors of rounded steering are states of the model: innovations scatter as their variances say, and are white.
TEST(Filter, RoundedCommandsAreNoiseOfAKnownSize) {
  DiagnoseRig rig;
  const ModelSpec bare = rig.catalogue().null_model();
  const double step = 0.03;
  const Log whole = rig.simulate(bare, {.seconds = 40, .seed = 3, .unsteady = 0.3});
  const auto scatter_and_colour = [&](bool unrounded) {
    Problem problem = rig.problem({DiagnoseRig::rounded(whole, step)});
    problem.command_step = {0.0, step};
    if (unrounded) problem.unround_commands();
    Fit f;
    f.model = bare;
    f.noise = rig.noise(problem, 0.001);
    if (!unrounded) f.noise = rig.noise(problem, 1.0);  // for the reference
    iterate_reference(problem, rig.road(), f);
    f.noise = rig.noise(problem, 0.001);
    FilterOptions options;
    options.innovations = true;
    const LinearModel lm = linearise(rig.catalogue().build(bare), problem.traces.front(), problem.stepping());
    EXPECT_EQ(lm.states, unrounded ? 11u : 9u);
    EXPECT_EQ(lm.memories(), 0u);
    double square = 0.0, product = 0.0, last = 0.0, count = 0.0;
    for (const Likelihood::Innovation& row : filter(lm, f.noise, options).innovations) {
      if (row.channel != 5) continue;
      const double e = row.error / std::sqrt(row.variance);
      square += e * e;
      product += e * last;
      last = e;
      count += 1.0;
    }
    return std::pair(square / count, product / square);
  };
  const auto [scatter, colour] = scatter_and_colour(true);
  EXPECT_GT(scatter, 0.75);
  EXPECT_LT(scatter, 1.1);
  EXPECT_LT(std::abs(colour), 0.1);
  EXPECT_GT(scatter_and_colour(false).first, 1.5);
}

TEST(Filter, SmoothingComesCloserToTheTruthThanTheSensors) {
  DiagnoseRig rig;
  const ModelSpec bare = rig.catalogue().null_model();
  const Log clean = rig.simulate(bare, {10, 7, 0});
  Problem problem = rig.problem({rig.simulate(bare, {10, 7, 1})});
  Fit f;
  f.model = bare;
  f.noise = rig.noise(problem, 0.1);
  smooth_reference(problem, rig.road(), f);
  smooth_reference(problem, rig.road(), f);
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

/// What is predicted for a sample knows the readings before it, whatever their colour.
TEST(Filter, PredictionsKnowNothingOfWhatFollows) {
  DiagnoseRig rig;
  const ModelSpec bare = rig.catalogue().null_model();
  Problem problem = rig.problem({rig.simulate(bare, {4, 9, 1})});
  LinearModel lm = linearise(rig.catalogue().build(bare), problem.traces.front(), 2);
  for (const double colour : {0.0, 0.7}) {
    Noise noise = rig.noise(problem, 1.0);
    noise.colour.fill(colour);
    FilterOptions options;
    options.predict = true;
    constexpr std::size_t at = 60;
    const std::vector<double> before = filter(lm, noise, options).predicted;
    for (std::size_t c = 0; c < channels; ++c) lm.innovation[at * channels + c] += 5.0 * noise.sensor[c];
    const std::vector<double> after = filter(lm, noise, options).predicted;
    for (std::size_t i = 0; i < (at + 1) * lm.states; ++i) EXPECT_EQ(after[i], before[i]) << i;
    EXPECT_GT(std::abs(after[(at + 1) * lm.states + 5] - before[(at + 1) * lm.states + 5]), 0.01 * noise.sensor[5]);
    options.smooth = true;
    EXPECT_EQ(filter(lm, noise, options).predicted, after);
  }
}

TEST(Filter, BlocksAddUp) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {6, 9, 1})});
  const LinearModel lm = linearise(rig.catalogue().build(rig.catalogue().null_model()), problem.traces.front(), 2);
  const Noise noise = rig.noise(problem, 0.5);
  FilterOptions options;
  options.block = 50;
  const Likelihood l = filter(lm, noise, options);
  double sum = 0.0;
  for (const double c : l.block_cost) sum += c;
  EXPECT_NEAR(sum, filter(lm, noise, {}).cost, 1e-9 * std::abs(sum));
  EXPECT_EQ(l.block_cost.size(), 7U);
}

TEST(Filter, MissingReadingsAreNotRead) {
  DiagnoseRig rig;
  Log log = rig.simulate(rig.catalogue().null_model(), {6, 9, 1});
  for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + 4] = std::nan("");
  Problem problem = rig.problem({log});
  const Likelihood l = filter(linearise(rig.catalogue().build(rig.catalogue().null_model()), problem.traces.front(), 2),
                              rig.noise(problem, 0.5), {});
  EXPECT_EQ(l.rows, 5 * log.size());
  EXPECT_TRUE(std::isfinite(l.cost));
}

/// Steps of the steering at single samples that the log lost leave no process noise behind.
TEST(Filter, LostCommandsExplainNothing) {
  DiagnoseRig rig;
  measured::Log log = rig.simulate(rig.catalogue().null_model(), {20, 71, 1});
  for (std::size_t k = 40; k + 1 < log.size(); k += 50) {
    // What the driver did there is not what the log's neighbours suggest.
    log.command[k].delta += 0.15;
    for (std::size_t c = 0; c < 6; ++c) log.reading[k * 6 + c] = std::nan("");
  }
  const auto cost_of = [&](bool told) {
    if (told) log.interpolated.assign(log.size(), false);
    for (std::size_t k = 40; told && k + 1 < log.size(); k += 50) log.interpolated[k] = true;
    Problem p = rig.problem({log});
    Noise noise = rig.noise(p, 0.003);
    return fit(p, rig.catalogue().null_model(), noise, 8).noise.process[2];
  };
  const double blind = cost_of(false), told = cost_of(true);
  EXPECT_GT(blind, 100.0 * told);
}

}  // namespace test_diagnose_filter
}  // namespace gripline::diagnose
