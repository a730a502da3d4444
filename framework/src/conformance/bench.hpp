// The small world in which plugins are asked: an oval road, the 1:43 car, its nominal model, a drive on record.
#pragma once

#include <filesystem>
#include <string>

#include "car/corrected_model.hpp"
#include "conformance/models.hpp"
#include "conformance/recorded_drive.hpp"
#include "geometry/course_adapter.hpp"
#include "plugin/registry.hpp"

namespace gripline::conformance {

/// Straights of 2 m, bends of 0.8 m to the left, 0.3 m to either edge: 9.03 m.
Track oval();

/// What is true of the car on record.
class RecordedTruth final : public Truth {
 public:
  double factor() const override { return 1.0; }
  double mu(Axle axle) const override;
  double tyre_force(Axle axle, double slip) const override { return car_.force(axle, slip); }
  bool accelerations(const Points<double>& points) const override { return fill(points); }
  bool accelerations(const Points<Dual8>& points) const override { return fill(points); }

 private:
  template <class T>
  static bool fill(const Points<T>& points) {
    for (std::size_t i = 0; i < points.n; ++i) {
      true_accelerations(points.q[i]);
      points.q[i].grade = T(points.at[i].grade);
      points.q[i].bank = T(points.at[i].bank);
    }
    return true;
  }
  TrueCar car_;
};

/// Level ground of friction 1.
class LevelGround final : public Ground {
 public:
  Patch at(double, double, double) const override { return {}; }
};

class Bench {
 public:
  /// `cache_dir`: where planners may keep expensive results between the processes of one call; empty: none.
  explicit Bench(std::string cache_dir = {});
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// What a plugin of this kind is given in a race. Truth only where the plugin declares that it needs it, unless
  /// `always_truth`.
  PluginContext context(const PluginEntry& entry, bool always_truth = false);
  CorrectedModel& nominal() { return nominal_; }
  /// A nominal model of its own: memory and past commands belong to whoever drives.
  CorrectedModel fresh_nominal() const;
  const Track& track() const { return track_; }
  const Course& course() const { return course_; }
  const Ground& ground() const { return ground_; }
  const Drive& drive() const { return drive_; }
  /// One step of the drive on record as the stack saw it; k counts on over its end, from the start again.
  Sample sample(std::int64_t k) const { return samples_[static_cast<std::size_t>(k) % samples_.size()]; }
  std::int64_t samples() const { return static_cast<std::int64_t>(samples_.size()); }
  /// What a stack sees of a car in this state.
  Observation observe(const State& x, double d, std::int64_t step) const;

 private:
  std::string cache_dir_;
  Track track_;
  TrackCourse course_;
  RollingCar rolling_;
  CorrectedModel nominal_;
  RecordedTruth truth_;
  LevelGround ground_;
  Drive drive_;
  std::vector<Sample> samples_;
};

/// Nominal values of a plugin's declared parameters: its defaults, of those that `diagnose` fits the start of a fit.
std::vector<abi::ParamValue> nominal_values(const PluginEntry& entry);

}  // namespace gripline::conformance
