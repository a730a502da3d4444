#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "diagnose/inference/fit.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_linear_model {

using test::DiagnoseRig;

/// What is left out behind the last effect that dynamic does not change what it dynamic.
TEST(StagedCar, MemoryRatesAreThoseOfTheWholeCar) {
  DiagnoseRig rig;
  const ModelSpec model = rig.with(rig.with("relaxation", {0.05}), "steer_lag", {0.04});
  Problem problem = rig.problem({rig.simulate(model, {10, 55, 1})});
  const Trace& trace = problem.traces.front();
  const StagedCar car = rig.catalogue().build(model);
  const std::vector<double> memory = simulate_memory(car, trace), whole = memory_rates(car, trace, memory);
  for (std::size_t k = 0; k < trace.size(); k += 100) {
    std::vector<double> rate(3);
    const ActingCommand<double> command = trace.command(k, 0.0);
    CarBatch<double> batch;
    batch.n = 1;
    batch.motion = trace.motion.data() + k * channels;
    batch.memory = memory.data() + k * 3;
    batch.command = &command;
    batch.at = &trace.at[k];
    batch.memory_rate = rate.data();
    car.memory_rates(batch);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_DOUBLE_EQ(rate[j], whole[k * 3 + j]);
  }
}

/// A first-order lag of a sine is off its steady value by a share w tau / root(1 + (w tau)^2) of its amplitude; of a
/// sine about another value, the first may also lack that value altogether.
TEST(LinearModel, TheFirstMemoryVariesAsMemoriesDoAlongTheTraceAndByWhatHadToBuildUp) {
  const DiagnoseRig rig;
  constexpr double tau = 0.1, rate = 5.0, amplitude = 0.1;
  const ModelSpec model = rig.with("steer_lag", {tau});
  const double off = amplitude * rate * tau / std::hypot(1.0, rate * tau) / std::numbers::sqrt2;
  for (const double about : {0.0, 0.08}) {
    Log log = rig.simulate(model, {10, 56, 1});
    for (std::size_t k = 0; k < log.size(); ++k)
      log.command[k].delta = about + amplitude * std::sin(rate * static_cast<double>(k) * log.dt);
    const Problem problem = rig.problem({log});
    const LinearModel lm = linearise(rig.catalogue().build(model), problem.traces.front(), 1);
    ASSERT_EQ(lm.memory_variance.size(), 1U);
    EXPECT_NEAR(std::sqrt(lm.memory_variance.front()), std::hypot(off, about), 0.02 * amplitude) << about;
    EXPECT_TRUE(linearise(rig.catalogue().build(rig.catalogue().null_model()), problem.traces.front(), 1)
                    .memory_variance.empty());
  }
}

TEST(LinearModel, StepsOfIntegrationFollowTheSampleTime) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {10, 49, 1})});
  const StagedCar car = rig.catalogue().build(rig.catalogue().null_model());
  const int nominal = substeps_of_motion(car, problem.traces);
  problem.traces.front().log.dt = 0.05;
  const int slow = substeps_of_motion(car, problem.traces);
  problem.traces.front().log.dt = 0.002;
  EXPECT_EQ(substeps_of_motion(car, problem.traces), 1);
  EXPECT_GT(slow, nominal);
}

}  // namespace test_diagnose_linear_model
}  // namespace gripline::diagnose
