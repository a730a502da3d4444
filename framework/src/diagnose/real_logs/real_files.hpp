// The files of a real car's diagnosis: diagnosis.json and augmented_world.json, and what the report adds to them.
#pragma once

#include <filesystem>
#include <list>
#include <string>

#include "config/node.hpp"
#include "diagnose/real_logs/cornering.hpp"
#include "diagnose/result/diagnosis.hpp"
#include "plugin/registry.hpp"

namespace gripline::diagnose {

/// diagnosis.json (framework/doc/diagnose.md, "Logs of real cars").
Node real_diagnosis_json(const Diagnosis& d, const MissingEffects& found, const Cornering& corners);

/// Writes diagnosis.json and augmented_world.json into a folder that is there.
void write_real_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const MissingEffects& found,
                          const Cornering& corners);

/// diagnosis_report.json: the sentence, the logs with what was found about them, the calibrated parameters, and effects
/// in the words of their plugins.
Node real_report(const Diagnosis& d, const MissingEffects& found, const std::string& world_file,
                 const Registry& registry, const std::list<measured::SessionFile>& files);

}  // namespace gripline::diagnose
