// The folder of one run, OUT/<stack>/<seed>/: its files are written into OUT/<stack>/.<seed>.partial/ and renamed when
// they are complete, so that a run is there whole or not at all.
#pragma once

#include <filesystem>
#include <string>

#include "experiment/run_key.hpp"
#include "experiment/run_result.hpp"

namespace gripline {

std::filesystem::path run_folder(const std::filesystem::path& out, const RunId& id);
std::filesystem::path partial_folder(const std::filesystem::path& out, const RunId& id);

/// The key under which a failed run is kept. It differs from run_key(), so that the run is shown in tables and still
/// raced again by the next call.
std::string broken_key(const std::string& key);

/// Whether other runs may have been driven while this one was; only times measured exclusively are compared.
enum class MachineUse { shared, exclusive };

/// Writes the summary into the partial folder and puts that in the place of the run's folder, if there is one already.
/// These three throw std::runtime_error with the system's reason.
void keep_run(const RunSummary& summary, const std::string& key, const std::filesystem::path& out,
              MachineUse use = MachineUse::shared);

/// Makes the folder of a run that was not driven because it would equal `driven` to the last bit: a summary alone.
void keep_copied_run(const RunResult& driven, std::uint64_t seed, const std::string& key,
                     const std::filesystem::path& out);

/// Keeps the rows written so far of a run whose process failed, with a summary that says why.
void keep_broken_run(const RaceSpec& race, const RunId& id, const std::filesystem::path& out, const std::string& key,
                     const std::string& why);

}  // namespace gripline
