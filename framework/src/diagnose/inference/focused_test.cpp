#include "diagnose/inference/focused_test.hpp"

#include <cmath>

namespace gripline::diagnose {

double wilson_hilferty(double chi_square, double dof) {
  const double spread = 2.0 / (9.0 * dof);
  return (std::cbrt(chi_square / dof) - (1.0 - spread)) / std::sqrt(spread);
}

ResidualTest focused_test(const ScoreSystem& system, std::span<const Eigen::Index> rows, Where where,
                          bool process_noise) {
  const ScoreTest s = score_test(system.normal.N(rows, rows), system.normal.g(rows), system.own_params);
  ResidualTest test;
  test.where = where;
  test.focused = true;
  test.gain = s.gain;
  test.dof = s.dof;
  const double critical = process_noise ? thresholds::misfit_focused_process_noise : thresholds::misfit_focused;
  if (s.dof > 0)
    test.statistic = thresholds::misfit / critical * wilson_hilferty(2.0 * s.gain, static_cast<double>(s.dof));
  return test;
}

}  // namespace gripline::diagnose
