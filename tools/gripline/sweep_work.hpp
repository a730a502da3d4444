// What the words of `gripline sweep` do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sweep/sweep.hpp"

namespace gripline::tools {

/// How the runs of a sweep are to be had.
struct SweepWork {
  std::filesystem::path out;
  std::string engine = "local";
  int jobs = 0;           // 0: one per core
  std::size_t chunk = 0;  // 0: the engine's own
  bool wait = false, resume = false;
  std::filesystem::path scratch;  // absolute; empty: in OUT
  std::string partition, time, mem;
  std::vector<std::string> sbatch;
};

/// Prints count, time and disk; one run is driven and thrown away to know them, unless OUT has some. Exit code.
int plan_sweep(const sweep::Request& request, const SweepWork& work);
/// Writes the manifest and has done what is missing. All give the program's exit code: 0, 75 when runs are missing that
/// --resume may have, 4 when runs broke, 3 when versions differ.
int start_sweep(const sweep::Request& request, const SweepWork& work);
int continue_sweep(const SweepWork& work);
int sweep_status(const std::filesystem::path& out);
int sweep_cancel(const std::filesystem::path& out);
int sweep_merge(const std::filesystem::path& out);
/// One task of a batch, as an engine's job runs it.
int sweep_task(const std::filesystem::path& out, const std::string& batch, const std::string& task);

}  // namespace gripline::tools
