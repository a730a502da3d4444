#include "conformance/exercise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "conformance/formula.hpp"
#include "util/clock.hpp"

namespace gripline::conformance {
namespace {

void add(Answers answers, std::initializer_list<double> numbers) {
  if (answers != nullptr) answers->insert(answers->end(), numbers);
}
void add(Answers answers, const State& x) { add(answers, {x.x, x.y, x.yaw, x.vx, x.vy, x.omega, x.delta}); }

/// Vehicle models and effects.
template <class Interface>
class FormulaExercise : public Exercise {
 public:
  FormulaExercise(const PluginEntry& entry, const PluginContext& context, const std::vector<abi::ParamValue>& values)
      : instance_(create<Interface>(entry, context, values)),
        formula_(formula_of(entry.decl->kind, instance_.get(), entry, values)),
        width_(formula_->inputs().size()),
        rows_(driving_rows(*formula_, instants, 11)),
        prepared_(formula_->prepare(instants, rows_)) {}
  void step(std::int64_t k, Answers answers) override {
    if (answers == nullptr) return prepared_->run();
    const auto from = rows_.begin() + (k % instants) * static_cast<std::ptrdiff_t>(width_);
    evaluate(1, {from, from + static_cast<std::ptrdiff_t>(width_)}, answers);
  }
  void extremes(const char*& where, Answers answers) override {
    const std::vector<double> rows = edge_rows(*formula_);
    for (std::size_t i = 0; i < edge_count; ++i) {
      where = edge_name(i);
      const auto from = rows.begin() + static_cast<std::ptrdiff_t>(i * width_);
      evaluate(1, {from, from + static_cast<std::ptrdiff_t>(width_)}, answers);
      std::vector<Dual8> row(from, from + static_cast<std::ptrdiff_t>(width_)),
          params(formula_->values().begin(), formula_->values().end());
      row[1].d[0] = row[2].d[1] = row[3].d[2] = 1.0;
      for (const Dual8& out : formula_->evaluate(1, row, params))
        for (const double slope : out.d) add(answers, {slope});
    }
    where = "of no points at all";
    formula_->evaluate_none();
  }
  void ask(Answers answers) const override { evaluate(instants, rows_, answers); }

 private:
  static constexpr std::int64_t instants = 24;
  void evaluate(std::size_t n, const std::vector<double>& rows, Answers answers) const {
    const std::vector<double> out = formula_->evaluate(n, rows, formula_->values());
    if (answers != nullptr) answers->insert(answers->end(), out.begin(), out.end());
  }
  Instance<Interface> instance_;
  std::unique_ptr<Formula> formula_;
  std::size_t width_;
  std::vector<double> rows_;
  std::unique_ptr<Formula::Prepared> prepared_;
};

class EstimatorExercise final : public Exercise {
 public:
  EstimatorExercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                    const std::vector<abi::ParamValue>& values)
      : bench_(bench),
        estimator_(create<Estimator>(entry, context, values)),
        formula_(formula_of(abi::Kind::estimator, estimator_.get(), entry, values)),
        rows_(driving_rows(*formula_, instants, 11)),
        prepared_(formula_->prepare(instants, rows_)) {}
  void step(std::int64_t k, Answers answers) override {
    Sample sample = bench_.sample(k);
    sample.step = k;
    sample.t = sample.at.t = static_cast<double>(k) * dt;
    sample.at_next.t = sample.t + dt;
    estimator_->update(sample);
    const Belief b = estimator_->belief();
    add(answers, {b.mu_front, b.mu_rear, b.sigma_front, b.sigma_rear});
    if (answers == nullptr)
      prepared_->run();
    else if (k % 10 == 0)
      ask(answers);
  }
  void extremes(const char*& where, Answers answers) override {
    for (std::int64_t k = 0; k < 30; ++k) step(k, answers);
    constexpr std::array<const char*, 5> names = {"after a step at standstill", "after a step in reverse",
                                                  "after a step at full lock", "after a step while spinning",
                                                  "after an unexplained step"};
    const std::array<State, 5> states = {State{}, State{.vx = -0.8, .vy = 0.02, .omega = 0.1, .delta = 0.1},
                                         State{.vx = 1.5, .vy = 0.3, .omega = 6, .delta = 0.35},
                                         State{.vx = 0.01, .vy = 0.4, .omega = 12, .delta = -0.35},
                                         State{.vx = 2, .vy = 0, .omega = 0, .delta = 0}};
    for (std::size_t i = 0; i < states.size(); ++i) {
      where = names[i];
      Sample sample = bench_.sample(30);
      sample.x = sample.x_next = states[i];
      const double jump = i + 1 == states.size() ? 40.0 : 0.0;
      sample.e_vx = -jump, sample.e_vy = jump, sample.e_omega = 20 * jump;
      estimator_->update(sample);
      ask(answers);
    }
    where = "of its correction";
    for (const double out : formula_->evaluate(edge_count, edge_rows(*formula_), {})) add(answers, {out});
    where = "of a correction of no points at all";
    formula_->evaluate_none();
    where = "of a tyre curve at no slip angles";
    estimator_->tyre_force(Axle::front, {}, {}, {});
  }
  void ask(Answers answers) const override {
    const Belief b = estimator_->belief();
    add(answers, {b.mu_front, b.mu_rear, b.sigma_front, b.sigma_rear});
    const std::array<double, 5> slip = {-0.3, -0.05, 0, 0.05, 0.3};
    for (const Axle axle : {Axle::front, Axle::rear}) {
      std::array<double, 5> force{}, sigma{};
      if (!estimator_->tyre_force(axle, slip, force, sigma)) continue;
      for (std::size_t i = 0; i < slip.size(); ++i) add(answers, {force[i], sigma[i]});
    }
    if (answers == nullptr) return;
    const std::vector<double> out = formula_->evaluate(instants, rows_, {});
    answers->insert(answers->end(), out.begin(), out.end());
  }
  const Estimator& estimator() const { return *estimator_; }

 private:
  static constexpr std::size_t instants = 8;
  Bench& bench_;
  Instance<Estimator> estimator_;
  std::unique_ptr<Formula> formula_;
  std::vector<double> rows_;
  std::unique_ptr<Formula::Prepared> prepared_;
};

/// Where a car could be on the oval: a step's share of the lap, a little off the line.
State on_road(const Bench& bench, std::int64_t k) {
  const double s = bench.course().length() * static_cast<double>(k % 450) / 450.0;
  const CoursePoint p = bench.course().at(s);
  const double n = 0.05 * std::sin(0.1 * static_cast<double>(k));
  return {.x = p.x - n * std::sin(p.yaw),
          .y = p.y + n * std::cos(p.yaw),
          .yaw = p.yaw,
          .vx = 1.0,
          .vy = 0.0,
          .omega = 1.0 * p.kappa,
          .delta = 0.062 * p.kappa};
}

struct OddPlace {
  const char* name;
  State x;
};
/// Places and motions that no plan foresees.
std::array<OddPlace, 5> odd_places(const Bench& bench) {
  std::array<OddPlace, 5> all;
  all.fill({"at standstill", on_road(bench, 40)});
  all[0].x.vx = all[0].x.omega = 0;
  all[1].name = "in reverse", all[1].x.vx = -0.8;
  all[2].name = "at full lock, spinning", all[2].x.delta = 0.35, all[2].x.omega = 12, all[2].x.vy = 0.5;
  all[3].name = "a metre off the road", all[3].x.y -= 1.0;
  all[4].name = "the wrong way round", all[4].x.yaw += std::numbers::pi;
  return all;
}

class PlannerExercise final : public Exercise {
 public:
  PlannerExercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                  const std::vector<abi::ParamValue>& values)
      : bench_(bench), planner_(create<SpeedPlanner>(entry, context, values)), horizon_(41) {}
  void step(std::int64_t k, Answers answers) override { plan(on_road(bench_, k), k, answers); }
  void extremes(const char*& where, Answers answers) override {
    for (const OddPlace& odd : odd_places(bench_)) {
      where = odd.name;
      plan(odd.x, 40, answers);
    }
    where = "for a horizon of one point";
    horizon_.resize(1);
    plan(on_road(bench_, 7), 7, answers);
    horizon_.resize(41);
  }
  void ask(Answers answers) const override {
    add(answers, {planner_->latency()});
    for (const LinePoint& p : planner_->line()) add(answers, {p.s, p.x, p.y, p.yaw, p.kappa, p.left, p.right});
  }

 private:
  void plan(const State& x, std::int64_t k, Answers answers) {
    const double mu = 0.7 + 0.2 * std::sin(0.02 * static_cast<double>(k));
    planner_->plan(bench_.observe(x, 0.2, k), {.mu_front = mu, .mu_rear = mu, .trusted = k > 100}, nullptr, horizon_);
    for (const RefPoint& r : horizon_) {
      const Place& at = r.at;
      add(answers, {r.s, r.x, r.y, r.yaw, r.kappa, r.v, r.left, r.right, r.beta});
      add(answers,
          {at.t, at.s, at.n, at.lap_fraction, at.yaw_line, at.kappa, at.grade, at.bank, at.direction, at.grip});
    }
    add(answers, {planner_->latency()});
  }
  Bench& bench_;
  Instance<SpeedPlanner> planner_;
  std::vector<RefPoint> horizon_;
};

/// A reference along the centre line at a constant speed, from where the car is.
void follow_centre(const Bench& bench, const Observation& now, double v, std::vector<RefPoint>& horizon) {
  const double length = bench.course().length();
  for (std::size_t k = 0; k < horizon.size(); ++k) {
    const double ahead = v * dt * static_cast<double>(k);
    const CoursePoint p = bench.course().at(std::fmod(now.at.s + ahead, length));
    RefPoint& r = horizon[k];
    r = {};
    r.s = ahead, r.x = p.x, r.y = p.y, r.yaw = p.yaw, r.kappa = p.kappa, r.v = v, r.left = p.left, r.right = p.right;
    r.at.t = now.t + dt * static_cast<double>(k), r.at.s = p.s, r.at.lap_fraction = p.lap_fraction;
    r.at.yaw_line = p.yaw, r.at.kappa = p.kappa;
  }
}

class ControllerExercise final : public Exercise {
 public:
  ControllerExercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                     const std::vector<abi::ParamValue>& values)
      : bench_(bench), model_(bench.fresh_nominal()), controller_(create<Controller>(entry, context, values)) {
    const int points = controller_->horizon();
    if (points < 1 || points > 10000)
      throw PluginError("wants a horizon of " + std::to_string(points) + " points, expected 1 to 10000");
    horizon_.resize(static_cast<std::size_t>(points));
  }
  void step(std::int64_t k, Answers answers) override { decide(on_road(bench_, k), k, answers); }
  void extremes(const char*& where, Answers answers) override {
    for (const OddPlace& odd : odd_places(bench_)) {
      where = odd.name;
      decide(odd.x, 40, answers);
    }
  }
  void ask(Answers answers) const override {
    add(answers, {static_cast<double>(controller_->horizon())});
    for (const State& x : controller_->predicted()) add(answers, x);
  }
  Command decide(const State& x, std::int64_t k, Answers answers) {
    const Observation now = bench_.observe(x, 0.2, k);
    follow_centre(bench_, now, 0.8, horizon_);
    const Command command = controller_->control(now, horizon_, model_);
    add(answers, {command.u.d, command.u.ddelta});
    return command;
  }

 private:
  Bench& bench_;
  CorrectedModel model_;
  Instance<Controller> controller_;
  std::vector<RefPoint> horizon_;
};

class PlantExercise final : public Exercise {
 public:
  PlantExercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                const std::vector<abi::ParamValue>& values)
      : bench_(bench), plant_(create<Plant>(entry, context, values)) {
    plant_->reset({.vx = 1.0}, bench_.ground());
  }
  void step(std::int64_t k, Answers answers) override {
    if (k % 200 == 0) plant_->reset({.vx = 1.0}, bench_.ground());
    const double t = static_cast<double>(k) * dt;
    add(answers, plant_->advance(0.2 + 0.2 * std::sin(1.3 * t), 0.1 * std::sin(2.1 * t), dt, bench_.ground()));
    add(answers, {plant_->axle_force(Axle::front), plant_->axle_force(Axle::rear)});
  }
  void extremes(const char*& where, Answers answers) override {
    struct Case {
      const char* name;
      double vx, d, delta;
    };
    for (const Case& one : {Case{"at standstill", 0, 0, 0}, Case{"in reverse", -0.8, 0, 0.1},
                            Case{"at full lock and full throttle", 1.5, 1, 0.35},
                            Case{"at full lock and full brakes", 1.5, -0.1, -0.35}}) {
      where = one.name;
      plant_->reset({.vx = one.vx}, bench_.ground());
      for (int k = 0; k < 50; ++k) add(answers, plant_->advance(one.d, one.delta, dt, bench_.ground()));
      ask(answers);
    }
  }
  void ask(Answers answers) const override {
    for (const Axle axle : {Axle::front, Axle::rear}) {
      add(answers, {plant_->mu(axle), plant_->axle_force(axle)});
      for (const double slip : {-0.3, -0.05, 0.0, 0.05, 0.3}) add(answers, {plant_->tyre_force(axle, slip)});
    }
  }

 private:
  Bench& bench_;
  Instance<Plant> plant_;
};

}  // namespace

std::unique_ptr<Exercise> make_exercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                                        const std::vector<abi::ParamValue>& values) {
  switch (entry.decl->kind) {
    case abi::Kind::vehicle:
      return std::make_unique<FormulaExercise<VehicleModel>>(entry, context, values);
    case abi::Kind::effect:
      return std::make_unique<FormulaExercise<Effect>>(entry, context, values);
    case abi::Kind::estimator:
      return std::make_unique<EstimatorExercise>(entry, bench, context, values);
    case abi::Kind::planner:
      return std::make_unique<PlannerExercise>(entry, bench, context, values);
    case abi::Kind::controller:
      return std::make_unique<ControllerExercise>(entry, bench, context, values);
    case abi::Kind::plant:
      break;
  }
  return std::make_unique<PlantExercise>(entry, bench, context, values);
}

Lap drive_lap(const PluginEntry& entry, Bench& bench, const std::vector<abi::ParamValue>& values) {
  ControllerExercise driver(entry, bench, bench.context(entry), values);
  const Car car = small_car();
  TrueCar truth;
  Lap lap;
  lap.length = bench.course().length();
  State x = on_road(bench, 0);
  x.vx = 0.5;
  double s = bench.observe(x, 0, 0).at.s;
  constexpr double enough_s = 5;
  const double begin = thread_cpu_s();
  for (; lap.covered < lap.length && lap.steps < 1200; ++lap.steps) {
    lap.cut_short = thread_cpu_s() - begin > enough_s;
    if (lap.cut_short) break;
    const Command command = driver.decide(x, lap.steps, nullptr);
    lap.unsolved += command.solved ? 0 : 1;
    const double delta = x.delta + command.u.ddelta * dt;
    lap.largest_d = std::max({lap.largest_d, command.u.d - car.d_max, car.d_min - command.u.d});
    lap.largest_ddelta = std::max(lap.largest_ddelta, std::abs(command.u.ddelta) - car.ddelta_max);
    lap.largest_delta = std::max(lap.largest_delta, std::abs(delta) - car.delta_max);
    if (!std::isfinite(command.u.d) || !std::isfinite(command.u.ddelta)) {
      lap.largest_d = lap.largest_ddelta = INFINITY;
      return lap;
    }
    Input u{std::clamp(command.u.d, car.d_min, car.d_max), 0};
    u.ddelta = (std::clamp(delta, -car.delta_max, car.delta_max) - x.delta) / dt;
    u.ddelta = std::clamp(u.ddelta, -car.ddelta_max, car.ddelta_max);
    x = truth.step(x, u);
    const Place at = bench.observe(x, u.d, lap.steps).at;
    lap.covered += std::remainder(at.s - s, lap.length);
    lap.farthest = std::max(lap.farthest, std::abs(at.n));
    s = at.s;
    if (lap.farthest > 1.0) break;
  }
  return lap;
}

Learned learn(const PluginEntry& entry, Bench& bench, const std::vector<abi::ParamValue>& values) {
  const Instance<Estimator> estimator = create<Estimator>(entry, bench.context(entry), values);
  constexpr double enough_s = 3;
  const double begin = thread_cpu_s();
  std::int64_t taught = 0;
  for (; taught < bench.samples() * 3 / 4 && thread_cpu_s() - begin < enough_s; ++taught)
    estimator->update(bench.sample(taught));
  RollingCar rolling;
  StagedCar car(rolling, RollingCar::values());
  car.add(*estimator, {}, entry.decl->id);
  CorrectedModel corrected(std::move(car), {.dt = dt, .hold = Hold::zoh, .integration = {find_tableau("rk4"), 1}});
  double before[3] = {}, after[3] = {};
  for (std::int64_t k = taught; k < taught + bench.samples() / 4; ++k) {
    const Sample sample = bench.sample(k);
    if (sample.x.vx < small_car().v_min) continue;
    const State next = corrected.advance(sample.x, sample.u, sample.at);
    const double e[] = {sample.e_vx, sample.e_vy, sample.e_omega};
    const double left[] = {(sample.x_next.vx - next.vx) / dt, (sample.x_next.vy - next.vy) / dt,
                           (sample.x_next.omega - next.omega) / dt};
    for (int c = 0; c < 3; ++c) {
      before[c] += e[c] * e[c];
      after[c] += left[c] * left[c];
    }
  }
  Learned learned;
  learned.cut_short = taught < bench.samples() * 3 / 4;
  learned.belief = estimator->belief();
  for (int c = 0; c < 3; ++c) learned.left[c] = std::sqrt(after[c] / before[c]);
  return learned;
}

}  // namespace gripline::conformance
