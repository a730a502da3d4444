// A car as data flow: a vehicle model and effects, evaluated stage by stage, for values and derivatives alike.
#pragma once

#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <gripline/interfaces.hpp>

namespace gripline {

/// Commands as they act at one instant.
template <class T>
struct ActingCommand {
  T d, delta, delta_rate;
};

/// n instants of one car. Rows of `motion` are x, y, yaw, vx, vy, omega; rows of `memory` the effects' memories in the
/// order they were added. `params` are all parameters (StagedCar::params order); null means the stored values, for
/// T = double only.
template <class T>
struct CarBatch {
  std::size_t n = 0;
  const T* motion = nullptr;
  const ActingCommand<T>* command = nullptr;
  const T* memory = nullptr;
  const Place* at = nullptr;
  const T* params = nullptr;
  const History<T>* history = nullptr;
  T* motion_rate = nullptr;
  T* memory_rate = nullptr;
};
inline constexpr int motion_size = 6;

/// A model and its effects. Holds pointers, owns neither; the order of effects is the order of `add`.
class StagedCar {
 public:
  StagedCar(const VehicleModel& model, std::vector<double> params);

  /// Throws std::invalid_argument when the model has no such stage.
  void add(const Effect& effect, std::vector<double> params, const std::string& name);

  int memory() const { return memory_; }
  /// The longest delay at which the effects read past commands with the stored parameters [s].
  double look_back() const;
  /// Calls `use` with the delay of each effect that reads past commands with the stored parameters [s].
  template <class Use>
  void for_each_delay(const Use& use) const {
    for (const Part& part : parts_)
      if (const double delay = part.effect->look_back(std::span(params_).subspan(part.params)); delay > 0.0) use(delay);
  }

  /// All parameters: the model's, then each effect's.
  std::span<const double> params() const { return params_; }
  std::span<double> params() { return params_; }
  /// Where the parameters of effect number i (or, for -1, of the model) begin.
  std::size_t param_offset(int effect) const;
  std::size_t effects() const { return parts_.size(); }

  /// Quantities of the instants that are evaluated together: eight stay in the first-level cache.
  template <class T>
  using Scratch = std::array<Quantities<T>, 8>;

  /// Rates of every instant. Allocates nothing. Const and reentrant: scratch lives on the stack, or is the caller's,
  /// who spares its being set to zero where calls are many.
  template <class T>
  void rates(const CarBatch<T>& batch) const;
  template <class T>
  void rates(const CarBatch<T>& batch, Scratch<T>& scratch) const;

  /// Rates of the memory only, for callers that integrate it along a known motion: stages after the last effect with
  /// memory are left out, and batch.motion_rate is not written.
  void memory_rates(const CarBatch<double>& batch) const;

  /// The last stage reached, for callers that need forces or slips: q holds batch.n quantities. Those of stages that
  /// the model does not have are zero.
  template <class T>
  void quantities(const CarBatch<T>& batch, Quantities<T>* q) const;

  /// Steady memory for every instant of the batch, written to memory (n rows).
  void start_memory(const CarBatch<double>& batch, double* memory) const;

  /// Passes readings through the effects of Stage::reading. Null params: as in CarBatch.
  template <class T>
  void read(Reading<T>* readings, std::size_t n, const Place* at, const std::type_identity_t<T>* params) const;

 private:
  struct Part {
    const Effect* effect;
    std::size_t params, memory;
  };
  /// Either model stages first..last (part < 0) or one effect.
  struct Step {
    Stage first, last;
    int part;
  };
  void plan();
  template <class T>
  void run(std::span<const Step> steps, const Points<T>& chunk, const CarBatch<T>& batch, std::size_t begin) const;
  /// Runs the steps chunk by chunk: that from point `begin` on fills `quantities_at(begin)`, and `use(quantities, i)`
  /// sees point i of the batch after them.
  template <class T, class At, class Use>
  void in_chunks(std::span<const Step> steps, const CarBatch<T>& batch, const At& quantities_at, const Use& use) const;

  const VehicleModel* model_;
  std::vector<double> params_;
  std::vector<Part> parts_;
  std::vector<Step> steps_;
  std::vector<std::size_t> reading_;  // parts of Stage::reading
  std::size_t remembering_ = 0;       // steps up to the last effect that has memory
  bool lacks_stages_;                 // the model leaves quantities to be zero
  int memory_ = 0;
};

}  // namespace gripline
