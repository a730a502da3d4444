#include "report/report.hpp"

#include <system_error>

#include "config/errors.hpp"
#include "report/figures.hpp"
#include "report/inputs.hpp"
#include "report/measured_page.hpp"
#include "report/page.hpp"
#include "util/csv_writer.hpp"

namespace gripline::report {
namespace {

std::vector<std::filesystem::path> write_figures(const Inputs& inputs, const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw std::runtime_error("cannot make " + folder.string() + ": " + failed.message());
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

}  // namespace

Written write_report(const Options& options) try {
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
