// The names of the files in a folder of results, beside those of its runs (race/run_files.hpp): what --force removes.
// Whoever may know this component takes them from here, so that none is forgotten; the components report,
// diagnose/result and diagnose/real_logs may not.
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

// Of diagnoses.
inline constexpr const char* diagnosis = "diagnosis.json";
inline constexpr const char* diagnosis_report = "diagnosis_report.json";
inline constexpr const char* augmented_world = "augmented_world.json";
inline constexpr const char* diagnoses = "diagnoses.csv";
inline constexpr const char* nominal_world = "nominal_world.json";
inline constexpr const char* score = "score.csv";
inline constexpr const char* scorecard = "scorecard.txt";

// clang-format off
inline constexpr std::array all = {
    scene, claims, provenance, track, runs, table, pairs, validation, validation_traces, errors, ablation, parameters,
    samples, fitted, measured, diagnosis, diagnosis_report, augmented_world, diagnoses, nominal_world, score, scorecard,
    "report.html"};
// clang-format on

}  // namespace gripline::result_files
