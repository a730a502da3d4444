#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_candidates {

using test::DiagnoseRig;

TEST(Catalogue, HoldsEffectsThatCanBeFitted) {
  const DiagnoseRig rig({"bank"});
  const Catalogue& catalogue = rig.catalogue();
  ASSERT_GT(catalogue.candidates().size(), 30U);
  for (const Candidate& c : catalogue.candidates()) {
    EXPECT_FALSE(c.fitted.empty()) << c.id;
    EXPECT_FALSE(c.entry->needs_truth()) << c.id;
    EXPECT_EQ(c.excluded, c.id == "bank");
    EXPECT_EQ(&catalogue.candidates()[catalogue.find(c.id)], &c);
  }
  EXPECT_EQ(catalogue.find("no_such_effect"), catalogue.candidates().size());
  for (const char* id : {"steer_lag", "input_delay", "relaxation", "brake_fade"})
    EXPECT_TRUE(catalogue.candidates()[catalogue.find(id)].dynamic) << id;
  EXPECT_FALSE(catalogue.candidates()[catalogue.find("aero_drag")].dynamic);
}

/// A delay puts the command of some time ago in place of what acts: it stands before the offset that the world has, or
/// it would undo it.
TEST(Catalogue, MembersStandAmongTheWorldsOwnEffects) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [
    {"plugin": "motor_lag", "params": {"tau": 0.1}}, {"plugin": "steer_offset", "params": {"d0": 0.05}}]}})");
  const Catalogue& catalogue = rig.catalogue();
  const ModelSpec late = rig.with("input_delay", {0.0});
  std::string order;
  for (const Catalogue::Link& link : catalogue.chain(rig.with(late, "steer_gain", {0.1})))
    order += link.own ? (link.index == 0 ? "lag " : "offset ") : (link.index == 0 ? "delay " : "gain ");
  EXPECT_EQ(order, "delay lag gain offset ");
  EXPECT_EQ(catalogue.effect_number(late, 0), 0U);
  EXPECT_TRUE(catalogue.own_states_depend_on(catalogue.find("input_delay"))) << "states of the lag depend on the delay";
  EXPECT_FALSE(catalogue.own_states_depend_on(catalogue.find("steer_gain")));
  const measured::Log with = rig.simulate(late, {2, 5, 0.0}),
                      without = rig.simulate(catalogue.null_model(), {2, 5, 0.0});
  for (std::size_t k = 0; k < with.reading.size(); ++k) EXPECT_NEAR(with.reading[k], without.reading[k], 1e-9);
}

TEST(Catalogue, OffersNoSecondDelay) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [{"plugin": "input_delay", "params": {"T": 0.02}}]}})");
  for (const char* id : {"input_delay", "sensor_latency"})
    EXPECT_EQ(rig.catalogue().find(id), rig.catalogue().candidates().size()) << id;
  EXPECT_LT(rig.catalogue().find("steer_lag"), rig.catalogue().candidates().size());
}

TEST(Catalogue, NominalParametersAreFoundByName) {
  const DiagnoseRig rig;
  std::size_t index = 99;
  EXPECT_DOUBLE_EQ(rig.catalogue().nominal("Df", &index), 0.192);
  EXPECT_LT(index, 20U);
  EXPECT_TRUE(std::isnan(rig.catalogue().nominal("no_such_parameter")));
}

/// Whatever the order in which effects are added, they act in the order of their stages and precedences.
TEST(Catalogue, MembersStandInChainOrder) {
  const DiagnoseRig rig;
  const ModelSpec one = rig.with(rig.with(rig.with("vx_bias", {0.1}), "aero_drag", {0.2}), "steer_gain", {0.3});
  const ModelSpec other = rig.with(rig.with(rig.with("steer_gain", {0.3}), "vx_bias", {0.1}), "aero_drag", {0.2});
  EXPECT_EQ(one.members, other.members);
  EXPECT_EQ(one.values, other.values);
  EXPECT_EQ(rig.catalogue().name(one), "steer_gain+aero_drag+vx_bias");
  EXPECT_EQ(rig.catalogue().build(one).effects(), 3U);
}

TEST(Catalogue, WithoutUndoesWith) {
  const DiagnoseRig rig;
  const ModelSpec before = rig.with("steer_gain", {0.3});
  const std::size_t drag = rig.catalogue().find("aero_drag");
  const ModelSpec after = rig.catalogue().without(rig.catalogue().with(before, drag), drag);
  EXPECT_EQ(after.members, before.members);
  EXPECT_EQ(after.values, before.values);
  EXPECT_FALSE(after.has(drag));
  EXPECT_EQ(rig.catalogue().name(rig.catalogue().null_model()), "none");
}

/// Relaxing tyres have two hidden states, a lag and brakes that fade one each: the filter takes four.
TEST(Catalogue, CountsHiddenStates) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [
    {"plugin": "steer_lag", "params": {"tau": 0.02}}, {"plugin": "aero_drag", "params": {"a": 0.1}}]}})");
  const Catalogue& catalogue = rig.catalogue();
  const ModelSpec bare = catalogue.null_model(), lag = rig.with("motor_lag", {0.05});
  const std::size_t relaxation = catalogue.find("relaxation"), fade = catalogue.find("brake_fade");
  EXPECT_EQ(catalogue.hidden_states(bare), 1U);
  EXPECT_EQ(catalogue.hidden_states(lag), 2U);
  EXPECT_TRUE(catalogue.fits_filter(bare));
  EXPECT_TRUE(catalogue.fits_filter(bare, {relaxation, fade}));
  EXPECT_TRUE(catalogue.fits_filter(lag, {relaxation}));
  EXPECT_FALSE(catalogue.fits_filter(lag, {relaxation, fade}));
  EXPECT_TRUE(catalogue.fits_filter(lag, {relaxation, catalogue.find("steer_gain")}));
}

/// What is left of a delay of a pose is a parameter of the built car's readings, beside those of the model.
TEST(Catalogue, APoseMayBeLate) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.1);
  Catalogue& catalogue = rig.catalogue();
  const std::size_t plain = catalogue.build(catalogue.null_model()).params().size();
  catalogue.allow_for_late_pose(0, 0.004, 0.01);
  catalogue.allow_for_late_pose(1, 0.0, 0.02);
  ASSERT_TRUE(catalogue.pose_is_late());
  ModelSpec model = catalogue.null_model();
  ASSERT_EQ(model.nuisance.size(), 3U);
  EXPECT_EQ(catalogue.nuisances()[2].sigma, 0.02);
  EXPECT_EQ(model.nuisance[1], 0.004);
  model.nuisance = {0.2, 0.03, -0.05};
  const StagedCar car = catalogue.build(model);
  EXPECT_EQ(car.params()[catalogue.nuisances()[0].index], 0.2);
  const Place at;
  Reading<double> r{1.0, 2.0, 0.5, 3.0, 0.4, 2.0};
  car.read(&r, 1, &at, nullptr);
  EXPECT_NEAR(r.x, 1.0 - 0.03 * (3.0 * std::cos(0.5) - 0.4 * std::sin(0.5)), 1e-12);
  EXPECT_NEAR(r.y, 2.0 - 0.03 * (3.0 * std::sin(0.5) + 0.4 * std::cos(0.5)), 1e-12);
  EXPECT_NEAR(r.yaw, 0.5 + 0.05 * 2.0, 1e-12);
  EXPECT_EQ(r.vx, 3.0);
  catalogue.forget_late_pose();
  EXPECT_FALSE(catalogue.pose_is_late());
  EXPECT_EQ(catalogue.nuisances().size(), 1U);
  EXPECT_EQ(catalogue.build(catalogue.null_model()).params().size(), plain);
}

}  // namespace test_diagnose_candidates
}  // namespace gripline::diagnose
