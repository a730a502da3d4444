#include "measured/estimates/steady_turning.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "measured/estimates/independent_blocks.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Index = Eigen::Index;
constexpr double most_sideways = 4.0;  // [m/s2]
constexpr std::size_t fewest_windows = 20;

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

/// `late`: by how much what turning is read from is behind the steering [s].
Window window_of(const Session& log, std::size_t first, std::size_t end, double length, double late) {
  Window w;
  const auto n = static_cast<double>(end - first);
  if (end >= log.rows() || log.t[end] - log.t[first] > length + even_motion) return w;
  const auto reading = [&](std::size_t channel, double time) {
    return log.bridge(channel, time, INFINITY, even_motion).value;
  };
  for (std::size_t i = first; i < end; ++i) {
    w.time += log.t[i] / n;
    w.vx += reading(Channel::vx, log.t[i]) / n;
    w.delta += log.command[i].delta / n;
    if (log.has[Channel::yaw_rate]) w.rate += reading(Channel::yaw_rate, log.t[i] + late) / n;
  }
  if (!log.has[Channel::yaw_rate])
    w.rate = (reading(Channel::yaw, log.t[end] + late) - reading(Channel::yaw, log.t[first] + late)) /
             (log.t[end] - log.t[first]);
  w.complete = std::isfinite(w.rate) && std::isfinite(w.vx) && std::isfinite(w.delta);
  return w;
}

/// Whether a log has what a window is of.
bool has_turning(const Session& log) {
  return log.rows() > 0 && log.has[Channel::vx] && (log.has[Channel::yaw_rate] || log.has[Channel::yaw]);
}

std::vector<Window> windows_of(const Session& log, double length, double late) {
  std::vector<Window> all;
  for (std::size_t first = 0; first < log.rows();) {
    std::size_t end = first + 1;
    while (end < log.rows() && log.t[end] < log.t[first] + length) ++end;
    all.push_back(window_of(log, first, end, length, late));
    first = end;
  }
  return all;
}

/// Of windows whose neighbours are there too; `begin` is the log's first time.
void add_equations(const std::vector<Window>& windows, double begin, std::size_t log, double wheelbase, double slowest,
                   double length, std::vector<Equation>& to) {
  const std::size_t first_block = to.empty() ? 0 : to.back().block + 1;
  for (std::size_t i = 1; i + 1 < windows.size(); ++i) {
    const Window &before = windows[i - 1], &w = windows[i], &after = windows[i + 1];
    if (!before.complete || !w.complete || !after.complete) continue;
    if (after.time - before.time > 2.0 * (length + even_motion)) continue;
    if (w.vx < slowest || std::abs(w.vx * w.rate) > most_sideways) continue;
    const double change = (after.rate - before.rate) / (after.time - before.time);
    const auto block = static_cast<std::size_t>((w.time - begin) / independent_time);
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

/// Leaves out equations that are off by more than four standard deviations, each the median over 0.6745. A milliradian
/// is never far: on straights without noise the deviation is nothing.
void leave_out_far(std::vector<Equation>& all, const Eigen::Vector3d& solution) {
  constexpr double most = 4.0 / 0.6745, near = 1e-3;
  std::vector<double> off;
  off.reserve(all.size());
  for (const Equation& one : all) off.push_back(std::abs(one.delta - one.by.dot(solution)));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  const double far = std::max(most * *middle, near);
  std::erase_if(all, [&](const Equation& one) { return std::abs(one.delta - one.by.dot(solution)) > far; });
}

/// Calls use(first, end) for the equations of each block.
template <class Use>
void for_blocks(std::span<const Equation> all, const Use& use) {
  for (std::size_t first = 0; first < all.size();) {
    std::size_t end = first;
    while (end < all.size() && all[end].block == all[first].block) ++end;
    use(all.subspan(first, end - first));
    first = end;
  }
}

/// Sum over blocks of the outer products of their scores.
Eigen::Matrix3d scores_of(std::span<const Equation> all, const Eigen::Vector3d& solution) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for_blocks(all, [&](std::span<const Equation> block) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Equation& one : block) sum += one.by * (one.delta - one.by.dot(solution));
    spread += sum * sum.transpose();
  });
  return spread;
}

/// How many blocks of equal information would determine the combination `by` of the solution as well (Kish's effective
/// number): fewer than there are where some of them, such as straights, say little of it.
double equal_blocks(std::span<const Equation> all, const Eigen::Vector3d& by) {
  double sum = 0.0, squares = 0.0;
  for_blocks(all, [&](std::span<const Equation> block) {
    double information = 0.0;
    for (const Equation& one : block) information += square(by.dot(one.by));
    sum += information;
    squares += square(information);
  });
  return sum * sum / squares;
}

/// Whether the three terms are separable. Speeds that all lie within some 3 % of one do not suffice: what is read of
/// them is wrong by as much, and to err there looks like a gradient.
bool separable(const std::vector<Equation>& all) {
  constexpr double least = 2e-3;  // of an eigenvalue; of terms that do not depend on one another they are 1
  const Eigen::Matrix3d information = information_of(all);
  const Eigen::Vector3d size = information.diagonal().cwiseSqrt();
  if (!(size.minCoeff() > 0.0)) return false;
  const Eigen::Matrix3d unit = size.cwiseInverse().asDiagonal() * information * size.cwiseInverse().asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(unit).eigenvalues()[0] > least;
}

/// Whether a steering that turns the car is known well enough to divide by. By significance alone logs would be chosen
/// whose ratio came out too large, and with it a gradient that is too low: so by its error too, over what the steering
/// is to L omega / vx alone, which does not come out larger where the gradient comes out lower.
bool ratio_is_known(const std::vector<Equation>& all, double ratio, double sigma, double student) {
  constexpr double most = 0.3;
  double both = 0.0, alone = 0.0;
  for (const Equation& one : all) {
    both += one.by[0] * one.delta;
    alone += square(one.by[0]);
  }
  return ratio > student * sigma && sigma * alone < most * both;
}

/// What the logs say with what they read so late; `why_not` where they do not, and then nothing else.
struct Found {
  std::vector<Equation> all;
  double gradient = 0, low = 0, high = 0;  // [rad s2/m]
  std::string why_not;
};
Found nothing_since(std::string why) {
  Found out;
  out.why_not = std::move(why);
  return out;
}
constexpr const char* ratio_unknown =
    "the steering in them hardly explains how the car turns, so that its ratio is not known";

/// The interval of slope / ratio: the values g for which slope - g ratio is not significantly off 0 (Fieller, J. R.
/// Stat. Soc. B 16, 1954), which is bounded where the ratio is significantly above 0.
void set_interval(const Eigen::Vector3d& solution, const Eigen::Matrix3d& covariance, double student, Found& out) {
  const double t = student * student;
  const double a = square(solution[0]) - t * covariance(0, 0), b = solution[0] * solution[1] - t * covariance(0, 1);
  const double c = square(solution[1]) - t * covariance(1, 1), half = std::sqrt(std::max(0.0, b * b - a * c));
  out.low = (b - half) / a;
  out.high = (b + half) / a;
}

/// How late what turning is read from is taken to be [s].
struct Late {
  double yaw_rate = 0, yaw = 0;
};

/// The equations of all logs; none where no log has what they are of.
std::vector<Equation> equations_of(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                                   double slowest, Late late) {
  constexpr double wheelbases = 5.0;
  const double length = wheelbases * wheelbase / v_ref;
  std::vector<Equation> all;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const Session& log = *sessions[i];
    if (!has_turning(log)) continue;
    const auto windows = windows_of(log, length, log.has[Channel::yaw_rate] ? late.yaw_rate : late.yaw);
    add_equations(windows, log.t.front(), i, wheelbase, slowest, length, all);
  }
  for (int pass = 0; pass < 3 && all.size() >= fewest_windows; ++pass) {
    centre(all);
    leave_out_far(all, solution_of(all));
  }
  return all;
}

Found found_with(std::span<const Session* const> sessions, double wheelbase, double v_ref, Late late) {
  constexpr double half = 0.5, fewest_blocks = 3.0;
  const auto has_it = [](const Session* log) { return has_turning(*log); };
  if (std::ranges::none_of(sessions, has_it)) return nothing_since("none of them has a speed and a yaw rate or yaw");
  Found out;
  out.all = equations_of(sessions, wheelbase, v_ref, half * v_ref, late);
  if (out.all.size() < fewest_windows)
    return nothing_since("too little of them is gentle driving at " + significant(half * v_ref) + " m/s or faster");
  centre(out.all);
  if (!separable(out.all))
    return nothing_since("speeds in their corners vary too little to separate it from the steering ratio");
  const Eigen::Vector3d solution = solution_of(out.all);
  out.gradient = solution[1] / solution[0];
  if (!std::isfinite(out.gradient)) return nothing_since(ratio_unknown);
  const Eigen::Matrix3d inverse = information_of(out.all).inverse();
  const Eigen::Vector3d by(-out.gradient / solution[0], 1.0 / solution[0], 0.0);  // of the gradient, by the solution
  const double blocks = equal_blocks(out.all, inverse * by);
  if (!(blocks >= fewest_blocks)) return nothing_since("fewer than three stretches of 10 s with corners determine it");
  const Eigen::Matrix3d covariance = inverse * scores_of(out.all, solution) * inverse * (blocks / (blocks - 1.0));
  const double student = boost::math::quantile(boost::math::students_t(blocks - 1.0), 0.975);
  // A steering that does not turn the car, such as one that is constant, says nothing of its tyres.
  if (!ratio_is_known(out.all, solution[0], std::sqrt(covariance(0, 0)), student)) return nothing_since(ratio_unknown);
  set_interval(solution, covariance, student, out);
  return out;
}

/// Stretches of 10 s with a corner in them.
std::size_t count_blocks(std::span<const Equation> all) {
  std::size_t count = 0;
  for_blocks(all, [&](std::span<const Equation>) { ++count; });
  return count;
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
  return "neither understeers nor oversteers significantly (" + of(low) + " to " + of(high) + " deg/g)";
}

double SteadyTurning::gradient_of(std::span<const double> angle) const {
  const double slope = std::inner_product(of_slope.begin(), of_slope.end(), angle.begin(), 0.0);
  return slope / std::inner_product(of_ratio.begin(), of_ratio.end(), angle.begin(), 1.0);
}

TurningByLogs steady_turning(std::span<const Session* const> sessions, double wheelbase, double v_ref,
                             const TurningLateness& late) {
  const Found found = found_with(sessions, wheelbase, v_ref, {late.yaw_rate.value, late.yaw.value});
  if (!found.why_not.empty()) return {std::nullopt, found.why_not};
  double by_lateness = 0.0;
  for (const double Lateness::*end : {&Lateness::low, &Lateness::high}) {
    const Late other{late.yaw_rate.*end, late.yaw.*end};
    if (other.yaw_rate == late.yaw_rate.value && other.yaw == late.yaw.value) continue;
    const Found there = found_with(sessions, wheelbase, v_ref, other);
    // What may be determines nothing.
    if (!there.why_not.empty()) return {std::nullopt, "the delay of yaw rate or yaw is not known well enough"};
    by_lateness = std::max(by_lateness, std::abs(there.gradient - found.gradient));
  }
  constexpr double relative = 0.05, absolute = 0.025;
  const double unsteady = std::hypot(normal_95 * relative * found.gradient,
                                     normal_95 * absolute * wheelbase / (v_ref * v_ref), by_lateness);
  SteadyTurning out;
  out.gradient = found.gradient;
  out.low = out.gradient - std::hypot(unsteady, out.gradient - found.low);
  out.high = out.gradient + std::hypot(unsteady, found.high - out.gradient);
  out.blocks = count_blocks(found.all);
  const Eigen::Matrix3d inverse = information_of(found.all).inverse();
  for (const Equation& one : found.all) {  // of centred terms, so that a constant adds nothing
    const Eigen::Vector3d share = inverse * one.by;
    out.corners.push_back(one.corner);
    out.of_ratio.push_back(share[0]);
    out.of_slope.push_back(share[1]);
  }
  return {std::move(out), {}};
}

}  // namespace gripline::measured
