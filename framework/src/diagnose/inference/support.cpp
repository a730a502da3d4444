#include "diagnose/inference/support.hpp"

#include "diagnose/inference/bases.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Information on the own parameters with those of the basis profiled out, regularised where functions are collinear.
MatrixXd own_information(const ScoreSystem& system) {
  const Index own = system.own_params, count = system.normal.g.size() - own;
  const MatrixXd cross = system.normal.N.topRightCorner(own, count);
  VectorXd size = system.normal.N.diagonal().tail(count).cwiseSqrt();
  for (Index i = 0; i < count; ++i)
    if (!(size[i] > 0.0)) size[i] = 1e-300;
  const MatrixXd unit = size.cwiseInverse().asDiagonal() * system.normal.N.bottomRightCorner(count, count) *
                        size.cwiseInverse().asDiagonal();
  const MatrixXd regular = unit + 1e-6 * MatrixXd::Identity(count, count);
  const MatrixXd scaled = cross * size.cwiseInverse().asDiagonal();
  return system.normal.N.topLeftCorner(own, own) - scaled * regular.ldlt().solve(scaled.transpose());
}

}  // namespace

std::vector<double> support_beside(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                                   Where where) {
  const Catalogue& catalogue = *problem.catalogue;
  const MatrixXd information = own_information(
      basis_system(problem, fitted, along, [&](const Trace& trace) { return basis_of(problem, trace, where); }));
  const auto nuisances = static_cast<Index>(catalogue.nuisances().size());
  std::vector<double> support;
  Index at = nuisances;
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[fitted.model.members[i]];
    const auto p = static_cast<Index>(c.fitted.size());
    // Nuisances are profiled out; the other members keep their values, which is generous to this one.
    MatrixXd block = information.block(at, at, p, p);
    if (nuisances > 0) {
      const MatrixXd to = information.block(0, at, nuisances, p);
      block -= to.transpose() * information.topLeftCorner(nuisances, nuisances).ldlt().solve(to);
    }
    VectorXd off(p);
    for (Index f = 0; f < p; ++f) {
      const abi::ParamDecl& decl = c.decl(static_cast<std::size_t>(f));
      off[f] = fitted.model.values[i][c.fitted[static_cast<std::size_t>(f)]] - decl.neutral;
    }
    support.push_back(0.5 * off.dot(block * off) - problem.penalty(static_cast<std::size_t>(p)));
    at += p;
  }
  return support;
}

}  // namespace gripline::diagnose
