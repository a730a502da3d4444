#include "diagnose/inference/late_place.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/thresholds.hpp"
#include "measured/estimates/session_delays.hpp"

namespace gripline::diagnose {
namespace {

using measured::Channel;
using measured::channels;
using measured::Log;

constexpr std::size_t place_group = measured::delay_group[Channel::x];

struct Travel {
  double mean_speed = 0, longest_step = 0;  // [m/s], [s]
};

Travel travel_of(std::span<const LogFile> logs) {
  Travel out;
  double sum = 0.0, count = 0.0;
  for (const LogFile& file : logs)
    for (const Log& log : file.stretches) {
      out.longest_step = std::max(out.longest_step, log.dt);
      for (std::size_t k = 0; k < log.size(); ++k) {
        const double vx = log.reading[k * channels + Channel::vx];
        if (!std::isnan(vx)) sum += vx, count += 1.0;
      }
    }
  if (count > 0.0) out.mean_speed = sum / count;
  return out;
}

}  // namespace

std::optional<ChannelDelay> delay_for_lever(const Catalogue& catalogue, const Fit& found,
                                            std::span<const LogFile> logs) {
  const std::size_t lever = catalogue.find("pose_lever");
  if (lever == catalogue.candidates().size() || !found.model.has(lever)) return std::nullopt;
  const Travel travel = travel_of(logs);
  if (!(travel.mean_speed > 0.0)) return std::nullopt;
  const double ahead = found.model.values[found.model.position(lever)].front();  // px [m]
  const double seconds = -ahead / travel.mean_speed;
  if (!(seconds >= thresholds::least_delay * travel.longest_step && seconds <= thresholds::longest_late_place))
    return std::nullopt;
  constexpr double known_to = 0.25;
  return ChannelDelay{place_group, seconds, (1.0 - known_to) * seconds, (1.0 + known_to) * seconds};
}

ModelSpec with_delays_for_lever(const Catalogue& catalogue, const ModelSpec& found) {
  ModelSpec model = catalogue.without(found, catalogue.find("pose_lever"));
  const auto nuisances = catalogue.nuisances();
  std::vector<double> values;
  for (std::size_t i = 0; i < nuisances.size(); ++i)
    values.push_back(nuisances[i].delay || i >= found.nuisance.size() ? nuisances[i].nominal : found.nuisance[i]);
  model.nuisance = std::move(values);
  return model;
}

}  // namespace gripline::diagnose
