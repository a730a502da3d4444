#include "calibrate/effects/yaw_limit.hpp"

#include <gtest/gtest.h>

#include "calibrate/fit/fit.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_yaw_limit {

using measured::YawRateOffset;

std::vector<CandidateEffect> all_candidates() {
  const test::CalibrateRig rig;
  return candidate_effects(rig.spec.vehicle, rig.spec.car.car, testing_support::plugins(), true);
}

CandidateEffect& named(std::vector<CandidateEffect>& candidates, const std::string& id) {
  return *std::ranges::find(candidates, id, &CandidateEffect::id);
}

TEST(YawLimit, OnlyTheEffectThatAddsToTheYawRateIsLimited) {
  std::vector<CandidateEffect> candidates = all_candidates();
  std::vector<std::string> found;
  for (const CandidateEffect& c : candidates)
    if (offsets_yaw_rate(*c.entry, *c.effect)) found.push_back(c.id());
  EXPECT_EQ(found, std::vector<std::string>{"yawrate_bias"});

  limit_to_yaw(candidates, YawRateOffset{0.0, 0.001, 400});
  for (const CandidateEffect& c : candidates)
    for (std::size_t i = 0; i < c.numbers.size(); ++i) {
      if (c.id() == "yawrate_bias") continue;
      EXPECT_EQ(c.low[i], c.entry->params()[i].lo) << c.id();
      EXPECT_EQ(c.high[i], c.entry->params()[i].hi) << c.id();
    }
  const CandidateEffect& offset = named(candidates, "yawrate_bias");
  EXPECT_NEAR(offset.low.front(), -0.003, 1e-4);
  EXPECT_NEAR(offset.high.front(), 0.003, 1e-4);
}

TEST(YawLimit, ACandidateMayGoFromNothingToWhatYawSays) {
  std::vector<CandidateEffect> candidates = all_candidates();
  limit_to_yaw(candidates, YawRateOffset{-0.1, 0.01, 400});
  EXPECT_NEAR(named(candidates, "yawrate_bias").low.front(), -0.13, 1e-3);
  EXPECT_EQ(named(candidates, "yawrate_bias").high.front(), 0.0);
  candidates = all_candidates();
  limit_to_yaw(candidates, std::nullopt);
  EXPECT_EQ(named(candidates, "yawrate_bias").low.front(), -5.0);
  limit_to_yaw(candidates, YawRateOffset{20.0, 0.01, 400});  // beyond the effect's own range
  EXPECT_EQ(named(candidates, "yawrate_bias").high.front(), 5.0);
  EXPECT_EQ(named(candidates, "yawrate_bias").low.front(), 0.0);
}

/// The offset of a world that has one and does not know its size, as the logs' yaw leaves it.
struct OpenOffset {
  explicit OpenOffset(const char* patch = R"({"sigma": 0.1})") : rig(world(patch)) {
    places = parameter_places(rig.spec, rig.forecaster);
    Errors errors;
    values = parameters_of(rig.tree, rig.forecaster, errors);
    unknowns = read_unknowns(rig.tree, places, values, {}, errors);
    errors.throw_if_any();
  }
  static Node world(const char* patch) {
    return merge(
        test::small_car_world(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0}},
                     {"plugin": "yawrate_bias", "params": {"b": 0.05}}]}, "unknowns": {
                     "/plant/effects/steer_offset/params/d0": {"sigma": 0.1}}})"),
        testing_support::json(
            (std::string(R"({"unknowns": {"/plant/effects/yawrate_bias/params/b": )") + patch + "}}").c_str()));
  }
  Unknown& unknown(const std::string& pointer) { return *std::ranges::find(unknowns, pointer, &Unknown::pointer); }
  Unknown& offset() { return unknown("/plant/effects/yawrate_bias/params/b"); }
  std::vector<Unknown> limit(const YawRateOffset& by_yaw) {
    return limit_to_yaw(rig.spec, places, by_yaw, values, unknowns);
  }

  test::CalibrateRig rig;
  std::vector<ParameterPlace> places;
  std::vector<double> values;
  std::vector<Unknown> unknowns;
};

TEST(YawLimit, AnUnknownOfTheWorldStaysWhereYawSaysThatItIs) {
  OpenOffset world;
  const std::vector<Unknown> limited = world.limit({0.001, 0.001, 400});
  ASSERT_EQ(limited.size(), 1u);
  const Unknown& u = world.offset();
  EXPECT_EQ(limited.front().pointer, u.pointer);
  EXPECT_EQ(limited.front().low, u.low);
  EXPECT_NEAR(u.low, -0.002, 1e-4);
  EXPECT_NEAR(u.high, 0.004, 1e-4);
  EXPECT_EQ(u.prior, 0.001) << "not an end of the range, where a fit that stops at one would stay";
  EXPECT_EQ(world.values[u.index], 0.001);
  EXPECT_LT(world.unknown("/plant/effects/steer_offset/params/d0").low, -0.1);

  OpenOffset other;
  other.limit({0.06, 0.01, 400});  // which the world's value agrees with
  EXPECT_EQ(other.offset().prior, 0.05);
  EXPECT_EQ(other.values[other.offset().index], 0.05);
}

TEST(YawLimit, ARangeThatLeavesOutWhatYawSaysStays) {
  OpenOffset world(R"({"sigma": 0.1, "low": 0.04, "high": 0.06})");
  EXPECT_TRUE(world.limit({-0.1, 0.001, 400}).empty());
  EXPECT_EQ(world.offset().low, 0.04);
  EXPECT_EQ(world.offset().high, 0.06);
  EXPECT_EQ(world.offset().prior, 0.05);
}

/// Time that judges a fit says nothing of its bounds.
TEST(YawLimit, YawOfTimeHeldOutHasNoSay) {
  const test::CalibrateRig truth;
  std::list<measured::SessionFile> files(1);
  measured::Session& s = files.front().session;
  s = test::drive(truth.vehicle.car(), {.seconds = 120, .noise = 0});
  const HeldOutTimes held_out{30.0, 10.0};
  for (std::size_t row = 0; row < s.rows(); ++row)
    if (held_out.holds(s.t[row] - s.t.front())) s.reading[row * channels + 5] += 0.3;
  EXPECT_NEAR(offset_by_yaw(files)->value, 0.1, 0.01);
  EXPECT_NEAR(offset_by_yaw(files, held_out)->value, 0.0, 1e-3);
}

/// A yaw rate that shows too much; and where yaw turns with it, so that it is the model that is wrong.
TEST(YawLimit, AFitFollowsYawAndNotWhatTheModelMisses) {
  const test::CalibrateRig truth;
  measured::Session session = test::drive(truth.vehicle.car(), {.seconds = 60, .noise = 1});
  const auto fitted = [&](bool limited) {
    OpenOffset one(R"({"sigma": 1})");
    std::vector<FitLog> logs(1, FitLog(session, 0.02, {0.5, 1.0}, 0.5, 0.5));
    const Session* const only = &session;
    if (limited) one.limit(*measured::yaw_rate_offset({&only, 1}));
    std::erase_if(one.unknowns, [&](const Unknown& u) { return u.pointer != one.offset().pointer; });
    FitOptions options;
    options.tries = 1;
    return fit(one.rig.forecaster, logs, one.values, one.unknowns, options).params[one.unknowns.front().index];
  };
  for (std::size_t row = 0; row < session.rows(); ++row) session.reading[row * channels + 5] += 0.2;
  EXPECT_NEAR(fitted(false), 0.2, 0.005);
  EXPECT_NEAR(fitted(true), 0.2, 0.005);
  for (std::size_t row = 0; row < session.rows(); ++row) session.reading[row * channels + 2] += 0.2 * session.t[row];
  EXPECT_GT(fitted(false), 0.1);
  EXPECT_LT(fitted(true), 0.01);
}

}  // namespace test_yaw_limit
}  // namespace gripline::calibrate
