// Kalman filter over a linearised model: the likelihood of a log by its innovations, its derivatives by parameters (as
// normal equations) and by the variances of the unknown accelerations.
#pragma once

#include <memory>
#include <vector>

#include "diagnose/model/linear_model.hpp"

namespace gripline::diagnose {

/// Standard deviations of throttle and steering half-way between samples from where the log has them: a recorder that
/// leaves samples out does not say what the driver did there.
struct UnknownCommands {
  Commands steady{};  // the same in every step
  Commands moving{};  // beside it, as a share of LinearModel::command_variation of the step
  bool operator==(const UnknownCommands&) const = default;
};

/// Gaussian noise: standard deviations of the six readings, variances of the three unknown accelerations.
struct Noise {
  Channels sensor{};
  std::array<double, noise_states> process{};  // [m2/s4, m2/s4, rad2/s4]
  /// Correlation of a reading's error with that of the sample before (a first-order autoregressive process), between -1
  /// and 1; 0: white.
  Channels colour{};
  UnknownCommands command;  // counts along models with LinearModel::by_command
};

/// The negative log likelihood of the innovations and its derivatives.
struct Likelihood {
  double cost = 0;       // -log p up to a constant that does not depend on the model
  std::size_t rows = 0;  // scalar readings used
  // By parameters: cost(theta) ~ cost - g' d + d' N d / 2.
  std::size_t params = 0;
  std::vector<double> g, N;        // params; params x params, row-major
  std::vector<double> block_cost;  // of blocks of consecutive samples, when asked for
  // By process variances: gradient and expected information.
  std::array<double, noise_states> noise_gradient{};
  std::array<std::array<double, noise_states>, noise_states> noise_information{};
  // Of each reading, when asked for: the innovation and its variance.
  struct Innovation {
    std::size_t channel;
    double error, variance;
  };
  std::vector<Innovation> innovations;
  // Deviations from the reference, n x states, when asked for: smoothed, and predicted from the samples before alone.
  std::vector<double> smoothed, predicted;
};

/// What a pass computes beside the likelihood. `regressors` may be null; they must outlive the call.
struct FilterOptions {
  const std::vector<const Regressor*>* regressors = nullptr;
  bool noise_gradient = false;  // derivatives by the process variances
  bool smooth = false;
  bool predict = false;  // deviations from the samples before
  bool innovations = false;
  std::size_t block = 0;    // samples per block; 0: none
  std::size_t restart = 0;  // samples after which the state starts anew, diffuse; 0: never
};

/// Throws nothing; `noise.sensor` must be positive.
Likelihood filter(const LinearModel& model, const Noise& noise, const FilterOptions& options);
/// Likelihood and normal equations for these regressors, then for `further` ones.
Likelihood filter_along(const LinearModel& model, const Noise& noise, std::span<const Regressor> regressors,
                        std::span<const Regressor> further = {});

}  // namespace gripline::diagnose
