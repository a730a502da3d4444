#include "calibrate/fit/least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <random>

#include "util/normal_draw.hpp"
#include "util/statistics.hpp"

namespace gripline::calibrate {
namespace {

using Index = Eigen::Index;

constexpr double least_damping = 1e-7;

struct Sum {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

Sum sum_of(const BlockedNormalEquations& blocks, std::size_t n, std::span<const int> weight = {}) {
  Sum all{Eigen::MatrixXd::Zero(static_cast<Index>(n), static_cast<Index>(n)),
          Eigen::VectorXd::Zero(static_cast<Index>(n))};
  for (std::size_t b = 0; b < blocks.hessian.size(); ++b) {
    const double w = weight.empty() ? 1.0 : weight[b];
    if (w == 0.0) continue;
    all.hessian += w * blocks.hessian[b];
    all.gradient += w * blocks.gradient[b];
  }
  return all;
}

/// Solves hessian x = right side, scaled to a unit diagonal.
Eigen::VectorXd solve(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& right) {
  const Eigen::VectorXd scale = hessian.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(Eigen::VectorXd(scale.asDiagonal() * right));
}

/// Unknowns that stand at a bound and would move beyond it stay where they are.
std::vector<bool> held_at_bounds(std::span<const double> params, std::span<const Unknown> unknowns,
                                 const Eigen::VectorXd& gradient) {
  std::vector<bool> held(unknowns.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double value = params[unknowns[i].index];
    const double down = gradient(static_cast<Index>(i));
    held[i] = (value <= unknowns[i].low && down > 0.0) || (value >= unknowns[i].high && down < 0.0);
  }
  return held;
}

Eigen::VectorXd damped_step(Sum sum, const std::vector<bool>& held, double damping) {
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i]) continue;
    const auto at = static_cast<Index>(i);
    sum.hessian.row(at).setZero();
    sum.hessian.col(at).setZero();
    sum.hessian(at, at) = 1.0;
    sum.gradient(at) = 0.0;
  }
  sum.hessian.diagonal() *= 1.0 + damping;
  return -solve(sum.hessian, sum.gradient);
}

/// What a step of least damping takes off the cost to first order.
double expected_decrease(const Sum& sum, const std::vector<bool>& held) {
  const Eigen::VectorXd move = damped_step(sum, held, least_damping);
  return -move.dot(2.0 * sum.gradient + sum.hessian * move);
}

/// Draws of a normal distribution whose inverse covariance is `hessian`.
std::vector<Eigen::VectorXd> normal_moves(const Eigen::MatrixXd& hessian, std::size_t draws, std::mt19937& random) {
  const Eigen::VectorXd scale = hessian.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * hessian * scale.asDiagonal());
  std::vector<Eigen::VectorXd> moves;
  if (factor.info() != Eigen::Success) return moves;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    Eigen::VectorXd z(hessian.rows());
    for (Index i = 0; i < z.size(); ++i) z(i) = nearly_normal(random);
    moves.emplace_back(scale.asDiagonal() * factor.matrixU().solve(z));
  }
  return moves;
}

/// How much more the blocks' gradients scatter than the curvature says of errors that are independent and of unit
/// scale, over all unknowns together, at least 1: predictions that overlap err alike, and what the model lacks
/// errs alike for seconds. tr(M^-1 V) / tr(M^-1 H), V the blocks' covariance, H the curvature and M that with the
/// priors, so that each unknown counts by how much the blocks tell of it (quasi-likelihood with a dispersion:
/// Wedderburn, Biometrika 61, 1974).
double dispersion(const BlockedNormalEquations& blocks, const Eigen::MatrixXd& hessian, std::span<const double> params,
                  std::span<const Unknown> unknowns) {
  const auto count = static_cast<double>(blocks.gradient.size());
  if (blocks.gradient.size() < 2) return 1.0;
  Eigen::MatrixXd with_priors = hessian;
  prior_cost(params, unknowns, &with_priors);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(hessian.rows());
  for (const Eigen::VectorXd& g : blocks.gradient) mean += g / count;
  double scatter = 0.0, expected = 0.0;
  for (const Eigen::VectorXd& g : blocks.gradient) scatter += (g - mean).dot(solve(with_priors, g - mean));
  for (Index i = 0; i < hessian.rows(); ++i) expected += solve(with_priors, hessian.col(i))(i);
  return expected > 0.0 ? std::max(1.0, scatter * count / (count - 1.0) / expected) : 1.0;
}

}  // namespace

double prior_cost(std::span<const double> params, std::span<const Unknown> unknowns, Eigen::MatrixXd* hessian,
                  Eigen::VectorXd* gradient) {
  double sum = 0.0;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Unknown& u = unknowns[i];
    const double off = (search_value(u, params[u.index]) - search_value(u, u.prior)) / u.sigma;
    sum += off * off;
    if (hessian != nullptr) (*hessian)(static_cast<Index>(i), static_cast<Index>(i)) += 1.0 / (u.sigma * u.sigma);
    if (gradient != nullptr) (*gradient)(static_cast<Index>(i)) += off / u.sigma;
  }
  return sum;
}

std::vector<double> after_step(std::span<const double> params, std::span<const Unknown> unknowns,
                               const Eigen::VectorXd& move) {
  constexpr double longest_log = 1.0, longest = 3.0;  // of one step: a factor e, three standard deviations
  std::vector<double> out(params.begin(), params.end());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Unknown& u = unknowns[i];
    double value = out[u.index];
    const double by = move(static_cast<Index>(i));
    value = u.log ? value * std::exp(std::clamp(by, -longest_log, longest_log))
                  : value + std::clamp(by, -longest * u.sigma, longest * u.sigma);
    assign(out, u, std::clamp(value, u.low, u.high));
  }
  return out;
}

std::vector<double> least_squares(const PredictionErrors& errors, std::span<const Unknown> unknowns,
                                  std::vector<double> params, const LeastSquaresOptions& options, double& cost) {
  constexpr int most_steps = 8;  // tried from one set of derivatives: four to eight of them cost as much
  constexpr double minor = 0.1;  // of a decrease: one more is not worth another step, or other derivatives
  double damping = 1e-2;
  std::vector<ObserverSteps> steps_of_best;  // at the best parameters so far; none where their cost was known
  cost = std::isnan(options.initial_cost) ? errors.cost(params, &steps_of_best) + prior_cost(params, unknowns)
                                          : options.initial_cost;
  if (unknowns.empty()) return params;
  int small_steps = 0;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    Sum sum = sum_of(errors.linearise(params, unknowns, steps_of_best), unknowns.size());
    prior_cost(params, unknowns, &sum.hessian, &sum.gradient);
    const auto held = held_at_bounds(params, unknowns, sum.gradient);
    const double before = cost;
    if (expected_decrease(sum, held) < minor * options.tolerance * before) break;
    std::vector<double> best = params;
    const auto step = [&](double by) {
      const Eigen::VectorXd move = damped_step(sum, held, by);
      if (!move.allFinite()) return false;  // no bound would hold it
      std::vector<double> next = after_step(params, unknowns, move);
      std::vector<ObserverSteps> taken;
      const double after = errors.cost(next, &taken) + prior_cost(next, unknowns);
      if (!(after < cost)) return false;
      best = std::move(next);
      steps_of_best = std::move(taken);
      cost = after;
      damping = by;
      return true;
    };
    // More damping until a step is better; from a better one on, in the direction in which steps get much better still.
    const double first = damping;
    double tried = first;
    int steps = 1;
    bool better = step(tried);
    while (!better && steps++ < most_steps) better = step(tried *= 5.0);
    if (better && steps == 1) {
      const auto much_better = [&](double by) {
        const double so_far = before - cost;
        return step(by) && before - cost > (1.0 + minor) * so_far;
      };
      while (steps++ < most_steps && tried > least_damping && much_better(tried *= 0.2)) continue;
      tried = first;
      const bool less_is_better = damping < first;
      while (!less_is_better && steps++ < most_steps && much_better(tried *= 5.0)) continue;
    }
    if (!better) damping = tried;
    params = std::move(best);
    if (options.progress) options.progress({iteration + 1, before, cost});
    small_steps = before - cost < options.tolerance * before ? small_steps + 1 : 0;
    if (!better || small_steps >= 2) break;
  }
  return params;
}

Bootstrap bootstrap(const BlockedNormalEquations& blocks, std::span<const double> params,
                    std::span<const Unknown> unknowns, unsigned seed) {
  constexpr std::size_t draws = 400;
  const std::size_t n = unknowns.size(), count = blocks.hessian.size();
  Bootstrap out;
  out.interval.resize(n);
  if (n == 0 || count == 0) return out;
  std::mt19937 random(seed);
  std::vector<std::vector<double>> move(n);
  std::vector<Eigen::VectorXd> steps;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    std::vector<int> weight(count, 0);
    for (std::size_t b = 0; b < count; ++b) ++weight[random() % count];
    Sum sum = sum_of(blocks, n, weight);
    prior_cost(params, unknowns, &sum.hessian, &sum.gradient);
    steps.push_back(-solve(sum.hessian, sum.gradient));
    for (std::size_t i = 0; i < n; ++i) move[i].push_back(steps.back()(static_cast<Index>(i)));
  }
  Sum sum = sum_of(blocks, n);
  sum.hessian /= dispersion(blocks, sum.hessian, params, unknowns);
  prior_cost(params, unknowns, &sum.hessian, &sum.gradient);
  // Intervals of few blocks are wide: Student's quantile over that of a normal; one block says no more than two.
  const boost::math::students_t student(std::max(1.0, static_cast<double>(count) - 1.0));
  const double few = boost::math::quantile(student, 0.975) / normal_95;
  Eigen::VectorXd middle(static_cast<Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const Unknown& u = unknowns[i];
    std::sort(move[i].begin(), move[i].end());
    const double centre = middle(static_cast<Index>(i)) = move[i][draws / 2];
    // Few blocks vary little among themselves: what prior and curvature allow is the least that is said.
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(static_cast<Index>(n), static_cast<Index>(i));
    const double curvature = std::sqrt(std::max(0.0, solve(sum.hessian, unit)(static_cast<Index>(i))));
    double spread = 0.0;
    for (const double m : move[i]) spread += (m - centre) * (m - centre);
    const double sigma = few * std::max(std::sqrt(spread / draws), curvature);
    Interval& interval = out.interval[i];
    interval.sigma = sigma;
    interval.learned = 1.0 - std::min(1.0, sigma * sigma / (u.sigma * u.sigma));
    const double value = params[u.index];
    const auto at = [&](double off) { return std::clamp(u.log ? value * std::exp(off) : value + off, u.low, u.high); };
    interval.low = at(few * std::min(move[i][draws / 40] - centre, -normal_95 * curvature));
    interval.high = at(few * std::max(move[i][draws - 1 - draws / 40] - centre, normal_95 * curvature));
  }
  out.posterior_moves = normal_moves(sum.hessian / (few * few), draws, random);
  for (const Eigen::VectorXd& step : steps) out.params.push_back(after_step(params, unknowns, few * (step - middle)));
  return out;
}

}  // namespace gripline::calibrate
