// The folder an experiment writes: claimed, continued or refused.
#pragma once

#include <filesystem>
#include <string>

#include "experiment.hpp"

namespace gripline {

/// Makes OUT ready for an experiment with this identity. An existing folder that is not empty is refused (InputError)
/// unless it holds the same experiment (finished runs are then kept) or `force` (its contents are then removed; a
/// folder that gripline did not make is never emptied).
void open_out_folder(const std::filesystem::path& out, const std::string& identity, bool force);

/// What the report needs to know once per experiment: scene.json, track.csv, provenance.json.
void write_scene(const std::filesystem::path& out, const RaceSpec& race, const Registry& registry);

}  // namespace gripline
