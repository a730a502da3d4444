#include "diagnose/inference/problem.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::diagnose {

double Problem::penalty_per_parameter() const {
  double independent = 0.0;
  if (rough_road)
    independent =
        std::min(static_cast<double>(rows), static_cast<double>(noise_states) * seconds() / (2.0 * noise_time));
  else
    for (const double rho : colour) independent += static_cast<double>(rows / channels) * (1.0 - rho) / (1.0 + rho);
  return 0.5 * std::log(std::max(1.0, independent));
}

double Problem::penalty(std::size_t parameters) const {
  const std::size_t shape = parameters - std::min(parameters, thresholds::full_penalty_parameters);
  return penalty_per_parameter() *
         (static_cast<double>(parameters - shape) + thresholds::shape_penalty * static_cast<double>(shape));
}

bool Problem::is_read(std::size_t channel) const {
  return std::ranges::any_of(traces, [channel](const Trace& trace) {
    for (std::size_t k = 0; k < trace.size(); ++k)
      if (!std::isnan(trace.log.reading[k * channels + channel])) return true;
    return false;
  });
}

double Problem::seconds() const {
  double sum = 0.0;
  for (const Trace& trace : traces) sum += static_cast<double>(trace.size()) * trace.log.dt;
  return sum;
}

measured::CommandHold Problem::hold() const {
  return traces.empty() ? measured::CommandHold{} : traces.front().log.hold;
}

void Problem::hold_commands(const measured::CommandHold& how) {
  command = {};
  bend = {};
  for (Trace& trace : traces) {
    measured::hold_commands(trace.log, how);
    trace.bend_commands(bend);
  }
}

void Problem::unround_commands() {
  unrounded = true;
  for (Trace& trace : traces) {
    trace.unround_commands(command_step);
    trace.bend_commands(bend);  // what lies between commands follows them
  }
}

std::array<double, noise_states> process_noise_ratio(const Problem& problem, const Noise& noise) {
  std::array<double, noise_states> ratio;
  for (std::size_t c = 0; c < noise_states; ++c) ratio[c] = std::sqrt(noise.process[c]) / problem.process_unit[c];
  return ratio;
}

bool has_strong_process_noise(const Problem& problem, const Noise& noise) {
  return std::ranges::min(process_noise_ratio(problem, noise)) > thresholds::strong_process_noise;
}

bool has_noticeable_process_noise(const Problem& problem, const Noise& noise) {
  return std::ranges::max(process_noise_ratio(problem, noise)) > thresholds::noticeable_process_noise;
}

std::vector<Linearised> linearise_all(const Problem& problem, const ModelSpec& model) {
  std::vector<Linearised> all;
  for (const Trace& trace : problem.traces)
    all.push_back(linearise_with_regressors(*problem.catalogue, model, trace, problem.stepping()));
  return all;
}

}  // namespace gripline::diagnose
