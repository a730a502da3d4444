// gripline import LOG --map MAP.json --out LOG.gripline.csv: a logger's table in gripline's
// own columns, and its health. gripline import --guess LOG [--out MAP.json]: a first map.
#include <cmath>
#include <fstream>
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "measured/delimited_table.hpp"
#include "measured/gripline_log.hpp"
#include "measured/log_guess.hpp"
#include "measured/session_health.hpp"
#include "util/csv_writer.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

void print(const std::vector<measured::Finding>& findings) {
  std::size_t width = 5, middle = 5;
  for (const measured::Finding& f : findings) {
    width = std::max(width, f.check.size());
    middle = std::max(middle, f.found.size());
  }
  const auto pad = [](const std::string& text, std::size_t to) {
    return text + std::string(to - text.size() + 2, ' ');
  };
  std::cout << pad("check", width) << pad("found", middle) << "done\n";
  for (const measured::Finding& f : findings)
    std::cout << pad(f.check, width) << pad(f.found, middle) << f.done
              << (f.level == measured::Finding::Level::bad ? "  (!)" : "") << '\n';
}

int guess(const fs::path& log, const po::variables_map& given) {
  const measured::Guess guessed = measured::guess_map(measured::read_delimited(log));
  const std::string text = to_json_text(guessed.map);
  if (const auto named = text_of(given, "out")) {
    const fs::path out = *named;
    require_writable("--out", out, Words{log.string()});
    write_file(out, text);
    std::cerr << "map: " << out.string() << '\n';
  } else {
    std::cout << text;
  }
  for (const std::string& remark : guessed.remarks) std::cerr << remark << '\n';
  return good;
}

}  // namespace

int run_import(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("map", po::value<std::string>(), "what the columns mean, JSON; without it gripline's own columns");
  add("out", po::value<std::string>(), "the log to write; with --guess the map");
  add("guess", po::bool_switch(), "write a first map for this log");
  add("v-ref", po::value<double>()->default_value(0.0),
      "typical speed of the car, for the checks [m/s]; 0: from the log");
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "import LOG --map MAP.json [--out LOG.gripline.csv]", "log");
  if (!given) return good;
  const Words words = words_of(*given, "log");
  if (words.size() != 1)
    throw InputError("import needs one log: gripline import LOG --map MAP.json --out LOG.gripline.csv");
  const fs::path log = words.front();
  if ((*given)["guess"].as<bool>()) return guess(log, *given);

  const auto mapped = text_of(*given, "map");
  const measured::LogMap map = mapped ? measured::load_log_map(*mapped) : measured::gripline_map();
  const fs::path out = text_of(*given, "out").value_or(log.stem().string() + ".gripline.csv");
  Words inputs{log.string()};
  if (mapped) inputs.push_back(*mapped);
  require_writable("--out", out, inputs);

  const measured::SessionFile file = measured::read_session(log, map);
  const double v_ref = (*given)["v-ref"].as<double>();
  measured::check_session(file, v_ref > 0.0 ? v_ref : measured::typical_speed(file.session));
  print(measured::health_of(file));
  const auto remarks = measured::write_gripline_log(out, file, map);
  for (const std::string& remark : remarks) std::cout << remark << '\n';
  std::cout << "log: " << out.string() << '\n';
  return good;
}

}  // namespace gripline::tools
