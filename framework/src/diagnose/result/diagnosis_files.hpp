// The files of a diagnosis: diagnosis.json and augmented_world.json (framework/doc/diagnose.md), the report's data.
#pragma once

#include <filesystem>

#include "config/node.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

Node diagnosis_json(const Diagnosis& d);

/// What the named effects and refitted parameters change in a world's plant: a merge patch.
Node world_patch(const Diagnosis& d, const Diagnoser& diagnoser, const WorldSpec& world);

/// case.json (framework/doc/diagnose-cases.md): exclude, nominal_uncertainty, noise_sigma; `track` is
/// resolved beside the case or in ../../tracks.
struct CaseFile {
  CaseOptions options;
  std::optional<std::filesystem::path> track;
  std::string vehicle;
};
CaseFile read_case(const std::filesystem::path& file);
/// The object nominal_uncertainty, of a case or of a world.
void read_uncertainty(const Node& node, CaseOptions& options, Errors& errors);

/// Writes diagnosis.json and augmented_world.json (which extends `world_file`) into a folder, creating it.
void write_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const Diagnoser& diagnoser,
                     const WorldSpec& world, const std::filesystem::path& world_file,
                     const std::optional<std::filesystem::path>& track);

}  // namespace gripline::diagnose
