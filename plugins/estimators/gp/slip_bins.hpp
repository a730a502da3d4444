// Forces of an axle by its slip, for the friction that `gp_own_mu` believes in.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace gripline::gp {

/// The friction of one axle from its forces: bins of slip hold the mean force relative to a common scale, and the
/// newest samples set the scale. So forces at large slips count on, scaled to the present friction, while the car
/// drives with small ones. With mu from the window alone a slower car would show smaller slips and so an even smaller
/// mu. A force that opposes the slip has no information on mu: the slip is small and noisy, or it has just changed
/// sign. Left in, such samples would make bins whose mean is near zero or below, against which every other sample is
/// off.
class SlipBins {
 public:
  /// Slip angle [rad] and lateral force [N] of a sample, both positive to the left.
  void add(double slip, double force) {
    const int i = static_cast<int>(std::abs(slip) / width);
    const double size = slip < 0 ? -force : force;
    if (i >= bins || std::abs(slip) < smallest || !(size > 0)) return;
    Bin& bin = bins_[i];
    if (bin.count >= fewest) {
      const double ratio = std::clamp(size / (scale_ * bin.force), 0.5, 2.0);
      spread_ += scale_gain * ((ratio - 1) * (ratio - 1) - spread_);
      scale_ *= 1 + scale_gain * (ratio - 1);
    }
    bin.count = std::min(bin.count + 1, bin_memory);
    bin.force += (size / scale_ - bin.force) / bin.count;
  }
  /// Largest force [N] at the present scale; 0 before any bin has enough samples.
  double peak() const {
    double best = 0;
    for (const Bin& bin : bins_)
      if (bin.count >= fewest) best = std::max(best, bin.force);
    return scale_ * best;
  }
  /// Its standard deviation [N].
  double deviation() const { return peak() * std::sqrt(spread_); }

 private:
  static constexpr int bins = 12;
  static constexpr double width = 0.05;       // [rad]; the last bin ends at the 0.6 rad of the paper
  static constexpr double smallest = 0.05;    // [rad]: below, the error of the slip dominates the force
  static constexpr double scale_gain = 0.05;  // per sample
  static constexpr int fewest = 3, bin_memory = 200;

  struct Bin {
    int count = 0;
    double force = 0;  // mean over the scale; positive once there is a sample
  };
  std::array<Bin, bins> bins_ = {};
  double scale_ = 1, spread_ = 0;
};

}  // namespace gripline::gp
