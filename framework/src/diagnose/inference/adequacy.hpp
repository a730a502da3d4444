// Is a fitted model adequate? Score tests of generic accelerations, smooth functions of place, time, state and inputs,
// and of what else an adequate model would not show: uneven process noise, spectral lines, members that are not
// constant.
#pragma once

#include <span>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/residual_test.hpp"

namespace gripline::diagnose {

/// All tests of a fitted model: one of each kind, in the order of Where; then one of process noise in some
/// accelerations only (quantity "noise", of the kind of the strongest before it); one of spectral lines (quantity
/// "frequency"); then the focused ones. The model is adequate when no statistic exceeds thresholds::misfit.
std::vector<ResidualTest> residual_tests(const Problem& problem, const Fit& fitted);

/// The strongest of some tests; a focused one only when no other exceeds thresholds::misfit.
const ResidualTest& strongest(std::span<const ResidualTest> tests);

}  // namespace gripline::diagnose
