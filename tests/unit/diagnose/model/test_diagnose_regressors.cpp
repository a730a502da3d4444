#include <gtest/gtest.h>

#include "diagnose/model/regressors.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_regressors {

using test::DiagnoseRig;

std::vector<double> rates(const DiagnoseRig& rig, const ModelSpec& model, const Trace& trace) {
  const StagedCar car = rig.catalogue().build(model);
  return rates_at_samples(car, trace, simulate_memory(car, trace));
}

/// Root mean square difference of a regressor's rates from central differences, over that of the differences.
double mismatch(const std::vector<double>& regressor, const std::vector<double>& high, const std::vector<double>& low,
                double step) {
  double off = 0.0, size = 0.0;
  for (std::size_t k = 0; k < regressor.size() / 3; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const double slope = (high[k * channels + 3 + c] - low[k * channels + 3 + c]) / (2.0 * step);
      off += std::pow(regressor[k * 3 + c] - slope, 2);
      size += slope * slope;
    }
  return std::sqrt(off / size);
}

class Regressors : public ::testing::Test {
 protected:
  Regressors() : problem_(rig_.problem({rig_.simulate(rig_.catalogue().null_model(), {6, 97, 1})})) {}
  const Trace& trace() const { return problem_.traces.front(); }
  DiagnoseRig rig_;
  Problem problem_;
};

TEST_F(Regressors, OfAModelAreDerivativesOfItsRates) {
  // front_stiff acts through the memory of relaxation, aero_drag does not, steer_lag has a memory of its own.
  for (const auto& [id, value, other] :
       {std::tuple("aero_drag", 0.3, "mass"), std::tuple("front_stiff", 0.1, "relaxation"),
        std::tuple("steer_lag", 0.04, "mass")}) {
    const ModelSpec base = rig_.catalogue().with(rig_.catalogue().null_model(), rig_.catalogue().find(other));
    const ModelSpec model = rig_.with(base, id, {value});
    const Linearised l = linearise_with_regressors(rig_.catalogue(), model, trace(), 2);
    ASSERT_EQ(l.own.size(), 2U);
    const bool first = model.position(rig_.catalogue().find(id)) == 0;
    const double step = 1e-4 * value;
    EXPECT_LT(mismatch(l.own[first ? 0 : 1].rate, rates(rig_, rig_.with(base, id, {value + step}), trace()),
                       rates(rig_, rig_.with(base, id, {value - step}), trace()), step),
              1e-2)
        << id;
  }
}

/// Also beside an effect with memory, where derivatives by parameters of the car are differences.
TEST_F(Regressors, OfALatePoseAreWhatItsReadingsMove) {
  rig_.catalogue().allow_for_late_pose(0, 0.0, 0.01);
  const ModelSpec bare = rig_.catalogue().null_model();
  for (const ModelSpec& model : {bare, rig_.catalogue().with(bare, rig_.catalogue().find("relaxation"))}) {
    const Linearised l = linearise_with_regressors(rig_.catalogue(), model, trace(), 2);
    const std::vector<double>& reading = l.own.front().reading;
    ASSERT_EQ(reading.size(), trace().size() * channels);
    for (std::size_t k = 0; k < trace().size(); k += 10) {
      // The place moves back by a second of travel for a second of delay; nothing else changes.
      const double vx = trace().motion[k * 6 + 3], vy = trace().motion[k * 6 + 4], yaw = trace().motion[k * 6 + 2];
      EXPECT_NEAR(reading[k * channels], -(vx * std::cos(yaw) - vy * std::sin(yaw)), 1e-9);
      EXPECT_NEAR(reading[k * channels + 1], -(vx * std::sin(yaw) + vy * std::cos(yaw)), 1e-9);
      for (std::size_t c = 2; c < channels; ++c) EXPECT_EQ(reading[k * channels + c], 0.0);
    }
  }
}

TEST_F(Regressors, OfCandidatesStartFromNeutral) {
  const ModelSpec bare = rig_.catalogue().null_model();
  const LinearModel lm = linearise(rig_.catalogue().build(bare), trace(), 2);
  std::vector<Regressor> regressors;
  std::vector<CandidateRegressors> groups;
  candidate_regressors(rig_.catalogue(), bare, trace(), regressors, groups);
  ASSERT_EQ(groups.size(), rig_.catalogue().candidates().size());
  std::size_t next = 0;
  for (const CandidateRegressors& group : groups) {
    EXPECT_EQ(group.first, next) << "groups follow one another";
    next += group.count;
    const Candidate& c = rig_.catalogue().candidates()[group.candidate];
    if (c.id == "friction_scale") {
      EXPECT_LT(mismatch(regressors[group.first].rate, rates(rig_, rig_.with(c.id, {1e-4}), trace()),
                         rates(rig_, rig_.with(c.id, {-1e-4}), trace()), 1e-4),
                1e-4);
    }
    if (c.id == "friction_patch") {
      // Its place does nothing while there is no patch: one regressor of the strength for each place tried.
      ASSERT_EQ(group.starts.size(), group.count);
      EXPECT_GT(group.count, 10U);
      EXPECT_NE(group.starts[0][1], group.starts[1][1]);
    }
    if (c.id == "vx_bias") {
      ASSERT_EQ(regressors[group.first].reading.size(), trace().size() * channels);
      EXPECT_DOUBLE_EQ(regressors[group.first].reading[3], 1.0);
    }
  }
  EXPECT_EQ(next, regressors.size());
}

/// Where tyres relax, as an effect that was found or in the world itself, the place of a patch does nothing while there
/// is no patch, to the last digit: places are tried.
TEST_F(Regressors, OfShapesBeforeAMemoryAreScanned) {
  const DiagnoseRig relaxing({}, {},
                             R"({"plant": {"effects": [{"plugin": "relaxation", "params": {"sigma": 0.05}}]}})");
  Trace lap = trace();  // that passes every place: elsewhere a patch does nothing, to the last digit
  for (std::size_t k = 0; k < lap.size(); ++k)
    lap.at[k].lap_fraction = static_cast<double>(k) / static_cast<double>(lap.size());
  const std::vector<std::pair<const Catalogue*, ModelSpec>> cars = {
      {&rig_.catalogue(), rig_.with("relaxation", {0.05})}, {&relaxing.catalogue(), relaxing.catalogue().null_model()}};
  for (const auto& [catalogue, model] : cars) {
    const LinearModel lm = linearise(catalogue->build(model), lap, 2);
    ASSERT_EQ(lm.memories(), 2U);
    std::vector<Regressor> regressors;
    std::vector<CandidateRegressors> groups;
    candidate_regressors(*catalogue, model, lap, regressors, groups);
    const auto patch = std::ranges::find(groups, catalogue->find("friction_patch"), &CandidateRegressors::candidate);
    ASSERT_NE(patch, groups.end());
    EXPECT_GT(patch->count, 10U);
    EXPECT_EQ(patch->starts.size(), patch->count);
  }
}

/// The tyres of the world itself relax: what acts before them shows in the rates through what they remember.
class RegressorsBeforeTheWorldsOwnMemory : public ::testing::Test {
 protected:
  RegressorsBeforeTheWorldsOwnMemory()
      : rig_({}, {}, R"({"plant": {"effects": [{"plugin": "relaxation", "params": {"sigma": 0.05}}]}})") {
    rig_.trust({"Df"}, 0.02);
    problem_ = rig_.problem({rig_.simulate(rig_.catalogue().null_model(), {6, 97, 1})});
  }
  const Trace& trace() const { return problem_.traces.front(); }
  double mismatch_of(const Regressor& regressor, const ModelSpec& more, const ModelSpec& less, double step) const {
    return mismatch(regressor.rate, rates(rig_, more, trace()), rates(rig_, less, trace()), step);
  }
  DiagnoseRig rig_;
  Problem problem_;
};

TEST_F(RegressorsBeforeTheWorldsOwnMemory, OfCandidates) {
  const ModelSpec bare = rig_.catalogue().null_model();
  const LinearModel lm = linearise(rig_.catalogue().build(bare), trace(), 2);
  ASSERT_EQ(lm.memories(), 2U);
  std::vector<Regressor> regressors;
  std::vector<CandidateRegressors> groups;
  candidate_regressors(rig_.catalogue(), bare, trace(), regressors, groups);
  std::size_t asked = 0;
  for (const CandidateRegressors& group : groups) {
    const std::string& id = rig_.catalogue().candidates()[group.candidate].id;
    if (id != "front_stiff" && id != "load_transfer" && id != "steer_offset" && id != "yaw_inertia") continue;
    ++asked;
    EXPECT_LT(mismatch_of(regressors[group.first], rig_.with(id, {1e-4}), rig_.with(id, {-1e-4}), 1e-4), 1e-2) << id;
  }
  EXPECT_EQ(asked, 4U);
}

TEST_F(RegressorsBeforeTheWorldsOwnMemory, OfEffectsAndRefittedParameters) {
  const ModelSpec model = rig_.with("front_stiff", {0.1});
  const Linearised l = linearise_with_regressors(rig_.catalogue(), model, trace(), 2);
  ASSERT_EQ(l.own.size(), 2U);
  ModelSpec more = model, less = model;
  const double step = 1e-4 * rig_.catalogue().nuisances().front().nominal;
  more.nuisance.front() += step;
  less.nuisance.front() -= step;
  EXPECT_LT(mismatch_of(l.own[0], more, less, step), 1e-2);
  EXPECT_LT(mismatch_of(l.own[1], rig_.with("front_stiff", {0.1 + 1e-5}), rig_.with("front_stiff", {0.1 - 1e-5}), 1e-5),
            1e-2);
}

}  // namespace test_diagnose_regressors
}  // namespace gripline::diagnose
