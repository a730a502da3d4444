#include "diagnose/result/fitted_parameters.hpp"

#include <algorithm>
#include <cmath>

#include "util/statistics.hpp"

namespace gripline::diagnose {

void set_parameters(const Catalogue& catalogue, Diagnosis& d) {
  const Fit& fitted = d.fit;
  std::size_t at = 0;
  const std::size_t p = fitted.theta.size();
  d.nominal_fit.clear();
  for (const Nuisance& n : catalogue.nuisances()) {
    if (!n.delay) d.nominal_fit.emplace_back(n.name, fitted.theta[at]);
    ++at;
  }
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[fitted.model.members[i]];
    d.named[i].params.clear();
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      const abi::ParamDecl& decl = c.decl(f);
      const double sigma = std::sqrt(std::max(0.0, fitted.covariance[at * p + at]));
      d.named[i].params.push_back({decl.name, decl.unit, fitted.theta[at], fitted.theta[at] - normal_95 * sigma,
                                   fitted.theta[at] + normal_95 * sigma});
    }
  }
}

}  // namespace gripline::diagnose
