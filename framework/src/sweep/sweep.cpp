#include "sweep/sweep.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <stdexcept>

#include "config/assignment_errors.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/reader.hpp"
#include "experiment/experiment.hpp"
#include "sweep/keys.hpp"
#include "sweep/kinds.hpp"
#include "util/made_folders.hpp"
#include "util/whole_file.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr const char* manifest_name = "sweep.json";
constexpr const char* keys_name = "keys.txt";
constexpr std::size_t key_line = 65;  // 64 digits and the end of the line
constexpr std::size_t most_runs = 10'000'000;

std::vector<std::string> texts_of(const Node& node) {
  std::vector<std::string> texts;
  for (const Node& one : node.array()) texts.push_back(one.text());
  return texts;
}

/// Seeds of an experiment's tree as it stands.
std::vector<std::uint64_t> own_seeds(const Node& tree, const SweptKind& kind) {
  const Node* const node = kind.seeds != nullptr ? tree.find(kind.seeds) : nullptr;
  if (node == nullptr || node->is_null()) return {1};
  Errors errors;
  std::vector<std::uint64_t> seeds;
  if (std::string_view(kind.seeds) == "seeds")
    seeds = read_seeds(*node, errors);
  else
    seeds = {static_cast<std::uint64_t>(read_integer(*node, {0, largest_seed}, errors))};
  errors.throw_if_any();
  return seeds;
}

std::vector<std::string> all_rows(const Node& tree, const SweptKind& kind) {
  if (kind.rows == nullptr) return {""};
  std::vector<std::string> names;
  const Node* const rows = tree.find(kind.rows);
  if (rows != nullptr && rows->is_object())
    for (const Member& member : rows->object())
      if (member.key != "note" && !member.value.is_null()) names.push_back(member.key);
  return names;
}

/// Rows in the order of the file, those asked for.
std::vector<std::string> chosen_rows(const std::vector<std::string>& all, const std::vector<std::string>& only) {
  std::vector<std::string> rows;
  for (const std::string& row : all)
    if (only.empty() || std::find(only.begin(), only.end(), row) != only.end()) rows.push_back(row);
  return rows;
}

void require_known_rows(const std::vector<std::string>& only, const std::vector<std::string>& known) {
  for (const std::string& name : only)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("no row \"" + name + "\" in the experiments" + did_you_mean(name, known));
}

/// Reads an experiment with these assignments; an error that one of them causes is reported at that assignment.
void try_reading(const Part& part, const std::vector<std::string>& assignments, const std::string& seeds_text,
                 const Registry& registry) {
  const auto read = [&](std::span<const std::string> some) {
    const Node tree = load_experiment(part.file, some);
    const SweptKind& kind = kind_of(tree);
    if (!seeds_text.empty() && kind.seeds != nullptr) require_drawn_seeds_fit(tree, seeds_text);
    kind.check(part.file, tree, registry);
  };
  try {
    read(assignments);
  } catch (const InputError& error) {
    throw attribute_to_assignments(error, assignments, read);
  }
}

struct TriedSetting {
  std::vector<std::string> values;
  std::size_t index = 0;  ///< of a list or a hypercube
};

/// Settings in which every value of every factor occurs; of long lists and hypercubes a sample.
std::vector<TriedSetting> settings_to_try(const Design& design) {
  constexpr std::size_t most = 32;
  std::vector<TriedSetting> all;
  if (design.kind() == Design::Kind::factorial) {
    const TriedSetting first{design.setting(0)};
    all.push_back(first);
    for (std::size_t f = 0; f < first.values.size(); ++f)
      for (std::size_t level = 1; level < design.factors()[f].levels.size(); ++level) {
        all.push_back(first);
        all.back().values[f] = design.factors()[f].levels[level];
      }
    return all;
  }
  const std::size_t count = std::min(most, design.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t index = i * design.size() / count;
    all.push_back({design.setting(index), index});
  }
  return all;
}

/// What is wrong with one value of a factor names the value: others stand at the same --set. Nobody gave those of a
/// list there; they are told where they stand in the list.
Diagnostic told_at_value(Diagnostic one, const Design& design, const TriedSetting& setting) {
  const auto factor = std::ranges::find(design.factors(), one.pointer, &Factor::pointer);
  if (one.file != "--set" || factor == design.factors().end()) return one;
  const auto number = static_cast<std::size_t>(factor - design.factors().begin());
  one.message = escape_control(setting.values[number]) + ": " + one.message;
  if (const std::optional<ListPlace> place = design.place(setting.index, number)) {
    one.file = place->file;
    one.line = place->line;
    one.column = place->column;
  }
  return one;
}

/// Reads every experiment with every setting to try, and tells all that is wrong at once: one bad road of many must
/// not hide the next. A value that several settings have is told once.
void try_settings(const Sweep& sweep, const Registry& registry) {
  Errors errors;
  std::set<std::string> told;
  for (const Part& part : sweep.parts)
    for (const TriedSetting& setting : settings_to_try(sweep.design)) {
      try {
        try_reading(part, assignments_of(sweep.assignments, sweep.design, setting.values), sweep.seeds_from, registry);
      } catch (const InputError& error) {
        for (const Diagnostic& one : error.diagnostics()) {
          Diagnostic at_value = told_at_value(one, sweep.design, setting);
          if (told.insert(at_value.file + '\n' + at_value.pointer + '\n' + at_value.message).second)
            errors.add(std::move(at_value));
        }
      }
    }
  errors.throw_if_any();
}

void read_parts(const Request& request, Sweep& sweep) {
  std::vector<std::string> known;
  for (const fs::path& file : request.files) {
    Part part;
    part.file = fs::absolute(file).lexically_normal();
    part.name = file.stem().string();
    const auto same = [&](const Part& other) { return other.name == part.name; };
    if (std::any_of(sweep.parts.begin(), sweep.parts.end(), same)) part.name = shown(file);
    if (std::any_of(sweep.parts.begin(), sweep.parts.end(), same)) throw InputError(shown(file) + " is named twice");
    // With the first setting, which may be what makes the experiment complete.
    const Node tree = load_experiment(file, assignments_of(request.assignments, request.design, 0));
    const SweptKind& kind = kind_of(tree);
    part.kind = kind.name;
    const std::vector<std::string> rows = all_rows(tree, kind);
    known.insert(known.end(), rows.begin(), rows.end());
    part.rows = chosen_rows(rows, request.only);
    if (request.seeds && kind.seeds == nullptr)
      throw InputError("--seeds: " + shown(file) + " is an experiment of kind \"" + kind.name +
                       "\", which draws nothing");
    part.seeds = request.seeds ? *request.seeds : own_seeds(tree, kind);
    if (!request.seeds_from.empty() && kind.seeds != nullptr)
      part.seeds = seeds_from(request.seeds_from, part.seeds.size());
    sweep.parts.push_back(std::move(part));
  }
  require_known_rows(request.only, known);
}

void number_runs(Sweep& sweep) {
  std::size_t next = 0;
  for (Part& part : sweep.parts) {
    part.first = next;
    const std::size_t each = part.rows.size() * part.seeds.size();
    if (each > 0 && sweep.design.size() > (most_runs - std::min(next, most_runs)) / each)
      throw InputError("more than " + std::to_string(most_runs) + " runs; make several sweeps of it");
    next += sweep.design.size() * each;
  }
  if (next == 0) throw InputError("no run is asked for");
}

Node part_node(const Part& part) {
  Node node = Node::empty_object();
  node.set("file", Node(part.file.string()));
  node.set("name", Node(part.name));
  node.set("kind", Node(part.kind));
  node.set("rows", texts_node(part.rows));
  Node::Array seeds;
  for (const std::uint64_t seed : part.seeds) seeds.emplace_back(static_cast<double>(seed));
  node.set("seeds", Node(std::move(seeds)));
  return node;
}

/// A text for a library, and a list where several have its name.
Node libraries_node(const Libraries& libraries) {
  Node node = Node::empty_object();
  for (const auto& [name, hashes] : libraries)
    node.set(name, hashes.size() == 1 ? Node(*hashes.begin())
                                      : texts_node(std::vector<std::string>(hashes.begin(), hashes.end())));
  return node;
}

Libraries libraries_from(const Node& node) {
  Libraries libraries;
  for (const Member& one : node.object()) {
    const std::vector<std::string> hashes =
        one.value.is_array() ? texts_of(one.value) : std::vector<std::string>{one.value.text()};
    libraries[one.key].insert(hashes.begin(), hashes.end());
  }
  return libraries;
}

Node manifest_node(const Sweep& sweep) {
  Node node = Node::empty_object();
  node.set("gripline_sweep", Node(1.0));
  node.set("name", Node(sweep.name));
  node.set("runs", Node(static_cast<double>(sweep.size())));
  node.set("folder", Node(sweep.folder.string()));
  Node::Array parts;
  for (const Part& part : sweep.parts) parts.push_back(part_node(part));
  node.set("experiments", Node(std::move(parts)));
  node.set("assignments", texts_node(sweep.assignments));
  node.set("design", sweep.design.to_node());
  node.set("seeds_from", Node(sweep.seeds_from));
  node.set("plugin_dirs", texts_node(sweep.plugin_dirs));
  node.set("timeout_s", Node(sweep.timeout_s));
  node.set("memory_mb", Node(static_cast<double>(sweep.memory_mb)));
  node.set("keep_files", Node(sweep.keep_files));
  node.set("version", Node(sweep.version));
  node.set("program", Node(sweep.program));
  node.set("libraries", libraries_node(sweep.libraries));
  node.set("keys_sha256", Node(sweep.keys_sha256));
  return node;
}

/// Keys of all runs; no more than a few lines are held. Gives the file's SHA-256.
std::string write_keys(const fs::path& out, Keys& keys, const Sweep& sweep) {
  constexpr std::size_t together = 256;
  WholeFile file(out / keys_name);
  Sha256 hash;
  const std::size_t count = sweep.size();
  for (std::size_t next = 0; next < count;) {
    std::string block;
    for (const std::size_t end = std::min(count, next + together); next < end; ++next)
      block += keys.key(sweep.at(next)) + "\n";
    hash.add(block);
    file.write(block);
  }
  file.finish();
  return hash.hex();
}

/// Whether a sweep was being planned into a folder without a manifest: that is written after the keys.
bool is_half_planned(const fs::path& out) {
  std::error_code failed;
  if (fs::exists(out / (std::string(keys_name) + ".partial"), failed)) return true;
  std::ifstream in(out / keys_name, std::ios::binary);
  std::string line;
  std::getline(in, line);
  return line.size() == key_line - 1 && line.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Of the file that key() reads, whatever stands at its path by now, and of any size.
std::string hash_of_open_file(int handle) {
  Sha256 hash;
  std::string block(std::size_t{1} << 16U, '\0');
  for (off_t place = 0;;) {
    const ssize_t got = pread(handle, block.data(), block.size(), place);
    if (got <= 0) return hash.hex();  // what cannot be read is not the file that was written
    hash.add({block.data(), static_cast<std::size_t>(got)});
    place += got;
  }
}

/// What a sweep is called in what it prints: its experiments, or of many the first and how many more there are.
std::string name_of(const std::vector<Part>& parts) {
  constexpr std::size_t most = 3;
  std::string name = fs::path(parts.front().name).stem().string();
  if (parts.size() > most) return name + " and " + std::to_string(parts.size() - 1) + " more";
  for (std::size_t i = 1; i < parts.size(); ++i) name.append("_").append(fs::path(parts[i].name).stem().string());
  return name;
}

}  // namespace

std::size_t Sweep::size() const {
  const Part& last = parts.back();
  return last.first + design.size() * last.rows.size() * last.seeds.size();
}

RunAt Sweep::at(std::size_t index) const {
  RunAt run;
  run.index = index;
  while (run.part + 1 < parts.size() && parts[run.part + 1].first <= index) ++run.part;
  const Part& part = parts[run.part];
  std::size_t rest = index - part.first;
  run.seed = part.seeds[rest % part.seeds.size()];
  rest /= part.seeds.size();
  run.row = rest % part.rows.size();
  run.setting = rest / part.rows.size();
  return run;
}

Sweep plan(const Request& request, const Registry& registry) {
  if (request.files.empty()) throw InputError("which experiment? For example experiments/table1.json");
  require_effect(request.assignments, request.design);
  Sweep sweep;
  sweep.design = request.design;
  sweep.assignments = request.assignments;
  sweep.seeds_from = request.seeds_from;
  sweep.timeout_s = request.timeout_s;
  sweep.memory_mb = request.memory_mb;
  sweep.keep_files = request.keep_files;
  sweep.folder = fs::current_path();
  for (const std::string& dir : request.plugin_dirs) sweep.plugin_dirs.push_back(fs::absolute(dir).lexically_normal());
  sweep.version = GRIPLINE_VERSION;
  sweep.program = sha256_of_file("/proc/self/exe");
  try {
    read_parts(request, sweep);
  } catch (const InputError&) {
    sweep.parts.clear();
    for (const fs::path& file : request.files) sweep.parts.emplace_back().file = file;
    try_settings(sweep, registry);  // errors are reported at the assignment that causes them
    throw;
  }
  sweep.name = name_of(sweep.parts);
  try_settings(sweep, registry);
  number_runs(sweep);
  return sweep;
}

bool holds_sweep(const fs::path& out) {
  std::error_code ignored;
  return fs::is_regular_file(out / manifest_name, ignored);
}

void require_sweep_folder(const fs::path& out) {
  std::error_code failed;
  if (fs::exists(out, failed) && !fs::is_directory(out, failed))
    throw InputError(out.string() + " is a file; --out names a folder");
  bool others = false;
  for (const auto& entry : fs::directory_iterator(out, failed)) others |= entry.path().filename() != ".lock";
  if (others && !holds_sweep(out) && !is_half_planned(out))
    throw InputError(out.string() + " already holds something that is no sweep; choose another --out");
  make_folders(out, failed);
  if (failed) throw InputError("cannot make " + out.string() + ": " + failed.message());
}

void write_manifest(const fs::path& out, const Sweep& planned, const Registry& registry) {
  std::error_code failed;
  fs::create_directories(out, failed);
  Sweep sweep = planned;
  Keys keys(sweep, registry);
  sweep.keys_sha256 = write_keys(out, keys, sweep);
  sweep.libraries = keys.libraries();
  write_file(out / manifest_name, to_json_text(manifest_node(sweep)));
}

Sweep read_manifest(const fs::path& out) {
  if (!holds_sweep(out))
    throw InputError(out.string() + " holds no sweep; expected a folder that gripline sweep made (--out)");
  const Node node = parse_file(out / manifest_name);
  try {
    Sweep sweep;
    sweep.name = node.at("name").text();
    sweep.folder = node.at("folder").text();
    for (const Node& one : node.at("experiments").array()) {
      Part part{one.at("file").text(), one.at("name").text(), one.at("kind").text(), texts_of(one.at("rows")), {}, 0};
      for (const Node& seed : one.at("seeds").array()) part.seeds.push_back(static_cast<std::uint64_t>(seed.number()));
      sweep.parts.push_back(std::move(part));
    }
    sweep.assignments = texts_of(node.at("assignments"));
    sweep.design = Design::from_node(node.at("design"));
    sweep.seeds_from = node.at("seeds_from").text();
    sweep.plugin_dirs = texts_of(node.at("plugin_dirs"));
    sweep.timeout_s = node.at("timeout_s").number();
    sweep.memory_mb = static_cast<std::size_t>(node.at("memory_mb").number());
    sweep.keep_files = node.at("keep_files").boolean();
    sweep.version = node.at("version").text();
    sweep.program = node.at("program").text();
    sweep.libraries = libraries_from(node.at("libraries"));
    if (const Node* const hash = node.find("keys_sha256"); hash != nullptr) sweep.keys_sha256 = hash->text();
    number_runs(sweep);
    return sweep;
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    throw InputError((out / manifest_name).string() + " is not as gripline wrote it; plan the sweep again");
  }
}

KeyFile::KeyFile(const fs::path& out, const Sweep& sweep)
    : file_(out / keys_name), in_(open(file_.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (in_.handle < 0) throw InputError(file_.string() + ": " + std::strerror(errno) + "; plan the sweep again");
  const off_t bytes = lseek(in_.handle, 0, SEEK_END);
  size_ = bytes > 0 ? static_cast<std::size_t>(bytes) / key_line : 0;
  const bool known = !sweep.keys_sha256.empty();  // folders of older versions have no hash
  if (size_ != sweep.size() || (known && hash_of_open_file(in_.handle) != sweep.keys_sha256))
    throw InputError(file_.string() + " has other keys than " + manifest_name +
                     " was written with; plan the sweep again");
}

KeyFile::OpenFile::~OpenFile() {
  if (handle >= 0) close(handle);
}

std::string KeyFile::key(std::size_t index) const {
  std::string text(key_line - 1, '\0');
  const auto place = static_cast<off_t>(index * key_line);
  if (pread(in_.handle, text.data(), text.size(), place) != static_cast<ssize_t>(text.size()))
    throw InputError(file_.string() + " is shorter than its sweep; plan it again");
  return text;
}

void require_same_versions(const Sweep& sweep, const Registry& registry) {
  if (sha256_of_file("/proc/self/exe") != sweep.program)
    throw PluginError("this gripline (" GRIPLINE_VERSION ") is another build than the one that planned the sweep (" +
                      sweep.version + "): results of both are not mixed; use the same, or plan the sweep again");
  for (const auto& [name, hashes] : sweep.libraries) {
    std::map<fs::path, std::string> found;
    for (const PluginEntry& entry : registry.entries())
      if (entry.library.filename() == name) found.try_emplace(entry.library);
    if (found.empty()) throw PluginError(name + ": the sweep was planned with this library and it is not found here");
    for (auto& [file, hash] : found) hash = sha256_of_file(file);
    const auto is_there = [&](const std::string& hash) {
      return std::ranges::any_of(found, [&](const auto& one) { return one.second == hash; });
    };
    if (!std::ranges::all_of(hashes, is_there))
      throw PluginError(found.begin()->first.string() +
                        " is another build than the one that the sweep was planned with: results of both are " +
                        "not mixed; use the same, or plan the sweep again");
  }
}

Node texts_node(std::span<const std::string> texts) {
  Node::Array array;
  for (const std::string& text : texts) array.emplace_back(text);
  return Node(std::move(array));
}

}  // namespace gripline::sweep
