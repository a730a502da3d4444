#include "report/report.hpp"

#include <system_error>

#include "config/errors.hpp"
#include "report/figures.hpp"
#include "report/inputs.hpp"
#include "report/measured_page.hpp"
#include "report/page.hpp"
#include "report/sweep_page.hpp"
#include "util/whole_file.hpp"

namespace gripline::report {
namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw std::runtime_error("cannot make " + folder.string() + ": " + failed.message());
}

std::vector<std::filesystem::path> write_figures(const Inputs& inputs, const std::filesystem::path& folder) {
  make_folder(folder);
  std::vector<std::filesystem::path> written;
  const std::vector<FigureFile> measured =
      inputs.measured.is_object() ? measured_figures(inputs.measured) : std::vector<FigureFile>{};
  for (const std::vector<FigureFile>& figures : {race_figures(inputs), model_figures(inputs), measured})
    for (const FigureFile& figure : figures) {
      write_file(folder / figure.name, figure.svg);
      written.push_back(folder / figure.name);
    }
  return written;
}

/// A sweep's folder has tables of the same names and no run's files: its page is made of its own file alone.
Written write_sweep_report(const Options& options, const nlohmann::json& data) {
  Written written;
  written.page = options.page.empty() ? options.folder / "report.html" : options.page;
  const std::string html = sweep_page(data);
  write_file(written.page, html);
  written.bytes = html.size();
  if (!options.figures) return written;
  const std::filesystem::path folder =
      options.figure_folder.empty() ? options.folder / "figures" : options.figure_folder;
  make_folder(folder);
  for (const FigureFile& figure : sweep_figures(data)) {
    write_file(folder / figure.name, figure.svg);
    written.figures.push_back(folder / figure.name);
  }
  return written;
}

}  // namespace

Written write_report(const Options& options) try {
  if (const nlohmann::json sweep = read_json(options.folder / "sweep_report.json"); sweep.is_object())
    return write_sweep_report(options, sweep);
  const Inputs inputs = read_inputs(options.folder);
  Written written;
  written.page = options.page.empty() ? options.folder / "report.html" : options.page;
  const std::string html = inputs.measured.is_object() ? measured_page(inputs.measured, inputs.scene, inputs.claims)
                                                       : page_html(inputs, options.progress);
  write_file(written.page, html);
  written.bytes = html.size();
  if (options.figures)
    written.figures =
        write_figures(inputs, options.figure_folder.empty() ? options.folder / "figures" : options.figure_folder);
  return written;
} catch (const nlohmann::json::exception& error) {
  throw InputError(options.folder.string() + ": a JSON file there is not as gripline wrote it: " + error.what());
}

}  // namespace gripline::report
