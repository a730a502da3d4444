// gripline import LOG --map MAP.json --out LOG.gripline.csv: a logger's table, or a bag of ROS, in gripline's
// own columns, and its health. gripline import --guess LOG [--out MAP.json]: a first map.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string_view>

#include "bags/bag_guess.hpp"
#include "bags/bag_table.hpp"
#include "cli/companion.hpp"
#include "cli/options.hpp"
#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "gripline/import_bag.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/health/session_health.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/gripline_log.hpp"
#include "measured/session/log_guess.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_windows.hpp"
#include "tables/delimited_table.hpp"
#include "util/whole_file.hpp"

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
  const auto is_bad = [](const measured::Finding& f) { return f.level == measured::Finding::Level::bad; };
  std::cout << pad("check", width) << pad("found", middle) << "done\n";
  for (const measured::Finding& f : findings)
    std::cout << pad(f.check, width) << pad(f.found, middle) << f.done << (is_bad(f) ? "  (!)" : "") << '\n';
  if (std::ranges::any_of(findings, is_bad))
    std::cout << "(!): look at this before the log is used: the log or its map may be wrong there, or the log cannot "
                 "show what is named\n";
}

/// A recording of ROS, by its first bytes or, of what cannot be read, by its name.
bool is_bag(const fs::path& log) {
  std::array<char, 9> begin{};
  std::ifstream(log, std::ios::binary).read(begin.data(), begin.size());
  const std::string_view text(begin.data(), begin.size());
  constexpr std::array<std::string_view, 4> endings = {".bag", ".db3", ".mcap", ".zstd"};  // the last two: refused
  return text == "#ROSBAG V" || text == "SQLite fo" ||
         std::find(endings.begin(), endings.end(), log.extension().string()) != endings.end();
}

void append_cell(std::string& line, double value) {
  std::array<char, 40> digits{};
  if (!std::isnan(value))
    line.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  line += ',';
}

/// What the map reads of a bag, for commands that read tables with the same map.
void write_table(const fs::path& file, const DelimitedTable& table) {
  std::string out;
  for (const std::string& name : table.name) out += name + ',';
  out.back() = '\n';
  for (std::size_t r = 0; r < table.rows(); ++r) {
    for (const std::vector<double>& column : table.column) append_cell(out, column[r]);
    out.back() = '\n';
  }
  write_file(file, out);
  std::cout << "table: " << file.string() << '\n';
}

int guess(const fs::path& log, const po::variables_map& given, OpenBag open) {
  const measured::Guess guessed = is_bag(log) ? bags::guess_map(*open(log)) : measured::guess_map(read_delimited(log));
  const std::string text = to_json_text(guessed.map);
  if (const auto named = text_of(given, "out")) {
    const fs::path out = *named;
    require_writable("--out", out, Words{log.string()});
    // A map is edited by hand: a new guess must not take its place unasked.
    if (fs::is_regular_file(out) && given.count("force") == 0)
      throw InputError(out.string() +
                       " exists, and may have been edited; expected another --out, or --force to replace it");
    write_file(out, text);
    std::cerr << "map: " << out.string() << '\n';
  } else {
    std::cout << text;
  }
  for (const std::string& remark : guessed.remarks) std::cerr << remark << '\n';
  if (guessed.open.empty()) return good;
  std::string unnamed;
  for (const std::string& channel : guessed.open) unnamed += (unnamed.empty() ? "" : ", ") + channel;
  std::cerr << log.string() << ": no column looks like " << unnamed
            << ": fill in \"column\": \"?\" there; the notes beside it list columns and their ranges\n";
  return bad_input;
}

}  // namespace

int import_log(Arguments args, OpenBag open) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("map", po::value<std::string>(), "what the columns mean, JSON; without it gripline's own columns");
  add("out", po::value<std::string>(), "the log to write; with --guess the map");
  add("guess", po::bool_switch(), "write a first map for this log");
  add("force", "with --guess: replace the map that is there");
  add("table", po::value<std::string>(), "of a bag of ROS: write what the map reads of it as CSV, for fit and predict");
  add("v-ref", po::value<double>()->default_value(0.0),
      "typical speed of the car, for the checks [m/s]; 0: from the log");
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "import LOG --map MAP.json [--out LOG.gripline.csv]", "log");
  if (!given) return good;
  const Words words = words_of(*given, "log");
  if (words.size() != 1)
    throw InputError("import needs one log: gripline import LOG --map MAP.json --out LOG.gripline.csv");
  const fs::path log = words.front();
  const bool bag = is_bag(log);
  if (bag && open == nullptr)
    exec_companion("gripline-bags", "import of ROS bags (built with gripline: cmake --build build)", args);
  if ((*given)["guess"].as<bool>()) return guess(log, *given, open);

  const auto mapped = text_of(*given, "map"), table_file = text_of(*given, "table");
  if (bag && !mapped)
    throw InputError("a bag needs a map of its topics: --map MAP.json (gripline import --guess " + log.string() +
                     " writes a first one)");
  if (!bag && table_file) throw InputError("--table is of bags: " + log.string() + " is a table already");
  const measured::LogMap map = mapped ? measured::load_log_map(*mapped) : measured::gripline_map();
  const fs::path out = text_of(*given, "out").value_or(log.stem().string() + ".gripline.csv");
  Words inputs{log.string()};
  if (mapped) inputs.push_back(*mapped);
  require_writable("--out", out, inputs);
  inputs.push_back(out.string());
  if (table_file) require_writable("--table", *table_file, inputs);

  DelimitedTable table = bag ? bags::read_table(*open(log), map) : read_delimited(log);
  if (table_file) write_table(*table_file, table);
  const measured::SessionFile file = measured::read_session(std::move(table), map);
  const double v_ref = (*given)["v-ref"].as<double>();
  measured::check_session(file, v_ref > 0.0 ? v_ref : measured::typical_speed(at_centre_of_gravity(file)));
  print(measured::health_of(file));
  const measured::DelaysToTakeOff delays = delays_to_take_off(map, file);
  for (const std::string& remark : delays.remarks) std::cout << remark << '\n';
  for (const std::string& remark : measured::write_gripline_log(out, file, delays.seconds)) std::cout << remark << '\n';
  std::cout << "log: " << out.string() << '\n';
  return good;
}

int run_import(Arguments args) { return import_log(args, nullptr); }

}  // namespace gripline::tools
