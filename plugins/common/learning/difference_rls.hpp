// Recursive least squares on rates that are differences of noisy readings.
//
//   y_k = (z_{k+1} - z_k) / dt = row_k theta + (n_{k+1} - n_k) / dt + w_k
//
// n is the sensor's noise: it enters two neighbouring rates with opposite signs, so that treating them as independent
// would lose most of the information in a run of samples. The noise of the newest reading is therefore an unknown
// beside theta; two slots per channel take turns as the older and the newer one. w is what the equations leave out. The
// gain is the Kalman gain, forgetting is whatever the caller adds to the covariance between steps.
//
// Source: Anderson, Moore, Optimal Filtering (1979), section 11.1 (coloured measurement noise by augmentation).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gripline::learning {

class DifferenceRls {
 public:
  DifferenceRls(Eigen::Index unknowns, Eigen::Index channels) : unknowns_(unknowns), channels_(channels) {
    const Eigen::Index size = unknowns + 2 * channels;
    covariance_.setZero(size, size);
    row_.setZero(size);
    gain_.setZero(size);
    estimate_.setZero(size);
  }

  auto theta() { return estimate_.head(unknowns_); }
  auto theta() const { return estimate_.head(unknowns_); }
  auto covariance() { return covariance_.topLeftCorner(unknowns_, unknowns_); }
  auto covariance() const { return covariance_.topLeftCorner(unknowns_, unknowns_); }

  /// Starts over: the unknowns' covariance, no memory of readings.
  void reset_covariance(const Eigen::MatrixXd& covariance) {
    covariance_.setZero();
    covariance_.topLeftCorner(unknowns_, unknowns_) = covariance;
  }
  /// Estimated noise of the newest reading of a channel.
  double noise(int channel) const { return estimate_[slot(channel, parity_)]; }

  /// Forgets the noise of the last reading: the next step does not continue the previous one. `sigma` per channel.
  void break_sequence(const double* sigma) {
    for (Eigen::Index c = 0; c < channels_; ++c) fresh_slot(slot(c, parity_), sigma[c]);
  }
  /// Begins a step: the newer noise of the last step becomes the older one, a new one is drawn.
  void begin_step(const double* sigma) {
    parity_ ^= 1;
    for (Eigen::Index c = 0; c < channels_; ++c) fresh_slot(slot(c, parity_), sigma[c]);
  }
  /// Within a step: resets the noise estimate of the older reading, as break_sequence() does. While the unknowns change
  /// faster than their covariance says, the readings' noise is made to account for it, and more so in every step.
  void reset_older_noise(const double* sigma) {
    for (Eigen::Index c = 0; c < channels_; ++c) fresh_slot(slot(c, parity_ ^ 1), sigma[c]);
  }

  struct Innovation {
    double error, variance;
  };
  /// Error of the prediction of rate y in this channel, and its variance. `regressor` has `unknowns` entries.
  template <class Row>
  Innovation innovation(int channel, const Row& regressor, double y, double dt, double model_sigma) {
    row_.setZero();
    row_.head(unknowns_) = regressor;
    row_[slot(channel, parity_)] = 1.0 / dt;
    row_[slot(channel, parity_ ^ 1)] = -1.0 / dt;
    gain_.noalias() = covariance_ * row_;
    return {y - row_.dot(estimate_), row_.dot(gain_) + model_sigma * model_sigma};
  }
  /// Takes in the rate of the last call of innovation().
  void update(const Innovation& innovation) {
    estimate_ += gain_ * (innovation.error / innovation.variance);
    covariance_.noalias() -= (gain_ / innovation.variance) * gain_.transpose();
  }

 private:
  Eigen::Index slot(Eigen::Index channel, int parity) const { return unknowns_ + 2 * channel + parity; }
  void fresh_slot(Eigen::Index i, double sigma) {
    covariance_.row(i).setZero();
    covariance_.col(i).setZero();
    covariance_(i, i) = sigma * sigma;
    estimate_[i] = 0;
  }

  Eigen::Index unknowns_, channels_;
  int parity_ = 0;
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd row_, gain_, estimate_;
};

}  // namespace gripline::learning
