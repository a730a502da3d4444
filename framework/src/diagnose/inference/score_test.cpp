#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ScoreTest score_test(const MatrixXd& N, const VectorXd& g, Index own_params, double rank_tolerance) {
  const Index count = g.size() - own_params;
  ScoreTest s;
  s.information = N.bottomRightCorner(count, count);
  VectorXd r = g.tail(count);
  if (own_params > 0) {
    const MatrixXd base = N.topLeftCorner(own_params, own_params) +
                          1e-12 * MatrixXd(N.topLeftCorner(own_params, own_params).diagonal().asDiagonal());
    const Eigen::LDLT<MatrixXd> ldlt(base);
    const MatrixXd cross = N.topRightCorner(own_params, count);
    s.information -= cross.transpose() * ldlt.solve(cross);
    r -= cross.transpose() * ldlt.solve(g.head(own_params));
  }
  s.score = r;
  VectorXd size = N.diagonal().tail(count).cwiseSqrt();
  for (Index i = 0; i < count; ++i)
    if (!(size[i] > 0.0)) size[i] = 1e-300;
  const MatrixXd unit = size.cwiseInverse().asDiagonal() * s.information * size.cwiseInverse().asDiagonal();
  const VectorXd unit_r = size.cwiseInverse().asDiagonal() * r;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit);
  s.step = VectorXd::Zero(count);
  for (Index i = 0; i < count; ++i) {
    const double lambda = eigen.eigenvalues()[i];
    if (!(lambda > rank_tolerance)) continue;
    ++s.dof;
    const double along = eigen.eigenvectors().col(i).dot(unit_r);
    s.gain += 0.5 * along * along / lambda;
    s.step += eigen.eigenvectors().col(i) * (along / lambda);
  }
  s.step = size.cwiseInverse().asDiagonal() * s.step;
  return s;
}

ScoreSystem score_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const FurtherRegressors& further) {
  const Catalogue& catalogue = *problem.catalogue;
  ScoreSystem out;
  for (std::size_t t = 0; t < problem.traces.size(); ++t) {
    const LinearModel& lm = along[t].lm;
    const std::vector<Regressor>& own = along[t].own;
    const std::vector<Regressor> others = further(problem.traces[t], lm);
    out.own_params = static_cast<Index>(own.size());
    out.normal.add(filter_along(lm, fitted.noise, own, others));
  }
  out.normal.add(nuisance_priors(catalogue, fitted.model));
  fix_at_limits(catalogue, fitted.model, out.normal);
  return out;
}

}  // namespace gripline::diagnose
