#include "measured/displacement_lag.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gripline::measured {
namespace {

struct Vector {
  double x = 0, y = 0;
};

/// Velocity in the world's axes and its integral from the beginning, by samples; NaN where it is not known.
struct Way {
  std::vector<Vector> sum;
  std::vector<std::size_t> missing;  // of the samples before
  bool known(std::size_t from, std::size_t to) const { return missing[from] == missing[to + 1]; }
};

Way way_of(const PlaneMotion& m, const std::vector<Vector>& heading, std::size_t later) {
  const std::size_t n = m.x.size();
  Way out{std::vector<Vector>(n), std::vector<std::size_t>(n + 1, 0)};
  Vector before;
  for (std::size_t k = 0; k < n; ++k) {
    Vector v{std::numeric_limits<double>::quiet_NaN(), 0};
    if (k + later < n) {
      const double vx = m.vx[k + later], vy = m.vy[k + later];
      v = {heading[k].x * vx - heading[k].y * vy, heading[k].y * vx + heading[k].x * vy};
    }
    const bool missing = std::isnan(v.x + v.y);
    out.missing[k + 1] = out.missing[k] + (missing ? 1 : 0);
    if (k > 0) out.sum[k] = out.sum[k - 1];
    if (k > 0 && !missing && out.missing[k - 1] == out.missing[k]) {
      out.sum[k].x += 0.5 * m.dt * (v.x + before.x);
      out.sum[k].y += 0.5 * m.dt * (v.y + before.y);
    }
    before = v;
  }
  return out;
}

}  // namespace

void DisplacementLag::Sums::add(const double (&row)[terms]) {
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t j = 0; j <= i; ++j) product[i][j] += row[i] * row[j];
  rows += 1;
}

void DisplacementLag::Sums::add(const Sums& other, double weight) {
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t j = 0; j <= i; ++j) product[i][j] += weight * other.product[i][j];
  moved += weight * other.moved;
  rows += weight * other.rows;
}

double DisplacementLag::Sums::rest() const {
  Eigen::Matrix4d normal;
  Eigen::Vector4d right;
  for (int i = 0; i < 4; ++i) {
    right[i] = product[unknowns][i];
    for (int j = 0; j <= i; ++j) normal(i, j) = normal(j, i) = product[i][j];
    normal(i, i) += 1e-9 * normal(i, i) + 1e-12;  // a lever that nothing shows stays 0
  }
  const double left = product[unknowns][unknowns] - right.dot(normal.ldlt().solve(right));
  return rows > 0.0 ? std::max(0.0, left) / rows : std::numeric_limits<double>::infinity();
}

DisplacementLag::DisplacementLag(const PlaneMotion& motion) : dt_(motion.dt) {
  // Ten seconds, less in a short log: few blocks drawn anew hardly differ.
  constexpr std::size_t least_blocks = 8;
  const std::size_t n = motion.x.size();
  const auto block = std::max<std::size_t>(1, std::min(static_cast<std::size_t>(10.0 / dt_), n / least_blocks));
  blocks_ = std::max<std::size_t>(1, n / block);
  constexpr double earliest = -1.2, latest = 1.2;  // [s]
  first_ = std::lround(earliest / dt_);
  lags_ = static_cast<std::size_t>(std::lround(latest / dt_) - first_) + 1;
  sums_.resize(blocks_ * lags_);
  for (std::size_t lag = 0; lag < lags_; ++lag) add_lag(motion, lag, block);
}

/// Where the velocity is the later one it is read later against heading and place; else the place is the late one.
void DisplacementLag::add_lag(const PlaneMotion& m, std::size_t lag, std::size_t block) {
  constexpr double window = 0.5;  // [s]
  const long steps = first_ + static_cast<long>(lag);
  const auto later = static_cast<std::size_t>(std::max(0L, steps)),
             late = static_cast<std::size_t>(std::max(0L, -steps));
  const auto w = static_cast<std::size_t>(std::max(1.0, std::round(window / m.dt)));
  const std::size_t n = m.x.size(), stride = std::max<std::size_t>(1, w / 5);
  std::vector<Vector> heading(n);
  for (std::size_t k = 0; k < n; ++k) heading[k] = {std::cos(m.yaw[k]), std::sin(m.yaw[k])};
  const Way way = way_of(m, heading, later);
  for (std::size_t k = 0; k + w + late < n; k += stride) {
    const Vector moved{m.x[k + w + late] - m.x[k + late], m.y[k + w + late] - m.y[k + late]};
    if (!way.known(k, k + w) || std::isnan(moved.x + moved.y)) continue;
    const Vector said{way.sum[k + w].x - way.sum[k].x, way.sum[k + w].y - way.sum[k].y};
    const Vector turned{heading[k + w].x - heading[k].x, heading[k + w].y - heading[k].y};
    Sums& sums = sums_[std::min(k / block, blocks_ - 1) * lags_ + lag];
    sums.add({said.x, -said.y, turned.x, -turned.y, moved.x - said.x});
    sums.add({said.y, said.x, turned.y, turned.x, moved.y - said.y});
    sums.moved += moved.x * moved.x + moved.y * moved.y;
  }
}

double DisplacementLag::best(std::span<const int> weight, double* correlation) const {
  std::vector<double> rest(lags_);
  std::vector<double> moved(lags_);
  for (std::size_t lag = 0; lag < lags_; ++lag) {
    Sums all;
    for (std::size_t b = 0; b < blocks_; ++b) all.add(sums_[b * lags_ + lag], weight[b]);
    rest[lag] = all.rest();
    moved[lag] = all.rows > 0.0 ? all.moved / all.rows : 0.0;
  }
  const auto least = static_cast<std::size_t>(std::min_element(rest.begin(), rest.end()) - rest.begin());
  if (correlation != nullptr)
    *correlation = moved[least] > 0.0 ? std::sqrt(std::max(0.0, 1.0 - rest[least] / moved[least])) : 0.0;
  double offset = 0.0;
  if (least > 0 && least + 1 < lags_) {
    const double a = rest[least - 1], b = rest[least], c = rest[least + 1];
    const double bend = a - 2.0 * b + c;
    if (bend > 0.0) offset = 0.5 * (a - c) / bend;
  }
  return (static_cast<double>(first_) + static_cast<double>(least) + offset) * dt_;
}

bool DisplacementLag::is_at_end(double lag) const {
  const double steps = lag / dt_ - static_cast<double>(first_);
  return steps < 1.0 || steps > static_cast<double>(lags_) - 2.0;
}

}  // namespace gripline::measured
