#include "measured/steady_turning.hpp"

#include <Eigen/Dense>
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

constexpr double longest_gap = 0.25;  // [s] between readings

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
  Window w;
  const auto n = static_cast<double>(end - first);
  if (end >= log.rows() || log.t[end] - log.t[first] > length + longest_gap) return w;
  const auto reading = [&](std::size_t channel, double time) {
    return log.bridge(channel, time, INFINITY, longest_gap);
  };
  for (std::size_t i = first; i < end; ++i) {
    w.time += log.t[i] / n;
    w.vx += reading(vx_at, log.t[i]) / n;
    w.delta += log.command[i].delta / n;
    if (log.has[rate_at]) w.rate += reading(rate_at, log.t[i] + yaw_rate_late) / n;
  }
  if (!log.has[rate_at])
    w.rate = (reading(yaw_at, log.t[end]) - reading(yaw_at, log.t[first])) / (log.t[end] - log.t[first]);
  w.complete = std::isfinite(w.rate) && std::isfinite(w.vx) && std::isfinite(w.delta);
  return w;
}

std::vector<Window> windows_of(const Session& log, double length, double yaw_rate_late) {
  std::vector<Window> all;
  for (std::size_t first = 0; first < log.rows();) {
    std::size_t end = first + 1;
    while (end < log.rows() && log.t[end] < log.t[first] + length) ++end;
    all.push_back(window_of(log, first, end, length, yaw_rate_late));
    first = end;
  }
  return all;
}

/// Of windows whose neighbours are there too.
void add_equations(const std::vector<Window>& windows, std::size_t log, double wheelbase, double slowest, double length,
                   std::vector<Equation>& to) {
  const std::size_t first_block = to.empty() ? 0 : to.back().block + 1;
  for (std::size_t i = 1; i + 1 < windows.size(); ++i) {
    const Window &before = windows[i - 1], &w = windows[i], &after = windows[i + 1];
    if (!before.complete || !w.complete || !after.complete) continue;
    if (after.time - before.time > 2.0 * (length + longest_gap)) continue;
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
  off.reserve(all.size());
  for (const Equation& one : all) off.push_back(std::abs(one.delta - one.by.dot(solution)));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  const double far = most * *middle;
  std::erase_if(all, [&](const Equation& one) { return std::abs(one.delta - one.by.dot(solution)) > far; });
}

/// Covariance of the solution, errors being independent from block to block only.
Eigen::Matrix3d covariance_of(const std::vector<Equation>& all, const Eigen::Vector3d& solution, std::size_t& blocks) {
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
  const Eigen::Matrix3d inverse = information_of(all).inverse();
  return inverse * spread * inverse * (n / (n - 1.0));
}

/// Whether the three terms can be told from one another.
bool apart(const std::vector<Equation>& all) {
  constexpr double least = 1e-4;  // of an eigenvalue; of terms that do not depend on one another they are 1
  const Eigen::Matrix3d information = information_of(all);
  const Eigen::Vector3d size = information.diagonal().cwiseSqrt();
  if (!(size.minCoeff() > 0.0)) return false;
  const Eigen::Matrix3d unit = size.cwiseInverse().asDiagonal() * information * size.cwiseInverse().asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(unit).eigenvalues()[0] > least;
}

/// What the logs say with the yaw rate so late.
struct Found {
  std::vector<Equation> all;
  double gradient = 0, sigma = 0, student = 0;  // `student`: quantile of 97.5 %
  std::size_t blocks = 0;
};

std::optional<Found> found_with(std::span<const Session* const> sessions, double wheelbase, double v_ref, double late) {
  constexpr double wheelbases = 5.0, half = 0.5;
  const double length = wheelbases * wheelbase / v_ref;
  Found out;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const Session& log = *sessions[i];
    if (!log.has[vx_at] || !(log.has[rate_at] || log.has[yaw_at])) continue;
    add_equations(windows_of(log, length, late), i, wheelbase, half * v_ref, length, out.all);
  }
  for (int pass = 0; pass < 3 && out.all.size() >= fewest_windows; ++pass) {
    centre(out.all);
    leave_out_far(out.all, solution_of(out.all));
  }
  if (out.all.size() < fewest_windows) return std::nullopt;
  centre(out.all);
  if (!apart(out.all)) return std::nullopt;
  const Eigen::Vector3d solution = solution_of(out.all);
  const Eigen::Matrix3d covariance = covariance_of(out.all, solution, out.blocks);
  if (out.blocks < fewest_blocks) return std::nullopt;
  const boost::math::students_t t(static_cast<double>(out.blocks) - 1.0);
  out.student = boost::math::quantile(t, 0.975);
  // A steering that does not turn the car, such as one that is constant, says nothing of its tyres.
  if (!(solution[0] > out.student * std::sqrt(covariance(0, 0)))) return std::nullopt;
  out.gradient = solution[1] / solution[0];
  const Eigen::Vector3d by(-out.gradient / solution[0], 1.0 / solution[0], 0.0);
  out.sigma = std::sqrt(by.dot(covariance * by));
  return out;
}

}  // namespace

std::string cornering_text(double gradient) {
  return (gradient < 0.0 ? "oversteers by " : "understeers by ") + significant(std::abs(degrees_per_g(gradient)), 2) +
         " deg/g";
}

std::string SteadyTurning::text() const {
  const auto of = [](double value) { return significant(degrees_per_g(value), 2); };
  if (low > 0.0) return cornering_text(gradient) + " (" + of(low) + " to " + of(high) + ")";
  if (high < 0.0) return cornering_text(gradient) + " (" + of(-high) + " to " + of(-low) + ")";
  return "neither surely understeers nor oversteers (" + of(low) + " to " + of(high) + " deg/g)";
}

double SteadyTurning::gradient_of(std::span<const double> angle) const {
  const double slope = std::inner_product(of_gradient.begin(), of_gradient.end(), angle.begin(), 0.0);
  return slope / std::inner_product(of_ratio.begin(), of_ratio.end(), angle.begin(), 1.0);
}

std::optional<SteadyTurning> steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                                            const Lateness& yaw_rate) {
  const auto found = found_with(sessions, wheelbase, v_ref, yaw_rate.value);
  if (!found) return std::nullopt;
  constexpr double normal_95 = 1.959964, relative = 0.05, absolute = 0.025;
  double half = std::hypot(found->student * found->sigma, normal_95 * relative * found->gradient,
                           normal_95 * absolute * wheelbase / (v_ref * v_ref));
  double by_lateness = 0.0;
  for (const double end : {yaw_rate.low, yaw_rate.high})
    if (const auto other = found_with(sessions, wheelbase, v_ref, end); other && end != yaw_rate.value)
      by_lateness = std::max(by_lateness, std::abs(other->gradient - found->gradient));
  half = std::hypot(half, by_lateness);
  SteadyTurning out;
  out.gradient = found->gradient;
  out.low = out.gradient - half;
  out.high = out.gradient + half;
  out.blocks = found->blocks;
  const Eigen::Matrix3d inverse = information_of(found->all).inverse();
  for (const Equation& one : found->all) {  // of centred terms, so that a constant adds nothing
    const Eigen::Vector3d share = inverse * one.by;
    out.corners.push_back(one.corner);
    out.of_ratio.push_back(share[0]);
    out.of_gradient.push_back(share[1]);
  }
  return out;
}

}  // namespace gripline::measured
