// The files of a diagnosis: diagnosis.json and augmented_world.json.
#pragma once

#include <filesystem>

#include "config/node.hpp"
#include "diagnose/result/diagnoser.hpp"

namespace gripline::diagnose {

/// diagnosis.json (framework/doc/diagnose.md, "What it writes").
Node diagnosis_json(const Diagnosis& d);

/// What the named effects and refitted parameters change in a world's plant: a merge patch. Throws std::logic_error
/// where effects of the world's file were left out of `world`, as they are written there by their number.
Node world_patch(const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world);

/// Writes diagnosis.json and augmented_world.json (which extends `world_file`) into a folder, creating it.
void write_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const Diagnoser& diagnoser,
                     const WorldSpec& world, const std::filesystem::path& world_file,
                     const std::optional<std::filesystem::path>& track);

}  // namespace gripline::diagnose
