// Smoothing after Bryson and Frazier: the adjoint of the filter, without inverses.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "diagnose/model/linear_model.hpp"

namespace gripline::diagnose {

/// What a filter with N states keeps of its pass, and the smoothed states that follow from it.
template <std::size_t N>
class AdjointSmoother {
 public:
  explicit AdjointSmoother(const LinearModel& model) : model_(model) {}

  /// Before anything is kept.
  void reserve() {
    kept_P_.resize(model_.n * N * N);
    kept_z_.resize(model_.n * N);
    updates_.reserve(model_.n * channels);
  }
  /// For covariance and state before the first reading of sample k.
  double* covariance(std::size_t k) { return kept_P_.data() + k * N * N; }
  double* state(std::size_t k) { return kept_z_.data() + k * N; }
  /// An update by a reading of sample k with the innovation e, its variance S and the gains K. `row`: what it is read
  /// as, where that is not its row of H.
  void add(std::size_t k, std::size_t channel, double e, double S, const std::array<double, N>& K, const double* row) {
    updates_.push_back({k, channel, e, S, row != nullptr});
    if (row != nullptr) rows_.insert(rows_.end(), row, row + N);
    gains_.insert(gains_.end(), K.begin(), K.end());
  }

  /// x_s = x_f + P_f lambda with lambda running backwards through updates and predictions.
  std::vector<double> smooth() const {
    std::vector<double> smoothed(model_.n * N);
    std::array<double, N> lambda{};
    std::size_t u = updates_.size(), whole = rows_.size();
    for (std::size_t k = model_.n; k-- > 0;) {
      while (u > 0 && updates_[u - 1].k == k) {
        --u;
        const Update& one = updates_[u];
        const double* const K = gains_.data() + u * N;
        double along = 0.0;
        for (std::size_t i = 0; i < N; ++i) along += K[i] * lambda[i];
        const double push = one.e / one.S - along;
        if (one.whole_row) {
          whole -= N;
          for (std::size_t j = 0; j < N; ++j) lambda[j] += rows_[whole + j] * push;
        } else if (model_.H.empty()) {
          lambda[one.channel] += push;
        } else {
          const double* const h = model_.H.data() + (k * channels + one.channel) * channels;
          for (std::size_t j = 0; j < channels; ++j) lambda[j] += h[j] * push;
        }
      }
      for (std::size_t i = 0; i < N; ++i) {
        double sum = kept_z_[k * N + i];
        for (std::size_t j = 0; j < N; ++j) sum += kept_P_[(k * N + i) * N + j] * lambda[j];
        smoothed[k * N + i] = sum;
      }
      if (k == 0) break;
      const double* const F = model_.F.data() + (k - 1) * N * N;
      std::array<double, N> back{};
      for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j) back[j] += F[i * N + j] * lambda[i];
      lambda = back;
    }
    return smoothed;
  }

 private:
  struct Update {
    std::size_t k, channel;
    double e, S;
    bool whole_row;  // its row is among the kept ones, else that of H
  };

  const LinearModel& model_;
  std::vector<double> kept_P_, kept_z_, gains_, rows_;
  std::vector<Update> updates_;
};

}  // namespace gripline::diagnose
