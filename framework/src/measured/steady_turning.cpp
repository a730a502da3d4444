#include "measured/steady_turning.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using Index = Eigen::Index;
constexpr std::size_t yaw_at = 2, vx_at = 3, rate_at = 5;
constexpr double block_length = 10.0;  // [s]
constexpr double most_sideways = 4.0;  // [m/s2]
constexpr std::size_t fewest_blocks = 3, fewest_windows = 20;

/// Means over a window of a log; `complete` where all its rows have what is needed.
struct Window {
  double time = 0, rate = 0, vx = 0, delta = 0;
  bool complete = false;
};

/// One equation: what the steering is explained by, and the steering.
struct Equation {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();  // L omega / vx, vx omega, omega'
  double delta = 0;
  SteadyTurning::Corner corner;
  std::size_t log = 0, block = 0;
};

Window window_of(const Session& log, std::size_t first, std::size_t end, double length, double yaw_rate_late) {
  constexpr double longest_gap = 0.25;
  Window w;
  const auto n = static_cast<double>(end - first);
  w.time = log.t[first] + 0.5 * length;
  if (end >= log.rows() || end - first < 2 || log.t[end] - log.t[first] > length + longest_gap) return w;
  for (std::size_t i = first; i < end; ++i) {
    w.vx += log.at(i, vx_at) / n;
    w.delta += log.command[i].delta / n;
    if (log.has[rate_at]) w.rate += log.interpolate(rate_at, log.t[i] + yaw_rate_late, longest_gap) / n;
  }
  if (!log.has[rate_at]) w.rate = (log.at(end, yaw_at) - log.at(first, yaw_at)) / (log.t[end] - log.t[first]);
  w.complete = std::isfinite(w.rate) && std::isfinite(w.vx) && std::isfinite(w.delta);
  return w;
}

std::vector<Window> windows_of(const Session& log, double length, double yaw_rate_late) {
  std::vector<Window> all;
  for (std::size_t first = 0; first < log.rows();) {
    std::size_t end = first;
    while (end < log.rows() && log.t[end] < log.t[first] + length) ++end;
    all.push_back(window_of(log, first, end, length, yaw_rate_late));
    first = std::max(end, first + 1);
  }
  return all;
}

/// Of windows whose neighbours are there too.
void add_equations(const std::vector<Window>& windows, std::size_t log, double wheelbase, double slowest, double length,
                   std::vector<Equation>& to) {
  const std::size_t first_block = to.empty() ? 0 : to.back().block + 1;
  for (std::size_t i = 1; i + 1 < windows.size(); ++i) {
    const Window &before = windows[i - 1], &w = windows[i], &after = windows[i + 1];
    if (!before.complete || !w.complete || !after.complete || after.time - before.time > 2.5 * length) continue;
    if (w.vx < slowest || std::abs(w.vx * w.rate) > most_sideways) continue;
    const double change = (after.rate - before.rate) / (after.time - before.time);
    const auto block = static_cast<std::size_t>((w.time - windows.front().time) / block_length);
    to.push_back(
        {{wheelbase * w.rate / w.vx, w.vx * w.rate, change}, w.delta, {w.vx, w.rate}, log, first_block + block});
  }
}

/// Takes each log's mean off, and with it a steering offset.
void centre(std::vector<Equation>& all) {
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin;
    Equation mean;
    for (; end < all.size() && all[end].log == all[begin].log; ++end) {
      mean.by += all[end].by;
      mean.delta += all[end].delta;
    }
    const auto n = static_cast<double>(end - begin);
    for (; begin < end; ++begin) {
      all[begin].by -= mean.by / n;
      all[begin].delta -= mean.delta / n;
    }
  }
}

Eigen::Matrix3d information_of(const std::vector<Equation>& all) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Equation& one : all) sum += one.by * one.by.transpose();
  return sum;
}

Eigen::Vector3d solution_of(const std::vector<Equation>& all) {
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Equation& one : all) right += one.by * one.delta;
  return information_of(all).ldlt().solve(right);
}

/// Leaves out equations that are off by more than four times the usual, the median over 0.6745.
void leave_out_far(std::vector<Equation>& all, const Eigen::Vector3d& solution) {
  constexpr double most = 4.0 / 0.6745;
  std::vector<double> off;
  for (const Equation& one : all) off.push_back(std::abs(one.delta - one.by.dot(solution)));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  const double far = most * *middle;
  std::erase_if(all, [&](const Equation& one) { return std::abs(one.delta - one.by.dot(solution)) > far; });
}

/// Standard error of the gradient, errors being independent from block to block only (the sandwich of White,
/// Econometrica 48, 1980, by clusters).
double standard_error(const std::vector<Equation>& all, const Eigen::Vector3d& solution, std::size_t& blocks) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  blocks = 0;
  for (std::size_t i = 0; i < all.size();) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t block = all[i].block; i < all.size() && all[i].block == block; ++i)
      sum += all[i].by * (all[i].delta - all[i].by.dot(solution));
    spread += sum * sum.transpose();
    ++blocks;
  }
  const auto n = static_cast<double>(blocks);
  const Eigen::Vector3d row = information_of(all).ldlt().solve(Eigen::Vector3d::UnitY());
  return std::sqrt(row.dot(spread * row) * n / (n - 1.0));
}

}  // namespace

std::string SteadyTurning::text() const {
  const auto of = [](double value) { return significant(degrees_per_g(value), 2); };
  if (low > 0.0) return "understeers by " + of(gradient) + " deg/g (" + of(low) + " to " + of(high) + ")";
  if (high < 0.0) return "oversteers by " + of(-gradient) + " deg/g (" + of(-high) + " to " + of(-low) + ")";
  return "neither surely understeers nor oversteers (" + of(low) + " to " + of(high) + " deg/g)";
}

double SteadyTurning::gradient_of(std::span<const double> angle) const {
  return std::inner_product(of_gradient.begin(), of_gradient.end(), angle.begin(), 0.0);
}

std::optional<SteadyTurning> steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                                            double yaw_rate_late) {
  constexpr double wheelbases = 5.0, half = 0.5;
  const double length = wheelbases * wheelbase / v_ref;
  std::vector<Equation> all;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const Session& log = *sessions[i];
    if (!log.has[vx_at] || !(log.has[rate_at] || log.has[yaw_at])) continue;
    add_equations(windows_of(log, length, yaw_rate_late), i, wheelbase, half * v_ref, length, all);
  }
  for (int pass = 0; pass < 3 && all.size() >= fewest_windows; ++pass) {
    centre(all);
    leave_out_far(all, solution_of(all));
  }
  if (all.size() < fewest_windows) return std::nullopt;
  centre(all);
  const Eigen::Vector3d solution = solution_of(all);
  SteadyTurning out;
  // Cars that weave are not quite steady: simulated ones show the gradient to 7 %.
  constexpr double unsteady = 0.05;
  const double sigma = std::hypot(standard_error(all, solution, out.stretches), unsteady * solution(1));
  if (out.stretches < fewest_blocks || !std::isfinite(sigma)) return std::nullopt;
  const boost::math::students_t t(static_cast<double>(out.stretches) - 1.0);
  const Eigen::Vector3d row = information_of(all).ldlt().solve(Eigen::Vector3d::UnitY());
  for (const Equation& one : all) {
    out.corners.push_back(one.corner);
    out.of_gradient.push_back(one.by.dot(row));  // of centred terms, so that a constant adds nothing
  }
  out.ratio = solution(0);
  out.gradient = solution(1);
  out.low = out.gradient - sigma * boost::math::quantile(t, 0.975);
  out.high = out.gradient + sigma * boost::math::quantile(t, 0.975);
  return out;
}

}  // namespace gripline::measured
