#include "report/report.hpp"

#include <fstream>
#include <stdexcept>
#include <system_error>

#include "report/inputs.hpp"
#include "report/page.hpp"

namespace gripline::report {
namespace {

namespace fs = std::filesystem;

/// Aside, then renamed: whoever looks finds a whole file or none.
void write_whole(const fs::path& file, const std::string& text) {
  const fs::path aside = file.parent_path() / ("." + file.filename().string() + ".part");
  std::ofstream out(aside, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  std::error_code failed;
  if (out) fs::rename(aside, file, failed);
  if (!out || failed) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    throw std::runtime_error(file.string() +
                             ": cannot be written; expected a folder one may write to and room on the disk");
  }
}

}  // namespace

Written write_report(const Options& options) {
  const Inputs inputs = read_inputs(options.folder);
  Written written;
  written.page = options.page.empty() ? options.folder / "report.html" : options.page;
  const std::string html = page_html(inputs, options.progress);
  write_whole(written.page, html);
  written.bytes = html.size();
  return written;
}

}  // namespace gripline::report
