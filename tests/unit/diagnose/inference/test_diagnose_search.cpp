#include <gtest/gtest.h>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/search.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

/// A log through the whole search.
struct Searched {
  Searched(const DiagnoseRig& rig, Measured log) : problem(rig.problem({std::move(log)})), search(problem, rig.road()) {
    search.run();
  }
  std::string name() const { return problem.catalogue->name(search.best().model); }
  Problem problem;
  Search search;
};

constexpr std::array<double, 3> smooth = {0, 0, 0}, everywhere = {1, 1, 1};

TEST(Search, NamesWhatIsMissing) {
  DiagnoseRig rig;
  const Searched found(rig, rig.simulate(rig.with("drive_gain", {0.12}), {30, 31, 1}));
  EXPECT_EQ(found.name(), "drive_gain");
  EXPECT_NEAR(found.search.best().theta.front(), 0.12, 0.005);
}

TEST(Search, NamesTwo) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("steer_offset", {0.015}), "yaw_inertia", {0.25});
  const Searched found(rig, rig.simulate(truth, {30, 33, 1}));
  EXPECT_EQ(found.name(), "steer_offset+yaw_inertia");
}

/// A heavier car on a slicker road corners as before: neither shows by itself.
TEST(Search, NamesTwoThatHideEachOther) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("mass", {0.12}), "friction_scale", {-0.095});
  const Searched found(rig, rig.simulate(truth, {30, 34, 1}));
  EXPECT_EQ(found.name(), "mass+friction_scale");
  const Fit& nothing = found.search.null_model();
  const std::vector<Extension> pairs = best_pairs(found.problem, nothing, screen(found.problem, nothing));
  ASSERT_GT(pairs.size(), 1u);
  EXPECT_EQ(rig.catalogue().name(pairs.front().start), "mass+friction_scale");
  EXPECT_GE(pairs[0].gain, pairs[1].gain);
}

TEST(Search, NamesNothingWhenNothingIsMissing) {
  DiagnoseRig rig;
  const Searched found(rig, rig.simulate(rig.catalogue().bare(), {30, 35, 1}));
  EXPECT_TRUE(found.search.best().model.members.empty());
  for (const BasisTest& test : remainder(found.problem, found.search.best())) EXPECT_LT(test.excess, 4.0);
}

/// A channel that nobody read starts far from where it was: models linearised there would take up the error.
TEST(Search, NamesNothingWithoutTheLateralSpeed) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {61, 62, 63}) {
    diagnose::Measured log = rig.simulate(rig.catalogue().bare(), {40, seed, 1});
    for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * 6 + 4] = std::nan("");
    const Searched found(rig, log);
    EXPECT_EQ(found.name(), "none") << seed;
    for (const Fit* one : found.search.tried()) EXPECT_LT(one->score - found.search.null_model().score, 6.5) << seed;
  }
}

/// The second effect explains a four-hundredth of what the first does, and that is still thousands of units.
TEST(Search, NamesTheSmallBesideTheHuge) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("vx_scale", {-0.3}), "yaw_inertia", {0.2});
  const Searched found(rig, rig.simulate(truth, {40, 57, 0.3}));
  EXPECT_EQ(found.name(), "yaw_inertia+vx_scale");
}

TEST(Search, TellsExactSynonyms) {
  DiagnoseRig rig;
  const Searched found(rig, rig.simulate(rig.with("input_delay", {0.04}), {20, 37, 1}));
  EXPECT_EQ(found.name(), "input_delay");
  const auto& same = found.search.synonyms();
  ASSERT_EQ(same.count(rig.catalogue().find("input_delay")), 1U);
  EXPECT_EQ(same.at(rig.catalogue().find("input_delay")),
            std::vector<std::size_t>{rig.catalogue().find("sensor_latency")});
}

TEST(Search, WrongNominalParametersAreFittedAlongside) {
  DiagnoseRig rig;
  std::vector<Nuisance> nuisances;
  for (const char* name : {"Df", "Dr", "Cm1"}) {
    Nuisance n;
    n.name = name;
    n.nominal = rig.catalogue().nominal(name, &n.index);
    n.sigma = 0.02 * n.nominal;
    nuisances.push_back(n);
  }
  rig.catalogue().set_nuisances(nuisances);
  ModelSpec truth = rig.with("rolling_res", {0.4});
  truth.nuisance[0] *= 1.02;
  truth.nuisance[1] *= 0.985;
  truth.nuisance[2] *= 0.98;
  const Searched found(rig, rig.simulate(truth, {30, 41, 1}));
  EXPECT_EQ(found.name(), "rolling_res");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(found.search.best().theta[i], truth.nuisance[i], 0.01 * truth.nuisance[i]) << nuisances[i].name;
}

/// Three standard deviations are more than a nuisance may take: the tyre's grip is named.
TEST(Search, NuisancesStayWithinTheirLimits) {
  DiagnoseRig rig;
  Nuisance n;
  n.name = "Df";
  n.nominal = rig.catalogue().nominal(n.name, &n.index);
  n.sigma = 0.02 * n.nominal;
  rig.catalogue().set_nuisances({n});
  const Searched found(rig, rig.simulate(rig.with("front_grip", {0.06}), {20, 27, 1}));
  EXPECT_LE(found.search.null_model().theta[0], n.nominal * 1.0401);
  EXPECT_EQ(found.name(), "front_grip");
}

/// Slopes of the road in random accelerations: ten coefficients that together stand out, none by itself.
TEST(Search, NamesAGradeInProcessNoise) {
  DiagnoseRig rig;
  const ModelSpec truth =
      rig.with("grade", {-0.003, -0.003, -0.012, -0.036, -0.027, -0.003, 0.003, 0.018, 0.039, 0.024});
  const Searched found(rig, rig.simulate(truth, {.seconds = 60, .seed = 51, .rough = everywhere}));
  EXPECT_TRUE(rough_road(found.problem, found.search.best().noise));
  EXPECT_EQ(found.name(), "grade");
}

/// Where the road hides the car, readings that follow one another tell the same: parameters cost less than by their
/// number, and effects that this makes visible are seen. Nothing that is not there is.
TEST(Search, ChargesByIndependentValuesOnARoughRoad) {
  DiagnoseRig rig;
  const ModelSpec small = rig.with("steer_offset", {0.003});
  for (const auto& rough : {smooth, everywhere}) {
    const Measured log = rig.simulate(small, {.seconds = 40, .seed = 57, .rough = rough});
    const double usual = rig.problem({log}).penalty_per_parameter, independent = 3.0 * 40.02 / 0.5;
    const Searched found(rig, log);
    EXPECT_EQ(found.name(), "steer_offset");
    EXPECT_NEAR(found.problem.penalty_per_parameter, rough == smooth ? usual : 0.5 * std::log(independent), 1e-9);
  }
  for (const std::uint64_t seed : {58, 59, 60}) {
    const Searched found(rig, rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = seed, .rough = everywhere}));
    EXPECT_EQ(found.name(), "none") << seed;
  }
}

/// The search's work is counted, not timed, and when it is spent the best so far is the answer.
TEST(Search, EndsWithWhatItHasWhenItsWorkIsSpent) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("steer_offset", {0.015}), "yaw_inertia", {0.25});
  const std::vector<Measured> log{rig.simulate(truth, {20, 33, 1})};
  const auto searched = [&](double most_work) {
    Problem problem = rig.problem(log);
    SearchOptions options;
    options.most_work = most_work;
    Search search(problem, rig.road(), options);
    search.run();
    return std::pair(search.work(), search.best().model.members.size());
  };
  const auto whole = searched(1e12), none = searched(0.0);
  EXPECT_EQ(whole.second, 2u);
  // Less than what the nominal car itself takes: nothing is tried. A little more: one effect is found, no second looked for.
  EXPECT_EQ(none.second, 0u);
  const auto some = searched(none.first + 1.0);
  EXPECT_EQ(some.second, 1u);
  EXPECT_GT(some.first, none.first + 1.0);
  EXPECT_LT(some.first, 0.7 * whole.first);
  EXPECT_EQ(searched(none.first + 1.0), some);
}

/// What could be as well is told also when no work is left: without its rivals the best would look surer than it is.
TEST(Search, KeepsRivalsWhenItsWorkIsSpent) {
  DiagnoseRig rig;
  const Measured log = rig.simulate(rig.with("drive_gain", {0.03}), {.seconds = 20, .seed = 302, .rough = everywhere});
  const auto near = [&](double most_work) {
    Problem problem = rig.problem({log});
    SearchOptions options;
    options.most_work = most_work;
    Search search(problem, rig.road(), options);
    search.run();
    const auto all = search.tried();
    return std::count_if(all.begin(), all.end(), [&](const Fit* one) {
      return !one->model.members.empty() && one->score > search.best().score - 4.0;
    });
  };
  EXPECT_GT(near(1e12), 1);
  EXPECT_GT(near(40000), 1);
}

}  // namespace
}  // namespace gripline::diagnose
