// What is to be explained: logs with their references, noise levels, and what a parameter costs.
#pragma once

#include <vector>

#include "diagnose/inference/filter.hpp"
#include "diagnose/model/regressors.hpp"
#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {

/// Input of fits and searches. Holds a pointer to the catalogue.
struct Problem {
  const Catalogue* catalogue = nullptr;
  std::vector<Trace> traces;
  Channels sensor{};                                // standard deviations of the readings
  std::array<double, noise_states> process_unit{};  // typical size of unknown accelerations [m/s2, m/s2, rad/s2]
  int substeps = 2;                                 // of integration, per sample
  Channels colour{};                                // of the readings' noise, see Noise::colour
  double noise_time = default_noise_time;           // correlation time of unknown accelerations [s]
  UnknownCommands command;                          // between samples, see Noise::command
  Commands bend{};                                  // of the commands of all traces, see measured::bend_commands
  double hold_time = 0.0;   // [s] for which the world holds each command, where the log left some of them out; else 0
  Commands command_step{};  // to which commands were rounded, where that counts; 0: not
  bool unrounded = false;   // whether the traces' commands are the expected ones, see measured::unround_commands
  std::size_t rows = 0;     // readings of all traces
  bool rough_road = false;  // whether independent accelerations count as data, see penalty_per_parameter()
  /// Whether profiles along the lap have a prior of their parameters' scales around zero: where no data are they are
  /// not determined otherwise.
  bool shape_prior = false;

  /// Schwarz's penalty [log likelihood]: half the logarithm of the number of independent readings, of which one whose
  /// noise is coloured counts for less. On a rough road, of the independent values of its accelerations: one per
  /// channel in twice their correlation time.
  double penalty_per_parameter() const;
  /// Penalty of one effect with so many parameters [log likelihood]: see thresholds::full_penalty_parameters.
  double penalty(std::size_t parameters) const;
  /// How models are brought from sample to sample.
  Stepping stepping() const { return {substeps, noise_time, command != UnknownCommands{}}; }
  /// Whether any trace has a reading of this channel.
  bool is_read(std::size_t channel) const;
  /// Duration of all traces together [s].
  double seconds() const;
  /// What commands do between samples, of all traces.
  measured::CommandHold hold() const;
  /// Sets it; nothing is bent or unknown of the commands then.
  void hold_commands(const measured::CommandHold& how);
  /// Takes commands as rounded by the recorder: sets `unrounded`.
  void unround_commands();
};

/// What a model is fitted for: to be compared with others, or as the result. Derivatives of the likelihood are taken
/// along predicted motion (predicted_motion.hpp) on a rough road only, and of a result wherever motion holds noise. A
/// deficient model leaves such noise, too, and predicts worse than it smooths: what is compared is not fitted so.
enum class FitFor { comparison, result };

/// Standard deviations of the unknown accelerations over their typical size.
std::array<double, noise_states> process_noise_ratio(const Problem& problem, const Noise& noise);
/// Whether all three accelerations are random (a rough road). A deficient model shows as noise in one or two of them.
bool has_strong_process_noise(const Problem& problem, const Noise& noise);
/// Whether any of them is.
bool has_noticeable_process_noise(const Problem& problem, const Noise& noise);

/// A model along every trace.
std::vector<Linearised> linearise_all(const Problem& problem, const ModelSpec& model);

}  // namespace gripline::diagnose
