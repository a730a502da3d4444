#include "measured/estimates/displacement_lag.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "measured/estimates/independent_blocks.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

constexpr double window = 0.5, longest = 1.2;  // [s]

struct Vector {
  double x = 0, y = 0;
};
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y}; }

/// Velocity in the world's axes, read so many samples later, and its integral from the beginning.
struct Way {
  std::vector<Vector> velocity, sum;
  std::vector<std::size_t> missing;  // of the samples before
  bool known(std::size_t from, std::size_t to) const { return missing[from] == missing[to + 1]; }
  Vector between(std::size_t from, std::size_t to) const { return sum[to] - sum[from]; }
};

class Displacements {
 public:
  explicit Displacements(const PlaneMotion& motion) : m_(motion), n_(motion.x.size()), w_(steps(window)), heading_(n_) {
    for (std::size_t k = 0; k < n_; ++k) heading_[k] = {std::cos(m_.yaw[k]), std::sin(m_.yaw[k])};
  }
  std::size_t steps(double seconds) const {
    return static_cast<std::size_t>(std::max(1.0, std::round(seconds / m_.dt)));
  }
  std::size_t size() const { return n_; }

  /// What the place moved from a sample on, what the velocity says, and how the heading turned.
  struct One {
    std::size_t sample;
    Vector moved, said, turned;
  };
  /// At a lag of so many samples.
  std::vector<One> at(long lag) const {
    const std::size_t late = late_by(lag), stride = std::max<std::size_t>(1, w_ / 5);
    const Way way = way_of(later_by(lag));
    std::vector<One> out;
    for (std::size_t k = 0; k + w_ + late < n_; k += stride) {
      const One one{k, displacement(k + late), way.between(k, k + w_), heading_[k + w_] - heading_[k]};
      if (way.known(k, k + w_) && !std::isnan(one.moved.x + one.moved.y)) out.push_back(one);
    }
    return out;
  }
  /// How what the velocity says changes with the lag against the place [m/s], from every sample on. Where the place is
  /// the late one, the velocity says so with less noise than differences of the place do.
  std::vector<Vector> changes(long lag) const {
    const Way here = way_of(later_by(lag));
    std::vector<Vector> out(n_);
    if (lag < 0) {
      for (std::size_t k = 0; k + w_ < n_; ++k) out[k] = here.velocity[k + w_] - here.velocity[k];
      return out;
    }
    const Way before = lag > 0 ? way_of(later_by(lag - 1)) : here, after = way_of(later_by(lag + 1));
    const double span = (lag > 0 ? 2.0 : 1.0) * m_.dt;
    for (std::size_t k = 0; k + w_ < n_; ++k) {
      const bool known = before.known(k, k + w_) && after.known(k, k + w_);
      const Vector change = after.between(k, k + w_) - before.between(k, k + w_);
      out[k] = known ? Vector{change.x / span, change.y / span} : Vector{not_a_number, 0};
    }
    return out;
  }

 private:
  /// Where the velocity is the later one it is read later against heading and place; else the place is the late one.
  static std::size_t later_by(long lag) { return static_cast<std::size_t>(std::max(0L, lag)); }
  static std::size_t late_by(long lag) { return static_cast<std::size_t>(std::max(0L, -lag)); }
  Vector displacement(std::size_t k) const { return {m_.x[k + w_] - m_.x[k], m_.y[k + w_] - m_.y[k]}; }
  Way way_of(std::size_t later) const {
    Way out{std::vector<Vector>(n_), std::vector<Vector>(n_), std::vector<std::size_t>(n_ + 1, 0)};
    for (std::size_t k = 0; k < n_; ++k) {
      Vector& v = out.velocity[k];
      v.x = not_a_number;
      if (k + later < n_) {
        const double vx = m_.vx[k + later], vy = m_.vy[k + later];
        v = {heading_[k].x * vx - heading_[k].y * vy, heading_[k].y * vx + heading_[k].x * vy};
      }
      const bool missing = std::isnan(v.x + v.y);
      out.missing[k + 1] = out.missing[k] + (missing ? 1 : 0);
      if (k > 0) out.sum[k] = out.sum[k - 1];
      if (k > 0 && !missing && out.missing[k - 1] == out.missing[k]) {
        out.sum[k].x += 0.5 * m_.dt * (v.x + out.velocity[k - 1].x);
        out.sum[k].y += 0.5 * m_.dt * (v.y + out.velocity[k - 1].y);
      }
    }
    return out;
  }

  const PlaneMotion& m_;
  std::size_t n_, w_;
  std::vector<Vector> heading_;
};

/// By what a lag is off, and the nuisances: scale, turn, lever ahead and to the left.
constexpr int unknowns = 5;
using Row = Eigen::Matrix<double, unknowns, 1>;
using Square = Eigen::Matrix<double, unknowns, unknowns>;

struct Sums {
  Square normal = Square::Zero();
  Row right = Row::Zero();
  double rest = 0, moved = 0, rows = 0;

  /// Without a change only the nuisances are in the sums.
  void add(const Displacements::One& one, const Vector& change = {}) {
    const Vector &said = one.said, &turned = one.turned;
    add(Row{change.x, said.x, -said.y, turned.x, -turned.y}, one.moved.x - said.x);
    add(Row{change.y, said.y, said.x, turned.y, turned.x}, one.moved.y - said.y);
    moved += one.moved.x * one.moved.x + one.moved.y * one.moved.y;
  }
  void add(const Row& row, double residual) {
    normal.noalias() += row * row.transpose();
    right += residual * row;
    rest += residual * residual;
    rows += 1;
  }
  void add(const Sums& other) {
    normal += other.normal;
    right += other.right;
    rest += other.rest;
    moved += other.moved;
    rows += other.rows;
  }
};

/// The mean square that is left with the nuisances fitted, the lag as it is.
double left_at(const Sums& all) {
  if (!(all.rows > 0)) return std::numeric_limits<double>::infinity();
  const Eigen::Matrix4d normal = all.normal.bottomRightCorner<4, 4>();
  const Eigen::Vector4d right = all.right.tail<4>();
  const Eigen::Matrix4d sure = normal + 1e-9 * Eigen::Matrix4d(normal.diagonal().asDiagonal());
  return std::max(0.0, all.rest - right.dot(sure.ldlt().solve(right))) / all.rows;
}

/// The lag of least squares, in samples. None where it is as far as lags are tried, or where a lag changes so little
/// that noise says which is the best one.
std::optional<long> best_lag(const Displacements& displacements) {
  constexpr double rises = 1.15;  // by so much, for a tenth of a second more or less
  const auto most = static_cast<long>(displacements.steps(longest)),
             beside = static_cast<long>(displacements.steps(0.1));
  std::vector<double> left;
  for (long lag = -most; lag <= most; ++lag) {
    Sums all;
    for (const Displacements::One& one : displacements.at(lag)) all.add(one);
    left.push_back(left_at(all));
  }
  const long best = std::min_element(left.begin(), left.end()) - left.begin() - most;
  const auto at = [&](long lag) { return left[static_cast<std::size_t>(lag + most)]; };
  if (!std::isfinite(at(best)) || std::abs(best) + beside > most) return std::nullopt;
  if (!(std::min(at(best - beside), at(best + beside)) > rises * at(best))) return std::nullopt;
  return best;
}

/// Sums at a lag by blocks in which there are some.
std::vector<Sums> by_blocks(const Displacements& displacements, long lag, double dt) {
  const std::size_t block = samples_of_block(dt, displacements.size());
  std::vector<Sums> blocks(displacements.size() / block + 1);
  const std::vector<Vector> changes = displacements.changes(lag);
  for (const Displacements::One& one : displacements.at(lag)) {
    const Vector& change = changes[one.sample];
    if (!std::isnan(change.x + change.y)) blocks[one.sample / block].add(one, change);
  }
  std::erase_if(blocks, [](const Sums& one) { return !(one.rows > 0); });
  return blocks;
}

}  // namespace

/// Least squares with an interval by blocks: what residuals are correlated by within one is in it.
std::optional<DisplacementLag> displacement_lag(const PlaneMotion& motion) {
  const Displacements displacements(motion);
  const std::optional<long> best = best_lag(displacements);
  if (!best) return std::nullopt;
  const std::vector<Sums> blocks = by_blocks(displacements, *best, motion.dt);
  if (blocks.size() < least_blocks) return std::nullopt;
  Sums all;
  for (const Sums& one : blocks) all.add(one);
  const Square inverse = all.normal.ldlt().solve(Square::Identity());
  const Row found = inverse * all.right;
  Square scatter = Square::Zero();
  for (const Sums& one : blocks) {
    const Row score = one.right - one.normal * found;
    scatter += score * score.transpose();
  }
  const double variance = (inverse * scatter * inverse)(0, 0);
  if (!std::isfinite(variance) || !std::isfinite(found[0])) return std::nullopt;
  return DisplacementLag{static_cast<double>(*best) * motion.dt + found[0], std::sqrt(std::max(0.0, variance)),
                         blocks.size(), all.moved > 0 ? 1.0 - all.rest / all.moved : 0.0};
}

}  // namespace gripline::measured
