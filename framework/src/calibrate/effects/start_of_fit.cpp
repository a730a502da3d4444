#include "calibrate/effects/start_of_fit.hpp"

#include "calibrate/effects/yaw_limit.hpp"
#include "config/errors.hpp"

namespace gripline::calibrate {

StartOfFit start_of_fit(const Node& tree, const Trial& world, const measured::LogMap& map,
                        const std::list<measured::SessionFile>& files,
                        const std::optional<measured::YawRateOffset>& by_yaw, std::span<const std::string> chosen) {
  StartOfFit start;
  Errors errors;
  start.given = parameters_of(tree, world.forecaster, errors);
  start.values = start.given;
  start.unknowns = read_unknowns(tree, world.places, start.values, chosen, errors);
  errors.throw_if_any();
  fix_or_start_delays(map, files, world.forecaster, tree, start.values, start.unknowns);
  start.limited = limit_to_yaw(world.spec, world.places, by_yaw, start.values, start.unknowns);
  return start;
}

}  // namespace gripline::calibrate
