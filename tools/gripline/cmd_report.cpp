// gripline report: the page and the figures of a results folder.
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "report/report.hpp"
#include "util/progress.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

report::Written write_with_progress(report::Options options) {
  CallbackProgress progress(std::cerr, "report");
  options.progress = [callback = progress.callback()](std::size_t done, std::size_t total, const std::string& what) {
    callback(static_cast<double>(done), total, what);
  };
  report::Written written = write_report(options);
  progress.finish();
  return written;
}

/// Refuses a --page that is one of the files the report is made from.
void require_page(const std::filesystem::path& page, const std::filesystem::path& folder) {
  std::vector<std::string> inputs;
  std::error_code failed;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, failed))
    if (entry.is_regular_file(failed) && entry.path().extension() != ".html") inputs.push_back(entry.path().string());
  require_writable("--page", page, inputs);
}

std::string size_text(std::size_t bytes) {
  const std::size_t tenths = bytes / 100000;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " MB";
}

}  // namespace

int run_report(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("figures", "write the figures as SVG files too, into OUT/figures");
  add("page", po::value<std::string>(), "the page to write (default: OUT/report.html)");
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "report OUT [options]", "results");
  if (!given) return good;
  const Words folders = words_of(*given, "results");
  if (folders.empty()) throw InputError("which results? For example out/table1");
  if (folders.size() > 1) throw InputError("one folder at a time; found " + folders[0] + " and " + folders[1]);
  report::Options options;
  options.folder = folders.front();
  options.figures = given->count("figures") > 0;
  if (given->count("page") > 0) {
    options.page = (*given)["page"].as<std::string>();
    require_page(options.page, options.folder);
  }
  const report::Written written = write_with_progress(std::move(options));
  std::cout << "report: " << written.page.string() << " (" << size_text(written.bytes) << ")\n";
  for (const std::filesystem::path& figure : written.figures) std::cout << "figure: " << figure.string() << '\n';
  return good;
}

bool write_case_report(const std::filesystem::path& folder) {
  try {
    report::Options options;
    options.folder = folder;
    write_report(options);
    return true;
  } catch (const std::exception& e) {
    std::cerr << "no report: " << e.what() << '\n';
    return false;
  }
}

bool report_results(const std::filesystem::path& folder) {
  try {
    report::Options options;
    options.folder = folder;
    std::cout << "report: " << write_with_progress(std::move(options)).page.string() << '\n';
    return true;
  } catch (const std::exception& e) {
    std::cerr << "no report: " << e.what() << '\n';
    return false;
  }
}

}  // namespace gripline::tools
