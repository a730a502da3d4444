// The names of the files in a folder of results, beside those of its runs (race/run_files.hpp): what --force removes.
// Whoever writes one of them and may know this component takes its name from here, so that none is forgotten.
#pragma once

#include <array>

namespace gripline::result_files {

// Of any experiment.
inline constexpr const char* scene = "scene.json";
inline constexpr const char* claims = "claims.json";
// Of races.
inline constexpr const char* provenance = "provenance.json";
inline constexpr const char* track = "track.csv";
inline constexpr const char* runs = "runs.csv";
inline constexpr const char* table = "table.csv";
inline constexpr const char* pairs = "pairs.csv";
// Of validations.
inline constexpr const char* validation = "validation.csv";
inline constexpr const char* validation_traces = "validation_traces.csv";
// Of the kind "measured".
inline constexpr const char* errors = "errors.csv";
inline constexpr const char* ablation = "ablation.csv";
inline constexpr const char* parameters = "parameters.csv";
inline constexpr const char* samples = "samples.csv";
inline constexpr const char* fitted = "fitted.json";
inline constexpr const char* measured = "measured.json";

inline constexpr std::array all = {scene, claims, provenance, track, runs, table, pairs, validation, validation_traces,
                                   errors, ablation, parameters, samples, fitted, measured,
                                   // Written by the components report and diagnose.
                                   "report.html", "diagnosis.json", "diagnosis_report.json", "augmented_world.json",
                                   "diagnoses.csv", "nominal_world.json", "score.csv", "scorecard.txt"};

}  // namespace gripline::result_files
