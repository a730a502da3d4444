#include "fuzz/targets.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <functional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <gripline/abi_layout.hpp>

#include "bags/message_fields.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "config/units.hpp"
#include "experiment/claims.hpp"
#include "geometry/track_file.hpp"
#include "gripline/validate_file.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/health/session_health.hpp"
#include "measured/log/log_file.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/gripline_log.hpp"
#include "measured/session/log_guess.hpp"
#include "measured/session/log_map.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_file.hpp"
#include "measured/session/session_windows.hpp"
#include "plugin/library_probe.hpp"
#include "report/columns.hpp"
#include "report/report.hpp"
#include "support/paths.hpp"
#include "util/child_process.hpp"
#include "util/csv.hpp"

namespace gripline::fuzz {
namespace {

namespace fs = std::filesystem;

void require(bool good, const std::string& what) {
  if (!good) throw Finding(what);
}

/// A folder of this process, in memory where the machine has such a place.
const fs::path& scratch() {
  static const fs::path folder = [] {
    const fs::path base = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    fs::path made = base / ("gripline_fuzz_" + std::to_string(getpid()));
    fs::create_directories(made);
    std::atexit([] { fs::remove_all(scratch()); });
    return made;
  }();
  return folder;
}

/// Calls read(); a refusal must be ours, and say of which file it speaks.
template <class Read>
bool taken(const Read& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    require(!error.diagnostics().empty(), "refused without a word");
    for (const Diagnostic& one : error.diagnostics()) {
      // The report says the file in words.
      require(!one.file.empty() || one.message.starts_with(scratch().string()),
              "refused without a file: " + one.text());
      require(!one.message.empty(), "refused without a reason: " + one.text());
      require(one.text().size() < 10'000, "a message without end");
    }
  } catch (const PluginError&) {
  }
  return false;
}

fs::path file_of(const fs::path& name, std::string_view bytes) {
  const fs::path file = scratch() / name;
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  require(handle >= 0 && write(handle, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
          "no room for the input");
  close(handle);
  return file;
}

/// The parts between lines that are "---".
std::vector<std::string_view> parts_of(std::string_view bytes) {
  constexpr std::string_view separator = "\n---\n";
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; parts.size() < 16;) {
    const std::size_t end = bytes.find(separator, at);
    parts.push_back(bytes.substr(at, end - at));
    if (end == std::string_view::npos) break;
    at = end + separator.size();
  }
  return parts;
}

/// The product's plugins, asked in this process: they are not what is fuzzed.
const Registry& plugins() {
  static const Registry all = [] {
    run_children_here() = true;
    return Registry({testing_support::plugin_dir()});
  }();
  return all;
}

/// JSON, a merge patch over it, an assignment into it.
void json(std::string_view bytes) {
  const std::vector<std::string_view> parts = parts_of(bytes);
  taken([&] {
    Node base = parse_text(parts[0], "base");
    const std::string text = to_json_text(base);
    const Node again = parse_text(text, "again");
    require(to_json_text(again) == text, "written and read back it is another tree");
    require(content_text(again) == content_text(base), "its content changed by writing it");
    if (parts.size() > 1) {
      const Node patch = parse_text(parts[1], "patch");
      const Node once = merge(base, patch);
      require(content_text(merge(once, patch)) == content_text(once), "a patch applied twice is not the patch");
      (void)merge_keeping_nulls(base, patch);
    }
    if (parts.size() > 2) {
      apply_assignment(base, parts[2]);
      (void)to_json_text(base);
    }
  });
}

/// Any JSON file of ours, as `validate` reads it.
void config(std::string_view bytes) {
  const fs::path file = file_of("input.json", bytes);
  taken([&] { tools::validate_file(file, plugins()); });
}

/// A road that was read must be one: finite everywhere, and found again where it is.
void check_road(const Track& track) {
  require(std::isfinite(track.length()) && track.length() > 0, "a road without a length");
  for (int i = 0; i < 20; ++i) {
    const CurvePoint p = track.at(track.length() * i / 20);
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.yaw), "a road that leads nowhere");
    require(track.half_width_left(p.s) >= 0 && track.half_width_right(p.s) >= 0, "a road of negative width");
  }
}

void track(std::string_view bytes) {
  const fs::path file = file_of("track.csv", bytes);
  taken([&] {
    const Track road = load_track(file);
    check_road(road);
    std::ostringstream out;
    write_track_csv(out, road, std::max(road.length() / 200, 1e-3));
  });
}

void log(std::string_view bytes) {
  const fs::path file = file_of("log.csv", bytes);
  taken([&] { measured::read_log_file(file, {2.0, nullptr}); });
}

/// A logger's table; behind a line "---" the map of its columns, without which one is guessed.
void import_log(std::string_view bytes) {
  const std::vector<std::string_view> parts = parts_of(bytes);
  const fs::path table = file_of("logger.csv", parts[0]);
  const bool mapped = parts.size() > 1;
  const fs::path map = file_of("map.json", mapped ? parts[1] : "");
  taken([&] {
    measured::LogMap read;
    if (mapped) {
      read = measured::load_log_map(map);
    } else {
      Errors errors;
      const Node guessed = measured::guess_map(read_delimited(table)).map;
      read = measured::read_log_map(parse_text(to_json_text(guessed), table.string()), errors);
      errors.throw_if_any();
    }
    const measured::SessionFile file = measured::read_session(table, read);
    measured::check_session(file, measured::typical_speed(at_centre_of_gravity(file)));
    for (const measured::Finding& found : measured::health_of(file))
      require(!found.check.empty(), "a finding without a name");
    measured::write_gripline_log(scratch() / "logger.gripline.csv", file, delays_to_take_off(read, file).seconds);
  });
}

/// The definition of a ROS type; behind a line "---" bytes of a message of it, read as ROS 1 and as ROS 2 write them.
/// Who reads a bag adds the file's name to a refusal.
void message(std::string_view bytes) {
  const std::vector<std::string_view> parts = parts_of(bytes);
  for (const bags::Wire wire : {bags::Wire::ros1, bags::Wire::cdr}) {
    try {
      const bags::Schema schema =
          bags::parse_schema("car_msgs/State", std::string(parts[0]), wire, bags::common_definitions());
      const std::vector<std::string> paths = bags::number_paths(schema, 3, 100);
      bags::FieldReader reader(schema, paths, 0);
      if (parts.size() > 1)
        require(reader.read(std::as_bytes(std::span(parts[1]))).size() == paths.size(), "a number is missing");
    } catch (const InputError&) {
    }
  }
}

/// Tables: parameters of plugins read strictly, results read leniently.
void tables(std::string_view bytes) {
  const fs::path file = file_of("table.csv", bytes);
  for (const bool missing : {false, true})
    taken([&] {
      const CsvTable table = read_csv(file, missing);
      require(table.values.size() == table.rows() * table.columns, "a table with ragged rows");
      if (!table.header.empty()) (void)table.column(table.header.back());
    });
  const report::Columns columns = report::Columns::parse(bytes, true);
  for (const std::string& name : columns.names())
    require(columns.numbers(name).size() == columns.rows(), "a column of another length");
}

/// A folder of results: files one after the other, each "name\n" and its bytes up to a line "---".
void report_folder(std::string_view bytes) {
  const fs::path folder = scratch() / "results";
  fs::remove_all(folder);
  fs::create_directories(folder / "elm/1");
  constexpr std::array names = {"runs.csv",         "table.csv",       "scene.json",
                                "claims.json",      "track.csv",       "validation.csv",
                                "diagnoses.csv",    "diagnosis.json",  "validation_traces.csv",
                                "provenance.json",  "elm/1/steps.csv", "diagnosis_report.json",
                                "elm/1/replay.csv", "elm/1/tyres.csv", "augmented_world.json",
                                "elm/1/timing.csv", "elm/1/line.csv",  "elm/1/summary.json"};
  for (const std::string_view part : parts_of(bytes)) {
    const std::string_view name = part.substr(0, part.find('\n'));
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    file_of(fs::path("results") / name, part.substr(std::min(name.size() + 1, part.size())));
  }
  taken([&] {
    report::Options options;
    options.folder = folder;
    options.figures = true;
    const report::Written written = write_report(options);
    require(written.bytes > 0, "an empty page");
  });
}

/// Hands out pieces of the input.
class Pieces {
 public:
  explicit Pieces(std::string_view bytes) : rest_(bytes) {}
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const auto value = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }
  double number() {
    double value = 0.0;
    const std::size_t size = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), size);
    rest_.remove_prefix(size);
    return value;
  }
  /// Null one time in eight; lives as long as this.
  const char* text() {
    const std::uint8_t size = byte();
    if (size % 8 == 7) return nullptr;
    const std::size_t count = std::min<std::size_t>(size, rest_.size());
    texts_.emplace_back(rest_.substr(0, count));
    rest_.remove_prefix(count);
    return texts_.back().c_str();
  }

 private:
  std::string_view rest_;
  std::deque<std::string> texts_;
};

void* make_nothing(const PluginContext*, const abi::ParamValue*, char*, std::size_t) { return nullptr; }
void destroy_nothing(void*) {}

/// What a library may declare of itself, as it would stand in memory.
void manifest(std::string_view bytes) {
  Pieces pieces(bytes);
  std::vector<abi::ParamDecl> params(pieces.byte() % 4);
  for (abi::ParamDecl& p : params) {
    p = {};
    p.name = pieces.text();
    p.unit = pieces.text();
    p.doc = pieces.text();
    p.type = static_cast<abi::ParamType>(pieces.byte() % 6);
    p.default_value = pieces.number();
    p.lo = pieces.number();
    p.hi = pieces.number();
    p.choices = pieces.text();
  }
  std::vector<abi::PluginDecl> decls(pieces.byte() % 3);
  for (abi::PluginDecl& d : decls) {
    d = {};
    d.kind = static_cast<abi::Kind>(pieces.byte() % 8);
    d.id = pieces.text();
    d.version = pieces.text();
    d.summary = pieces.text();
    d.params = params.data();
    d.param_count = params.size();
    d.create = pieces.byte() % 8 == 0 ? nullptr : make_nothing;
    d.destroy = pieces.byte() % 8 == 0 ? nullptr : destroy_nothing;
    d.advice = pieces.text();
  }
  const std::uint8_t stranger = pieces.byte() % 8;
  abi::Manifest whole = {abi::number,   sizeof(abi::Manifest), abi::layout_hash(), &abi::virtual_slots,
                         pieces.text(), decls.data(),          decls.size()};
  if (stranger == 0) whole.size += 8;
  if (stranger == 1) whole.virtual_slots = nullptr;
  const std::string problem = manifest_problem(whole);
  require(escape_control(problem) == problem, "words of a library that do harm: " + escape_control(problem));
  if (!problem.empty()) return;
  for (const abi::PluginDecl& d : decls) require(d.id != nullptr && *d.id != '\0', "a plugin without an id");
}

/// Any file that is called a library: probed in processes of its own, as the registry does it.
void library(std::string_view bytes) {
  const bool before = std::exchange(run_children_here(), false);
  const std::array files = {file_of("input.so", bytes)};
  const std::vector<std::string> problems = probe_libraries(files, 5.0);
  run_children_here() = before;
  require(problems.size() == 1, "a file without an answer");
}

void claims(std::string_view bytes) {
  const std::vector<std::string> stacks = {"elm", "none", "best"};
  Errors errors;
  Origin origin{std::make_shared<const Source>(Source{"claims", {}}), 1, 1, "/claims/0"};
  const std::optional<Claim> claim = read_claim(Node(bytes, origin), stacks, errors);
  require(claim.has_value() || !errors.empty(), "a claim that is neither good nor bad");
  taken([&] { errors.throw_if_any(); });
  if (!claim || !errors.empty()) return;
  const ClaimResult result = judge(*claim, 3, 0.8, [](const std::string&, const std::string& column, int run) {
    return column == "mu_rmse" ? std::nullopt : std::optional<double>(run + 1.5);
  });
  require(result.runs_held <= result.runs, "more runs held than there are");
}

void units(std::string_view bytes) {
  for (const char* unit : {"m", "1", "1/s^0.5", "N s/m"}) {
    try {
      require(std::isfinite(to_si(bytes, unit)), "a quantity that is no number");
    } catch (const UnitError& error) {
      require(*error.what() != '\0', "refused without a word");
    }
  }
}

constexpr std::array all = {Target{"json", json},       Target{"config", config},        Target{"track", track},
                            Target{"log", log},         Target{"import", import_log},    Target{"message", message},
                            Target{"tables", tables},   Target{"report", report_folder}, Target{"manifest", manifest},
                            Target{"library", library}, Target{"claims", claims},        Target{"units", units}};

}  // namespace

std::span<const Target> targets() { return all; }

const Target* find_target(std::string_view name) {
  const auto* const found = std::find_if(all.begin(), all.end(), [&](const Target& t) { return t.name == name; });
  return found == all.end() ? nullptr : found;
}

}  // namespace gripline::fuzz
