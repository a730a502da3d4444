#include <gtest/gtest.h>

#include "diagnose/inference/reference.hpp"
#include "diagnose/inference/screening.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_screening {

using test::DiagnoseRig;

/// A log of `truth` with the null model fitted to it.
struct Screened {
  Problem problem;
  Fit null_model;
  Screening screening;
  Screened(const DiagnoseRig& rig, const ModelSpec& truth) : problem(rig.problem({rig.simulate(truth, {20, 91, 1})})) {
    null_model = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 1.0), 4);
    iterate_reference(problem, rig.road(), null_model);
    null_model = fit(problem, null_model.model, null_model.noise, 4);
    screening = screen(problem, null_model);
  }
  const Extension& of(const std::string& id) const {
    const std::size_t c = problem.catalogue->find(id);
    return *std::find_if(screening.extensions.begin(), screening.extensions.end(),
                         [&](const Extension& e) { return e.candidate == c; });
  }
};

TEST(Screening, PredictsWhatAFitFinds) {
  const DiagnoseRig rig;
  const Screened s(rig, rig.with("drive_gain", {0.02}));
  EXPECT_EQ(rig.catalogue().name(s.screening.extensions.front().start), "drive_gain");
  const Extension& e = s.of("drive_gain");
  const double predicted = e.start.values.front()[rig.catalogue().candidates()[e.candidate].fitted.front()];
  const Fit fitted = fit(s.problem, e.start, s.null_model.noise, 10);
  EXPECT_NEAR(fitted.theta.front(), 0.02, 0.004);
  EXPECT_NEAR(predicted, fitted.theta.front(), 0.3 * fitted.theta.front());
  const double gain = s.null_model.cost - fitted.cost;
  // The fit estimates the noise anew, which took up part of the misfit before: it gains more than was predicted.
  EXPECT_GT(e.gain, s.problem.penalty(e.dof));
  EXPECT_LT(e.gain, gain);
}

/// Where a refitted parameter has taken most of an effect up, the effect's start moves it back: both together would be
/// too much.
TEST(Screening, StartsMoveRefittedParameters) {
  DiagnoseRig rig;
  rig.trust({"Cm1"}, 0.04);
  const double nominal = rig.catalogue().nuisances().front().nominal;
  const Screened s(rig, rig.with("drive_gain", {0.06}));
  const double taken_up = s.null_model.model.nuisance[0] - nominal;
  EXPECT_GT(taken_up, 0.02 * nominal);
  const Extension& e = s.of("drive_gain");
  EXPECT_LT(e.start.nuisance[0] - nominal, 0.5 * taken_up);
  const auto rise = [&](const ModelSpec& start) {
    return fit(s.problem, start, s.null_model.noise, 1).cost - s.null_model.cost;
  };
  ModelSpec left_behind = e.start;
  left_behind.nuisance = s.null_model.model.nuisance;
  EXPECT_LT(rise(e.start), 0.01 * rise(left_behind));
}

/// A refitted parameter that an effect has pushed to its limit comes back from there beside it: the effect is predicted
/// whole, with what the parameter's prior gains, and not only by what the limit leaves.
TEST(Screening, RefittedParametersComeBackFromTheirLimits) {
  DiagnoseRig rig;
  constexpr double trust = 0.02, size = 0.10;  // five standard deviations, of which two are the parameter's
  rig.trust({"Bf"}, trust);
  const double nominal = rig.catalogue().nuisances().front().nominal;
  const Screened s(rig, rig.with("front_stiff", {size}));
  ASSERT_NEAR(s.null_model.model.nuisance[0], (1.0 + 2.0 * trust) * nominal, 1e-6 * nominal);
  ASSERT_TRUE(s.screening.at_limit);
  const Extension& e = s.of("front_stiff");
  EXPECT_NEAR(e.start.nuisance[0], nominal, trust * nominal);
  EXPECT_NEAR(e.start.values.front()[rig.catalogue().candidates()[e.candidate].fitted.front()], size, 0.3 * size);
  // To second order along the same linearisation: what a fit at the same noise gains, within a third.
  const double gain = s.null_model.cost - fit(s.problem, e.start, s.null_model.noise, 1).cost;
  EXPECT_NEAR(e.gain, gain, 0.35 * gain);
}

/// What a model's own parameters would still gain is no gain of an effect, of a fit that has not ended too.
TEST(Screening, GainsAreBesideThoseOfTheOwnParameters) {
  DiagnoseRig rig;
  rig.trust({"Bf", "Cm1"}, 0.02);
  const Screened s(rig, rig.with("front_stiff", {0.10}));
  Fit early = s.null_model;
  early.model.nuisance[1] *= 1.01;
  const Screening again = screen(s.problem, early);
  ASSERT_TRUE(s.screening.at_limit && again.at_limit);
  EXPECT_LT(s.screening.own_gain, 0.1);
  EXPECT_GT(again.own_gain, 10.0);
  const std::size_t other = rig.catalogue().find("vx_bias");
  for (const Extension& e : again.extensions)
    if (e.candidate == other) {
      EXPECT_NEAR(e.gain, s.of("vx_bias").gain, 0.5);
    }
}

/// Of an effect that a refitted parameter can do as well the log tells no more than how far that is trusted, at its
/// limit too; of others all that it told before.
TEST(Screening, InformationBesideARefittedParameterIsItsTrust) {
  DiagnoseRig rig;
  const auto information = [&](const ModelSpec& truth, const std::string& id) {
    const Screened s(rig, truth);
    for (const CandidateRegressors& group : s.screening.groups)
      if (group.candidate == rig.catalogue().find(id)) return information_beside(s.screening, group.first);
    return 0.0;
  };
  const ModelSpec nothing = rig.catalogue().null_model();
  const double grip = information(nothing, "front_grip"), offset = information(nothing, "vx_bias");
  EXPECT_GT(grip, 100.0 / (0.02 * 0.02));
  rig.trust({"Df"}, 0.02);
  for (const double size : {0.0, 0.06})
    EXPECT_NEAR(information(rig.with("front_grip", {size}), "front_grip") * 0.02 * 0.02, 1.0, 0.1) << size;
  EXPECT_GT(information(rig.catalogue().null_model(), "vx_bias"), 0.5 * offset);
}

/// A patch has no size to derive its place by: places are tried, and the best becomes the start.
TEST(Screening, ScansPlaces) {
  const DiagnoseRig rig;
  const Screened s(rig, rig.with("friction_patch", {-0.3, 0.25, 0.15}));
  const Extension& e = s.of("friction_patch");
  EXPECT_NEAR(e.start.values.front()[1], 0.25, 0.1);
  EXPECT_LT(e.start.values.front()[0], 0.0);
}

TEST(Screening, LeavesOutMembersAndExcludedEffects) {
  const DiagnoseRig rig({"aero_drag"});
  Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {6, 92, 1})});
  Fit one;
  one.model = rig.with("mass", {0.0});
  one.noise = rig.noise(problem, 1.0);
  const Screening s = screen(problem, one);
  EXPECT_EQ(s.own_params, 1U);
  EXPECT_EQ(s.extensions.size(), s.groups.size());
  EXPECT_EQ(s.extensions.size(), rig.catalogue().candidates().size() - 2);
  for (const Extension& e : s.extensions) {
    EXPECT_NE(rig.catalogue().candidates()[e.candidate].id, "aero_drag");
    EXPECT_EQ(e.start.members.size(), 2U);
  }
}

TEST(Screening, EqualRegressorsAreSynonyms) {
  const DiagnoseRig rig;
  const Screened s(rig, rig.catalogue().null_model());
  const auto same = synonyms(s.screening);
  ASSERT_EQ(same.size(), 1U);
  EXPECT_EQ(rig.catalogue().candidates()[same.begin()->first].id, "input_delay");
  ASSERT_EQ(same.begin()->second.size(), 1U);
  EXPECT_EQ(rig.catalogue().candidates()[same.begin()->second.front()].id, "sensor_latency");
}

/// A log that was cut shows parts of the lap in one stretch and others in the next: what a stretch does not pass makes
/// no other parameters.
TEST(Screening, AddsStretchesOfDifferentPartsOfTheLap) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("aero_drag", {0.3});
  Problem problem = rig.problem({rig.simulate(truth, {8, 91, 1}), rig.simulate(truth, {12, 92, 1})});
  const std::array<std::pair<double, double>, 2> parts = {std::pair(0.0, 0.2), std::pair(0.0, 2.0)};  // of laps
  for (std::size_t i = 0; i < 2; ++i) {
    Trace& trace = problem.traces[i];
    for (std::size_t k = 0; k < trace.size(); ++k)
      trace.at[k].lap_fraction = std::fmod(
          std::lerp(parts[i].first, parts[i].second, static_cast<double>(k) / static_cast<double>(trace.size())), 1.0);
  }
  const Fit fitted = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 1.0), 4);
  const Screening s = screen(problem, fitted);
  const CandidateRegressors& last = s.groups.back();
  EXPECT_EQ(static_cast<std::size_t>(s.normal.g.size()), last.first + last.count);
  EXPECT_EQ(rig.catalogue().name(s.extensions.front().start), "aero_drag");
}

/// A car that never brakes says nothing of its brakes, nor of how they fade: to the last digit, as a regressor is scaled
/// to unit size before its rank is found.
TEST(Screening, PutsLastWhatTheLogSaysNothingOf) {
  const DiagnoseRig rig;
  const Screened s(rig, rig.with("drive_gain", {0.02}));
  const std::vector<Extension>& all = s.screening.extensions;
  EXPECT_EQ(s.of("brake_gain").dof, 0U);
  EXPECT_EQ(s.of("brake_fade").dof, 0U);
  EXPECT_EQ(rig.catalogue().candidates()[all[all.size() - 1].candidate].id, "brake_gain");
  EXPECT_EQ(rig.catalogue().candidates()[all[all.size() - 2].candidate].id, "brake_fade");
}

/// Nor does one that never steers say how fast its wheels follow.
TEST(Screening, FindsNoLagOfASteeringThatStandsStill) {
  const DiagnoseRig rig;
  const Problem problem =
      rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 4, .seed = 93, .steer = 0})});
  Fit null_model;
  null_model.model = rig.catalogue().null_model();
  null_model.noise = rig.noise(problem, 1.0);
  const Screening s = screen(problem, null_model);
  std::map<std::string, std::size_t> dof;
  for (const Extension& e : s.extensions) dof[rig.catalogue().candidates()[e.candidate].id] = e.dof;
  EXPECT_EQ(dof.at("steer_gain"), 0U);
  EXPECT_EQ(dof.at("steer_lag"), 0U);
  EXPECT_EQ(dof.at("motor_lag"), 1U);
}

/// Beside three hidden states of the world's own effects the filter takes one more. Of two lags that are missing either
/// may be tried, both together may not, however much they would bring.
TEST(Screening, PairsFitTheFilter) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [
    {"plugin": "steer_lag", "params": {"tau": 0.02}}, {"plugin": "relaxation", "params": {"sigma": 0.02}}]}})");
  const Catalogue& catalogue = rig.catalogue();
  const Screened s(rig, rig.with(rig.with("motor_lag", {0.08}), "steer_lag", {0.04}));
  for (const char* id : {"motor_lag", "steer_lag"}) {
    EXPECT_GT(s.of(id).gain, s.problem.penalty(1)) << id;
    EXPECT_EQ(catalogue.hidden_states(s.of(id).start), 4U) << id;
  }
  const std::vector<Extension> pairs = best_pairs(s.problem, s.null_model, s.screening);
  EXPECT_FALSE(pairs.empty());
  for (const Extension& pair : pairs) EXPECT_TRUE(catalogue.fits_filter(pair.start)) << catalogue.name(pair.start);
}

}  // namespace test_diagnose_screening
}  // namespace gripline::diagnose
