#include "diagnose/real_logs/missing_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/effects/start_of_fit.hpp"
#include "calibrate/fit/session_adaptation.hpp"
#include "config/json_file.hpp"
#include "support/calibrate_rig.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace test_diagnose_missing_effects {

using test::CalibrateRig;
using test::small_car_world;

/// A world that knows nothing of pedals and steering, and a log of a car with these effects.
MissingEffects found_in_log_of(const char* effects, const char* nominal_patch = "{}",
                               const test::WeavingLog& log = {.seconds = 60, .noise = 1},
                               const std::vector<test::WeavingLog>& held_out = {},
                               const std::function<void(measured::Session&)>& change = {},
                               const measured::LogMap& map = measured::gripline_map()) {
  const CalibrateRig truth(small_car_world(effects));
  const CalibrateRig nominal(merge(small_car_world(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Bf": {"group": "tyres", "sigma": 0.3, "scale": "log"},
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})"),
                                   testing_support::json(nominal_patch)));
  const auto driven = [&](const test::WeavingLog& one, const std::string& name) {
    measured::SessionFile file;
    file.session = test::drive(truth.vehicle.car(), one);
    file.session.name = name;
    if (change) change(file.session);
    file.row_step = 0.02;
    return file;
  };
  std::list<measured::SessionFile> others;
  for (const test::WeavingLog& one : held_out) others.push_back(driven(one, "held out"));
  MissingOptions options;
  options.fit.slowest = 0.5;
  options.fit.starts = 60;
  return find_missing(nominal.tree, nominal.spec, testing_support::plugins(), map, {driven(log, "fitted")}, others,
                      options, ".");
}

const MissingEffect* find(const MissingEffects& found, const std::string& effect) {
  const auto at = std::ranges::find_if(found.named, [&](const auto& one) { return one.addition.name == effect; });
  return at == found.named.end() ? nullptr : &*at;
}

TEST(MissingEffects, ErrorsAsLargeAsTheSensorsNoiseTellNothingMore) {
  MissingEffects found;
  found.found = 0.393;
  EXPECT_FALSE(found.at_noise());  // noise was not measured
  found.noise = 0.39;
  EXPECT_TRUE(found.at_noise());
  found.found = 0.45;
  EXPECT_FALSE(found.at_noise());
  EXPECT_FALSE(found.noise_too_large());
  found.found = 0.3;  // below what sensors alone would leave: that figure is wrong
  EXPECT_FALSE(found.at_noise());
  EXPECT_TRUE(found.noise_too_large());
}

TEST(MissingEffects, AValueAtAnEndOfItsRangeIsNoEstimate) {
  MissingEffect::Value v{"T", "s", 0.0412, 0.0398, 0.0431, 0.0, 0.1};
  EXPECT_EQ(v.text(4, true), "T = 0.0412 (0.0398 to 0.0431) s");
  EXPECT_EQ(v.text(2, false), "T = 0.041 s");
  for (const double end : {0.0, 0.1}) {
    v.value = end;
    EXPECT_EQ(v.text(4, true), "T is kept within its range [0, 0.1] s");
  }
  v.value = 0.0999;
  EXPECT_FALSE(v.at_edge());
  const MissingEffect::Value open{"k", "1", 0.3, 0.2, 0.4};
  EXPECT_EQ(open.text(3, true), "k = 0.3 (0.2 to 0.4)");
}

TEST(MissingEffects, EachEndOfARangeCountsByItself) {
  constexpr double open = std::numeric_limits<double>::infinity();
  const auto at_end = [](double value, double least, double most) {
    return MissingEffect::Value{"k", "1", value, 0, 0, least, most}.at_end();
  };
  EXPECT_EQ(at_end(0.0, 0.0, 0.1), "low");
  EXPECT_EQ(at_end(0.1, 0.0, 0.1), "high");
  EXPECT_EQ(at_end(0.05, 0.0, 0.1), "");
  EXPECT_EQ(at_end(0.0, 0.0, open), "low");
  EXPECT_EQ(at_end(1e-3, 0.0, open), "");
  EXPECT_EQ(at_end(1e6, 0.0, open), "");
  EXPECT_EQ(at_end(-2.0 * (1.0 - 1e-12), -2.0, open), "low");
  EXPECT_EQ(at_end(3e5, -open, 3e5), "high");
  EXPECT_EQ(at_end(-3e5, -open, 3e5), "");
  EXPECT_EQ(at_end(7.0, -open, open), "");
}

TEST(MissingEffects, DeadZoneAndSteeringOffsetAreNamedWithTheirSizesAndStandInTheWorld) {
  const MissingEffects found = found_in_log_of(R"({"plant": {"effects": [
      {"plugin": "throttle_dead_zone", "params": {"z": 0.12}}, {"plugin": "steer_offset", "params": {"d0": 0.03}}]}})");
  for (const auto& [effect, value, close] :
       {std::tuple("throttle_dead_zone", 0.12, 0.02), {"steer_offset", 0.03, 0.003}}) {
    const MissingEffect* const named = find(found, effect);
    ASSERT_NE(named, nullptr) << effect;
    EXPECT_TRUE(named->change.helps()) << effect;
    EXPECT_FALSE(named->measurement);
    ASSERT_EQ(named->params.size(), 1u);
    EXPECT_NEAR(named->params.front().value, value, close) << effect;
    EXPECT_TRUE(std::isfinite(named->params.front().least) && std::isfinite(named->params.front().most)) << effect;
    EXPECT_FALSE(named->params.front().at_edge()) << effect;
  }
  EXPECT_LT(found.found, 0.5 * found.calibrated);
  EXPECT_LT(found.calibrated, found.given);
  const CalibrateRig again(found.world);
  EXPECT_EQ(again.spec.vehicle.effects.size(), found.named.size());
}

/// What is returned is fitted as `fit` does, to all of the time, and says how large its errors are: by that `predict`
/// weighs how far a parameter moves with the session.
TEST(MissingEffects, TheWorldReturnedIsAFittedOne) {
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})");
  EXPECT_TRUE(calibrate::session_weighing(found.world));
  const auto at = [&](const char* pointer) { return find_pointer(found.world, pointer)->number(); };
  EXPECT_GE(at("/calibration/starts"), 55);  // 60 are wanted; a half of the time would have 30
  EXPECT_NEAR(at("/plant/effects/0/params/d0"), 0.03, 0.003);
  const double width =
      find_pointer(found.world, "/unknowns/~1plant~1effects~1steer_offset~1params~1d0/session")->number();
  EXPECT_GT(width, 1e-5);
  EXPECT_LT(width, 0.003) << "one session: as well as it is known";
}

/// What was known before the logs counts once, and so do the logs: as in `gripline fit` of the same world. Counted
/// twice they move Bf by 0.007 more.
TEST(MissingEffects, TheLastFitIsByThePriorsOfTheWorld) {
  const char* const bare = R"({"plant": {"effects": []}})";
  const char* const prior = R"({"plant": {"params": {"Bf": 5.15}}, "unknowns": {
      "/plant/params/Bf": {"group": "tyres", "sigma": 0.005, "scale": "log"}}})";
  const test::WeavingLog log{.seconds = 60, .noise = 10};
  const MissingEffects found = found_in_log_of(bare, prior, log);
  ASSERT_TRUE(found.named.empty());
  std::list<measured::SessionFile> files(1);
  files.front().session = test::drive(CalibrateRig(small_car_world(bare)).vehicle.car(), log);
  const CalibrateRig world(merge(merge(small_car_world(bare), testing_support::json(R"({"unknowns": {
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})")),
                                 testing_support::json(prior)));
  calibrate::FitOptions options;
  options.slowest = 0.5;
  options.starts = 60;
  auto logs = fit_logs(files, nullptr, 0.02, options);
  const calibrate::Trial trial(world.spec, world.forecaster.options());
  const auto start = calibrate::start_of_fit(world.tree, trial, measured::gripline_map(), files, std::nullopt);
  const calibrate::FitResult fitted = fit(trial.forecaster, logs, start.values, start.unknowns, options);
  const auto value_of = [](const auto& parameters) {
    return std::ranges::find(parameters, "/plant/params/Bf", [](const auto& p) { return p.unknown.pointer; })->value;
  };
  EXPECT_NEAR(value_of(found.parameters), value_of(fitted.parameters), 0.001);
}

/// A straight servo map in the world, a bent one in the car. What was not to be fitted of the map is named by itself,
/// and stands in the world found, open.
TEST(MissingEffects, AnIdleParameterOfAnEffectThatTheWorldListsIsNamed) {
  const std::string pointer = "/plant/effects/steer_map/params/c";
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9, "c": -2}}]}})",
                      R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 1}}]},
          "unknowns": {"/plant/effects/steer_map/params/g": {"group": "steer", "sigma": 0.2}}})");
  const MissingEffect* const named = find(found, "steer_map.c");
  ASSERT_NE(named, nullptr);
  ASSERT_EQ(named->params.size(), 1u);
  EXPECT_EQ(named->params.front().name, "c");
  EXPECT_NEAR(named->params.front().value, -2.0, 0.3);
  EXPECT_TRUE(named->change.helps());
  const CalibrateRig again(found.world);
  ASSERT_EQ(again.spec.vehicle.effects.size(), 1u);
  EXPECT_NE(found.world.find("unknowns")->find(pointer), nullptr);
  const auto places = parameter_places(again.spec, again.forecaster);
  const auto place = std::ranges::find(places, pointer, &calibrate::ParameterPlace::pointer);
  ASSERT_NE(place, places.end());
  EXPECT_NEAR(again.forecaster.defaults()[place->index], named->params.front().value, 0.3);
}

/// A servo that is off by 0.4 milliradian and turns further to one side. Predictions are better with the offset, but
/// not surely, which is enough beside the curve.
TEST(MissingEffects, ASmallOffsetIsNamedBesideTheCurveOfASteering) {
  const MissingEffects found = found_in_log_of(
      R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 1, "a": -0.3}},
                                {"plugin": "steer_offset", "params": {"d0": -0.0004}}]}})",
      R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 1}}]},
          "unknowns": {"/plant/effects/steer_map/params/g": {"group": "steer", "sigma": 0.2}}})");
  ASSERT_NE(find(found, "steer_map.a"), nullptr);
  EXPECT_NEAR(find(found, "steer_map.a")->params.front().value, -0.3, 0.05);
  const MissingEffect* const offset = find(found, "steer_offset");
  ASSERT_NE(offset, nullptr);
  EXPECT_NEAR(offset->params.front().value, -0.0004, 0.0002);
  EXPECT_LT(offset->change.change, 0.0);
  EXPECT_FALSE(offset->change.helps()) << "it would be named for itself";
}

/// Nor is an offset named where the curve alone is missing.
TEST(MissingEffects, ACurveOfASteeringThatIsStraightAheadIsNamedAlone) {
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 1, "a": -0.8}}]}})",
                      R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 1}}]},
          "unknowns": {"/plant/effects/steer_map/params/g": {"group": "steer", "sigma": 0.2}}})");
  EXPECT_NE(find(found, "steer_map.a"), nullptr);
  EXPECT_EQ(find(found, "steer_offset"), nullptr);
}

/// What the logs do not tell is returned with what was known of it, by its place in the world found.
TEST(MissingEffects, ParametersThatLogsDoNotTellKeepTheirPrior) {
  measured::LogMap map = measured::gripline_map();
  for (auto& channel : map.channel)
    if (channel) channel->delay.reset();
  const std::string pointer = "/calibration/delays/yaw_rate";
  constexpr double sigma = 1e-5;
  const MissingEffects found = found_in_log_of(
      R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})",
      format(R"({"unknowns": {"%s": {"group": "delays", "sigma": %g}}})", pointer.c_str(), sigma).c_str(),
      {.seconds = 60, .noise = 1}, {}, {}, map);
  ASSERT_NE(find(found, "steer_offset"), nullptr);
  ASSERT_EQ(found.undetermined.size(), 1u);
  const calibrate::FittedParameter& one = found.undetermined.front();
  EXPECT_EQ(one.unknown.pointer, pointer);
  EXPECT_NEAR(one.interval.high - one.interval.low, 2 * 1.96 * sigma, 0.1 * sigma);
  const Vehicle car(found.spec.vehicle, CalibrateRig::context(found.spec));
  const calibrate::Forecaster forecaster(car.car(), CalibrateRig::options(found.spec));
  EXPECT_EQ(one.unknown.index, forecaster.index(calibrate::ForecastParameter::delay_yaw_rate));
}

/// Tyres that know no end of grip, of the same stiffness: to first order less grip does next to nothing there that
/// stiffness does not do. And back-EMF, which trades with drive: both are found by fits that go on until little
/// changes.
TEST(MissingEffects, AnEndOfGripAndBackEmfAreNamedThoughStiffnessAndDriveHideThem) {
  const auto sliding = [](double t) {
    return CommandSample<double>{0.45 + 0.25 * std::sin(0.5 * t), 0.3 * std::sin(1.3 * t) + 0.1 * std::sin(3.1 * t)};
  };
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"params": {"Df": 5, "Dr": 5, "Bf": 6, "Br": 7}, "effects": []}})",
                      R"({"plant": {"params": {"Df": 15, "Dr": 15, "Bf": 2, "Br": 2.3333, "Cm2": 0}}, "unknowns": {
          "/plant/params/Br": {"group": "tyres", "sigma": 0.3, "scale": "log"},
          "/plant/params/Cr0": {"group": "drive", "sigma": 0.5, "scale": "log"}}})",
                      {.seconds = 60, .noise = 1, .command = sliding});
  std::string names;
  for (const MissingEffect& one : found.named) names += one.addition.name + ' ';
  EXPECT_NE(find(found, "back_emf"), nullptr) << names;
  // The front axle slides first; where the rear one never does, less grip of both is no better.
  const MissingEffect* const front = find(found, "front_grip");
  const MissingEffect* const grip = front != nullptr ? front : find(found, "friction_scale");
  ASSERT_NE(grip, nullptr) << names;
  EXPECT_NEAR(grip->params.front().value, -2.0 / 3.0, 0.1);
  EXPECT_LT(found.found, 0.5 * found.calibrated);
  EXPECT_TRUE(found.calibration.helps());
  EXPECT_TRUE(found.all.helps());
}

/// A log held out of less than three stretches cannot say that an effect helps; it does not take it away for that.
TEST(MissingEffects, AShortLogHeldOutHasNoSay) {
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})", "{}",
                      {.seconds = 60, .noise = 1}, {{.seconds = 15, .noise = 1, .seed = 2}});
  EXPECT_NE(find(found, "steer_offset"), nullptr);
  ASSERT_EQ(found.sessions.size(), 1u);
  EXPECT_EQ(found.sessions.front().log, "held out");
  EXPECT_LT(found.sessions.front().change.change, 0.0);
  EXPECT_EQ(found.sessions.front().change.high, 1.0) << "nothing is told of two stretches";
}

/// An offset of the yaw rate is named. Where yaw turns with it, it is none of a channel.
TEST(MissingEffects, AnOffsetOfTheYawRateIsNamedWhereYawSaysSo) {
  const auto found_with = [](double of_rate, double of_yaw) {
    return found_in_log_of(R"({"plant": {"effects": []}})", "{}", {.seconds = 60, .noise = 1}, {},
                           [&](measured::Session& s) {
                             for (std::size_t row = 0; row < s.rows(); ++row) {
                               s.reading[row * measured::channels + 2] += of_yaw * s.t[row];
                               s.reading[row * measured::channels + 5] += of_rate;
                             }
                           });
  };
  const MissingEffects found = found_with(-0.1, 0.0);
  const MissingEffect* const named = find(found, "yawrate_bias");
  ASSERT_NE(named, nullptr);
  EXPECT_TRUE(named->measurement);
  EXPECT_TRUE(named->change.helps());
  EXPECT_NEAR(named->params.front().value, -0.1, 0.005);
  const MissingEffects contradicted = found_with(-0.1, -0.1);
  EXPECT_EQ(find(contradicted, "yawrate_bias"), nullptr);
  EXPECT_FALSE(contradicted.named.empty()) << "the yaw rate is off, whatever for";
}

/// Until the offset is known the logs seem not to tell of tyres and inertia, and effects would stand in its place.
TEST(MissingEffects, AnOffsetOfTheYawRateHidesNoParameterOfTheWorld) {
  const MissingEffects found = found_in_log_of(
      R"({"plant": {"params": {"Cm1": 8, "Bf": 7.5, "Br": 9, "Df": 5, "Dr": 5}, "effects": []}})", R"({"unknowns": {
          "/plant/params/Dr": {"group": "tyres", "sigma": 0.4, "scale": "log"},
          "/plant/params/Df": {"group": "tyres", "sigma": 0.4, "scale": "log"},
          "/plant/params/Br": {"group": "tyres", "sigma": 0.4, "scale": "log"},
          "/plant/params/Iz": {"group": "car", "sigma": 0.4, "scale": "log"},
          "/plant/params/Cr0": {"group": "drive", "sigma": 0.4, "scale": "log"}}})",
      {.seconds = 60, .noise = 1}, {}, [](measured::Session& s) {
        for (std::size_t row = 0; row < s.rows(); ++row) s.reading[row * measured::channels + 5] += 0.5;
      });
  ASSERT_EQ(found.named.size(), 1u);
  EXPECT_EQ(found.named.front().addition.name, "yawrate_bias");
  EXPECT_NEAR(found.named.front().params.front().value, 0.5, 0.03);
  for (const auto& [pointer, value] : {std::pair("/plant/params/Cm1", 8.0), {"/plant/params/Dr", 5.0}}) {
    const auto at = std::ranges::find(found.parameters, pointer,
                                      [](const calibrate::FittedParameter& p) { return p.unknown.pointer; });
    ASSERT_NE(at, found.parameters.end()) << pointer;
    EXPECT_NEAR(at->value, value, 0.04 * value) << pointer;
  }
}

/// Air drag shows in the one stretch that is fast.
TEST(MissingEffects, AnEffectThatFewStretchesShowIsTried) {
  const auto command = [](double t) {
    const CommandSample<double> slow = test::weave(t);
    return CommandSample<double>{t > 59.0 && t < 71.0 ? 0.9 : 0.5 * slow.d,
                                 t > 58.0 && t < 72.0 ? 0.1 * slow.delta : slow.delta};
  };
  const MissingEffects found =
      found_in_log_of(R"({"plant": {"effects": [{"plugin": "aero_drag", "params": {"a": 0.4}}]}})", "{}",
                      {.seconds = 80, .noise = 1, .command = command});
  const auto drag = std::ranges::find(found.ranking, "aero_drag", &ScoredEffect::effect);
  ASSERT_NE(drag, found.ranking.end());
  EXPECT_TRUE(drag->tried);
}

/// What sensors alone would leave is of all channels that errors are of, also of those that are read in few of the
/// rows; where one of them does not show its noise, it is not known.
TEST(MissingEffects, NoiseOfSensorsIsThatOfEveryChannelOrUnknown) {
  const auto noise_with = [](std::size_t every) {
    return found_in_log_of(R"({"plant": {"effects": []}})", "{}", {.seconds = 60, .noise = 10}, {},
                           [&](measured::Session& s) {
                             for (std::size_t row = 0; row < s.rows(); ++row)
                               if (row % every != 0) s.reading[row * measured::channels + 5] = NAN;
                           })
        .noise;
  };
  const double dense = noise_with(1), sparse = noise_with(3);
  EXPECT_GT(dense, 0.0);
  EXPECT_NEAR(sparse, dense, 0.3 * dense);
  EXPECT_EQ(noise_with(40), 0.0);
}

/// Predictions start where the car moves. While it stands its channels hardly change.
TEST(MissingEffects, NoiseOfSensorsIsThatOfACarThatMoves) {
  const auto noise_with = [](std::size_t standing) {
    return found_in_log_of(R"({"plant": {"effects": []}})", "{}", {.seconds = 60, .noise = 10}, {},
                           [&](measured::Session& s) {
                             for (std::size_t row = 0; row < standing; ++row) {
                               s.t.push_back(s.t.back() + 0.02);
                               for (std::size_t c = 0; c < measured::channels; ++c)
                                 s.reading.push_back(c < measured::Channel::vx ? s.at(s.rows() - 2, c) : 0.0);
                               s.command.push_back({});
                             }
                           })
        .noise;
  };
  const double driving = noise_with(0);
  EXPECT_NEAR(noise_with(4000), driving, 0.3 * driving);
}

TEST(MissingEffects, NothingIsNamedWhereNothingIsMissing) {
  const MissingEffects found = found_in_log_of(R"({"plant": {"params": {"Cm1": 14}, "effects": []}})");
  EXPECT_TRUE(found.named.empty()) << found.named.front().addition.name;
}

}  // namespace test_diagnose_missing_effects
}  // namespace gripline::diagnose
