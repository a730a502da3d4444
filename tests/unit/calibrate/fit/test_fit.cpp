#include "calibrate/fit/fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <random>

#include "calibrate/effects/advice.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_fit {

using test::CalibrateRig;
using test::drive;
using test::small_car_world;

constexpr const char* unknowns = R"({"unknowns": {
  "/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Dr": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Cm1": {"group": "drive", "sigma": 0.5, "scale": "log"},
  "/plant/params/Cd": {"group": "drive", "sigma": "1e-9 N s2/m2"},
  "/plant/effects/steer_offset/params/d0": {"group": "steer", "sigma": "20 mrad"}}})";

/// A log of a car of which four things differ from the world's.
struct Bench {
  explicit Bench(const char* chosen = "", double noise = 0.5, double seconds = 40, const char* patch = unknowns)
      : truth(small_car_world(R"({"plant": {"params": {"Bf": 6, "Dr": 7, "Cm1": 14},
                                            "effects": [{"plugin": "steer_offset", "params": {"d0": 0.02}}]}})")),
        rig(merge(small_car_world(), testing_support::json(patch))) {
    files.emplace_back();
    files.back().session = drive(truth.vehicle.car(), {.seconds = seconds, .noise = noise, .delay = {0, 0, 0, 0.15}});
    options.slowest = 0.5;
    options.starts = 60;
    logs = fit_logs(files, nullptr, 0.02, options);
    Errors errors;
    values = parameters_of(rig.tree, rig.forecaster, errors);
    const std::vector<std::string> names =
        *chosen == '\0' ? std::vector<std::string>{} : std::vector<std::string>{chosen};
    open = read_unknowns(rig.tree, parameter_places(rig.spec, rig.forecaster), values, names, errors);
    errors.throw_if_any();
  }
  FitResult run() { return fit(rig.forecaster, logs, values, open, options); }

  CalibrateRig truth, rig;
  std::list<measured::SessionFile> files;
  FitOptions options;
  std::vector<FitLog> logs;
  std::vector<double> values;
  std::vector<Unknown> open;
};

const FittedParameter* find(const FitResult& result, const std::string& pointer) {
  for (const FittedParameter& p : result.parameters)
    if (p.unknown.pointer == pointer) return &p;
  return nullptr;
}

TEST(Fit, FindsWhatTheLogsCarHasWithIntervalsThatHoldIt) {
  Bench bench;
  const FitResult result = bench.run();
  for (const auto& [pointer, value, close] : {std::tuple("/plant/params/Bf", 6.0, 0.4),
                                              {"/plant/params/Dr", 7.0, 0.3},
                                              {"/plant/params/Cm1", 14.0, 0.4},
                                              {"/plant/effects/steer_offset/params/d0", 0.02, 0.003},
                                              {"/calibration/delays/yaw_rate", 0.15, 0.01}}) {
    const FittedParameter* const p = find(result, pointer);
    ASSERT_NE(p, nullptr) << pointer;
    EXPECT_NEAR(p->value, value, close) << pointer;
    EXPECT_EQ(p->status, FittedParameter::Status::determined) << pointer;
    EXPECT_LT(p->interval.low, p->value);
    EXPECT_GT(p->interval.high, p->value);
    EXPECT_GT(p->interval.learned, 0.8) << pointer;
  }
  const auto& before = result.errors[result.errors.size() - 2];
  const auto& fitted = result.errors.back();
  EXPECT_EQ(fitted.name, "fitted");
  for (const std::size_t q : {0u, 1u, 2u, 4u}) EXPECT_LT(fitted.error[q].rms, 0.5 * before.error[q].rms) << q;
  // It ends where further steps hardly lower the cost, whatever ended the searches before the last one.
  PredictionErrors errors(bench.rig.forecaster, bench.logs);
  errors.weighing = result.weighing;
  std::vector<Unknown> open;
  for (const FittedParameter& p : result.parameters)
    if (p.status == FittedParameter::Status::determined) open.push_back(p.unknown);
  LeastSquaresOptions more;
  more.iterations = 2;
  double further = 0.0;
  least_squares(errors, open, result.params, more, further);
  EXPECT_GT(further, (1.0 - 2e-3) * result.cost_after);
}

TEST(Fit, WhatTheLogDoesNotTellIsSaidAndKeptAtItsPrior) {
  Bench bench;
  const FitResult result = bench.run();
  const FittedParameter* const p = find(result, "/plant/params/Cd");  // known to a billionth before
  ASSERT_NE(p, nullptr);
  EXPECT_EQ(p->status, FittedParameter::Status::undetermined);
  EXPECT_EQ(p->value, p->unknown.prior);
  EXPECT_NEAR(p->interval.high, 1.96e-9, 1e-12);  // what the prior says
}

/// As of a search that has looked at other things before. The prior of Cd is the end of its range, where it draws the
/// fit: the log did not lead there.
TEST(Fit, WhatTheLogDoesNotTellMayStayWhereTheFitBegins) {
  Bench bench;
  bench.options.undetermined_stay = true;
  double begin = 0.0;
  for (const Unknown& u : bench.open)
    if (u.pointer == "/plant/params/Cd") begin = bench.values[u.index] = u.prior + 1e-9;
  const FitResult result = bench.run();
  const FittedParameter* const p = find(result, "/plant/params/Cd");
  ASSERT_NE(p, nullptr);
  EXPECT_EQ(p->status, FittedParameter::Status::undetermined);
  EXPECT_EQ(p->value, begin);
  EXPECT_EQ(result.params[p->unknown.index], begin);
  EXPECT_EQ(p->unknown.prior, begin - 1e-9);
  EXPECT_NEAR(p->interval.high - begin, 1.96e-9, 1e-12);
}

TEST(Fit, IntervalsAreAsWideAsWhatIsNotDeterminedLeavesThem) {
  // Of two offsets the log tells the sum. One is known to 2 mrad before and stays at its prior, so the other is known
  // to 2 mrad at best.
  Bench bench("", 0.5, 40, R"({
    "plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0}},
                          {"plugin": "steer_offset", "params": {"d0": 0}}]},
    "unknowns": {"/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log"},
                 "/plant/params/Dr": {"group": "tyres", "sigma": 0.5, "scale": "log"},
                 "/plant/params/Cm1": {"group": "drive", "sigma": 0.5, "scale": "log"},
                 "/plant/effects/1/params/d0": {"group": "steer", "sigma": "2 mrad"},
                 "/plant/effects/0/params/d0": {"group": "steer", "sigma": "20 mrad"}}})");
  const FitResult result = bench.run();
  EXPECT_EQ(find(result, "/plant/effects/1/params/d0")->status, FittedParameter::Status::undetermined);
  const FittedParameter* const p = find(result, "/plant/effects/0/params/d0");
  ASSERT_EQ(p->status, FittedParameter::Status::determined);
  EXPECT_NEAR(p->value, 0.02, 0.003);
  EXPECT_GT(p->interval.high - p->value, 1.9 * 2e-3);
  EXPECT_LT(p->interval.high - p->value, 4 * 2e-3);
}

TEST(Fit, FrictionIsHardlyKnownWhereNoTyreSlides) {
  Bench bench("tyres");
  bench.files.front().session =
      drive(bench.truth.vehicle.car(), {.seconds = 30, .noise = 1, .command = [](double t) {
                                          return CommandSample<double>{0.2, 0.03 * std::sin(0.8 * t)};
                                        }});
  bench.logs = fit_logs(bench.files, nullptr, 0.02, bench.options);
  const FitResult result = bench.run();
  const Friction found = friction_of(bench.rig.vehicle.car(), bench.rig.spec.car.car, result.params,
                                     result.bootstrap_draws, result.posterior_draws);
  EXPECT_GT(found.total_high - found.total_low, 0.3);
}

TEST(Fit, AParameterAtItsBoundIsSaidAndKeptThere) {
  Bench bench;
  for (Unknown& u : bench.open)
    if (u.pointer == "/plant/params/Cm1") u.high = 13.0;  // the truth is 14
  const FitResult result = bench.run();
  const FittedParameter* const p = find(result, "/plant/params/Cm1");
  EXPECT_EQ(p->status, FittedParameter::Status::at_bound);
  EXPECT_EQ(p->value, 13.0);
  EXPECT_EQ(p->interval.high, 13.0);
  EXPECT_EQ(result.params[p->unknown.index], 13.0);
}

TEST(Fit, ArrivesAtOneModelFromStartsApart) {
  std::vector<std::array<double, 4>> errors;
  for (const unsigned seed : {11U, 13U}) {
    Bench bench;
    std::mt19937 random(seed);
    for (const Unknown& u : bench.open) {
      const double z = 1.5 * (static_cast<double>(random()) / 2147483648.0 - 1.0);  // up to one and a half widths
      if (u.group == "delays" || u.observer || u.sigma < 1e-6) continue;
      bench.values[u.index] =
          std::clamp(u.log ? u.prior * std::exp(z * u.sigma) : u.prior + z * u.sigma, u.low, u.high);
    }
    const auto fitted = bench.run().errors.back();
    errors.push_back({fitted.error[0].rms, fitted.error[1].rms, fitted.error[2].rms, fitted.error[4].rms});
  }
  for (std::size_t k = 1; k < errors.size(); ++k)
    for (std::size_t q = 0; q < 4; ++q) EXPECT_NEAR(errors[k][q], errors[0][q], 0.01 * errors[0][q]) << k << ' ' << q;
}

TEST(Fit, WhatIsTheSameIsFittedAsOne) {
  Bench bench;
  Unknown* leader = nullptr;
  for (Unknown& u : bench.open)
    if (u.pointer == "/plant/params/Bf") leader = &u;
  ASSERT_NE(leader, nullptr);
  for (const ParameterPlace& p : parameter_places(bench.rig.spec, bench.rig.forecaster))
    if (p.pointer == "/plant/params/Br") leader->same.push_back({p.pointer, p.index});
  ASSERT_EQ(leader->same.size(), 1u);
  const FitResult result = bench.run();
  EXPECT_EQ(result.params[leader->index], result.params[leader->same[0].index]);
  EXPECT_NE(result.params[leader->index], bench.values[leader->index]);
}

TEST(Fit, OnlyWhatIsChosenMoves) {
  Bench bench("tyres");
  const FitResult result = bench.run();
  EXPECT_EQ(result.parameters.size(), 2u);
  EXPECT_EQ(result.params[bench.rig.forecaster.index(ForecastParameter::gain_yaw)],
            bench.values[bench.rig.forecaster.index(ForecastParameter::gain_yaw)]);
}

TEST(Fit, IsTheSameTwice) {
  Bench a("drive"), b("drive");
  EXPECT_EQ(a.run().params, b.run().params);
}

/// Steers and accelerates until the tyres of a slippery floor slide.
CommandSample<double> wild(double t) {
  return {0.4 + 0.3 * std::sin(0.6 * t), 0.3 * std::sin(0.9 * t) + 0.12 * std::sin(2.7 * t + 1.0)};
}

TEST(Fit, FrictionOfASlipperyFloorIsReadFromTheDryModel) {
  int covered = 0;
  constexpr int sessions = 3;
  for (int k = 0; k < sessions; ++k) {
    const double mu = 0.35 + 0.09 * k / (sessions - 1);
    const double peak = 0.5 * mu * 1.6 * gravity;
    Node truth = small_car_world();
    set_value(truth, "/plant/params/Df", peak * 1.04);
    set_value(truth, "/plant/params/Dr", peak * 0.96);
    set_value(truth, "/plant/params/Bf", 6.5);
    const CalibrateRig slippery(truth);
    CalibrateRig dry(merge(small_car_world(), testing_support::json(R"({"unknowns": {
        "/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log"},
        "/plant/params/Br": {"group": "tyres", "sigma": 0.5, "scale": "log"},
        "/plant/params/Df": {"group": "tyres", "sigma": 0.4, "scale": "log"},
        "/plant/params/Dr": {"group": "tyres", "sigma": 0.4, "scale": "log"}}})")));
    std::list<measured::SessionFile> files(1);
    files.front().session = drive(slippery.vehicle.car(),
                                  {.seconds = 40, .noise = 1, .seed = 3U + static_cast<unsigned>(k), .command = wild});
    FitOptions options;
    options.slowest = 0.5;
    options.starts = 60;
    std::vector<FitLog> logs = fit_logs(files, nullptr, 0.02, options);
    Errors errors;
    const std::vector<double> values = parameters_of(dry.tree, dry.forecaster, errors);
    const std::vector<std::string> tyres{"tyres"};
    const auto open = read_unknowns(dry.tree, parameter_places(dry.spec, dry.forecaster), values, tyres, errors);
    ASSERT_EQ(open.size(), 4u);
    const FitResult result = fit(dry.forecaster, logs, values, open, options);
    const Friction found =
        friction_of(dry.vehicle.car(), dry.spec.car.car, result.params, result.bootstrap_draws, result.posterior_draws);
    EXPECT_NEAR(found.total, mu, 0.03) << k;
    EXPECT_LT(found.total_high - found.total_low, 0.15) << k;
    covered += found.total_low <= mu && mu <= found.total_high;
  }
  EXPECT_GE(covered, sessions - 1);
}

TEST(Fit, AdviceNamesTheEffectThatIsMissing) {
  Bench bench;
  const CalibrateRig dragging(small_car_world(R"({"plant": {"effects": [{"plugin": "steer_offset"},
      {"plugin": "diff_yaw", "params": {"k": 4}}]}})"));
  bench.files.front().session = drive(dragging.vehicle.car(), {.seconds = 120, .noise = 0.2});
  bench.logs = fit_logs(bench.files, nullptr, 0.02, bench.options);
  std::erase_if(bench.open, [](const Unknown& u) { return u.group == "tyres"; });
  const FitResult result = bench.run();
  const auto advice =
      advise(bench.rig.spec, testing_support::plugins(), bench.rig.forecaster.options(), bench.logs, result);
  ASSERT_FALSE(advice.empty());
  std::vector<std::string> first;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, advice.size()); ++i) first.push_back(advice[i].effect);
  EXPECT_THAT(first, testing::Contains("diff_yaw"));
  EXPECT_GT(advice.front().gain, 0.01);
}

/// Stiffness of the front tyres is an unknown that was kept at its prior: an effect that scales it is another name of
/// it.
TEST(Fit, AdviceNamesNoEffectThatOnlyDoesWhatAnUnknownDoes) {
  Bench bench;
  const CalibrateRig stiff(small_car_world(R"({"plant": {"params": {"Bf": 9}}})"));
  bench.files.front().session = drive(stiff.vehicle.car(), {.seconds = 40, .noise = 0.2});
  bench.logs = fit_logs(bench.files, nullptr, 0.02, bench.options);
  FitResult result = bench.run();
  for (FittedParameter& p : result.parameters)
    if (p.unknown.pointer == "/plant/params/Bf") {
      p.status = FittedParameter::Status::undetermined;
      assign(result.params, p.unknown, p.unknown.prior);
    }
  const auto find_front = [&] {
    for (const Advice& a :
         advise(bench.rig.spec, testing_support::plugins(), bench.rig.forecaster.options(), bench.logs, result))
      if (a.effect == "front_stiff") return a.values;
    return std::vector<Advice::Value>{};
  };
  EXPECT_TRUE(find_front().empty());
  std::erase_if(result.parameters, [](const FittedParameter& p) { return p.unknown.pointer == "/plant/params/Bf"; });
  const auto values = find_front();  // no unknown any more: told by name
  ASSERT_FALSE(values.empty());
  EXPECT_FALSE(values.front().name.empty());
  EXPECT_GT(values.front().value, 0.1);
}

TEST(Fit, TellsItsProgressFromTheBeginningToTheEnd) {
  Bench bench("/plant/params/Cm1", 0.5, 20);
  std::vector<double> shares;
  bench.options.progress = [&](double share, const std::string&) { shares.push_back(share); };
  bench.run();
  ASSERT_GT(shares.size(), 5u);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_EQ(shares.front(), 0.0);
  EXPECT_GT(shares.back(), 0.6);
  EXPECT_LE(shares.back(), 1.0);
}

TEST(Fit, ALogInWhichNobodyDrivesIsRefused) {
  Bench bench;
  bench.options.slowest = bench.options.crawling = 100.0;
  EXPECT_THROW(fit_logs(bench.files, nullptr, 0.02, bench.options), InputError);
}

TEST(Fit, ASlowLogCountsWhereItMovesUnlessOthersAreFasterAndOneThatNeverDoesIsLeftOut) {
  Bench bench;
  bench.files.emplace_back(bench.files.front()).session.name = "slow.csv";
  bench.files.emplace_back(bench.files.front()).session.name = "parked.csv";
  for (std::size_t i = 0; i < bench.files.front().session.rows(); ++i) {
    std::next(bench.files.begin())->session.reading[i * channels + 3] = 0.4;
    bench.files.back().session.reading[i * channels + 3] = 0.1;
  }
  bench.options.crawling = 0.3;
  std::string said;
  bench.options.print = [&](const std::string& line) { said += line; };
  auto logs = fit_logs(bench.files, nullptr, 0.02, bench.options);
  ASSERT_EQ(logs.size(), 1u);
  EXPECT_EQ(logs[0].session->name, "weave");
  EXPECT_THAT(said, testing::AllOf(testing::HasSubstr("parked.csv: hardly anywhere"),
                                   testing::HasSubstr("slow.csv: slower than 0.5 m/s throughout")));
  bench.files.pop_front();
  logs = fit_logs(bench.files, nullptr, 0.02, bench.options);
  ASSERT_EQ(logs.size(), 1u);
  EXPECT_EQ(logs[0].session->name, "slow.csv");
  EXPECT_GT(logs[0].starts.time.size(), 10u);
}

TEST(FittedWorld, IsAWorldThatPredictsAsTheFitDid) {
  Bench bench;
  const FitResult result = bench.run();
  const Node written = parse_text(to_json_text(
      fitted_world(bench.rig.tree, bench.rig.spec, bench.rig.forecaster, result, {{"a.csv"}, "map.json"}, ".")));
  const CalibrateRig again(written);
  Errors errors;
  const auto params = parameters_of(written, again.forecaster, errors);
  EXPECT_TRUE(errors.empty());
  for (std::size_t i = 0; i < params.size(); ++i)
    EXPECT_NEAR(params[i], result.params[i], 1e-8 * (1 + std::abs(result.params[i]))) << i;
  EXPECT_EQ(written.find("calibration")->find("logs")->array().front().text(), "a.csv");
  EXPECT_NE(find_pointer(written, "/calibration/parameters/0/low"), nullptr);
}

}  // namespace test_fit
}  // namespace gripline::calibrate
