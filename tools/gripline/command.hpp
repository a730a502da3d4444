// The commands of the program: one function each, one file each.
#pragma once

#include <filesystem>

#include "cli/program.hpp"

namespace gripline::tools {

int run_compare(Arguments args);
int run_one(Arguments args);
int run_validate(Arguments args);
int run_plugins(Arguments args);
int run_bench_command(Arguments args);
int run_report(Arguments args);
int run_columns(Arguments args);
int run_diagnose(Arguments args);
int run_predict(Arguments args);
int run_import(Arguments args);
int run_fit(Arguments args);
int run_limit(Arguments args);
int run_track(Arguments args);
int run_sweep(Arguments args);
int run_export(Arguments args);

/// Writes the report of a folder that was just filled and says where it is. A report that cannot be written is said on
/// stderr and spoils nothing that is there: false.
bool report_results(const std::filesystem::path& folder);
/// Writes the report of one of an experiment's many cases: as report_results(), but silent unless it fails.
bool write_case_report(const std::filesystem::path& folder);

}  // namespace gripline::tools
