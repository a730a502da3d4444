#include "diagnose/real_logs/cornering.hpp"

#include "calibrate/fit/handling.hpp"
#include "car/vehicle.hpp"
#include "measured/session/centre_of_gravity.hpp"

namespace gripline::diagnose {

Cornering cornering_of(const std::list<measured::SessionFile>& files, const WorldSpec& given,
                       const MissingEffects& found) {
  const Car& car = given.car.car;
  PluginContext context;
  context.car = car;
  const Vehicle as_given(given.vehicle, context), as_found(found.spec.vehicle, context);
  const calibrate::Forecaster forecaster(as_found.car(), calibrate::forecast_options(found.spec));
  std::list<measured::Session> own;
  std::vector<const measured::Session*> sessions;
  for (const measured::SessionFile& file : files) sessions.push_back(&own.emplace_back(at_centre_of_gravity(file)));
  std::vector<calibrate::FittedParameter> known = found.parameters;
  known.insert(known.end(), found.undetermined.begin(), found.undetermined.end());
  const auto late = calibrate::turning_lateness(forecaster, found.params, known);
  auto [turning, why_not] = measured::steady_turning(sessions, car.lf + car.lr, car.v_ref, late);
  Cornering out{std::move(turning), {}, {}, std::move(why_not)};
  if (!out.by_log) return out;
  out.given = calibrate::gradient_in(*out.by_log, as_given.car(), as_given.car().params());
  out.found = calibrate::gradient_in(*out.by_log, as_found.car(), found.params);
  return out;
}

}  // namespace gripline::diagnose
