#include "diagnose/inference/measured_noise.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::diagnose {

MeasuredNoise higher_peak(const MeasuredNoise& all, const MeasuredNoise& fewer) {
  return fewer.gain > all.gain + thresholds::noise_gain ? fewer : all;
}

bool differs_from_assumed(const Problem& problem, const MeasuredNoise& measured) {
  const auto differs = [](double a, double b) {
    return std::max(a, b) > thresholds::other_noise_factor * std::min(a, b);
  };
  bool other = differs(measured.noise_time, problem.noise_time);
  for (std::size_t i = 0; i < measured.bend.size(); ++i) {
    other |= differs(measured.noise.command.steady[i], problem.command.steady[i]);
    other |= differs(measured.noise.command.moving[i], problem.command.moving[i]);
    other |= std::abs(measured.bend[i] - problem.bend[i]) > thresholds::other_bend;
  }
  for (std::size_t c = 0; c < channels; ++c) {
    other |= differs(measured.noise.sensor[c], problem.sensor[c]);
    other |= std::abs(measured.noise.colour[c] - problem.colour[c]) > thresholds::other_colour;
  }
  return other;
}

bool is_simpler(const Problem& problem, const MeasuredNoise& measured) {
  bool gone = false, come = false;
  const auto count = [&](double assumed, double now) {
    gone |= assumed != 0.0 && now == 0.0;
    come |= assumed == 0.0 && now != 0.0;
  };
  for (std::size_t c = 0; c < channels; ++c) count(problem.colour[c], measured.noise.colour[c]);
  for (std::size_t i = 0; i < measured.bend.size(); ++i) {
    count(problem.bend[i], measured.bend[i]);
    count(problem.command.steady[i], measured.noise.command.steady[i]);
    count(problem.command.moving[i], measured.noise.command.moving[i]);
  }
  return gone && !come;
}

void assume(Problem& problem, const MeasuredNoise& measured) {
  problem.sensor = measured.noise.sensor;
  problem.colour = measured.noise.colour;
  problem.noise_time = measured.noise_time;
  problem.command = measured.noise.command;
  if (problem.bend != measured.bend)
    for (Trace& trace : problem.traces) trace.bend_commands(measured.bend);
  problem.bend = measured.bend;
  problem.rough_road = false;
}

}  // namespace gripline::diagnose
