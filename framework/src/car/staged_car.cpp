#include "car/staged_car.hpp"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cmath>

namespace gripline {
namespace {

constexpr std::size_t chunk_size = std::tuple_size_v<StagedCar::Scratch<double>>;
constexpr const char* stage_names[] = {"command", "drive", "load", "tyre", "force", "body", "reading"};

/// Stages that fill quantities which nobody else does: those of Stage::command are given.
constexpr unsigned filling_stages = stage_bit(Stage::drive) | stage_bit(Stage::load) | stage_bit(Stage::tyre) |
                                    stage_bit(Stage::force) | stage_bit(Stage::body);

/// What is given of one point. `clear`: what no stage will fill is zero, not what lay in memory.
template <class T>
void begin_point(Quantities<T>& q, const T* motion, const ActingCommand<T>& command, bool clear) {
  if (clear) q = Quantities<T>{};
  q.yaw = motion[2];
  q.vx = motion[3];
  q.vy = motion[4];
  q.omega = motion[5];
  q.d = command.d;
  q.delta = command.delta;
  q.delta_rate = command.delta_rate;
}

/// sin(a) without the call on flat ground: at zero the sine is its argument, derivatives included.
template <class T>
T sine_of_slope(const T& a) {
  using std::sin;
  return a < 0.0 || a > 0.0 ? sin(a) : a;
}

/// x' = vx cos(yaw) - vy sin(yaw), y' = vx sin(yaw) + vy cos(yaw), yaw' = omega, and the slope in the body rates.
template <class T>
void write_rates(const Quantities<T>& q, T* rate) {
  const auto [s, c] = sine_cosine(q.yaw);
  rate[0] = q.vx * c - q.vy * s;
  rate[1] = q.vx * s + q.vy * c;
  rate[2] = q.omega;
  rate[3] = q.ax - gravity * sine_of_slope(q.grade);
  rate[4] = q.ay + gravity * sine_of_slope(q.bank);
  rate[5] = q.aw;
}

template <class T>
const T* effective_params(const CarBatch<T>& batch, const std::vector<double>& stored) {
  if constexpr (std::is_same_v<T, double>) {
    if (batch.params == nullptr) return stored.data();
  }
  return batch.params;
}

}  // namespace

StagedCar::StagedCar(const VehicleModel& model, std::vector<double> params)
    : model_(&model), params_(std::move(params)), lacks_stages_((model.stages() & filling_stages) != filling_stages) {
  plan();
}

void StagedCar::add(const Effect& effect, std::vector<double> params, const std::string& name) {
  const Stage stage = effect.stage();
  if ((model_->stages() & stage_bit(stage)) == 0)
    throw std::invalid_argument("effect \"" + name + "\" acts on the " + stage_names[static_cast<int>(stage)] +
                                " stage, which this model does not have");
  if (stage == Stage::reading && effect.memory() > 0)
    throw std::invalid_argument("effect \"" + name + "\" has memory, which an effect of the reading stage cannot have");
  parts_.push_back({&effect, params_.size(), static_cast<std::size_t>(memory_)});
  params_.insert(params_.end(), params.begin(), params.end());
  memory_ += effect.memory();
  plan();
}

/// Merges consecutive model stages between effects into one call each.
void StagedCar::plan() {
  steps_.clear();
  reading_.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].effect->stage() == Stage::reading) reading_.push_back(i);
  Stage from = Stage::command;
  for (int s = 0; s < static_cast<int>(Stage::reading); ++s) {
    const Stage stage = static_cast<Stage>(s);
    bool model_called = false;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (parts_[i].effect->stage() != stage) continue;
      if (!model_called) steps_.push_back({from, stage, -1});
      model_called = true;
      steps_.push_back({stage, stage, static_cast<int>(i)});
    }
    if (model_called) from = static_cast<Stage>(s + 1);
  }
  if (from <= Stage::body) steps_.push_back({from, Stage::body, -1});
  remembering_ = 0;
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (steps_[i].part >= 0 && parts_[static_cast<std::size_t>(steps_[i].part)].effect->memory() > 0)
      remembering_ = i + 1;
}

double StagedCar::look_back() const {
  double longest = 0.0;
  for_each_delay([&](double delay) { longest = std::max(longest, delay); });
  return longest;
}

std::size_t StagedCar::param_offset(int effect) const {
  return effect < 0 ? 0 : parts_.at(static_cast<std::size_t>(effect)).params;
}

template <class T>
void StagedCar::run(std::span<const Step> steps, const Points<T>& chunk, const CarBatch<T>& batch,
                    std::size_t begin) const {
  const auto stride = static_cast<std::size_t>(memory_);
  for (const Step& step : steps) {
    Points<T> points = chunk;
    if (step.part < 0) {
      model_->evaluate(step.first, step.last, points);
      continue;
    }
    const Part& part = parts_[static_cast<std::size_t>(step.part)];
    points.params = chunk.params + part.params;
    points.memory_stride = stride;
    if (batch.memory != nullptr) points.memory = batch.memory + begin * stride + part.memory;
    if (batch.memory_rate != nullptr) points.memory_rate = batch.memory_rate + begin * stride + part.memory;
    if (batch.history != nullptr) points.history = batch.history + begin;
    part.effect->apply(points);
  }
}

template <class T, class At, class Use>
void StagedCar::in_chunks(std::span<const Step> steps, const CarBatch<T>& batch, const At& quantities_at,
                          const Use& use) const {
  const T* const params = effective_params(batch, params_);
  for (std::size_t begin = 0; begin < batch.n; begin += chunk_size) {
    const std::size_t n = std::min(chunk_size, batch.n - begin);
    Quantities<T>* const q = quantities_at(begin);
    for (std::size_t i = 0; i < n; ++i)
      begin_point(q[i], batch.motion + (begin + i) * motion_size, batch.command[begin + i], lacks_stages_);
    Points<T> chunk;
    chunk.n = n;
    chunk.q = q;
    chunk.at = batch.at + begin;
    chunk.params = params;
    run<T>(steps, chunk, batch, begin);
    for (std::size_t i = 0; i < n; ++i) use(q[i], begin + i);
  }
}

template <class T>
void StagedCar::rates(const CarBatch<T>& batch) const {
  Scratch<T> scratch;
  rates(batch, scratch);
}

template <class T>
void StagedCar::rates(const CarBatch<T>& batch, Scratch<T>& scratch) const {
  in_chunks(
      std::span<const Step>(steps_), batch, [&](std::size_t) { return scratch.data(); },
      [&](const Quantities<T>& q, std::size_t i) { write_rates(q, batch.motion_rate + i * motion_size); });
}

void StagedCar::memory_rates(const CarBatch<double>& batch) const {
  Scratch<double> scratch;
  in_chunks(
      std::span<const Step>(steps_).first(remembering_), batch, [&](std::size_t) { return scratch.data(); },
      [](const Quantities<double>&, std::size_t) {});
}

template <class T>
void StagedCar::quantities(const CarBatch<T>& batch, Quantities<T>* q) const {
  in_chunks(
      std::span<const Step>(steps_), batch, [&](std::size_t begin) { return q + begin; },
      [](const Quantities<T>&, std::size_t) {});
}

void StagedCar::start_memory(const CarBatch<double>& batch, double* memory) const {
  boost::container::small_vector<double, 16> unused(static_cast<std::size_t>(memory_));
  for (std::size_t i = 0; i < batch.n; ++i) {
    Quantities<double> q;
    begin_point(q, batch.motion + i * motion_size, batch.command[i], true);
    double* const row = memory + i * static_cast<std::size_t>(memory_);
    for (const Step& step : std::span(steps_).first(remembering_)) {
      Points<double> points;
      points.n = 1;
      points.q = &q;
      points.at = batch.at + i;
      points.params = effective_params(batch, params_);
      if (batch.history != nullptr) points.history = batch.history + i;
      if (step.part < 0) {
        model_->evaluate(step.first, step.last, points);
        continue;
      }
      const Part& part = parts_[static_cast<std::size_t>(step.part)];
      points.params += part.params;
      points.memory_stride = static_cast<std::size_t>(memory_);
      std::fill_n(row + part.memory, part.effect->memory(), 0.0);
      if (part.effect->memory() > 0) part.effect->start_memory(points, row + part.memory);
      points.memory = row + part.memory;
      points.memory_rate = unused.data();
      part.effect->apply(points);
    }
  }
}

template <class T>
void StagedCar::read(Reading<T>* readings, std::size_t n, const Place* at,
                     const std::type_identity_t<T>* params) const {
  for (const std::size_t i : reading_) {
    const Part& part = parts_[i];
    Points<T> points;
    points.n = n;
    points.reading = readings;
    points.at = at;
    if constexpr (std::is_same_v<T, double>)
      points.params = (params != nullptr ? params : params_.data()) + part.params;
    else
      points.params = params + part.params;
    part.effect->apply(points);
  }
}

template void StagedCar::rates(const CarBatch<double>&) const;
template void StagedCar::rates(const CarBatch<Dual8>&) const;
template void StagedCar::rates(const CarBatch<double>&, Scratch<double>&) const;
template void StagedCar::rates(const CarBatch<Dual8>&, Scratch<Dual8>&) const;
template void StagedCar::quantities(const CarBatch<double>&, Quantities<double>*) const;
template void StagedCar::quantities(const CarBatch<Dual8>&, Quantities<Dual8>*) const;
template void StagedCar::read(Reading<double>*, std::size_t, const Place*, const double*) const;
template void StagedCar::read(Reading<Dual8>*, std::size_t, const Place*, const Dual8*) const;

}  // namespace gripline
