#include "diagnose/result/uncertain_parameters.hpp"

#include <cmath>
#include <string>

#include "config/errors.hpp"

namespace gripline::diagnose {

std::vector<Nuisance> uncertain_parameters(const CaseOptions& options, const Catalogue& catalogue) {
  std::vector<Nuisance> uncertain;
  const bool stated = !options.uncertainty.empty();
  for (const auto& [key, size] : stated ? options.uncertainty : options.guessed) {
    Nuisance n;
    const std::string over_m = "_over_m";
    const bool per_mass = key.ends_with(over_m);
    n.name = per_mass ? key.substr(0, key.size() - over_m.size()) : key;
    n.nominal = catalogue.nominal(n.name, &n.index);
    if (std::isnan(n.nominal) && !stated) continue;
    if (std::isnan(n.nominal))
      throw InputError("nominal_uncertainty names \"" + key + "\", which is not a parameter of the nominal model");
    // A relative deviation of nothing is nothing: where the nominal value is 0 the size is that of the parameter.
    n.sigma = size * (per_mass ? catalogue.car().m : n.nominal != 0.0 ? std::abs(n.nominal) : 1.0);
    if (n.sigma > 0.0) uncertain.push_back(n);
  }
  return uncertain;
}

}  // namespace gripline::diagnose
