// `gripline report`: one self-contained page, and the figures as SVG files, from an OUT folder. Runs nothing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gripline::report {

struct Options {
  std::filesystem::path folder;         ///< what compare, run or diagnose wrote
  std::filesystem::path page;           ///< empty: folder / "report.html"
  bool figures = false;                 ///< write the SVG figures too
  std::filesystem::path figure_folder;  ///< empty: folder / "figures"
  std::function<void(std::size_t done, std::size_t total, const std::string& what)> progress;  ///< may be empty
};

struct Written {
  std::filesystem::path page;
  std::size_t bytes = 0;
  std::vector<std::filesystem::path> figures;
};

/// Writes the page, whole or not at all (aside, then renamed), and the figures if asked for. Same folder, same bytes.
/// Throws InputError with one line when there is nothing to report or a file cannot be read, std::runtime_error when
/// one cannot be written.
Written write_report(const Options& options);

}  // namespace gripline::report
