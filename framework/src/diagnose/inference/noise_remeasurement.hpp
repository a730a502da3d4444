// What a search has assumed of noise and of commands, asked again with the best model that it has found. What was found
// under other assumptions is then forgotten: the pool has a new null model and nothing else.
#pragma once

#include "diagnose/inference/model_pool.hpp"

namespace gripline::diagnose {

/// Whether commands are held from row to row, linear between them, or held in steps that the log left out: up to half a
/// sample lies between these, which otherwise is an effect's. Another is taken where the log is as likely in it with
/// fewer effects, or significantly likelier with the same. Returns the new null model, or null where all stays as it
/// is.
const Fit* hold_commands_anew(ModelPool& pool, const Road& road, const Fit& null_model, const Fit& found);

/// Measures the noise with the best model where it is not what was assumed: coloured, unknown accelerations with
/// another correlation time, or commands that the log leaves out. Returns the new null model, or null where all stays
/// as it is.
const Fit* measure_noise_anew(ModelPool& pool, const Road& road, const Fit& null_model, const Fit& best);

}  // namespace gripline::diagnose
