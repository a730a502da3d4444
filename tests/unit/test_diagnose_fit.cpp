#include <gtest/gtest.h>

#include "diagnose/adequacy.hpp"
#include "diagnose/constancy.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/search.hpp"
#include "diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

constexpr std::array<double, 3> smooth = {0, 0, 0}, everywhere = {1, 1, 1};

TEST(Fit, FindsParametersWithinTheirUncertainty) {
  DiagnoseRig rig;
  const std::vector<std::pair<const char*, std::vector<double>>> effects = {{"rolling_res", {0.3}},
                                                                            {"front_stiff", {-0.15}},
                                                                            {"steer_lag", {0.04}},
                                                                            {"input_delay", {0.031}},
                                                                            {"vx_bias", {0.05}}};
  for (const auto& [id, values] : effects) {
    const ModelSpec truth = rig.with(id, values);
    Problem problem = rig.problem({rig.simulate(truth, {20, 21, 1})});
    const Fit rough = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 4);
    renew_reference(problem, rig.road(), rough);
    const Fit found =
        fit(problem, rig.catalogue().with(rig.catalogue().bare(), rig.catalogue().find(id)), rough.noise, 15);
    EXPECT_NEAR(found.theta.front(), values.front(), 4.0 * std::sqrt(found.covariance.front())) << id;
    EXPECT_LT(std::sqrt(found.covariance.front()), 0.05 * std::abs(values.front())) << id;
  }
}

TEST(Fit, ProcessVariancesVanishWhenThereIsNone) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {20, 23, 1})});
  const Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 12);
  for (std::size_t i = 0; i < noise_states; ++i)
    EXPECT_LT(std::sqrt(f.noise.process[i]), 0.1 * problem.process_unit[i]);
}

/// A tyre that relaxes shows nothing of its stiffness in the rates of an instant, only through what is remembered.
TEST(Fit, FindsWhatActsBeforeAnEffectThatRemembers) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("relaxation", {0.05}), "front_stiff", {0.15});
  Problem problem = rig.problem({rig.simulate(truth, {20, 25, 1})});
  const Fit rough = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 4);
  renew_reference(problem, rig.road(), rough);
  const ModelSpec start = rig.with(rig.with("relaxation", {0.04}), "front_stiff", {0.02});
  Fit found = fit(problem, start, rough.noise, 15);
  renew_reference(problem, rig.road(), found);
  found = fit(problem, found.model, found.noise, 10);
  const auto stiff = found.model.values[found.model.position(rig.catalogue().find("front_stiff"))][0];
  const auto sigma = found.model.values[found.model.position(rig.catalogue().find("relaxation"))][0];
  EXPECT_NEAR(stiff, 0.15, 0.003);
  EXPECT_NEAR(sigma, 0.05, 0.003);
}

/// Three standard deviations are more than a nuisance may take: the tyre's grip is named.
TEST(Fit, NuisancesStayWithinTheirLimits) {
  DiagnoseRig rig;
  Nuisance n;
  n.name = "Df";
  n.nominal = rig.catalogue().nominal(n.name, &n.index);
  n.sigma = 0.02 * n.nominal;
  rig.catalogue().set_nuisances({n});
  Problem problem = rig.problem({rig.simulate(rig.with("front_grip", {0.06}), {20, 27, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_LE(search.nothing().theta[0], n.nominal * 1.0401);
  EXPECT_EQ(rig.catalogue().name(search.best().model), "front_grip");
}

TEST(Search, NamesWhatIsMissing) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("drive_gain", {0.12}), {30, 31, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_EQ(rig.catalogue().name(search.best().model), "drive_gain");
  EXPECT_NEAR(search.best().theta.front(), 0.12, 0.005);
}

TEST(Search, NamesTwo) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("steer_offset", {0.015}), "yaw_inertia", {0.25});
  Problem problem = rig.problem({rig.simulate(truth, {30, 33, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_EQ(rig.catalogue().name(search.best().model), "steer_offset+yaw_inertia");
}

TEST(Search, NamesNothingWhenNothingIsMissing) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {30, 35, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_TRUE(search.best().model.members.empty());
  for (const BasisTest& test : remainder(problem, search.best())) EXPECT_LT(test.excess, 4.0);
}

/// A channel that nobody read starts far from where it was: models linearised there would take up the error.
TEST(Search, NamesNothingWithoutTheLateralSpeed) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {61, 62, 63}) {
    diagnose::Measured log = rig.simulate(rig.catalogue().bare(), {40, seed, 1});
    for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * 6 + 4] = std::nan("");
    Problem p = rig.problem({log});
    Search search(p, rig.road());
    search.run();
    EXPECT_EQ(rig.catalogue().name(search.best().model), "none") << seed;
    for (const Fit* one : search.tried()) EXPECT_LT(one->score - search.nothing().score, 6.5) << seed;
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

/// The second effect explains a four-hundredth of what the first does, and that is still thousands of units.
TEST(Search, NamesTheSmallBesideTheHuge) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with(rig.with("vx_scale", {-0.3}), "yaw_inertia", {0.2});
  Problem problem = rig.problem({rig.simulate(truth, {40, 57, 0.3})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_EQ(rig.catalogue().name(search.best().model), "yaw_inertia+vx_scale");
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

/// What is measured in standard deviations of a noise that is not there means nothing, and the reader is told.
TEST(Diagnoser, TellsThatALogHasNoNoise) {
  DiagnoseRig rig;
  const auto told = [&](double noise) {
    Diagnoser diagnoser(rig.world(), rig.registry(), {});
    LogFile log;
    log.stretches.push_back(rig.simulate(rig.with("drive_gain", {0.12}), {20, 59, noise}));
    const Diagnosis d = diagnoser.run({&log, 1}, {});
    return std::any_of(d.health.begin(), d.health.end(),
                       [](const Health& h) { return h.found.starts_with("none to be seen"); });
  };
  EXPECT_TRUE(told(0.0));
  EXPECT_FALSE(told(1.0));
}

TEST(Search, TellsExactSynonyms) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("input_delay", {0.04}), {20, 37, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_EQ(rig.catalogue().name(search.best().model), "input_delay");
  const auto& same = search.synonyms();
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
  Problem problem = rig.problem({rig.simulate(truth, {30, 41, 1})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_EQ(rig.catalogue().name(search.best().model), "rolling_res");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(search.best().theta[i], truth.nuisance[i], 0.01 * truth.nuisance[i]) << nuisances[i].name;
}

/// A filter free to call anything random explains an oscillation by noise; it is told all the same, with its frequency.
TEST(Remainder, TellsARhythmFromNoise) {
  DiagnoseRig rig;
  Measured log = rig.simulate(rig.catalogue().bare(), {40, 45, 1});
  // What a yaw acceleration of 6 rad/s2 at 0.7 Hz adds to the readings of yaw and yaw rate.
  const double rate = 2.0 * M_PI * 0.7;
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double t = static_cast<double>(k) * log.dt;
    log.reading[k * channels + 2] -= 6.0 / (rate * rate) * std::sin(rate * t);
    log.reading[k * channels + 5] -= 6.0 / rate * std::cos(rate * t);
  }
  Problem problem = rig.problem({log});
  Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
  renew_reference(problem, rig.road(), f);
  f = fit(problem, f.model, f.noise, 8);
  double excess = 0.0, frequency = 0.0;
  for (const BasisTest& test : remainder(problem, f))
    if (test.quantity == "frequency") excess = test.excess, frequency = test.from;
  EXPECT_GT(excess, structured);
  EXPECT_NEAR(frequency, 0.7, 0.03);
}

/// A yaw acceleration that is random while nothing else is: no road does that.
TEST(Remainder, TellsARoughRoadFromWhatOneDirectionLacks) {
  DiagnoseRig rig;
  const auto uneven = [&](const std::array<double, 3>& rough) {
    Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = 87, .rough = rough})});
    Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
    renew_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    return remainder(problem, f)[4].excess;
  };
  EXPECT_LT(uneven(smooth), structured);
  EXPECT_LT(uneven(everywhere), structured);
  EXPECT_GT(uneven({1, 0, 0}), structured);
  EXPECT_GT(uneven({0, 0, 2}), structured);
}

/// The spectrum of a rough road has lines of its own: those are no rhythm.
TEST(Remainder, HearsNoRhythmInARoughRoad) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {81, 82, 83, 84, 85}) {
    Problem problem =
        rig.problem({rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = seed, .rough = everywhere})});
    Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
    renew_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    ASSERT_TRUE(rough_road(problem, f.noise));
    for (const BasisTest& test : remainder(problem, f)) EXPECT_LT(test.excess, structured) << test.quantity << seed;
  }
}

/// A grip that falls is no smaller grip: what is named must be the same throughout the log.
TEST(Remainder, WhatIsNamedIsConstant) {
  DiagnoseRig rig({"friction_drift"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 47, 1})});
    Fit f = fit(problem, rig.with("friction_scale", {-0.05}), rig.noise(problem, 1.0), 10);
    settle_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    double excess = 0.0;
    for (const BasisTest& test : constancy(problem, f, linearise_all(problem, f.model)))
      excess = std::max(excess, test.excess);
    return excess;
  };
  EXPECT_LT(most(rig.with("friction_scale", {-0.1})), structured);
  EXPECT_GT(most(rig.with("friction_drift", {-0.1})), structured);
}

/// Wheels that stand askew are no change of the steering's ratio: that would be larger to one side and smaller to the other.
TEST(Remainder, WhatIsNamedIsTheSameToBothSides) {
  DiagnoseRig rig({"steer_offset"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 48, 1})});
    Fit f = fit(problem, rig.with("steer_gain", {0.01}), rig.noise(problem, 1.0), 10);
    settle_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    return inconstancy(problem, f, linearise_all(problem, f.model)).front();
  };
  EXPECT_LT(most(rig.with("steer_gain", {0.06})), structured);
  EXPECT_GT(most(rig.with("steer_offset", {0.01})), structured);
}

/// What is left out behind the last effect that remembers does not change what it remembers.
TEST(StagedCar, MemoryRatesAreThoseOfTheWholeCar) {
  DiagnoseRig rig;
  const ModelSpec model = rig.with(rig.with("relaxation", {0.05}), "steer_lag", {0.04});
  Problem problem = rig.problem({rig.simulate(model, {10, 55, 1})});
  const Trace& trace = problem.traces.front();
  const StagedCar car = rig.catalogue().build(model);
  const std::vector<double> memory = run_memory(car, trace), whole = memory_rates(car, trace, memory);
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

TEST(LinearModel, StepsOfIntegrationFollowTheSampleTime) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {10, 49, 1})});
  const StagedCar car = rig.catalogue().build(rig.catalogue().bare());
  const int usual = substeps_of_motion(car, problem.traces);
  problem.traces.front().log.dt = 0.05;
  const int slow = substeps_of_motion(car, problem.traces);
  problem.traces.front().log.dt = 0.002;
  EXPECT_EQ(substeps_of_motion(car, problem.traces), 1);
  EXPECT_GT(slow, usual);
}

/// Shape parameters cost less than those that stand for an effect of their own, but never nothing.
TEST(Problem, ChargesShapesLess) {
  Problem p;
  p.penalty_per_parameter = 5.0;
  EXPECT_DOUBLE_EQ(p.charge(1), 5.0);
  EXPECT_DOUBLE_EQ(p.charge(3), 15.0);
  EXPECT_DOUBLE_EQ(p.charge(10), 15.0 + 7 * 2.0);
}

/// Slopes of the road in random accelerations: ten coefficients that together stand out, none by itself.
TEST(Search, NamesAGradeInProcessNoise) {
  DiagnoseRig rig;
  const ModelSpec truth =
      rig.with("grade", {-0.003, -0.003, -0.012, -0.036, -0.027, -0.003, 0.003, 0.018, 0.039, 0.024});
  Problem problem = rig.problem({rig.simulate(truth, {.seconds = 60, .seed = 51, .rough = everywhere})});
  Search search(problem, rig.road());
  search.run();
  EXPECT_TRUE(rough_road(problem, search.best().noise));
  EXPECT_EQ(rig.catalogue().name(search.best().model), "grade");
}

/// Where the road hides the car, readings that follow one another tell the same: parameters cost less than by their
/// number, and effects that this makes visible are seen. Nothing that is not there is.
TEST(Search, ChargesByIndependentValuesOnARoughRoad) {
  DiagnoseRig rig;
  const ModelSpec small = rig.with("steer_offset", {0.003});
  for (const bool rough : {false, true}) {
    Problem problem =
        rig.problem({rig.simulate(small, {.seconds = 40, .seed = 57, .rough = rough ? everywhere : smooth})});
    const double before = problem.penalty_per_parameter;
    Search search(problem, rig.road());
    search.run();
    EXPECT_EQ(rig.catalogue().name(search.best().model), "steer_offset") << rough;
    if (rough)
      EXPECT_NEAR(problem.penalty_per_parameter, 0.5 * std::log(3.0 * 40.02 / 0.5), 1e-9);
    else
      EXPECT_EQ(problem.penalty_per_parameter, before);
  }
  for (const std::uint64_t seed : {58, 59, 60}) {
    Problem problem =
        rig.problem({rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = seed, .rough = everywhere})});
    Search search(problem, rig.road());
    search.run();
    EXPECT_EQ(rig.catalogue().name(search.best().model), "none") << seed;
  }
}

/// Places that were not driven through: there a calm shape does nothing, and elsewhere it is what it was.
TEST(Fit, CalmShapesRestWhereNothingWasSeen) {
  DiagnoseRig rig;
  const ModelSpec truth = rig.with("bank", {0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02});
  Problem problem = rig.problem({rig.simulate(truth, {.seconds = 3, .seed = 89})});
  std::array<double, 10> seen{};
  for (const Place& at : problem.traces.front().at)
    seen[static_cast<std::size_t>(10.0 * at.lap_fraction + 0.5) % 10] += 0.01;
  ModelSpec start = truth;
  for (double& c : start.values.front()) c = 0.08;
  problem.calm_shapes = true;
  const Fit f = fit(problem, start, rig.noise(problem, 0.003), 10);
  int rested = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    const bool near = seen[i] + seen[(i + 1) % 10] + seen[(i + 9) % 10] + seen[(i + 2) % 10] + seen[(i + 8) % 10] > 0.0;
    if (near) continue;
    ++rested;
    EXPECT_LT(std::abs(f.theta[i]), 0.005) << i;
  }
  EXPECT_GT(rested, 2);
  EXPECT_GT(*std::max_element(f.theta.begin(), f.theta.end()), 0.012);
}

/// A fit that cannot come near what is wanted stops early, and says no more than it found.
TEST(Fit, StopsWhenTheScoreIsOutOfReach) {
  DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("drive_gain", {0.12}), {20, 53, 1})});
  const ModelSpec start = rig.with("yaw_inertia", {0.1});
  const Fit whole = fit(problem, start, rig.noise(problem, 5.0), 10);
  const Fit early = fit(problem, start, rig.noise(problem, 5.0), 10, {0.01, whole.score + 1e6});
  EXPECT_LE(early.score, whole.score + 1e-6);
  EXPECT_FALSE(early.converged);
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

TEST(Remainder, SeesAPushOfTheRoadAndWhereItIs) {
  // friction_patch may not be named: what it does is then a remainder in one place.
  DiagnoseRig rig({"friction_patch", "bank", "grade"});
  const ModelSpec truth = rig.with("friction_patch", {-0.3, 0.25, 0.15});
  Problem problem = rig.problem({rig.simulate(truth, {40, 43, 1})});
  Search search(problem, rig.road());
  search.run();
  double largest = 0.0;
  for (const BasisTest& test : remainder(problem, search.nothing())) largest = std::max(largest, test.excess);
  EXPECT_GT(largest, 4.0);
}

}  // namespace
}  // namespace gripline::diagnose
