// Has friction changed suddenly? A score test, the likelihood-ratio test for small changes: over the last samples, do
// the innovations correlate with the predicted forces?
//
//   score = sum e F / V,   which has the variance sum F^2 / V where nothing has changed
//
// e is the innovation of a rate, V its variance and F what the tyres are predicted to contribute to it: a scale that
// all forces share is tested for. Older samples count less and less. An alarm is a score beyond `alarm` standard
// deviations.
#pragma once

#include <algorithm>
#include <cmath>
#include <gripline/types.hpp>
#include <span>

#include "common/reference_step.hpp"

namespace gripline::elm_rls {

class SuddenChange {
 public:
  explicit SuddenChange(double alarm) : alarm_(alarm) {}

  /// Whether a sample with this side force over mass [m/s2] is tested: at small ones an offset of the steering looks
  /// like a change.
  static bool tests(double side, double mu_front, double mu_rear) {
    return !(side < tested_share * gravity * std::min(mu_front, mu_rear));
  }

  struct Rate {
    double error, variance;  // of its innovation
    double force;            // what the tyres are predicted to contribute
  };
  /// Takes in the rates of a sample, which lasts dt [s].
  void add(std::span<const Rate> rates, double dt) {
    const double kept = std::pow(memory, dt / reference_step);
    score_ *= kept;
    score_variance_ *= kept;
    for (const Rate& rate : rates) {
      score_ += rate.error * rate.force / rate.variance;
      score_variance_ += square(rate.force) / rate.variance;
    }
  }
  /// A score that is not a number is an alarm too: no later sample would mend it.
  bool alarms() const { return !(square(score_) <= square(alarm_) * score_variance_); }

  /// Friction is taken to have changed in this sample.
  void begin_change() {
    score_ = score_variance_ = 0;
    since_change_ = 0;
  }
  /// Time between two samples that follow each other [s].
  void pass(double dt) { since_change_ += dt; }
  /// Whether a change is so recent that the new friction is still being found.
  bool recent() const { return since_change_ < lasts; }
  /// What comes next does not follow the change. The score stays: behind a gap lies the same road.
  void break_sequence() { since_change_ = INFINITY; }
  void start_over() { *this = SuddenChange(alarm_); }

 private:
  static constexpr double memory = 0.9;        // share of the score kept in a reference_step of tested samples
  static constexpr double tested_share = 0.4;  // of friction: least side force of samples that are tested
  static constexpr double lasts = 0.5;         // [s] that the new friction is being found: 25 samples at 20 ms

  double alarm_;
  double score_ = 0, score_variance_ = 0;
  double since_change_ = INFINITY;  // [s] of samples
};

}  // namespace gripline::elm_rls
