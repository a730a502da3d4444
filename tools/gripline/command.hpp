// The commands of the program: one function each, one file each.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace gripline::tools {

/// Exit codes of the program.
enum Exit : int { good = 0, claim_failed = 1, bad_input = 2, plugin_unusable = 3, run_broke = 4 };

using Arguments = std::span<const std::string>;

int run_compare(Arguments args);
int run_one(Arguments args);
int run_validate(Arguments args);
int run_plugins(Arguments args);
int run_bench_command(Arguments args);
int run_report(Arguments args);
int run_diagnose(Arguments args);
int run_predict(Arguments args);

/// Writes the report of a folder that was just filled and says where it is. A report that cannot be written is said on
/// stderr and spoils nothing.
void report_results(const std::filesystem::path& folder);
/// The same without a word unless it fails: one of many.
void write_case_report(const std::filesystem::path& folder);

}  // namespace gripline::tools
