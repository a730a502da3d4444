// gripline export: results in the formats of other people's tools.
#include <cmath>
#include <iostream>
#include <optional>
#include <sstream>

#include "cli/companion.hpp"
#include "cli/options.hpp"
#include "config/errors.hpp"
#include "exports/foxglove.hpp"
#include "exports/runs.hpp"
#include "exports/video.hpp"
#include "exports/wide_csv.hpp"
#include "gripline/command.hpp"
#include "report/report.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"
#include "util/whole_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

/// The names of a list, which are of rows or seeds; none when the option was not given.
Words list_of(const po::variables_map& given, const std::string& name, const char* one) {
  const auto text = text_of(given, name.c_str());
  return text ? names_of("--" + name, *text, one) : Words{};
}

double number_of(const po::variables_map& given, const char* name, double otherwise) {
  const std::optional<std::string> text = text_of(given, name);
  if (!text) return otherwise;
  const std::optional<double> value = parse_number(*text);
  if (!value || !std::isfinite(*value)) {
    std::string words = "--";
    words.append(name).append(": expected a number, found \"").append(*text).append("\"");
    throw InputError(words);
  }
  return *value;
}

exports::VideoOptions video_options(const po::variables_map& given) {
  exports::VideoOptions options;
  if (const std::optional<std::string> size = text_of(given, "size")) {
    char x = 0;
    std::istringstream in(*size);
    if (!(in >> options.width >> x >> options.height) || x != 'x' || !in.eof())
      throw InputError("--size: expected WIDTHxHEIGHT in pixels, found \"" + *size + "\"");
  }
  if (const auto fps = text_of(given, "fps")) options.fps = static_cast<int>(whole_number("--fps", *fps, {1, 120}));
  options.rate = number_of(given, "rate", options.rate);
  options.from = number_of(given, "from", options.from);
  options.to = number_of(given, "to", options.to);
  options.follow = given.count("follow") > 0;
  return options;
}

void say_written(const std::string& what, const std::string& file) { std::cout << what << ": " << file << '\n'; }

/// Draws the page anew and films it, so that the video shows what the files say now.
void export_video(const std::filesystem::path& folder, const std::string& file, const exports::VideoOptions& options) {
  report::Options page;
  page.folder = folder;
  page.page = std::filesystem::path(file + ".html");
  const report::Written written = report::write_report(page);
  CallbackProgress progress(std::cerr, "video");
  const auto callback = progress.callback();
  try {
    exports::write_video(written.page, file, options, [&](std::size_t done, std::size_t total) {
      callback(static_cast<double>(done), total, "pictures");
    });
  } catch (...) {
    std::filesystem::remove(written.page);
    throw;
  }
  std::filesystem::remove(written.page);
  progress.finish();
}

}  // namespace

int run_export(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("mcap", po::value<std::string>(), "an MCAP file for Foxglove");
  add("csv", po::value<std::string>(), "one wide CSV file for PlotJuggler: t_s, then row/column");
  add("hdf5", po::value<std::string>(),
      "an HDF5 file of all tables, of a comparison or a sweep, for h5py, MATLAB and R; where built with HDF5");
  add("video", po::value<std::string>(), "the replay as an MP4 file; needs Chromium and ffmpeg");
  add("only", po::value<std::string>(), "these rows, separated by commas (default: all)");
  add("seed", po::value<std::string>(), "these seeds, separated by commas (default: the first of each row)");
  add("size", po::value<std::string>(), "of the video: WIDTHxHEIGHT in pixels (default 1280x720)");
  add("fps", po::value<std::string>(), "of the video: pictures a second (default 25)");
  add("rate", po::value<std::string>(), "of the video: seconds of the race in one second (default 1)");
  add("from", po::value<std::string>(), "of the video: where it begins [s] (default 0)");
  add("to", po::value<std::string>(), "of the video: where it ends [s] (default: with the race)");
  add("follow", "of the video: follow one car");
  add("help,h", "this text");
  const auto given = parse_options(
      args, visible, "export OUT --mcap FILE | --csv FILE | --hdf5 FILE | --video FILE [options]", "results");
  if (!given) return good;
  const Words folders = words_of(*given, "results");
  if (folders.size() != 1) throw InputError("which results? One folder, for example out/table1");
  const auto mcap = text_of(*given, "mcap"), csv = text_of(*given, "csv");
  const auto hdf5 = text_of(*given, "hdf5"), video = text_of(*given, "video");
  if (!mcap && !csv && !hdf5 && !video)
    throw InputError("export what? --mcap FILE, --csv FILE, --hdf5 FILE or --video FILE");
  for (const auto& [option, file] :
       {std::pair{"--mcap", mcap}, std::pair{"--csv", csv}, std::pair{"--hdf5", hdf5}, std::pair{"--video", video}})
    if (file) require_writable(option, *file, {});
  const exports::VideoOptions film = video_options(*given);
  if (video) exports::require_video_programs();
  if (mcap || csv) {
    const exports::Results results =
        exports::read_results(folders.front(), {list_of(*given, "only", "row"), list_of(*given, "seed", "seed")});
    if (mcap) write_file(*mcap, exports::foxglove_mcap(results));
    if (mcap) say_written("mcap", *mcap);
    if (csv) write_file(*csv, exports::wide_csv(results.runs));
    if (csv) say_written("csv", *csv);
  }
  if (video) export_video(folders.front(), *video, film);
  if (video) say_written("video", *video);
  if (hdf5)
    exec_companion("gripline-hdf5", "export --hdf5 (HDF5 when gripline was built)", Words{folders.front(), *hdf5});
  return good;
}

}  // namespace gripline::tools
