// How much later the velocity of a car is read than its place, or earlier, by what the place moves while the velocity
// says so. A heavy car changes its speed little within the time of a lag, and differences of its place drown in noise;
// the direction of its velocity turns with every bend, and displacements of half a second are far above the noise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline::measured {

/// Channels on one even grid, NaN where nothing was read: place [m] and heading [rad], velocity in the car's axes
/// [m/s]. The heading is on time.
struct PlaneMotion {
  std::span<const double> x, y, yaw, vx, vy;
  double dt = 0;  // [s]
};

/// Sums of squares at every lag, by blocks of the log. At each lag least squares of
///   place(t + w) - place(t) = (1 + scale) R(turn) integral of velocity + lever (heading(t + w) - heading(t))
/// by the scale of the speeds, the turn of their axes and where on the car the place is read.
class DisplacementLag {
 public:
  explicit DisplacementLag(const PlaneMotion& motion);

  std::size_t blocks() const { return blocks_; }
  /// Lag with the least sum of squares when blocks count so often each [s]; positive: the velocity is later.
  /// `correlation`: of what the place moves and what the velocity says, at that lag.
  double best(std::span<const int> weight, double* correlation = nullptr) const;
  /// Whether a lag is nearer than a step to the end of those that are tried.
  bool is_at_end(double lag) const;

 private:
  static constexpr std::size_t unknowns = 4, terms = unknowns + 1;  // and the displacement itself
  struct Sums {
    double product[terms][terms] = {};  // lower half
    double moved = 0;                   // squared displacements
    double rows = 0;
    void add(const double (&row)[terms]);
    void add(const Sums& other, double weight);
    double rest() const;  // sum of squares that is left, over the rows
  };
  void add_lag(const PlaneMotion& motion, std::size_t lag, std::size_t block);

  double dt_;
  long first_ = 0;  // lag, in steps
  std::size_t blocks_ = 0, lags_ = 0;
  std::vector<Sums> sums_;  // by block and lag
};

}  // namespace gripline::measured
