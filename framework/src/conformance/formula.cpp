#include "conformance/formula.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "conformance/recorded_drive.hpp"
#include "util/numbers.hpp"

namespace gripline::conformance {
namespace {

const std::vector<std::string> quantity_names = {
    "yaw",        "vx",          "vy",         "omega",      "d",           "delta",      "delta_rate", "motor",
    "emf",        "brake",       "rolling",    "drag",       "drive_force", "m",          "Iz",         "lf",
    "lr",         "load_front",  "load_rear",  "slip_front", "slip_rear",   "peak_front", "peak_rear",  "stiff_front",
    "stiff_rear", "force_front", "force_rear", "ax",         "ay",          "aw",         "grade",      "bank"};
const std::vector<std::string> reading_names = {"x", "y", "yaw", "vx", "vy", "omega"};
constexpr std::size_t quantity_count = sizeof(Quantities<double>) / sizeof(double);
constexpr std::size_t reading_count = sizeof(Reading<double>) / sizeof(double);
constexpr std::size_t past_samples = 60;  // of commands that an effect may ask for

/// Quantities of a car in a corner, every one of them different.
Quantities<double> corner() {
  Quantities<double> q{};
  q.yaw = 0.7, q.vx = 1.8, q.vy = -0.1, q.omega = 1.2;
  q.d = 0.5, q.delta = 0.1, q.delta_rate = 0.25;
  q.motor = 0.287, q.emf = 0.0545, q.brake = 0.25, q.rolling = 0.05, q.drag = 0.0004;
  q.drive_force = 0.1, q.m = 0.041, q.Iz = 27.8e-6, q.lf = 0.029, q.lr = 0.033;
  q.load_front = 1.1, q.load_rear = 0.9;
  q.slip_front = 0.05, q.slip_rear = 0.04, q.peak_front = 0.19, q.peak_rear = 0.17, q.stiff_front = 4, q.stiff_rear = 5;
  q.force_front = 0.06, q.force_rear = 0.05;
  q.ax = 0.4, q.ay = 1.6, q.aw = -0.8, q.grade = 0.01, q.bank = -0.02;
  return q;
}

/// What a model of these stages is to fill becomes NaN: what it reads too early or leaves unfilled shows in its
/// answers. Quantities of stages that it lacks are zero, as in a race.
template <class T>
void forget(Quantities<T>& q, unsigned stages) {
  const auto set = [stages](Stage stage, auto&... members) {
    const T unfilled((stages & stage_bit(stage)) != 0 ? not_a_number : 0.0);
    ((members = unfilled), ...);
  };
  set(Stage::drive, q.motor, q.emf, q.brake, q.rolling, q.drag);
  set(Stage::load, q.drive_force, q.m, q.Iz, q.lf, q.lr, q.load_front, q.load_rear);
  set(Stage::tyre, q.slip_front, q.slip_rear, q.peak_front, q.peak_rear, q.stiff_front, q.stiff_rear);
  set(Stage::force, q.force_front, q.force_rear);
  set(Stage::body, q.ax, q.ay, q.aw, q.grade, q.bank);
}

/// The road below instant i of a call: places differ, so that a formula that reads the wrong one is seen.
Place place(std::size_t i) {
  Place at;
  at.t = 3.0 + 0.02 * static_cast<double>(i);
  at.s = 1.0 + 0.1 * static_cast<double>(i);
  at.n = 0.05;
  at.lap_fraction = 0.11 + 0.011 * static_cast<double>(i);
  at.yaw_line = 0.6;
  at.kappa = 0.4;
  at.grade = 0.01;
  at.bank = -0.02;
  return at;
}

class PluginFormula final : public Formula {
 public:
  PluginFormula(const VehicleModel* model, const Effect* effect, const PluginEntry& entry,
                const std::vector<abi::ParamValue>& values)
      : model_(model), effect_(effect), fitted_(model != nullptr || entry.decl->kind == abi::Kind::effect) {
    for (const abi::ParamValue& value : values) all_.push_back(value.number);
    for (std::size_t i = 0; fitted_ && i < values.size(); ++i) {
      if (entry.params()[i].type != abi::ParamType::number) continue;
      names_.emplace_back(entry.params()[i].name);
      numbers_.push_back(values[i].number);
      places_.push_back(i);
    }
    if (effect_ == nullptr) return;
    reading_ = effect_->stage() == Stage::reading;
    memory_ = static_cast<std::size_t>(effect_->memory());
    past_ = effect_->look_back(all_) > 0 ? past_samples : 0;
  }

  std::vector<std::string> inputs() const override {
    std::vector<std::string> all = reading_ ? reading_names : quantity_names;
    for (std::size_t i = 0; i < memory_; ++i) all.push_back("memory " + std::to_string(i));
    return all;
  }
  std::vector<std::string> outputs() const override {
    std::vector<std::string> all = reading_ ? reading_names : quantity_names;
    for (std::size_t i = 0; i < memory_; ++i) all.push_back("rate of memory " + std::to_string(i));
    return all;
  }
  const std::vector<std::string>& params() const override { return names_; }
  const std::vector<double>& values() const override { return numbers_; }
  std::vector<double> evaluate(std::size_t n, const std::vector<double>& rows, const std::vector<double>& params,
                               std::size_t first) const override {
    return run(n, rows, params, first);
  }
  std::vector<Dual8> evaluate(std::size_t n, const std::vector<Dual8>& rows, const std::vector<Dual8>& params,
                              std::size_t first) const override {
    return run(n, rows, params, first);
  }
  std::unique_ptr<Prepared> prepare(std::size_t n, const std::vector<double>& rows) const override {
    return std::make_unique<PreparedCall>(*this, n, rows);
  }
  void evaluate_none() const override {
    Batch<double> plain;
    load(plain, 1, driving_rows(*this, 1, 3), numbers_, 0);
    plain.points.n = 0;
    call(plain.points);
    Batch<Dual8> dual;
    const std::vector<double> row = driving_rows(*this, 1, 3);
    load<Dual8>(dual, 1, {row.begin(), row.end()}, {numbers_.begin(), numbers_.end()}, 0);
    dual.points.n = 0;
    call(dual.points);
  }

 private:
  /// The arrays of one call.
  template <class T>
  struct Batch {
    std::vector<Quantities<T>> q;
    std::vector<Reading<T>> readings;
    std::vector<T> memory, rates, params;
    std::vector<Place> at;
    std::vector<CommandSample<T>> past;
    std::vector<History<T>> history;
    Points<T> points;
  };
  class PreparedCall final : public Prepared {
   public:
    PreparedCall(const PluginFormula& formula, std::size_t n, const std::vector<double>& rows)
        : formula_(formula), rows_(rows), dual_rows_(rows.begin(), rows.end()) {
      formula_.load(plain_, n, rows_, formula_.numbers_, 0);
      formula_.load(dual_, n, dual_rows_, {formula_.numbers_.begin(), formula_.numbers_.end()}, 0);
    }
    void run() override {
      formula_.refill(plain_, rows_);
      formula_.call(plain_.points);
      formula_.refill(dual_, dual_rows_);
      formula_.call(dual_.points);
    }

   private:
    const PluginFormula& formula_;
    std::vector<double> rows_;
    std::vector<Dual8> dual_rows_;
    Batch<double> plain_;
    Batch<Dual8> dual_;
  };

  std::size_t width() const { return reading_ ? reading_count : quantity_count; }
  template <class T>
  void call(const Points<T>& points) const {
    if (model_ != nullptr)
      model_->evaluate(Stage::command, Stage::body, points);
    else
      effect_->apply(points);
  }
  /// What a call changes, from the rows.
  template <class T>
  void refill(Batch<T>& batch, const std::vector<T>& rows) const {
    const std::size_t row = width() + memory_;
    for (std::size_t i = 0; i < batch.points.n; ++i) {
      T* const into = reading_ ? reinterpret_cast<T*>(&batch.readings[i]) : reinterpret_cast<T*>(&batch.q[i]);
      for (std::size_t j = 0; j < width(); ++j) into[j] = rows[i * row + j];
      if (model_ != nullptr) forget(batch.q[i], model_->stages());
      for (std::size_t j = 0; j < memory_; ++j) batch.memory[i * memory_ + j] = rows[i * row + width() + j];
    }
  }
  template <class T>
  void load_past(Batch<T>& batch, std::size_t first) const {
    const std::size_t n = batch.points.n;
    batch.past.resize(n * past_);
    if (past_ > 0) batch.history.resize(n);
    for (std::size_t i = 0; i < batch.history.size(); ++i) {
      for (std::size_t j = 0; j < past_; ++j) {
        const double t = static_cast<double>(j) * dt, shift = 0.1 * static_cast<double>(first + i);
        batch.past[i * past_ + j] = {T(0.4 + 0.3 * std::sin(3 * t)), T(0.2 * std::sin(5 * t + shift))};
      }
      batch.history[i] = {batch.past.data() + i * past_, past_, 0.0, dt, dt * past_samples - 1.3 * dt, Hold::foh};
    }
  }
  template <class T>
  void load(Batch<T>& batch, std::size_t n, const std::vector<T>& rows, const std::vector<T>& params,
            std::size_t first) const {
    Points<T>& points = batch.points;
    points.n = n;
    batch.q.resize(reading_ ? 0 : n);
    batch.readings.resize(reading_ ? n : 0);
    batch.memory.resize(n * memory_);
    batch.rates.resize(n * memory_);
    batch.params.assign(all_.begin(), all_.end());
    for (std::size_t i = 0; i < params.size(); ++i) batch.params[places_[i]] = params[i];
    for (std::size_t i = 0; i < n; ++i) batch.at.push_back(place(first + i));
    load_past(batch, first);
    refill(batch, rows);
    points.at = batch.at.data();
    points.params = batch.params.data();
    points.q = reading_ ? nullptr : batch.q.data();
    points.reading = reading_ ? batch.readings.data() : nullptr;
    points.memory = memory_ > 0 ? batch.memory.data() : nullptr;
    points.memory_rate = memory_ > 0 ? batch.rates.data() : nullptr;
    points.memory_stride = memory_;
    points.history = past_ > 0 ? batch.history.data() : nullptr;
  }
  template <class T>
  std::vector<T> run(std::size_t n, const std::vector<T>& rows, const std::vector<T>& params, std::size_t first) const {
    Batch<T> batch;
    load(batch, n, rows, params, first);
    call(batch.points);
    std::vector<T> out;
    out.reserve(n * (width() + memory_));
    for (std::size_t i = 0; i < n; ++i) {
      const T* const from =
          reading_ ? reinterpret_cast<const T*>(&batch.readings[i]) : reinterpret_cast<const T*>(&batch.q[i]);
      out.insert(out.end(), from, from + width());
      out.insert(out.end(), batch.rates.begin() + static_cast<std::ptrdiff_t>(i * memory_),
                 batch.rates.begin() + static_cast<std::ptrdiff_t>((i + 1) * memory_));
    }
    return out;
  }

  const VehicleModel* model_;
  const Effect* effect_;
  bool fitted_, reading_ = false;
  std::size_t memory_ = 0, past_ = 0;
  std::vector<double> all_, numbers_;
  std::vector<std::string> names_;
  std::vector<std::size_t> places_;
};

/// One instant's numbers from its seven first and the corner's.
std::vector<double> row_of(const Formula& formula, const std::array<double, 7>& first) {
  const std::vector<std::string> names = formula.inputs();
  std::vector<double> row(names.size(), 0.03);  // memory
  if (names.front() == "x") {
    const double readings[] = {1, 2, first[0], first[1], first[2], first[3]};
    std::copy(std::begin(readings), std::end(readings), row.begin());
    return row;
  }
  const Quantities<double> q = corner();
  std::memcpy(row.data(), &q, sizeof q);
  std::copy(first.begin(), first.end(), row.begin());
  return row;
}

/// Derivatives of one instant by one variable against differences of several steps and sides, so that a point without a
/// derivative nearby is no failure.
class DerivativeCheck {
 public:
  DerivativeCheck(const Formula& formula, std::vector<double> row)
      : formula_(formula),
        row_(std::move(row)),
        values_(formula.values()),
        base_(formula.evaluate(1, row_, values_)),
        inputs_(formula.inputs()),
        outputs_(formula.outputs()) {}

  std::string problem() {
    for (std::size_t first = 0; first < row_.size() + values_.size(); first += 8) {
      std::vector<Dual8> row(row_.begin(), row_.end()), values(values_.begin(), values_.end());
      for (std::size_t k = 0; k < 8 && first + k < row.size() + values.size(); ++k)
        (first + k < row.size() ? row[first + k] : values[first + k - row.size()]).d[k] = 1.0;
      const std::vector<Dual8> exact = formula_.evaluate(1, row, values);
      for (std::size_t i = 0; i < base_.size(); ++i)
        if (!(std::abs(exact[i].v - base_[i]) <= 1e-9 * (1 + std::abs(base_[i]))))
          return outputs_[i] + " is " + significant(base_[i], 4) + " for double and " + significant(exact[i].v, 4) +
                 " for Dual8: both are to be the same formula";
      for (std::size_t k = 0; k < 8 && first + k < row.size() + values.size(); ++k)
        if (std::string found = compare(first + k, exact, k); !found.empty()) return found;
    }
    return {};
  }

 private:
  std::vector<double> moved(std::size_t variable, double by) const {
    std::vector<double> row = row_, values = values_;
    (variable < row.size() ? row[variable] : values[variable - row.size()]) += by;
    return formula_.evaluate(1, row, values);
  }
  std::string compare(std::size_t variable, const std::vector<Dual8>& exact, std::size_t k) const {
    const double at = variable < row_.size() ? row_[variable] : values_[variable - row_.size()];
    const double h = 1e-5 * std::max(1e-3, std::abs(at));
    const std::vector<double> up = moved(variable, h), down = moved(variable, -h), up2 = moved(variable, h / 8),
                              down2 = moved(variable, -h / 8);
    for (std::size_t i = 0; i < base_.size(); ++i) {
      const double found = exact[i].d[k];
      const std::array slopes{(up[i] - down[i]) / (2 * h), (up[i] - base_[i]) / h, (base_[i] - down[i]) / h,
                              4 * (up2[i] - down2[i]) / h};
      const double noise = 1e-13 * (1 + std::abs(base_[i])) / h;
      const auto agrees = [&](double slope) {
        return std::abs(found - slope) <= 1e-4 * std::abs(slope) + 1e-7 * (1 + std::abs(base_[i])) + 10 * noise;
      };
      if (std::none_of(slopes.begin(), slopes.end(), agrees))
        return "d " + outputs_[i] + " / d " + name(variable) + " is " + significant(found, 4) + ", differences say " +
               significant(slopes[0], 4) + ": no double between, no value() in the formula";
    }
    return {};
  }
  std::string name(std::size_t variable) const {
    return variable < inputs_.size() ? inputs_[variable] : formula_.params()[variable - inputs_.size()];
  }

  const Formula& formula_;
  std::vector<double> row_, values_, base_;
  std::vector<std::string> inputs_, outputs_;
};

constexpr std::array<std::array<double, 7>, edge_count> edges = {{{0.3, 0, 0, 0, 0, 0, 0},
                                                                  {0.3, -0.8, 0.02, 0.1, -0.1, 0.1, 0},
                                                                  {0.3, 1.5, 0.3, 6, 0.3, 0.35, 5},
                                                                  {0.3, 0.01, 0.4, 12, 0.2, -0.35, -5},
                                                                  {0.3, 0, 1.2, 0.5, 1, 0.35, 0},
                                                                  {900.3, 3.5, 0, 0, 1, 0, 0}}};

}  // namespace

std::unique_ptr<Formula> formula_of(abi::Kind kind, const void* instance, const PluginEntry& entry,
                                    const std::vector<abi::ParamValue>& values) {
  const VehicleModel* const model = kind == abi::Kind::vehicle ? static_cast<const VehicleModel*>(instance) : nullptr;
  const Effect* const effect = kind == abi::Kind::effect      ? static_cast<const Effect*>(instance)
                               : kind == abi::Kind::estimator ? static_cast<const Estimator*>(instance)
                                                              : nullptr;
  return std::make_unique<PluginFormula>(model, effect, entry, values);
}

std::vector<double> driving_rows(const Formula& formula, std::size_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::vector<double> rows;
  for (std::size_t i = 0; i < n; ++i) {
    const double vx = uniform(0.5, 3), vy = uniform(-0.4, 0.4), omega = uniform(-6, 6), d = uniform(-0.1, 1);
    const double delta = uniform(-0.3, 0.3), rate = uniform(-4, 4);
    const std::vector<double> row = row_of(formula, {uniform(-3, 3), vx, vy, omega, d, delta, rate});
    rows.insert(rows.end(), row.begin(), row.end());
  }
  return rows;
}

std::vector<double> edge_rows(const Formula& formula) {
  std::vector<double> rows;
  for (const auto& edge : edges) {
    const std::vector<double> row = row_of(formula, edge);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  return rows;
}

const char* edge_name(std::size_t row) {
  constexpr std::array names = {"at standstill",   "in reverse",       "at full lock",
                                "nearly spinning", "sliding sideways", "at 3.5 m/s after 143 turns"};
  return names.at(row);
}

std::string batch_problem(const Formula& formula) {
  constexpr std::size_t instants = 17;
  const std::vector<double> rows = driving_rows(formula, instants, 5);
  const std::size_t width = formula.inputs().size();
  const std::vector<std::string> outputs = formula.outputs();
  const std::vector<double> together = formula.evaluate(instants, rows, formula.values());
  for (std::size_t i = 0; i < instants; ++i) {
    const auto from = rows.begin() + static_cast<std::ptrdiff_t>(i * width);
    const std::vector<double> alone =
        formula.evaluate(1, {from, from + static_cast<std::ptrdiff_t>(width)}, formula.values(), i);
    for (std::size_t j = 0; j < outputs.size(); ++j) {
      const double a = together[i * outputs.size() + j], b = alone[j];
      if (!(std::abs(a - b) <= 1e-12 * (1 + std::abs(b))))
        return outputs[j] + " of point " + std::to_string(i) + " is " + significant(a, 4) + " among " +
               std::to_string(instants) + " points and " + significant(b, 4) + " alone";
    }
  }
  return {};
}

std::string derivative_problem(const Formula& formula) {
  constexpr std::size_t instants = 12;
  const std::vector<double> rows = driving_rows(formula, instants, 7);
  const std::size_t width = formula.inputs().size();
  for (std::size_t i = 0; i < instants; ++i) {
    const auto from = rows.begin() + static_cast<std::ptrdiff_t>(i * width);
    if (std::string found = DerivativeCheck(formula, {from, from + static_cast<std::ptrdiff_t>(width)}).problem();
        !found.empty())
      return found;
  }
  return {};
}

}  // namespace gripline::conformance
