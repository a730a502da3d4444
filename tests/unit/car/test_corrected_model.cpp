#include "car/corrected_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/allocation_counter.hpp"
#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {

inline std::string hold_name(Hold hold) { return hold == Hold::zoh ? "zoh" : hold == Hold::foh ? "foh" : "rate"; }
inline void PrintTo(Hold hold, std::ostream* out) { *out << hold_name(hold); }

namespace test_corrected_model {

using namespace testing_support;

constexpr double dt = 0.02;

/// `dynamic` with JSON effects, under a hold.
class TestedModel {
 public:
  TestedModel(const std::string& effects, Hold hold, const std::string& method = "rk4", int substeps = 1)
      : file_(car_file()),
        vehicle_(spec(effects), context()),
        model_(vehicle_.car(), {dt, hold, {find_tableau(method), substeps}}) {}
  CorrectedModel& operator*() { return model_; }
  CorrectedModel* operator->() { return &model_; }
  const CarFile& file() const { return file_; }

 private:
  static CarFile car_file() {
    Errors errors;
    CarFile file = read_car(load_json(source_dir() / "worlds/cars/orca_1_43.json"), errors);
    errors.throw_if_any();
    return file;
  }
  VehicleSpec spec(const std::string& effects) const {
    Errors errors;
    VehicleSpec spec = read_vehicle(json(R"({"plugin": "dynamic", "params": {"Cb": 0.3}, "effects": )" + effects + "}"),
                                    plugins(), file_, "rk4", errors);
    errors.throw_if_any();
    return spec;
  }
  PluginContext context() const {
    PluginContext context;
    context.car = file_.car;
    context.dt = dt;
    return context;
  }
  CarFile file_;
  Vehicle vehicle_;
  CorrectedModel model_;
};

/// A sequence of random commands within the car's limits.
std::vector<Input> random_inputs(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  std::vector<Input> inputs;
  for (std::size_t i = 0; i < count; ++i) inputs.push_back({uniform(0.05, 1.0), uniform(-2.0, 2.0)});
  return inputs;
}

State moving() { return {0.3, -0.2, 0.8, 1.7, 0.1, 2.0, 0.08}; }

Place sloped() {
  Place at;
  at.t = 3.0;
  at.lap_fraction = 0.37;
  at.grade = 0.03;
  at.bank = -0.02;
  return at;
}

/// A row with memory and past commands that are not steady: a few steps under changing commands.
std::vector<double> lively_row(CorrectedModel& model, unsigned seed) {
  State x = moving();
  model.reset(x, 0.5, sloped());
  for (const Input& u : random_inputs(6, seed)) x = model.advance(x, u, sloped());
  std::vector<double> row(static_cast<std::size_t>(model.states()));
  model.start(x, row);
  return row;
}

std::vector<double> stepped(CorrectedModel& model, const std::vector<double>& row, const Input& input) {
  const Place at = sloped();
  const double u[] = {input.d, input.ddelta};
  std::vector<double> next(row.size());
  model.step(1, row, u, {&at, 1}, next, {}, {});
  return next;
}

/// Duals divide by multiplying with an inverse: the last digits may differ.
void expect_same(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-13 * std::max(1.0, std::abs(b[i]))) << i;
}

struct Case {
  const char* name;
  const char* effects;
  friend std::ostream& operator<<(std::ostream& out, const Case& one) { return out << one.name; }
};

/// One effect of every stage, effects with memory, effects with delays, all together.
const Case cases[] = {
    {"plain", "[]"},
    {"command_steer_lag", R"([{"plugin": "steer_lag", "params": {"tau": 0.04}}])"},
    {"command_motor_lag", R"([{"plugin": "motor_lag", "params": {"tau": 0.06}}])"},
    {"command_steer_gain", R"([{"plugin": "steer_gain", "params": {"k": 0.1}}])"},
    {"command_input_delay", R"([{"plugin": "input_delay", "params": {"T": 0.033}}])"},
    {"drive_back_emf", R"([{"plugin": "back_emf", "params": {"k": 0.1}}])"},
    {"drive_brake_fade", R"([{"plugin": "brake_fade", "params": {"k": 0.3}}])"},
    {"load_transfer", R"([{"plugin": "load_transfer", "params": {"h_over_L": 0.2}}])"},
    {"load_cog_shift", R"([{"plugin": "cog_shift", "params": {"k": 0.05}}])"},
    {"tyre_friction_scale", R"([{"plugin": "friction_scale", "params": {"k": -0.1}}])"},
    {"tyre_friction_patch", R"([{"plugin": "friction_patch", "params": {"k": -0.2, "s0": 0.4, "w": 0.1}}])"},
    {"tyre_comb_slip", R"([{"plugin": "comb_slip", "params": {"k": 0.5}}])"},
    {"force_relaxation", R"([{"plugin": "relaxation", "params": {"sigma": 0.06}}])"},
    {"body_aero_drag", R"([{"plugin": "aero_drag", "params": {"a": 0.4}}])"},
    {"body_plane_tilt", R"([{"plugin": "plane_tilt", "params": {"tx": 0.02, "ty": -0.01}}])"},
    {"body_grade", R"([{"plugin": "grade", "params": {"c2": 0.03, "c4": -0.02}}])"},
    {"reading_vx_bias", R"([{"plugin": "vx_bias", "params": {"b": 0.05}}])"},
    {"one_of_every_stage", R"([{"plugin": "input_delay", "params": {"T": 0.047}},
      {"plugin": "steer_lag", "params": {"tau": 0.04}}, {"plugin": "drive_gain", "params": {"k": 0.1}},
      {"plugin": "load_transfer", "params": {"h_over_L": 0.15}}, {"plugin": "friction_drift", "params": {"k": -0.1}},
      {"plugin": "relaxation", "params": {"sigma": 0.05}}, {"plugin": "wind", "params": {"wx": 1, "wy": -2}},
      {"plugin": "yawrate_bias", "params": {"b": 0.1}}])"},
};

class Derivatives : public testing::TestWithParam<std::tuple<Case, Hold>> {
 protected:
  static std::string effects() { return std::get<0>(GetParam()).effects; }
  static Hold hold() { return std::get<1>(GetParam()); }
  /// Relative to the size of the derivative, absolute below 1.
  static void expect_close(double exact, double difference, const std::string& what) {
    EXPECT_NEAR(exact, difference, 1e-6 * std::max(1.0, std::abs(difference))) << what;
  }
};

/// Fourth-order central difference of f over h.
template <class F>
double slope(F&& f, double h) {
  return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}

/// Controllers ask for rates in their step.
TEST(CorrectedModelRates, AllocateNothingWithMemory) {
  if (!rig::counts_allocations) GTEST_SKIP() << "the sanitizer owns malloc";
  TestedModel model(
      R"([{"plugin": "steer_lag", "params": {"tau": 0.04}}, {"plugin": "motor_lag", "params": {"tau": 0.06}}])",
      Hold::zoh);
  model->rates(moving(), {0.6, 0.0}, {});
  const long before = rig::allocations.load();
  const double turning = model->rates(moving(), {0.6, 0.0}, {}).omega;
  EXPECT_EQ(rig::allocations.load() - before, 0);
  EXPECT_TRUE(std::isfinite(turning));
}

TEST_P(Derivatives, ByStateMemoryPastCommandsAndInput) {
  TestedModel model(effects(), hold());
  const std::vector<double> row = lively_row(*model, 1);
  const auto n = row.size();
  const Input input = {0.6, 1.1};
  const Place at = sloped();
  const double u[] = {input.d, input.ddelta};
  std::vector<double> next(n), A(n * n, -1), B(n * 2, -1);
  model->step(1, row, u, {&at, 1}, next, A, B);
  expect_same(next, stepped(*model, row, input));
  for (std::size_t j = 0; j < n + 2; ++j) {
    const double size = j < n ? std::abs(row[j]) : std::abs(u[j - n]);
    const double h = 2e-4 * std::max(0.05, size);
    for (std::size_t i = 0; i < n; ++i) {
      const double difference = slope(
          [&](double by) {
            std::vector<double> moved = row;
            Input moved_input = input;
            (j < n ? moved[j] : j == n ? moved_input.d : moved_input.ddelta) += by;
            return stepped(*model, moved, moved_input)[i];
          },
          h);
      const double exact = j < n ? A[i * n + j] : B[i * 2 + j - n];
      expect_close(exact, difference, "d x" + std::to_string(i) + " / d " + std::to_string(j));
    }
  }
}

bool moves_look_back(StagedCar car, std::size_t param) {
  const double before = car.look_back();
  car.params()[param] += 1e-3;
  return car.look_back() != before;
}

/// The parameters' derivatives through the integrator, as whoever fits them asks for them: eight at a time.
TEST_P(Derivatives, ByEveryParameter) {
  TestedModel model(effects(), hold());
  const std::vector<double> row = lively_row(*model, 2);
  const StagedCar& car = model->car();
  const std::vector<double> params(car.params().begin(), car.params().end());
  const auto memory = static_cast<std::size_t>(car.memory());
  const std::size_t past = (row.size() - state_size - memory) / 2;
  const Integration rk4;
  const Input input = {0.7, -0.9};
  const double delta = row[6] + dt * input.ddelta;
  const Place at = sloped();
  const auto fill = [&](auto& stepper) {
    stepper.resize(1, static_cast<int>(memory), 4, past > 0 ? static_cast<int>(past) + 1 : 0);
    stepper.hold = hold();
    stepper.past_dt = dt;
    stepper.past_offset = -dt * static_cast<double>(hold() == Hold::zoh ? past : past - 1);
    for (std::size_t j = 0; j < motion_size; ++j) stepper.motion[j] = row[j];
    for (std::size_t j = 0; j < memory; ++j) stepper.memory[j] = row[state_size + j];
    for (std::size_t j = 0; j < past; ++j)
      stepper.past[j] = {row[state_size + memory + 2 * j], row[state_size + memory + 2 * j + 1]};
    if (past > 0) stepper.past[past] = {input.d, delta};
    stepper.ramp[0] = {{input.d, delta, input.ddelta}, {input.d, delta, input.ddelta}};
    if (hold() != Hold::zoh) stepper.ramp[0].begin.delta = row[6];
    if (hold() == Hold::foh) stepper.ramp[0].begin.d = row[row.size() - 2];
  };
  const auto after = [&](const std::vector<double>& values) {
    Stepper<double> stepper;
    fill(stepper);
    stepper.step(car, rk4, dt, 1, &at, values.data());
    std::vector<double> out(stepper.motion.begin(), stepper.motion.begin() + motion_size);
    out.insert(out.end(), stepper.memory.begin(), stepper.memory.begin() + static_cast<std::ptrdiff_t>(memory));
    return out;
  };
  const std::vector<double> plain = after(params), same = stepped(*model, row, input);
  for (std::size_t i = 0; i < motion_size; ++i) EXPECT_EQ(plain[i], same[i]);
  for (std::size_t first = 0; first < params.size(); first += 8) {
    std::vector<Dual8> seeded(params.begin(), params.end());
    const std::size_t count = std::min<std::size_t>(8, params.size() - first);
    for (std::size_t k = 0; k < count; ++k) seeded[first + k].d[k] = 1.0;
    Stepper<Dual8> stepper;
    fill(stepper);
    stepper.step(car, rk4, dt, 1, &at, seeded.data());
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t j = first + k;
      if (moves_look_back(car, j)) continue;  // it moves where steps are cut, which duals do not see
      const double h = 2e-4 * std::max(1e-3, std::abs(params[j]));
      for (std::size_t i = 0; i < plain.size(); ++i) {
        const double difference = slope(
            [&](double by) {
              std::vector<double> moved = params;
              moved[j] += by;
              return after(moved)[i];
            },
            h);
        const Dual8& exact = i < motion_size ? stepper.motion[i] : stepper.memory[i - motion_size];
        expect_close(exact.d[k], difference, "d x" + std::to_string(i) + " / d parameter " + std::to_string(j));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, Derivatives,
                         testing::Combine(testing::ValuesIn(cases), testing::Values(Hold::zoh, Hold::foh, Hold::rate)),
                         [](const auto& one) {
                           return std::get<0>(one.param).name + ("_" + hold_name(std::get<1>(one.param)));
                         });

TEST(CorrectedModel, ARowIsTheStateItsMemoryAndPastCommands) {
  EXPECT_EQ(TestedModel("[]", Hold::zoh)->states(), 7);
  EXPECT_EQ(TestedModel("[]", Hold::rate)->states(), 7);
  EXPECT_EQ(TestedModel("[]", Hold::foh)->states(), 9);  // the command that the ramp starts from
  EXPECT_EQ(TestedModel(R"([{"plugin": "relaxation"}])", Hold::zoh)->states(), 9);
  EXPECT_EQ(TestedModel(R"([{"plugin": "input_delay", "params": {"T": 0.04}}])", Hold::zoh)->states(), 7 + 2 * 3);
  TestedModel model(R"([{"plugin": "steer_lag"}, {"plugin": "input_delay", "params": {"T": 0.04}}])", Hold::zoh);
  const State x = moving();
  model->reset(x, 0.5, sloped());
  std::vector<double> row(static_cast<std::size_t>(model->states()));
  model->start(x, row);
  EXPECT_THAT(row, testing::ElementsAre(x.x, x.y, x.yaw, x.vx, x.vy, x.omega, x.delta, x.delta, 0.5, x.delta, 0.5,
                                        x.delta, 0.5, x.delta));
  model->advance(x, {0.9, 1.0}, sloped());
  model->start(x, row);
  EXPECT_EQ(row[12], 0.9);
  EXPECT_DOUBLE_EQ(row[13], x.delta + dt);
  EXPECT_EQ(row[10], 0.5);
}

/// A delay of whole steps is the same commands so many steps later, under every hold.
class WholeDelay : public testing::TestWithParam<std::tuple<Hold, int, std::string>> {};

TEST_P(WholeDelay, IsTheSameDriveLater) {
  const auto [hold, steps, method] = GetParam();
  TestedModel late(R"([{"plugin": "input_delay", "params": {"T": )" + std::to_string(0.02 * steps) + "}}]", hold,
                   method);
  TestedModel prompt("[]", hold, method);
  const std::vector<Input> inputs = random_inputs(30, 5);
  State x = moving();
  x.delta = 0.0;
  late->reset(x, 0.3, {});
  prompt->reset(x, 0.3, {});
  State y = x;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    Input then = k < static_cast<std::size_t>(steps) ? Input{0.3, 0.0} : inputs[k - static_cast<std::size_t>(steps)];
    x = late->advance(x, inputs[k], {});
    y = prompt->advance(y, then, {});
    ASSERT_NEAR(x.vx, y.vx, 1e-9) << "step " << k;
    ASSERT_NEAR(x.vy, y.vy, 1e-9) << "step " << k;
    ASSERT_NEAR(x.omega, y.omega, 1e-8) << "step " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Holds, WholeDelay,
                         testing::Combine(testing::Values(Hold::zoh, Hold::foh, Hold::rate),
                                          testing::Values(1, 2, 3, 7),
                                          testing::Values(std::string("rk4"), std::string("rk6"))),
                         [](const auto& one) {
                           return hold_name(std::get<0>(one.param)) + "_" + std::to_string(std::get<1>(one.param)) +
                                  "_" + std::get<2>(one.param);
                         });

/// What each hold means, seen by a model without dynamics of its own: the commands within the step.
TEST(CorrectedModel, HoldsActAsStated) {
  const auto look = [](Hold hold, int steps_before) {
    TestedModel model("[]", hold);
    State x = moving();
    model->reset(x, 0.2, {});
    for (int i = 0; i < steps_before; ++i) {
      model->advance(x, {0.5, 1.0}, {});
      x.delta += dt;
    }
    return model->quantities(x, {0.9, 2.0}, {});
  };
  for (const int before : {0, 1}) {
    const double delta = moving().delta + before * dt;
    const Quantities<double> zoh = look(Hold::zoh, before), foh = look(Hold::foh, before),
                             rate = look(Hold::rate, before);
    EXPECT_EQ(zoh.d, 0.9);
    EXPECT_DOUBLE_EQ(zoh.delta, delta + 2 * dt);
    EXPECT_EQ(foh.d, before == 0 ? 0.2 : 0.5);  // the throttle reached at the start of the step
    EXPECT_DOUBLE_EQ(foh.delta, delta);
    EXPECT_EQ(rate.d, 0.9);
    EXPECT_DOUBLE_EQ(rate.delta, delta);
    for (const auto& q : {zoh, foh, rate}) EXPECT_EQ(q.delta_rate, 2.0);
  }
}

TEST(CorrectedModel, OneJacobianMayBeAskedForAlone) {
  TestedModel model(R"([{"plugin": "relaxation", "params": {"sigma": 0.05}}])", Hold::zoh);
  const std::vector<double> row = lively_row(*model, 3);
  const auto n = row.size();
  const double u[] = {0.4, 0.7};
  const Place at;
  std::vector<double> next(n), A(n * n), B(n * 2), only_A(n * n), only_B(n * 2);
  model->step(1, row, u, {&at, 1}, next, A, B);
  model->step(1, row, u, {&at, 1}, next, only_A, {});
  model->step(1, row, u, {&at, 1}, next, {}, only_B);
  EXPECT_EQ(A, only_A);
  EXPECT_EQ(B, only_B);
}

TEST(CorrectedModel, AHorizonAtOnceIsItsStepsOneByOne) {
  TestedModel model(R"([{"plugin": "steer_lag"}, {"plugin": "input_delay", "params": {"T": 0.03}}])", Hold::zoh);
  constexpr std::size_t count = 13;
  std::vector<double> rows, u;
  std::vector<Place> at(count);
  for (unsigned i = 0; i < count; ++i) {
    const std::vector<double> row = lively_row(*model, i);
    rows.insert(rows.end(), row.begin(), row.end());
    u.insert(u.end(), {0.1 * i, 0.2 * i - 1});
    at[i].bank = 0.01 * i;
  }
  const std::size_t n = rows.size() / count;
  std::vector<double> next(rows.size()), A(count * n * n), B(count * n * 2), one(n), one_A(n * n), one_B(n * 2);
  model->step(count, rows, u, at, next, A, B);
  for (std::size_t i = 0; i < count; ++i) {
    model->step(1, std::span(rows).subspan(i * n, n), std::span(u).subspan(i * 2, 2), {&at[i], 1}, one, one_A, one_B);
    EXPECT_TRUE(std::equal(one.begin(), one.end(), next.begin() + static_cast<std::ptrdiff_t>(i * n)));
    EXPECT_TRUE(std::equal(one_A.begin(), one_A.end(), A.begin() + static_cast<std::ptrdiff_t>(i * n * n)));
    EXPECT_TRUE(std::equal(one_B.begin(), one_B.end(), B.begin() + static_cast<std::ptrdiff_t>(i * n * 2)));
  }
}

/// rates() is the limit of a short step, with memory at its steady value.
TEST(CorrectedModel, RatesAreTheLimitOfAStep) {
  TestedModel model(
      R"([{"plugin": "relaxation", "params": {"sigma": 0.05}}, {"plugin": "aero_drag", "params": {"a": 1}}])",
      Hold::zoh);
  const State x = moving();
  const Input u = {0.8, 0.0};
  const Prediction::Rates rates = model->rates(x, u, sloped());
  CorrectedModel brief(model->car(), {1e-6, Hold::zoh, {find_tableau("rk4"), 1}});
  brief.reset(x, u.d, sloped());
  const State next = brief.advance(x, u, sloped());
  EXPECT_NEAR(rates.vx, (next.vx - x.vx) / 1e-6, 1e-4);
  EXPECT_NEAR(rates.vy, (next.vy - x.vy) / 1e-6, 1e-4);
  EXPECT_NEAR(rates.omega, (next.omega - x.omega) / 1e-6, 2e-2);
}

/// A command that is held acts as its static effects say, behind no lag.
TEST(CorrectedModel, RatesSayWhatActsOfAHeldCommand) {
  const State x = moving();
  const Input u = {0.6, 1.0};
  TestedModel plain("[]", Hold::zoh), lagging(R"([{"plugin": "steer_lag"}, {"plugin": "motor_lag"}])", Hold::zoh);
  for (TestedModel* model : {&plain, &lagging}) {
    const Prediction::Rates rates = (*model)->rates(x, u, sloped());
    EXPECT_EQ(rates.d, u.d);
    EXPECT_EQ(rates.delta, x.delta);
  }
  TestedModel mapped(R"([{"plugin": "throttle_dead_zone", "params": {"z": 0.2}},
                         {"plugin": "steer_gain", "params": {"k": -0.1}},
                         {"plugin": "steer_offset", "params": {"d0": 0.05}}])",
                     Hold::zoh);
  const Prediction::Rates rates = mapped->rates(x, u, sloped());
  EXPECT_NEAR(rates.d, 0.5, 1e-15);
  EXPECT_NEAR(rates.delta, 0.9 * x.delta + 0.05, 1e-15);
}

TEST(CorrectedModel, ParametersMayChangeBetweenSteps) {
  TestedModel model(R"([{"plugin": "friction_scale", "params": {"k": 0}}])", Hold::zoh);
  const std::vector<double> row = lively_row(*model, 4);
  const Input u = {0.5, 0.5};
  const std::vector<double> fresh = stepped(*model, row, u);
  model->set_parameter(model->car().params().size() - 1, -0.5);
  const std::vector<double> worn = stepped(*model, row, u);
  EXPECT_LT(std::abs(worn[5] - row[5]), std::abs(fresh[5] - row[5]));
  const auto n = row.size();
  const Place at = sloped();
  const double input[] = {u.d, u.ddelta};
  std::vector<double> next(n), A(n * n), B(n * 2);
  model->step(1, row, input, {&at, 1}, next, A, B);
  expect_same(next, worn);
}

}  // namespace test_corrected_model
}  // namespace gripline
