#include "race/stack.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <type_traits>

#include "config/hash.hpp"
#include "plugin/guard.hpp"
#include "race/assembly.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_stack {

using testing::AllOf;
using testing::HasSubstr;
using namespace testing_support;

// Its plugins keep a pointer to its nominal model.
static_assert(!std::is_copy_constructible_v<Stack> && !std::is_copy_assignable_v<Stack>);
static_assert(!std::is_move_constructible_v<Stack> && !std::is_move_assignable_v<Stack>);

/// A world, a stack in it, and steps of both.
class Rig {
 public:
  explicit Rig(std::string_view stack, std::string_view world = "{}")
      : world_spec_(world_of(world)), stack_spec_(stack_of(world_spec_.car, stack)), race_(world_spec_, stack_spec_) {}
  World& world() { return race_.world(); }
  Stack& stack() { return race_.stack(); }
  const StackSpec& spec() const { return stack_spec_; }
  Sample advance(const Input& wanted) {
    const Observation before = world().observe();
    const Input u = world().advance(wanted);
    return stack().sample(before, u, world().observe());
  }

 private:
  WorldSpec world_spec_;
  StackSpec stack_spec_;
  RaceAssembly race_;
};

TEST(Stack, OnlyWhoDeclaresItIsToldTheTruth) {
  EXPECT_NO_THROW(Rig(R"({"estimator": {"plugin": "spy.blind"}, "planner": {"plugin": "spy.blind", "params": null},
    "controller": {"plugin": "spy.blind"}, "model": {"effects": [{"plugin": "spy.blind"}]}})"));
  EXPECT_NO_THROW(Rig(R"({"estimator": {"plugin": "spy.truthful"}})"));
  EXPECT_NO_THROW(Rig(R"({"estimator": {"plugin": "spy.truthful"}, "planner": {"plugin": "spy.blind", "params": null},
    "controller": {"plugin": "spy.blind"}})"));
}

/// Every library has a folder of its own in the cache, named by what the library is.
TEST(Stack, ALibraryMeetsOnlyWhatItKeptItself) {
  const WorldSpec world_spec = world_of();
  const StackSpec spec = stack_of(world_spec.car, R"({"controller": {"plugin": "fault.tells_cache", "params": null}})");
  const auto told = [&](const std::string& cache) {
    return refusal([&] { RaceAssembly(world_spec, spec, {.cache_dir = cache}); });
  };
  EXPECT_EQ(told(""), "fault.tells_cache: no cache");
  const std::string hash = sha256_of_file(spec.controller.entry->library).substr(0, 16);
  EXPECT_EQ(told("/cache"), "fault.tells_cache: /cache/faults-" + hash);
}

TEST(Stack, SaysWhetherItNeedsTheTruth) {
  const CarFile car = world_of().car;
  EXPECT_FALSE(stack_of(car).needs_truth());
  EXPECT_FALSE(stack_of(car, R"({"estimator": {"plugin": "none"}})").needs_truth());
  EXPECT_TRUE(stack_of(car, R"({"estimator": {"plugin": "spy.truthful"}})").needs_truth());
  EXPECT_TRUE(stack_of(car, R"({"estimator": {"plugin": "oracle"}})").needs_truth());
}

TEST(Stack, ANominalModelMustNotKnowTheTruth) {
  const CarFile car = world_of().car;
  EXPECT_THAT(refusal([&] { stack_of(car, R"({"model": {"plugin": "spy.truthful"}})"); }),
              HasSubstr("/model: \"spy.truthful\" is given the ground truth; a stack's nominal model must not be"));
  EXPECT_THAT(refusal([&] { stack_of(car, R"({"model": {"effects": [{"plugin": "spy.truthful"}]}})"); }),
              HasSubstr("\"spy.truthful\" is given the ground truth; a stack's nominal model must not be"));
}

/// It would do nothing: a stack predicts states, not readings. In a world's plant it has its place.
TEST(Stack, AnEffectOnReadingsHasNoPlaceInANominalModel) {
  const CarFile car = world_of().car;
  for (const std::string id : {"vx_bias", "velocity_lever"})
    EXPECT_THAT(refusal([&] {
                  stack_of(car, R"({"model": {"effects": [{"plugin": "aero_drag"}, {"plugin": ")" + id + R"("}]}})");
                }),
                HasSubstr("/model/effects/1: effect \"" + id +
                          "\" changes what sensors show, and nothing here reads that; it belongs into a world's plant"))
        << id;
  EXPECT_NO_THROW(world_of(R"({"plant": {"effects": [{"plugin": "vx_bias"}]}})"));
}

TEST(Stack, APlantOfAWorldIsNoNominalModel) {
  EXPECT_THAT(refusal([&] { stack_of(world_of().car, R"({"model": {"plugin": "double_track"}})"); }),
              HasSubstr("no vehicle plugin \"double_track\"; \"double_track\" is of kind plant"));
}

TEST(Stack, RefusalsSayWhatAndWhere) {
  const CarFile car = world_of().car;
  const auto why = [&](const char* patch) { return refusal([&] { stack_of(car, patch); }); };
  EXPECT_THAT(why(R"({"model": null})"), HasSubstr("/model: missing, expected a vehicle model"));
  EXPECT_THAT(why(R"({"planner": null})"), HasSubstr("/planner: missing, expected an object"));
  EXPECT_THAT(why(R"({"controller": null})"), HasSubstr("/controller: missing, expected an object"));
  EXPECT_THAT(why(R"({"estimator": {"params": {}}})"), HasSubstr("/estimator/plugin: missing"));
  EXPECT_THAT(why(R"({"adapt_after": "6.2 m"})"), HasSubstr("\"6.2 m\" is a length, expected a time [s]"));
  EXPECT_THAT(why(R"({"adapt_after": -1})"), HasSubstr("/adapt_after: -1 is out of range"));
  EXPECT_THAT(why(R"({"mu_init": 0})"), HasSubstr("/mu_init: 0 is out of range"));
  EXPECT_THAT(why(R"({"estimatr": null, "x": 1})"), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(why(R"({"controller": {"params": {"horizon": 0}}})"),
              HasSubstr("/controller/params/horizon: expected a whole number from 2 to 500, found 0"));
}

/// Line 4: what the nominal model leaves unexplained, as a rate; nothing when it is the plant itself.
TEST(Stack, TheSampleIsWhatTheNominalModelLeavesUnexplained) {
  const auto told = [](const std::string& more) {
    return R"({"model": {"plugin": "dynamic", "integrator": "rk6", "params": )" + published_tyres_json + more + "}}";
  };
  Rig same(told(""), R"({"start": {"speed": 1.5}})");
  Rig wrong(told(R"(, "effects": [{"plugin": "rolling_res", "params": {"a": -0.7}}])"), R"({"start": {"speed": 1.5}})");
  for (int k = 0; k < 10; ++k) {
    const Input u = {0.5, k < 5 ? 2.0 : -1.0};
    const Sample exact = same.advance(u);
    EXPECT_NEAR(exact.e_vx, 0, 1e-10);
    EXPECT_NEAR(exact.e_omega, 0, 1e-8);
    const Sample off = wrong.advance(u);
    EXPECT_NEAR(off.e_vx, -0.7, 0.02);
    EXPECT_EQ(off.step, k);
    EXPECT_NEAR(off.t, 0.02 * k, 1e-12);
    EXPECT_EQ(off.dt, 0.02);
    EXPECT_EQ(off.x_next.vx, wrong.world().state().vx);
    EXPECT_NEAR(off.at.t, 0.02 * k, 1e-12);
    EXPECT_NEAR(off.at_next.t, 0.02 * (k + 1), 1e-12);
    EXPECT_EQ(off.u.d, 0.5);
  }
}

/// What a stack is told of its car reaches its model and its plugins; the world's car stays as it is.
TEST(Stack, MayBeToldAnotherCarThanTheWorlds) {
  std::string heavy = R"({"car": {"m": 0.05, "known_params": {"Cm1": 0.3}}, "model": {"plugin": "dynamic", )";
  heavy.append(R"("integrator": "rk6", "params": )").append(published_tyres_json).append("}}");
  Rig rig(heavy, R"({"start": {"speed": 1.5}})");
  EXPECT_EQ(rig.spec().car.value().m, 0.05);
  EXPECT_EQ(rig.spec().car.value().lf, rig.world().spec().car.car.lf);
  EXPECT_NE(rig.world().spec().car.car.m, 0.05);
  double error = 0;
  for (int k = 0; k < 10; ++k) error = std::max(error, std::abs(rig.advance({0.5, 2.0}).e_vx));
  EXPECT_GT(error, 0.05);
  const CarFile car = world_of().car;
  const auto why = [&](const char* patch) { return refusal([&] { stack_of(car, patch); }); };
  EXPECT_THAT(why(R"({"car": {"mass": 1}})"), HasSubstr("/car/mass: unknown key \"mass\""));
  EXPECT_THAT(why(R"({"car": {"m": "1 s"}})"), HasSubstr("/car/m: \"1 s\" is a time, expected a mass [kg]"));
  EXPECT_THAT(why(R"({"car": {"known_params": {"Cm1": "x"}}})"),
              HasSubstr("/car/known_params/Cm1: expected a number in SI"));
}

/// A nominal model of the same equations that is not told the plant's tyres does not know them.
TEST(Stack, DefaultsOfAModelAreNotTheTruth) {
  Rig untold(R"({"model": {"plugin": "dynamic", "integrator": "rk6"}})", R"({"start": {"speed": 1.5}})");
  double largest = 0;
  for (int k = 0; k < 10; ++k) largest = std::max(largest, std::abs(untold.advance({0.5, 2.0}).e_omega));
  EXPECT_GT(largest, 1);
}

/// A plant with a lag, explained by a nominal model with the same lag: its memory is carried along the inputs applied.
TEST(Stack, MemoryOfTheNominalModelFollowsTheInputsApplied) {
  constexpr const char* lag =
      R"([{"plugin": "steer_lag", "params": {"tau": 0.05}}, {"plugin": "input_delay", "params": {"T": 0.04}}])";
  const std::string model = R"({"plugin": "dynamic", "integrator": "rk6", "params": )" + published_tyres_json +
                            R"(, "effects": )" + lag + "}";
  Rig rig(R"({"model": )" + model + "}", R"({"start": {"speed": 1.5}, "plant": )" + model + "}");
  for (int k = 0; k < 40; ++k) {
    const Sample sample = rig.advance({0.2 + 0.01 * k, k % 7 < 3 ? 2.0 : -1.5});
    EXPECT_NEAR(sample.e_omega, 0, 1e-8) << k;
    EXPECT_NEAR(sample.e_vx, 0, 1e-10) << k;
  }
}

TEST(Stack, BelievesMuInitUntilItTrusts) {
  Rig rig(R"({"estimator": {"plugin": "spy.truthful"}, "adapt_after": "0.1 s", "mu_init": 1.3})");
  for (int k = 0; k < 10; ++k) {
    const StackBelief belief = rig.stack().belief(0.02 * k);
    const bool trusts = 0.02 * k > 0.1;
    EXPECT_EQ(belief.mu.trusted, trusts);
    EXPECT_EQ(belief.learned != nullptr, trusts);
    if (trusts)
      EXPECT_NEAR(total_mu(belief.mu, rig.world().spec().car.car), 0.9092, 1e-4);
    else
      EXPECT_EQ(belief.mu.mu_front, 1.3);
    rig.advance({0.3, 0});
  }
}

/// The learned model drives before plans rest on it.
TEST(Stack, PlansStayCarefulUntilToldOtherwise) {
  Rig rig(
      R"({"estimator": {"plugin": "spy.truthful"}, "adapt_after": "0.1 s", "careful_until": "0.2 s", "mu_init": 0.4})");
  const CorrectedModel* const nominal = rig.stack().belief(0.0).model;
  const StackBelief careful = rig.stack().belief(0.15);
  EXPECT_NE(careful.model, nominal);
  EXPECT_FALSE(careful.mu.trusted);
  EXPECT_EQ(careful.mu.mu_front, 0.4);
  EXPECT_EQ(careful.learned, nullptr);
  const StackBelief later = rig.stack().belief(0.21);
  EXPECT_TRUE(later.mu.trusted);
  EXPECT_NEAR(total_mu(later.mu, rig.world().spec().car.car), 0.9092, 1e-4);
}

/// How far the wheels and the throttle are behind their commands in the middle of a step.
TEST(Stack, SamplesSayHowFarTheNominalModelIsBehindItsCommands) {
  Rig plain("{}", R"({"start": {"speed": 1.5}})");
  const Sample none = plain.advance({0.4, 2.0});
  EXPECT_EQ(none.d_lag, 0.0);
  EXPECT_EQ(none.delta_lag, 0.0);
  EXPECT_EQ(none.ddelta_lag, 0.0);
  const double tau = 0.05;
  Rig rig(R"({"model": {"effects": [{"plugin": "steer_lag", "params": {"tau": 0.05}}]}})",
          R"({"start": {"speed": 1.5}})");
  double wheel = 0.0;
  double delta = 0.0;
  for (int k = 0; k < 10; ++k) {
    const Sample sample = rig.advance({0.4, k < 5 ? 2.0 : -1.0});
    delta += 0.02 * (k < 5 ? 2.0 : -1.0);
    const double after = delta + (wheel - delta) * std::exp(-0.02 / tau);
    EXPECT_NEAR(sample.delta_lag, delta - 0.5 * (wheel + after), 5e-5) << k;
    const double turns = 0.5 * ((delta - wheel) + (delta - after)) / tau;
    EXPECT_NEAR(sample.ddelta_lag, (k < 5 ? 2.0 : -1.0) - turns, 1e-3) << k;
    EXPECT_EQ(sample.d_lag, 0.0);
    wheel = after;
  }
}

TEST(Stack, WithoutAnEstimatorItBelievesMuInitForGood) {
  Rig rig(R"({"mu_init": 0.8})");
  const StackBelief belief = rig.stack().belief(1000);
  EXPECT_EQ(belief.mu.mu_front, 0.8);
  EXPECT_EQ(belief.mu.mu_rear, 0.8);
  EXPECT_FALSE(belief.mu.trusted);
  EXPECT_EQ(belief.learned, nullptr);
  EXPECT_EQ(rig.stack().tyre_curve(), nullptr);
}

/// What the model that the stack believes in misses of the next step's yaw rate and speed.
double error_of_next(Rig& rig, const Input& input) {
  const Observation now = rig.world().observe();
  CorrectedModel& model = *rig.stack().belief(now.t).model;
  std::vector<double> row(static_cast<std::size_t>(model.states())), next(row.size());
  model.start(now.x, row);
  const double u[] = {input.d, input.ddelta};
  model.step(1, row, u, {&now.at, 1}, next, {}, {});
  const Sample sample = rig.advance(input);
  return std::max(std::abs(next[5] - sample.x_next.omega), std::abs(next[3] - sample.x_next.vx));
}

/// Who steps a world without Algorithm 1 is told of them as a race is.
TEST(Stack, FailuresOfItsPluginsHaveTheirNameAndTime) {
  const auto failure = [](const std::string& estimator) {
    Rig rig(R"({"estimator": {"plugin": ")" + estimator + R"("}})", R"({"start": {"speed": 1}})");
    try {
      for (int k = 0; k < 40; ++k) {
        rig.stack().learn(rig.advance({0.3, 0}));
        (void)rig.stack().belief(rig.world().time());
      }
    } catch (const PluginFailure& failed) {
      return std::string(failed.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(failure("fault.nan_friction"),
              AllOf(HasSubstr("fault.nan_friction at t = "), HasSubstr("returned a friction that is not a number")));
  EXPECT_THAT(failure("fault.negative_friction"), HasSubstr("expected none below 0"));
  EXPECT_THAT(failure("fault.nan_correction"), AllOf(HasSubstr("fault.nan_correction at t = "),
                                                     HasSubstr("returned a correction that is not a number")));
  EXPECT_EQ(failure("none"), "none");
}

/// f_corr = f_nom + e_pred after adapt_after, f_nom until then.
TEST(Stack, TheModelIsCorrectedAfterAdaptAfter) {
  Rig rig(
      R"({"estimator": {"plugin": "oracle"}, "model": {"plugin": "ekinematic", "integrator": "rk6"},
          "adapt_after": "0.1 s"})",
      R"({"start": {"speed": 1.5}})");
  for (int k = 0; k < 20; ++k) {
    const double t = rig.world().time(), error = error_of_next(rig, {0.4, k < 8 ? 1.5 : 0.0});
    EXPECT_EQ(t > 0.1, error < 1e-9) << k << ": " << error;
  }
}

/// Slopes that no map has, and an actuator that both sides know: it acts once.
TEST(Stack, TheOracleKnowsWhatThePlantsEffectsDo) {
  Rig rig(
      R"({"estimator": {"plugin": "oracle"}, "adapt_after": 0, "model": {"plugin": "ekinematic", "integrator": "rk6",
          "effects": [{"plugin": "steer_gain", "params": {"k": 0.1}}]}})",
      R"({"start": {"speed": 1.5}, "plant": {"integrator": "rk6", "effects": [
          {"plugin": "steer_gain", "params": {"k": 0.1}}, {"plugin": "aero_drag", "params": {"a": 0.4}},
          {"plugin": "plane_tilt", "params": {"tx": 0.05, "ty": -0.03}}]}})");
  rig.advance({0.4, 0});
  for (int k = 0; k < 20; ++k) EXPECT_LT(error_of_next(rig, {0.4, k < 8 ? 1.5 : 0.0}), 1e-9) << k;
}

/// A full-size car that states no drive.
Node car_without_drive() {
  return json(R"({"m": 1265, "Iz": 2093, "lf": 1.34, "lr": 1.3, "length": 4.18, "width": 1.84, "d_min": -1,
    "d_max": 1, "delta_max": 0.35, "ddelta_max": 1, "v_ref": 20, "v_min": 2})");
}
CarFile car_of(const Node& car) {
  Errors errors;
  CarFile file = read_car(car, errors);
  errors.throw_if_any();
  return file;
}

/// At the car's file, once, however many of a race's cars are modelled so.
TEST(Stack, ACarWithoutADriveIsToldOnceOfTheWorldAndAllStacks) {
  const Folder folder;
  write_text(folder / "car.json", to_json_text(car_without_drive()));
  Node tree = json(R"({"track": "tracks/hill.json", "duration": 1, "plant": {"plugin": "dynamic"}})");
  tree.set("car", Node((folder / "car.json").string()));
  inline_world_files(tree);
  Errors errors;
  const WorldSpec world = read_world(tree, plugins(), errors);
  const Node stack = json(R"({"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"},
                              "controller": {"plugin": "pure_pursuit"}})");
  for (const char* name : {"one", "other"}) {
    errors.set_context(std::string("stack ") + name);
    read_stack(name, stack, plugins(), world.car, errors);
  }
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_THAT(errors.sorted().front().text(),
              AllOf(HasSubstr("car.json:1:1: /known_params: at full throttle"), HasSubstr("[stack one, stack other]")));
}

/// A stack that is told the drive which the car's file lacks has one.
TEST(Stack, ItMayBeToldTheDriveThatItsCarLacks) {
  const CarFile car = car_of(car_without_drive());
  EXPECT_THAT(refusal([&] { stack_of(car); }), HasSubstr("/known_params: at full throttle"));
  EXPECT_NO_THROW(stack_of(car, R"({"car": {"known_params": {"Cm1": 7650}}})"));
}

}  // namespace test_stack
}  // namespace gripline
