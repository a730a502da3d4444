#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/search.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_search {

using test::DiagnoseRig;

/// A log through the whole search. Only the largest model can be said to lack another effect.
SearchResult searched(const DiagnoseRig& rig, Log log, double work_per_minute = thresholds::work_per_minute) {
  SearchOptions options;
  options.work_per_minute = work_per_minute;
  SearchResult found = search_effects(rig.problem({std::move(log)}), rig.road(), options);
  EXPECT_TRUE(!found.exhausted || found.best.model.members.size() == thresholds::max_effects);
  return found;
}
std::string name(const SearchResult& found) { return found.pool.problem().catalogue->name(found.best.model); }

constexpr std::array<double, 3> smooth = {0, 0, 0}, everywhere = {1, 1, 1};

/// Each model of a search that puts effects in, takes them out and exchanges them must beat more than the one before:
/// else it could go in circles, as it did where the share was of the larger model's evidence.
TEST(Search, WhatAModelMustBeatRisesWithTheSmallerOne) {
  for (const SearchReference along : {SearchReference::first, SearchReference::refined})
    for (std::size_t size = 1; size <= thresholds::max_effects; ++size) {
      double before = -std::numeric_limits<double>::infinity();
      for (double over_null = -50.0; over_null < 1e6; over_null += 1.0 + 0.1 * std::abs(over_null)) {
        const double required = required_evidence(size, over_null, along);
        EXPECT_GT(required, 0.0);
        EXPECT_GT(over_null + required, before) << size << ' ' << over_null;
        before = over_null + required;
      }
    }
}

TEST(Search, NamesWhatIsMissing) {
  DiagnoseRig rig;
  const SearchResult found = searched(rig, rig.simulate(rig.with("drive_gain", {0.12}), {30, 31, 1}));
  EXPECT_EQ(name(found), "drive_gain");
  EXPECT_NEAR(found.best.theta.front(), 0.12, 0.005);
}

TEST(Search, NamesTwo) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("steer_offset", {0.015}), "yaw_inertia", {0.25});
  const SearchResult found = searched(rig, rig.simulate(truth, {30, 33, 1}));
  EXPECT_EQ(name(found), "steer_offset+yaw_inertia");
}

/// A heavier car on a slicker road corners as before: neither shows by itself.
TEST(Search, NamesTwoThatHideEachOther) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("mass", {0.12}), "friction_scale", {-0.095});
  const SearchResult found = searched(rig, rig.simulate(truth, {30, 34, 1}));
  EXPECT_EQ(name(found), "mass+friction_scale");
  const Problem& problem = found.pool.problem();
  const std::vector<Extension> pairs = best_pairs(problem, found.null_model, screen(problem, found.null_model));
  ASSERT_GT(pairs.size(), 1u);
  EXPECT_EQ(rig.catalogue().name(pairs.front().start), "mass+friction_scale");
  EXPECT_GE(pairs[0].gain, pairs[1].gain);
}

TEST(Search, NamesNothingWhenNothingIsMissing) {
  DiagnoseRig rig;
  const SearchResult found = searched(rig, rig.simulate(rig.catalogue().null_model(), {30, 35, 1}));
  EXPECT_TRUE(found.best.model.members.empty());
  for (const ResidualTest& test : residual_tests(found.pool.problem(), found.best)) EXPECT_LT(test.statistic, 4.0);
}

/// A channel that nobody read starts far from where it was: models linearised there would take up the error.
TEST(Search, NamesNothingWithoutTheLateralSpeed) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {61, 62, 63}) {
    measured::Log log = rig.simulate(rig.catalogue().null_model(), {40, seed, 1});
    for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * 6 + 4] = std::nan("");
    const SearchResult found = searched(rig, log);
    EXPECT_EQ(name(found), "none") << seed;
    for (const Fit* one : found.pool.all()) EXPECT_LT(one->evidence - found.null_model.evidence, 6.5) << seed;
  }
}

/// The second effect explains a four-hundredth of what the first does, and that is still thousands of units.
TEST(Search, NamesTheSmallBesideTheHuge) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("vx_scale", {-0.3}), "yaw_inertia", {0.2});
  const SearchResult found = searched(rig, rig.simulate(truth, {40, 57, 0.3}));
  EXPECT_EQ(name(found), "yaw_inertia+vx_scale");
}

TEST(Search, TellsExactSynonyms) {
  DiagnoseRig rig;
  const SearchResult found = searched(rig, rig.simulate(rig.with("input_delay", {0.04}), {20, 37, 1}));
  EXPECT_EQ(name(found), "input_delay");
  const auto& same = found.synonyms;
  ASSERT_EQ(same.count(rig.catalogue().find("input_delay")), 1U);
  EXPECT_EQ(same.at(rig.catalogue().find("input_delay")),
            std::vector<std::size_t>{rig.catalogue().find("sensor_latency")});
}

TEST(Search, WrongNominalParametersAreFittedAlongside) {
  DiagnoseRig rig;
  rig.trust({"Df", "Dr", "Cm1"}, 0.02);
  ModelSpec truth = rig.with("rolling_res", {0.4});
  truth.nuisance[0] *= 1.02;
  truth.nuisance[1] *= 0.985;
  truth.nuisance[2] *= 0.98;
  const SearchResult found = searched(rig, rig.simulate(truth, {30, 41, 1}));
  EXPECT_EQ(name(found), "rolling_res");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(found.best.theta[i], truth.nuisance[i], 0.01 * truth.nuisance[i]) << i;
}

/// Three standard deviations are more than a nuisance may take: the tyre's grip is named.
TEST(Search, NuisancesStayWithinTheirLimits) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.02);
  const SearchResult found = searched(rig, rig.simulate(rig.with("front_grip", {0.06}), {20, 27, 1}));
  EXPECT_LE(found.null_model.theta[0], rig.catalogue().nuisances().front().nominal * 1.0401);
  EXPECT_EQ(name(found), "front_grip");
}

/// Slopes of the road in random accelerations: ten coefficients that together stand out, none by itself.
TEST(Search, NamesAGradeInProcessNoise) {
  DiagnoseRig rig;
  const ModelSpec truth =
      rig.with("grade", {-0.003, -0.003, -0.012, -0.036, -0.027, -0.003, 0.003, 0.018, 0.039, 0.024});
  const SearchResult found = searched(rig, rig.simulate(truth, {.seconds = 60, .seed = 51, .rough = everywhere}));
  EXPECT_TRUE(has_strong_process_noise(found.pool.problem(), found.best.noise));
  EXPECT_EQ(name(found), "grade");
}

/// In strong process noise neighbouring readings tell the same: the penalty counts independent ones, small effects are
/// found, and nothing that is not there.
TEST(Search, PenalisesByIndependentReadingsInProcessNoise) {
  DiagnoseRig rig;
  const ModelSpec small = rig.with("steer_offset", {0.003});
  for (const auto& rough : {smooth, everywhere}) {
    const Log log = rig.simulate(small, {.seconds = 40, .seed = 57, .rough = rough});
    const double smooth_penalty = rig.problem({log}).penalty_per_parameter(), independent = 3.0 * 40.02 / 0.5;
    const SearchResult found = searched(rig, log);
    EXPECT_EQ(name(found), "steer_offset");
    EXPECT_NEAR(found.pool.problem().penalty_per_parameter(),
                rough == smooth ? smooth_penalty : 0.5 * std::log(independent), 1e-9);
  }
  for (const std::uint64_t seed : {58, 59, 60}) {
    const SearchResult found =
        searched(rig, rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = seed, .rough = everywhere}));
    EXPECT_EQ(name(found), "none") << seed;
  }
}

/// A file does not say that its commands act until the next: half a sample of delay is then no effect.
TEST(Search, FindsThatCommandsAreHeld) {
  DiagnoseRig rig;
  const auto found_in = [&](const ModelSpec& truth, std::uint64_t seed) {
    Log log = rig.simulate(truth, {.seconds = 20, .seed = seed, .unsteady = 1, .held = true});
    log.hold.until_next = false;
    return searched(rig, log);
  };
  const SearchResult nothing = found_in(rig.catalogue().null_model(), 73),
                     gain = found_in(rig.with("drive_gain", {0.1}), 74);
  EXPECT_EQ(name(nothing), "none");
  EXPECT_TRUE(nothing.pool.problem().hold().until_next);
  EXPECT_EQ(name(gain), "drive_gain");
  EXPECT_NEAR(gain.best.theta.front(), 0.1, 0.01);
}

/// Every second row of a log whose commands are held from row to row: a quarter of a sample of delay is then no effect.
TEST(Search, KnowsOfHeldCommandsThatTheLogLeftOut) {
  DiagnoseRig rig;
  const auto thinned = [&](const ModelSpec& truth, std::uint64_t seed) {
    return rig.problem(
        {DiagnoseRig::thinned(rig.simulate(truth, {.seconds = 40, .seed = seed, .unsteady = 0.3, .held = true}))});
  };
  const auto found_in = [&](Problem problem) {
    problem.hold_time = 0.02;
    problem.hold_commands(measured::held_for(0.02, 0.04));
    return search_effects(problem, rig.road(), {});
  };
  const SearchResult nothing = found_in(thinned(rig.catalogue().null_model(), 76)),
                     grip = found_in(thinned(rig.with("rear_grip", {-0.1}), 77));
  EXPECT_EQ(name(nothing), "none");
  EXPECT_EQ(nothing.pool.problem().hold(), measured::held_for(0.02, 0.04));
  EXPECT_EQ(name(grip), "rear_grip");
  EXPECT_NEAR(grip.best.theta.front(), -0.1, 0.02);
  EXPECT_EQ(name(search_effects(thinned(rig.catalogue().null_model(), 76), rig.road(), {})), "input_delay");
}

/// What lies between rounded commands is between those that are expected.
TEST(Search, HeldCommandsThatWereLeftOutAreBetweenExpectedOnes) {
  DiagnoseRig rig;
  Problem problem = rig.problem({DiagnoseRig::rounded(
      DiagnoseRig::thinned(rig.simulate(rig.catalogue().null_model(), {.seconds = 4, .seed = 78, .held = true})),
      0.03)});
  problem.command_step = {0.0, 0.03};
  problem.hold_commands(measured::held_for(0.02, 0.04));
  const Log written = problem.traces.front().log;
  problem.unround_commands();
  const Log& expected = problem.traces.front().log;
  ASSERT_EQ(expected.fine.size(), 2 * expected.size() - 1);
  double moved = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(expected.fine[2 * k].delta, expected.command[k].delta) << k;
    moved = std::max(moved, std::abs(expected.command[k].delta - written.command[k].delta));
  }
  EXPECT_GT(moved, 1e-3);
}

/// Steering of a busy driver written in steps of 0.03 rad. Taken as it is written it leaves something unexplained.
TEST(Search, RoundedSteeringIsNoEffect) {
  DiagnoseRig rig;
  const double step = 0.03;
  const auto rounded = [&](const ModelSpec& truth) {
    return rig.problem({DiagnoseRig::rounded(rig.simulate(truth, {.seconds = 30, .seed = 71, .unsteady = 1}), step)});
  };
  const auto left = [](const SearchResult& found) {
    return strongest(residual_tests(found.pool.problem(), found.best)).statistic;
  };
  Problem problem = rounded(rig.catalogue().null_model());
  const SearchResult written = search_effects(problem, rig.road(), {});
  EXPECT_TRUE(!written.best.model.members.empty() || left(written) > thresholds::misfit);
  problem.command_step = {0.0, step};
  const SearchResult nothing = search_effects(problem, rig.road(), {});
  EXPECT_TRUE(nothing.pool.problem().unrounded);
  EXPECT_EQ(name(nothing), rig.catalogue().name(rig.catalogue().null_model()));
  EXPECT_LT(left(nothing), thresholds::misfit);
  Problem other = rounded(rig.with("rear_grip", {-0.07}));
  other.command_step = {0.0, step};
  const SearchResult one = search_effects(other, rig.road(), {});
  EXPECT_EQ(name(one), "rear_grip");
  EXPECT_LT(left(one), thresholds::misfit);
}

/// A controller that works in steps gives the car what it writes.
TEST(Search, ACarThatIsGivenRoundedSteeringIsTold) {
  DiagnoseRig rig;
  const double step = 0.03;
  Problem problem = rig.problem(
      {rig.simulate(rig.catalogue().null_model(), {.seconds = 30, .seed = 71, .unsteady = 0.3, .steer_step = step})});
  problem.command_step = {0.0, step};
  const SearchResult found = search_effects(problem, rig.road(), {});
  EXPECT_FALSE(found.pool.problem().unrounded);
  EXPECT_TRUE(found.best.model.members.empty());
}

/// A delay of the car is one, whatever the world says of its commands.
TEST(Search, ADelayIsNoHeldCommand) {
  DiagnoseRig rig;
  Problem problem =
      rig.problem({rig.simulate(rig.with("input_delay", {0.03}), {.seconds = 20, .seed = 75, .unsteady = 1})});
  EXPECT_FALSE(search_effects(problem, rig.road(), {}).pool.problem().hold().until_next);
  problem.hold_commands({.until_next = true});
  const SearchResult found = search_effects(problem, rig.road(), {});
  EXPECT_EQ(name(found), "input_delay");
  EXPECT_FALSE(found.pool.problem().hold().until_next);
  EXPECT_NEAR(found.best.theta.front(), 0.03, 0.002);
}

/// The search's work is counted, not timed, and when it is spent the best so far is the answer.
TEST(Search, EndsWithWhatItHasWhenItsWorkIsSpent) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("steer_offset", {0.015}), "yaw_inertia", {0.25});
  const Log log = rig.simulate(truth, {20, 33, 1});
  const auto work_and_effects = [&](double work_per_minute) {
    const SearchResult found = searched(rig, log, work_per_minute);
    return std::pair(found.pool.work(), found.best.model.members.size());
  };
  const auto whole = work_and_effects(1e12), none = work_and_effects(0.0);
  EXPECT_EQ(whole.second, 2u);
  // Less than what the nominal car itself takes: nothing is tried. A little more: one effect is found, no second looked
  // for.
  EXPECT_EQ(none.second, 0u);
  const auto some = work_and_effects(none.first + 1.0);
  EXPECT_EQ(some.second, 1u);
  EXPECT_GT(some.first, none.first + 1.0);
  EXPECT_LT(some.first, 0.7 * whole.first);
  EXPECT_EQ(work_and_effects(none.first + 1.0), some);
}

/// Rivals are kept also when no work is left: without them the best would look surer than it is.
TEST(Search, KeepsRivalsWhenItsWorkIsSpent) {
  DiagnoseRig rig;
  const Log log = rig.simulate(rig.with("drive_gain", {0.03}), {.seconds = 20, .seed = 302, .rough = everywhere});
  const auto near = [&](double work_per_minute) {
    const SearchResult found = searched(rig, log, work_per_minute);
    const auto all = found.pool.all();
    return std::count_if(all.begin(), all.end(), [&](const Fit* one) {
      return !one->model.members.empty() && one->evidence > found.best.evidence - 4.0;
    });
  };
  EXPECT_GT(near(1e12), 1);
  EXPECT_GT(near(40000), 1);
}

}  // namespace test_diagnose_search
}  // namespace gripline::diagnose
