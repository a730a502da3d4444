#include "diagnose/result/fitted_parameters.hpp"

#include <algorithm>
#include <cmath>

#include "util/statistics.hpp"

namespace gripline::diagnose {

Explanation with_fit(const Catalogue& catalogue, const Fit& fitted, Explanation explanation) {
  explanation.fit = fitted;
  std::size_t at = 0;
  const std::size_t p = fitted.theta.size();
  explanation.nominal_fit.clear();
  for (const Nuisance& n : catalogue.nuisances()) {
    if (!n.delay) explanation.nominal_fit.emplace_back(n.name, fitted.theta[at]);
    ++at;
  }
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[fitted.model.members[i]];
    std::vector<NamedEffect::Value>& params = explanation.named[i].params;
    params.clear();
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      const abi::ParamDecl& decl = c.decl(f);
      const double sigma = std::sqrt(std::max(0.0, fitted.covariance[at * p + at]));
      params.push_back({decl.name, decl.unit, fitted.theta[at], fitted.theta[at] - normal_95 * sigma,
                        fitted.theta[at] + normal_95 * sigma});
    }
  }
  return explanation;
}

}  // namespace gripline::diagnose
