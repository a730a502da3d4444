#include "diagnose/inference/preparation.hpp"

#include <algorithm>
#include <cmath>

#include "measured/log/log_noise.hpp"
#include "measured/log/rounding.hpp"
#include "measured/replay/replay.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

using measured::Finding;

bool was_read(std::span<const Log> stretches, std::size_t channel) {
  return std::ranges::any_of(stretches, [=](const Log& log) { return !measured::samples_with(log, channel).empty(); });
}

/// What is known of one channel's noise before a fit, as standard deviations in its unit.
struct ChannelNoise {
  double seen = 0, beside = 0;  // by fourth differences, and beside quick motion by eighth; NaN where neither tells
  double stated = 0;            // with what rounding adds; 0: nothing is stated
  double least = 0, most = 0;   // that are assumed
  bool of_sensor = false;       // stated is not rounding alone
  bool read = false;            // at all
};

/// The standard deviation to assume of readings that are too few or too far apart to show it.
double unseen_noise(const ChannelNoise& of, const std::string& name, std::vector<Finding>& health) {
  const std::string found = "not measurable, its readings are too few or too far apart";
  if (of.of_sensor) {
    health.push_back({Finding::Level::note, name, found, "the stated " + significant(of.stated) + " is used"});
    return std::max(of.least, of.stated);
  }
  // Taken for exact, they would outweigh all others.
  health.push_back({Finding::Level::bad, name, found + ", and not stated",
                    "taken for " + significant(of.most) + ": its readings have no weight until it is stated"});
  return of.most;
}

/// The standard deviation to assume of one channel.
double noise_to_assume(std::size_t channel, const ChannelNoise& of, std::vector<Finding>& health) {
  const std::string name = std::string("noise of ") + channel_info[channel].words;
  if (!of.read) return std::max(of.least, of.stated);
  if (std::isnan(of.seen)) return unseen_noise(of, name, health);
  double seen = of.seen;
  const double stated = of.stated;
  const bool of_motion =
      stated > 0.0 && seen > thresholds::noise_agrees_to * stated && of.beside < thresholds::noise_is_motion * seen;
  if (of_motion) seen = of.beside;
  if (of_motion && seen > thresholds::noise_agrees_from * stated && seen < thresholds::hidden_by_motion * stated) {
    health.push_back({Finding::Level::note, name,
                      "at most " + significant(seen) + ", hidden by the car's own quick motion",
                      (of.of_sensor ? "the stated " : "that of rounding, ") + significant(stated) + " is used"});
    return std::max(of.least, stated);
  }
  if (stated > 0.0 && seen < thresholds::noise_free * stated) {
    // Simulated, or filtered: what is left is rounding, of which nothing is known.
    health.push_back({Finding::Level::bad, name, "none measured, stated " + significant(stated),
                      "a twentieth of the stated is used; figures in standard deviations, intervals and confidence "
                      "are not reliable"});
    return thresholds::noise_free * stated;
  }
  const bool agrees =
      stated > 0.0 && seen > thresholds::noise_agrees_from * stated && seen < thresholds::noise_agrees_to * stated;
  if (agrees) return stated;
  health.push_back({of.of_sensor ? Finding::Level::note : Finding::Level::good, name,
                    significant(seen) + (of.of_sensor ? ", stated " + significant(stated) : ", not stated"),
                    "the measured one is used"});
  return std::max(of.least, seen);
}

/// Adds what rounding of a reading makes of the stated noise, where it counts.
double with_rounding(std::size_t channel, double step, double stated, std::vector<Finding>& health) {
  const double rounding = measured::rounding_noise(step);
  if (!(rounding > thresholds::least_rounding * stated)) return stated;
  const std::string unit = std::string(" ") + channel_info[channel].unit;
  health.push_back({Finding::Level::note, std::string("rounding of ") + channel_info[channel].words,
                    "to " + significant(step) + unit, "counts as noise of " + significant(rounding) + unit});
  return std::hypot(stated, rounding);
}

/// Steps of the commands; 0 where the car would hardly be accelerated by half of one.
Commands steps_that_count(const Problem& problem) {
  std::vector<Log> logs;
  for (const Trace& trace : problem.traces) logs.push_back(trace.log);
  Commands steps = measured::command_steps(logs);
  if (steps == Commands{}) return steps;
  const StagedCar car = problem.catalogue->build(problem.catalogue->null_model());
  Commands largest{};  // acceleration by a unit of each, over the typical one
  for (const Trace& trace : problem.traces) {
    const auto by = measured::rates_by_command(car, trace, simulate_memory(car, trace));
    for (std::size_t i = 0; i < by.size(); ++i)
      for (std::size_t k = 0; k < trace.size(); ++k)
        for (std::size_t c = 0; c < noise_states; ++c)
          largest[i] =
              std::max(largest[i], std::abs(by[i].motion[k * channels + Channel::vx + c]) / problem.process_unit[c]);
  }
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (measured::rounding_noise(steps[i]) * largest[i] < thresholds::no_process_noise) steps[i] = 0.0;
  return steps;
}

}  // namespace

Prepared prepare(const Catalogue& catalogue, const Road& road, std::span<const measured::LogFile> logs,
                 const Channels& stated) {
  Prepared out;
  Problem& problem = out.problem;
  problem.catalogue = &catalogue;
  const Car& car = catalogue.car();
  constexpr double typical = thresholds::typical_acceleration;
  problem.process_unit = {typical, typical, typical / (car.lf + car.lr)};
  std::vector<Log> stretches;
  for (const measured::LogFile& log : logs) {
    stretches.insert(stretches.end(), log.stretches.begin(), log.stretches.end());
    out.health.insert(out.health.end(), log.health.begin(), log.health.end());
  }
  Channels seen = estimate_noise(std::span<const Log>(stretches));
  const Channels steps = measured::reading_steps(stretches);
  for (std::size_t c = 0; c < channels; ++c) {
    const double size = c < Channel::yaw ? car.lf + car.lr : c == Channel::yaw ? 1.0 : car.v_ref;
    const double expected = with_rounding(c, steps[c], stated[c], out.health);
    out.expected_noise[c] = expected;
    if (expected > stated[c]) seen[c] = std::max(seen[c], measured::rounding_noise(steps[c]));
    constexpr std::size_t beside_motion = 8;  // order of differences that a quick motion enters less
    const ChannelNoise noise{.seen = seen[c],
                             .beside = measured::white_noise(stretches, c, beside_motion),
                             .stated = expected,
                             .least = thresholds::least_sensor_noise * size,
                             .most = size,
                             .of_sensor = stated[c] > 0.0,
                             .read = was_read(stretches, c)};
    problem.sensor[c] = noise_to_assume(c, noise, out.health);
  }
  for (Log& one : stretches) {
    Trace trace;
    trace.log = std::move(one);
    trace.set_motion(smooth_readings(trace.log, 3), road);
    problem.rows +=
        static_cast<std::size_t>(std::ranges::count_if(trace.log.reading, [](double r) { return std::isfinite(r); }));
    problem.traces.push_back(std::move(trace));
  }
  problem.substeps = substeps_of_motion(catalogue.build(catalogue.null_model()), problem.traces);
  problem.command_step = steps_that_count(problem);
  return out;
}

}  // namespace gripline::diagnose
