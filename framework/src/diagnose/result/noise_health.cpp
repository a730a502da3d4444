#include "diagnose/result/noise_health.hpp"

#include <cmath>
#include <string>

#include "diagnose/inference/hold_out.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {

using measured::Finding;

std::vector<Finding> with_noise(const Problem& problem, const Noise& noise, std::vector<Finding> health) {
  if (problem.colour != Channels{} || noise.command != UnknownCommands{}) {
    for (std::size_t c = 0; c < channels; ++c) {
      if (!problem.is_read(c)) continue;
      const std::string check = std::string("noise of ") + channel_info[c].words;
      std::erase_if(health, [&](const Finding& h) { return h.check == check && h.level != Finding::Level::bad; });
      const std::string text = format("%.3g %s, correlation from sample to sample %.2f", problem.sensor[c],
                                      channel_info[c].unit, problem.colour[c]);
      health.push_back({Finding::Level::note, check, text, "measured with the model"});
    }
  }
  if (problem.hold() != measured::CommandHold{})
    health.push_back({Finding::Level::note, "commands between samples",
                      problem.hold().until_next ? "held until the next row"
                                                : format("held for %.3g s each, of which the log left some out",
                                                         problem.hold().seconds(problem.traces.front().log.dt)),
                      "as the world says or as found with the model"});
  for (std::size_t i = 0; i < problem.command_step.size(); ++i) {
    if (problem.command_step[i] == 0.0) continue;
    const std::string text = format("to %.3g%s", problem.command_step[i], i == 0 ? "" : " rad");
    health.push_back({Finding::Level::note, i == 0 ? "rounding of throttle" : "rounding of steering", text,
                      problem.unrounded ? "expected values are used; what they leave open is noise"
                                        : "the car is given rounded commands"});
  }
  if (noise.command != UnknownCommands{}) {
    const auto& [steady, moving] = noise.command;
    const std::string text = format(
        "half-way off by %.3g and %.3g rad, and by %.2g and %.2g of their moves, around lines bent by %.2g "
        "and %.2g",
        steady[0], steady[1], moving[0], moving[1], problem.bend[0], problem.bend[1]);
    health.push_back(
        {Finding::Level::note, "commands between samples", text, "measured with the model; taken for noise"});
  }
  if (!has_strong_process_noise(problem, noise)) return health;
  const auto size = [&](std::size_t i) { return std::sqrt(noise.process[i]); };
  const std::string text = format("%.3g m/s2 along, %.3g m/s2 across, %.3g rad/s2 in yaw, correlation time %.2g s",
                                  size(0), size(1), size(2), problem.noise_time);
  health.push_back({problem.noise_time == default_noise_time ? Finding::Level::good : Finding::Level::note,
                    "unknown accelerations", text, "measured with the model"});
  return health;
}

std::vector<Finding> straight_commands(const Problem& problem, std::span<const measured::LogFile> held_out) {
  std::vector<Finding> rows;
  if (problem.bend == Commands{}) return rows;
  for (const measured::LogFile& log : held_out) {
    if (log.stretches.empty() || shares_bend(log.stretches.front(), problem)) continue;
    const std::string text = format("%s has one every %.3g s, the log fitted every %.3g s", log.name.c_str(),
                                    log.stretches.front().dt, problem.traces.front().log.dt);
    rows.push_back({Finding::Level::note, "commands between samples", text,
                    "left straight there: how they bend was measured at the other rate"});
  }
  return rows;
}

}  // namespace gripline::diagnose
