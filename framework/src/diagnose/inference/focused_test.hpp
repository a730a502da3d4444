// Score tests of few functions, with a sharper approximation of their distribution.
#pragma once

#include <span>

#include "diagnose/inference/residual_test.hpp"
#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {

/// Tests the functions among `rows` of a system, which begin with its own parameters. The statistic is Wilson's and
/// Hilferty's normal, scaled so that thresholds::misfit is its critical value, without or with process noise.
ResidualTest focused_test(const ScoreSystem& system, std::span<const Eigen::Index> rows, Where where,
                          bool process_noise);

/// A chi-square as a standard normal (Wilson and Hilferty 1931).
double wilson_hilferty(double chi_square, double dof);

}  // namespace gripline::diagnose
