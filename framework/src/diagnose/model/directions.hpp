// Directions in which a model may change: by its own parameters, and by what candidates would add.
#pragma once

#include "diagnose/model/linear_model.hpp"

namespace gripline::diagnose {

/// A model along a trace with the directions of its own free parameters: nuisances first, then every fitted parameter of
/// the members.
struct Linearised {
  LinearModel lm;
  std::vector<Direction> own;
  /// What evaluating it costs for each sample, in arbitrary units that no clock enters: the filter's matrices, the
  /// integration, and the memory run anew for directions found by moving a parameter. The bare car takes 4 or 5.
  double work = 0;
};
Linearised linearise_own(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace, int substeps);

/// A group of directions: what a candidate could add to the model.
struct Group {
  std::size_t candidate = 0;
  std::size_t first = 0, count = 0;         // among the directions
  std::vector<std::vector<double>> starts;  // scanned candidates: for each direction all parameters at that start
};

/// Directions of every candidate that may be named and is not in the model, from its neutral value. `lm` is the model's.
void candidate_directions(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace, const LinearModel& lm,
                          std::vector<Direction>& directions, std::vector<Group>& groups);

}  // namespace gripline::diagnose
