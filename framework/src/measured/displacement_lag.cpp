#include "measured/displacement_lag.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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
  Vector change(std::size_t from, std::size_t to) const { return velocity[to] - velocity[from]; }
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

  /// By what a lag is off, and the nuisances: scale, turn, lever ahead and to the left.
  static constexpr int unknowns = 5;
  using Row = Eigen::Matrix<double, unknowns, 1>;

  /// Calls use(sample, row, residual) for both components of every displacement, at a lag of so many samples: what the
  /// place moved beyond what the velocity says.
  template <class Use>
  void at(long lag, const Use& use) const {
    const auto later = static_cast<std::size_t>(std::max(0L, lag)), late = static_cast<std::size_t>(std::max(0L, -lag));
    const Way way = way_of(later);
    // How the way changes with the lag of a velocity that is later; of a place that is late its displacement does, and
    // the velocity says how with less noise than its differences.
    const bool of_way = lag >= 0;
    const Way before = of_way && later > 0 ? way_of(later - 1) : way, after = of_way ? way_of(later + 1) : way;
    const double span = (of_way && later == 0 ? 1.0 : 2.0) * m_.dt;
    const std::size_t stride = std::max<std::size_t>(1, w_ / 5);
    for (std::size_t k = 0; k + w_ + late < n_; k += stride) {
      const Vector moved = displacement(k + late);
      if (!way.known(k, k + w_) || std::isnan(moved.x + moved.y)) continue;
      if (!before.known(k, k + w_) || !after.known(k, k + w_)) continue;
      const Vector said = way.between(k, k + w_), turned = heading_[k + w_] - heading_[k];
      Vector change = way.change(k, k + w_);
      if (of_way) {
        change = after.between(k, k + w_) - before.between(k, k + w_);
        change = {change.x / span, change.y / span};
      }
      const Vector rest = moved - said;
      use(k, Row{change.x, said.x, -said.y, turned.x, -turned.y}, rest.x, moved.x);
      use(k, Row{change.y, said.y, said.x, turned.y, turned.x}, rest.y, moved.y);
    }
  }

 private:
  Vector displacement(std::size_t k) const { return {m_.x[k + w_] - m_.x[k], m_.y[k + w_] - m_.y[k]}; }
  Way way_of(std::size_t later) const {
    Way out{std::vector<Vector>(n_), std::vector<Vector>(n_), std::vector<std::size_t>(n_ + 1, 0)};
    for (std::size_t k = 0; k < n_; ++k) {
      Vector& v = out.velocity[k];
      v.x = std::numeric_limits<double>::quiet_NaN();
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

using Square = Eigen::Matrix<double, Displacements::unknowns, Displacements::unknowns>;

struct Sums {
  Square normal = Square::Zero();
  Displacements::Row right = Displacements::Row::Zero();
  double rest = 0, moved = 0, rows = 0;

  void add(const Displacements::Row& row, double residual, double place) {
    normal.noalias() += row * row.transpose();
    right += residual * row;
    rest += residual * residual;
    moved += place * place;
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

}  // namespace

std::optional<DisplacementLag> displacement_lag(const PlaneMotion& motion) {
  const Displacements displacements(motion);
  const auto most = static_cast<long>(displacements.steps(longest));
  std::vector<double> left;
  for (long lag = -most; lag <= most; ++lag) {
    Sums all;
    displacements.at(lag, [&](std::size_t, const auto& row, double rest, double place) { all.add(row, rest, place); });
    left.push_back(left_at(all));
  }
  const long best = std::min_element(left.begin(), left.end()) - left.begin() - most;
  // Where a lag changes little, noise says which is the best one.
  constexpr double rises = 1.15;  // by so much, for a tenth of a second more or less
  const auto beside = static_cast<long>(displacements.steps(0.1));
  const auto at = [&](long lag) { return left[static_cast<std::size_t>(lag + most)]; };
  if (!std::isfinite(at(best)) || std::abs(best) + beside > most) return std::nullopt;
  if (!(std::min(at(best - beside), at(best + beside)) > rises * at(best))) return std::nullopt;

  // Ten seconds, less in a short log: few blocks hardly show how blocks differ.
  constexpr std::size_t least_blocks = 8, fewest = 3;
  const auto block = std::max<std::size_t>(
      1, std::min(static_cast<std::size_t>(10.0 / motion.dt), displacements.size() / least_blocks));
  std::vector<Sums> blocks(displacements.size() / block + 1);
  displacements.at(best, [&](std::size_t k, const auto& row, double rest, double place) {
    blocks[k / block].add(row, rest, place);
  });
  std::erase_if(blocks, [](const Sums& one) { return !(one.rows > 0); });
  if (blocks.size() < fewest) return std::nullopt;
  Sums all;
  for (const Sums& one : blocks) all.add(one);
  // Least squares with an interval by blocks: what residuals are correlated by within one is in it.
  const Square inverse = all.normal.ldlt().solve(Square::Identity());
  const Displacements::Row found = inverse * all.right;
  Square scatter = Square::Zero();
  for (const Sums& one : blocks) {
    const Displacements::Row score = one.right - one.normal * found;
    scatter += score * score.transpose();
  }
  const double variance = (inverse * scatter * inverse)(0, 0);
  if (!std::isfinite(variance) || !std::isfinite(found[0])) return std::nullopt;
  return DisplacementLag{static_cast<double>(best) * motion.dt + found[0], std::sqrt(std::max(0.0, variance)),
                         blocks.size(), all.moved > 0 ? 1.0 - all.rest / all.moved : 0.0};
}

}  // namespace gripline::measured
