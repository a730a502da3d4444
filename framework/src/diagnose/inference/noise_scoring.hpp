// Maximum likelihood of the noise by Fisher scoring. With innovations e of variance S, both functions of the noise
// parameters, the cost is sum (e^2 / S + log S) / 2, its gradient and expected information are
//
//   g_a = sum (dS_a / S) (1 - e^2 / S) / 2 + e de_a / S,   I_ab = sum dS_a dS_b / (2 S^2) + de_a de_b / S
//
// (Gupta and Mehra 1974). The derivatives dS and de are differences of filter passes.
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <span>
#include <vector>

#include "diagnose/inference/measured_noise.hpp"

namespace gripline::diagnose {

/// One unknown of the noise.
struct NoiseParameter {
  enum class Kind { level, colour, acceleration, time, steady, moving, bend, parameter } kind;
  std::size_t which = 0;      // channel, acceleration, command or member of the model
  double longest_step = 1.0;  // of the logarithm; of a colour, a bend or a parameter itself, in its scale
  double least = 0.0, most = std::numeric_limits<double>::infinity();
  std::size_t of = 0;  // the member's parameter
  double scale = 1.0;
};

double& value_of(MeasuredNoise& m, const NoiseParameter& p);
double value_of(const MeasuredNoise& m, const NoiseParameter& p);

/// Moves one unknown within its range: a colour, a bend and a parameter (in its scales) by an addition, all others by a
/// factor's logarithm.
void move_by(MeasuredNoise& m, const NoiseParameter& p, double step);

/// A filter's path depends on which colours are zero: while they are unknown none is.
inline constexpr double hardly_coloured = 1e-7;

/// The innovations of all logs under some noise.
class Innovations {
 public:
  explicit Innovations(const Problem& problem) : problem_(problem) {}

  /// Valid until the next call.
  const std::vector<Likelihood::Innovation>& under(const MeasuredNoise& m);

 private:
  bool are_along(const MeasuredNoise& m) const;
  void linearise_all_logs(const MeasuredNoise& m);

  const Problem& problem_;
  // Of the noise that the logs are linearised under.
  double time_ = 0.0;  // 0: they are not
  bool commands_ = false;
  Commands bend_{};
  std::vector<std::vector<double>> values_;
  std::vector<LinearModel> logs_;
  std::vector<Likelihood::Innovation> rows_;
};

double cost_of(std::span<const Likelihood::Innovation> rows);

/// Gradient and expected information of the cost.
struct NoiseScores {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
};
NoiseScores scores_at(Innovations& innovations, const MeasuredNoise& at, std::span<const NoiseParameter> unknowns);

/// Fisher scoring with step halving. Gives the information at the end.
Eigen::MatrixXd fit_noise(Innovations& innovations, std::span<const NoiseParameter> unknowns, MeasuredNoise& m);

}  // namespace gripline::diagnose
