// The hidden layer of an extreme learning machine over one slip angle: h_j = a_j tanh(w_j slip + b_j), input weights
// and biases drawn once from a seed and never trained, so that the output is linear in what is learned. Steep nodes are
// small, a_j ~ 1 / w_j: descent then changes the curve as a whole before it bends it locally, and what was learned at
// one slip angle carries over to the others.
// Source: Huang, Zhu, Siew, Extreme learning machine (2006); the paper's input [slip, 1].
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace gripline::learning {

/// A small reproducible generator (splitmix64): the same numbers on every platform and standard library.
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(next() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t state_;
};

class HiddenLayer {
 public:
  /// Centres -b/w within +-reach [rad], the slips a car visits; steepness w between 1.2 and 7.2 over that range.
  HiddenLayer(int nodes, double reach, SplitMix64& random) : weight_(nodes), bias_(nodes), scale_(nodes) {
    for (int j = 0; j < nodes; ++j) {
      weight_[j] = random.uniform(gentlest, steepest) / reach;
      scale_[j] = gentlest / (weight_[j] * reach * std::sqrt(nodes));
      bias_[j] = -weight_[j] * random.uniform(-reach, reach);
    }
  }

  int nodes() const { return static_cast<int>(weight_.size()); }

  /// h += factor * h(slip); the span has `nodes` elements.
  void add(double slip, double factor, std::span<double> h) const {
    for (std::size_t j = 0; j < h.size(); ++j) h[j] += factor * scale_[j] * std::tanh(weight_[j] * slip + bias_[j]);
  }
  /// h += factor * dh/dslip.
  void add_slope(double slip, double factor, std::span<double> h) const {
    for (std::size_t j = 0; j < h.size(); ++j) {
      const double t = std::tanh(weight_[j] * slip + bias_[j]);
      h[j] += factor * scale_[j] * weight_[j] * (1.0 - t * t);
    }
  }

 private:
  static constexpr double gentlest = 1.2, steepest = 7.2;
  std::vector<double> weight_, bias_, scale_;
};

}  // namespace gripline::learning
