// The expected values follow framework/doc/diagnose-cases.md ("case.json" and "Scores"), not the code.
#include "diagnose/scoring/answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"
#include "support/scratch.hpp"

namespace gripline::diagnose {
namespace test_diagnose_answer {

using testing::HasSubstr;
using namespace testing_support;
using Set = std::vector<std::string>;
using Sets = std::vector<Set>;

/// An answer as its file says it; "kind" is added.
Answer answer(const std::string& members) {
  write_text(scratch("answer.json"), R"({"kind": "any", )" + members + "}");
  return read_answer(scratch("answer.json"));
}

Diagnosis diagnosis(Verdict verdict, const Set& named = {}, const Sets& equivalent = {}, const Set& delays = {}) {
  Diagnosis d;
  d.verdict = verdict;
  for (const std::string& id : named) d.named.emplace_back().effect = id;
  for (const std::string& id : delays) d.delays.emplace_back().effect = id;
  d.equivalent = equivalent;
  return d;
}

struct Judged {
  const char* what;
  Diagnosis diagnosis;
  double right;
};

void expect_judged(const std::string& members, const std::vector<Judged>& rows) {
  const Answer truth = answer(members);
  for (const Judged& row : rows) EXPECT_EQ(judge(truth, row.diagnosis), row.right) << members << ": " << row.what;
}

TEST(Judge, OneEffectIsNamedOrNot) {
  expect_judged(
      R"("effects": [{"effect": "aero_drag", "params": {"a": 0.4}}])",
      {{"named", diagnosis(Verdict::named, {"aero_drag"}), 1},
       {"another one", diagnosis(Verdict::named, {"rolling_res"}), 0},
       {"with another one", diagnosis(Verdict::named, {"aero_drag", "rolling_res"}), 0},
       {"nothing", diagnosis(Verdict::nothing_missing), 0},
       {"beside unknown", diagnosis(Verdict::unknown, {"aero_drag"}), 0},
       {"named, its synonyms listed", diagnosis(Verdict::named, {"aero_drag"}, {{"aero_drag"}, {"wind"}}), 1},
       {"one of two equals", diagnosis(Verdict::indistinguishable, {"aero_drag"}, {{"aero_drag"}, {"rolling_res"}}),
        0.5},
       {"the last of three equals",
        diagnosis(Verdict::indistinguishable, {"wind"}, {{"wind"}, {"rolling_res"}, {"aero_drag"}}), 0.5},
       {"not among the equals",
        diagnosis(Verdict::indistinguishable, {"rolling_res"}, {{"rolling_res"}, {"drive_gain"}}), 0},
       {"only within a larger set",
        diagnosis(Verdict::indistinguishable, {"rolling_res"}, {{"aero_drag", "mass"}, {"rolling_res"}}), 0}});
}

/// Equals count in full where the case has as many right sets as the verdict lists.
TEST(Judge, EquivalentSetsAreRightToo) {
  expect_judged(
      R"("effects": [{"effect": "input_delay", "params": {"T": 0.03}}], "equivalent": [["sensor_latency"]])",
      {{"hidden", diagnosis(Verdict::named, {"input_delay"}), 1},
       {"equivalent", diagnosis(Verdict::named, {"sensor_latency"}), 1},
       {"both at once", diagnosis(Verdict::named, {"input_delay", "sensor_latency"}), 0},
       {"another one", diagnosis(Verdict::named, {"steer_lag"}), 0},
       {"both as equals",
        diagnosis(Verdict::indistinguishable, {"sensor_latency"}, {{"sensor_latency"}, {"input_delay"}}), 1},
       {"two equals, one of them right",
        diagnosis(Verdict::indistinguishable, {"steer_lag"}, {{"steer_lag"}, {"sensor_latency"}}), 1},
       {"three equals",
        diagnosis(Verdict::indistinguishable, {"steer_lag"}, {{"steer_lag"}, {"sensor_latency"}, {"input_delay"}}),
        0.5},
       {"equals that are all wrong",
        diagnosis(Verdict::indistinguishable, {"steer_lag"}, {{"steer_lag"}, {"motor_lag"}}), 0}});
}

TEST(Judge, SetsAreComparedWholeInAnyOrder) {
  expect_judged(
      R"("effects": [{"effect": "friction_scale", "params": {"k": 0.9}}],
                   "equivalent": [["front_grip", "rear_grip"]])",
      {{"in order", diagnosis(Verdict::named, {"front_grip", "rear_grip"}), 1},
       {"the other way round", diagnosis(Verdict::named, {"rear_grip", "front_grip"}), 1},
       {"a half of it", diagnosis(Verdict::named, {"front_grip"}), 0},
       {"as equals, the other way round",
        diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"rear_grip", "front_grip"}, {"bank"}}), 0.5}});
  expect_judged(
      R"("effects": [{"effect": "mass", "params": {"k": 1.1}}, {"effect": "steer_lag", "params": {}}])",
      {{"both", diagnosis(Verdict::named, {"steer_lag", "mass"}), 1},
       {"one of them", diagnosis(Verdict::named, {"mass"}), 0},
       {"equals that hold one each", diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"steer_lag"}}), 0}});
}

TEST(Judge, NothingMissingIsToBeSaidSo) {
  expect_judged(R"("effects": [])",
                {{"said", diagnosis(Verdict::nothing_missing), 1},
                 {"a name", diagnosis(Verdict::named, {"aero_drag"}), 0},
                 {"a delay", diagnosis(Verdict::named, {}, {}, {"yaw_rate_delay"}), 0},
                 {"equals", diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"aero_drag"}}), 0},
                 {"unknown", diagnosis(Verdict::unknown), 0}});
}

TEST(Judge, WhatIsInNoCatalogueIsUnknown) {
  expect_judged(R"("effects": [{"effect": "steer_backlash", "params": {}}], "unknown": {"where": ["input"]})",
                {{"said", diagnosis(Verdict::unknown), 1},
                 {"beside a name", diagnosis(Verdict::unknown, {"steer_lag"}), 1},
                 {"a name", diagnosis(Verdict::named, {"steer_lag"}), 0},
                 {"nothing", diagnosis(Verdict::nothing_missing), 0},
                 {"equals", diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"aero_drag"}}), 0}});
}

/// The case forbids its name, so that no allowed set is right.
TEST(Judge, AnExcludedEffectIsUnknown) {
  expect_judged(R"("effects": [{"effect": "aero_drag", "params": {"a": 0.4}}], "excluded": ["aero_drag"],
                   "unknown": {"where": ["state"], "interval": null})",
                {{"said", diagnosis(Verdict::unknown), 1},
                 {"named all the same", diagnosis(Verdict::named, {"aero_drag"}), 0},
                 {"another one", diagnosis(Verdict::named, {"rolling_res"}), 0},
                 {"nothing", diagnosis(Verdict::nothing_missing), 0}});
}

/// A delay between channels is named in front of everything else, and is a name like the others.
TEST(Judge, DelaysOfChannelsAreNames) {
  expect_judged(R"("effects": [{"effect": "yaw_rate_delay", "params": {"T": 0.06}}])",
                {{"named", diagnosis(Verdict::named, {}, {}, {"yaw_rate_delay"}), 1},
                 {"the other channel's", diagnosis(Verdict::named, {}, {}, {"velocity_delay"}), 0},
                 {"with an effect", diagnosis(Verdict::named, {"mass"}, {}, {"yaw_rate_delay"}), 0}});
  expect_judged(R"("effects": [{"effect": "yaw_rate_delay", "params": {}}, {"effect": "aero_drag", "params": {}}])",
                {{"both", diagnosis(Verdict::named, {"aero_drag"}, {}, {"yaw_rate_delay"}), 1},
                 {"the delay only", diagnosis(Verdict::named, {}, {}, {"yaw_rate_delay"}), 0},
                 {"the effect only", diagnosis(Verdict::named, {"aero_drag"}), 0}});
  expect_judged(
      R"("effects": [{"effect": "mass", "params": {}}, {"effect": "yaw_delay", "params": {}}])",
      {{"equals beside it", diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"drive_gain"}}, {"yaw_delay"}),
        0.5},
       {"equals without it", diagnosis(Verdict::indistinguishable, {"mass"}, {{"mass"}, {"drive_gain"}}), 0}});
  expect_judged(
      R"("effects": [{"effect": "aero_drag", "params": {}}])",
      {{"with a delay that is not there", diagnosis(Verdict::named, {"aero_drag"}, {}, {"yaw_rate_delay"}), 0}});
}

Diagnosis unknown_at(Where where, double from, double to) {
  Diagnosis d = diagnosis(Verdict::unknown);
  d.unknown.emplace();
  d.unknown->where = where;
  d.unknown->from = from;
  d.unknown->to = to;
  return d;
}

Answer at(const std::string& unknown) { return answer(R"("effects": [], "unknown": )" + unknown); }

/// 5 % of a lap between the centres; lap fractions a whole number apart are one place.
TEST(JudgePlace, PlacesAreNearAcrossTheStartOfTheLap) {
  const Answer before_the_line = at(R"({"where": ["position"], "interval": [0.95, 1.01]})");  // centre 0.98
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.95, 1.01)), 1);
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.0, 0.04)), 1);          // 0.04 behind
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.02, 0.06)), 0);         // 0.06 behind
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, -0.05, 0.03)), 1);        // 0.01 before
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.98, 1.06)), 1);         // 0.04 behind
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 1.02, 1.06)), 0);         // 0.06 behind
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.90, 0.98)), 1);         // 0.04 before
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.88, 0.96)), 0);         // 0.06 before
  EXPECT_EQ(judge_place(before_the_line, unknown_at(Where::position, 0.43, 0.53)), 0);         // half a lap away
  const Answer behind_the_line = at(R"({"where": ["position"], "interval": [-0.01, 0.03]})");  // centre 0.01
  EXPECT_EQ(judge_place(behind_the_line, unknown_at(Where::position, 0.95, 0.99)), 1);         // 0.04 before
  EXPECT_EQ(judge_place(behind_the_line, unknown_at(Where::position, 0.93, 0.97)), 0);         // 0.06 before
}

TEST(JudgePlace, TimesAreNearWithinASecond) {
  const Answer gust = at(R"({"where": ["time"], "interval": [10, 14]})");  // centre 12
  EXPECT_EQ(judge_place(gust, unknown_at(Where::time, 12.5, 13.3)), 1);    // 0.9 late
  EXPECT_EQ(judge_place(gust, unknown_at(Where::time, 12.5, 13.7)), 0);    // 1.1 late
  EXPECT_EQ(judge_place(gust, unknown_at(Where::time, 10.1, 12.1)), 1);    // 0.9 early
  EXPECT_EQ(judge_place(gust, unknown_at(Where::time, 9.8, 12.0)), 0);     // 1.1 early
  EXPECT_EQ(judge_place(gust, unknown_at(Where::time, 14.9, 15.1)), 0);    // 3 late: time does not repeat
}

TEST(JudgePlace, TheKindOfFunctionMustBeAccepted) {
  const Answer either = at(R"({"where": ["input", "state"], "interval": null})");
  EXPECT_EQ(judge_place(either, unknown_at(Where::input, 0, 0)), 1);
  EXPECT_EQ(judge_place(either, unknown_at(Where::state, 3, 4)), 1);
  EXPECT_EQ(judge_place(either, unknown_at(Where::position, 0.1, 0.2)), 0);
  EXPECT_EQ(judge_place(either, unknown_at(Where::time, 1, 2)), 0);
  // Its numbers are of the input, those of the answer of time.
  EXPECT_EQ(judge_place(at(R"({"where": ["input", "time"], "interval": [30, 40]})"), unknown_at(Where::input, 1, 2)),
            1);
  // Right by its numbers, wrong by what they are of.
  EXPECT_EQ(judge_place(at(R"({"where": ["position"], "interval": [0.1, 0.2]})"), unknown_at(Where::time, 0.1, 0.2)),
            0);
}

TEST(JudgePlace, WhatIsNotCalledUnknownIsNotLocated) {
  EXPECT_EQ(judge_place(at(R"({"where": ["state"]})"), diagnosis(Verdict::named, {"mass"})), 0);
}

TEST(ReadAnswer, TellsTheConditionOfACase) {
  const auto condition = [](const std::string& more) { return answer(R"("effects": [])" + more).condition; };
  EXPECT_EQ(condition(""), "white");
  EXPECT_EQ(condition(R"(, "process_noise": null, "nuisance": null, "unknown": null)"), "white");
  EXPECT_EQ(condition(R"(, "process_noise": {"ax_mps2": 0.1, "tau_s": 0.25})"), "process_noise");
  EXPECT_EQ(condition(R"(, "process_noise": {"ax_mps2": 0.1, "tau_s": 1})"), "process_time");
  EXPECT_EQ(condition(R"(, "noise_correlation": 0.8)"), "coloured_noise");
  EXPECT_EQ(condition(R"(, "thinned": 2)"), "thinned");
  EXPECT_EQ(condition(R"(, "late": true)"), "late");
  EXPECT_EQ(condition(R"(, "nuisance": {"Df": 0.03})"), "wrong_nominal");
}

TEST(ReadAnswer, ReadsWhatIsHidden) {
  const Answer a = answer(R"("effects": [{"effect": "friction_scale", "params": {"k": 0.9}}],
    "equivalent": [["front_grip", "rear_grip"]], "nuisance": {"Df": -0.02}, "seed": 4, "laps": [3, 2])");
  EXPECT_EQ(a.kind, "any");
  EXPECT_EQ(a.names, Names{"friction_scale"});
  EXPECT_EQ(a.right, (std::vector<Names>{{"friction_scale"}, {"front_grip", "rear_grip"}}));
  ASSERT_EQ(a.effects.size(), 1u);
  EXPECT_EQ(a.effects[0].second.at("k"), 0.9);
  EXPECT_EQ(a.nuisance.at("Df"), -0.02);
  EXPECT_FALSE(a.unknown);
  EXPECT_FALSE(a.interval.has_value());
}

/// The car is as it is: only what its sensors show is late.
TEST(TrueModel, HasNoDelaysOfChannels) {
  const test::DiagnoseRig rig;
  const Answer a = answer(R"("effects": [{"effect": "aero_drag", "params": {"a": 0.4}},
    {"effect": "position_delay", "params": {"T": 0.06}}])");
  const auto model = true_model(rig.catalogue(), a);
  ASSERT_TRUE(model.has_value());
  EXPECT_EQ(model->members, std::vector{rig.catalogue().find("aero_drag")});
  EXPECT_FALSE(true_model(rig.catalogue(), answer(R"("effects": [{"effect": "no_such", "params": {}}])")));
}

TEST(ReadAnswer, RefusesWhatIsNone) {
  const Folder folder;
  EXPECT_THAT(refusal([&] { (void)read_answer(folder / "answer.json"); }), HasSubstr("no such file"));
  write_text(folder / "list.json", "[]");
  EXPECT_THAT(refusal([&] { (void)read_answer(folder / "list.json"); }), HasSubstr("expected an object"));
  write_text(folder / "empty.json", "{}");
  EXPECT_THAT(refusal([&] { (void)read_answer(folder / "empty.json"); }), HasSubstr("kind"));
  EXPECT_THAT(refusal([] { (void)answer(R"("effects": [{"params": {}}])"); }), HasSubstr("effect"));
}

/// Of experiments: a case without sets that are right holds nothing, or something that no catalogue has.
TEST(AnswerOf, CasesWithoutRightSetsAreUnknownOrNothing) {
  const Answer nothing = answer_of({}, false), outside = answer_of({}, true), said = answer_of({Names{}}, true);
  for (const Answer* one : {&nothing, &said}) {
    EXPECT_EQ(judge(*one, diagnosis(Verdict::nothing_missing)), 1);
    EXPECT_EQ(judge(*one, diagnosis(Verdict::unknown)), 0);
    EXPECT_EQ(judge(*one, diagnosis(Verdict::named, {}, {}, {"yaw_rate_delay"})), 0);
  }
  EXPECT_EQ(judge(outside, diagnosis(Verdict::unknown)), 1);
  EXPECT_EQ(judge(outside, diagnosis(Verdict::nothing_missing)), 0);
  const Answer either = answer_of({{"mass"}, {"wind", "bank"}}, true);
  EXPECT_EQ(judge(either, diagnosis(Verdict::named, {"bank", "wind"})), 1);
  EXPECT_EQ(judge(either, diagnosis(Verdict::named, {"bank"})), 0);
}

TEST(TrueModel, HasTheHiddenEffectsAndParameters) {
  test::DiagnoseRig rig;
  rig.trust({"Df", "Cr0"}, 0.03);
  const double nominal = rig.catalogue().nominal("Df"), resistance = rig.catalogue().nominal("Cr0");
  const Answer a = answer(R"("effects": [{"effect": "aero_drag", "params": {"a": 0.4}}],
    "nuisance": {"Df": 0.02, "Cr0_over_m": 0.06})");
  const std::optional<ModelSpec> model = true_model(rig.catalogue(), a);
  ASSERT_TRUE(model.has_value());
  ASSERT_EQ(model->members.size(), 1u);
  EXPECT_EQ(rig.catalogue().candidates()[model->members[0]].id, "aero_drag");
  EXPECT_EQ(model->values[0][0], 0.4);
  ASSERT_EQ(model->nuisance.size(), 2u);
  EXPECT_DOUBLE_EQ(model->nuisance[0], 1.02 * nominal);
  EXPECT_DOUBLE_EQ(model->nuisance[1], resistance + 0.06 * rig.world().car.car.m);  // m/s2 of the car's mass
  EXPECT_FALSE(true_model(rig.catalogue(), answer(R"("effects": [{"effect": "steer_backlash", "params": {}}])")));
}

}  // namespace test_diagnose_answer
}  // namespace gripline::diagnose
