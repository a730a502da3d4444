#include "experiment/out_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <set>
#include <span>
#include <sstream>
#include <vector>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/tree_diff.hpp"
#include "experiment/result_files.hpp"
#include "race/run_files.hpp"
#include "util/csv_writer.hpp"
#include "util/machine.hpp"
#include "util/made_folders.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

constexpr const char* marker = "experiment.json";
constexpr const char* half_marker = "experiment.json.partial";
constexpr const char* lock_name = ".lock";
constexpr const char* figures = "figures";
constexpr std::string_view half_written = ".partial";  // behind the name of what is being written

/// What the marker file says of a folder: whether gripline made it, and for which experiment.
struct Holder {
  bool ours = false;     // gripline's
  std::string identity;  // empty when the marker cannot be read
  Node tree;             // of its experiment; null where that was not kept
};
Holder holder_of(const fs::path& out) {
  std::error_code ignored;
  if (!fs::is_regular_file(out / marker, ignored)) return {};
  if (fs::file_size(out / marker, ignored) == 0) return {true, "", {}};  // truncated by a failure of the disk
  try {
    const Node node = parse_file(out / marker);
    const Node* const identity = node.find("identity");
    const Node* const tree = node.find("experiment");
    if (identity != nullptr && identity->is_text())
      return {true, identity->text(), tree != nullptr ? *tree : Node::null()};
  } catch (const std::exception&) {
  }
  return {};  // a file of that name that gripline did not write
}

/// Whether there is anything but the lock and a marker.
bool has_results(const fs::path& out) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(out, failed)) {
    const std::string name = entry.path().filename().string();
    if (name != lock_name && name != marker && name != half_marker) return true;
  }
  return false;
}

/// Whether there is anything but the lock and a half-written marker, left by a process or a power failure.
bool occupied(const fs::path& out) {
  std::error_code failed;
  return has_results(out) || fs::exists(out / marker, failed);
}

constexpr std::array<const char*, 3> not_of_identity = {"seeds", "claims", "claim_share"};

/// The first differences that make two experiments others, in brackets; empty where the folder kept no tree.
std::string what_differs(const Holder& holder, const EditedExperiment* edited) {
  constexpr std::size_t most = 3;
  if (edited == nullptr || edited->tree == nullptr || holder.tree.is_null()) return {};
  Node before = holder.tree, now = *edited->tree;
  for (const char* key : not_of_identity) before.erase(key), now.erase(key);
  const std::vector<std::string> all = differences(before, now);
  std::string text;
  for (std::size_t i = 0; i < std::min(all.size(), most); ++i) text += (i == 0 ? "" : "; ") + all[i];
  if (all.size() > most) text += "; and " + std::to_string(all.size() - most) + " more";
  return text.empty() ? text : " (" + text + ")";
}

void refuse_others(const fs::path& out, const std::string& identity, const OutFolderOptions& options) {
  const auto& [force, edited] = options;
  const Holder holder = holder_of(out);
  if (!holder.ours)
    throw InputError(out.string() + (force
                                         ? " was not made by gripline; --force does not empty it, choose another --out"
                                         : " already holds something else; choose another --out"));
  if (holder.identity == identity || force) return;
  if (holder.identity.empty())
    throw InputError(out.string() + ": its " + marker +
                     " cannot be read; choose another --out, or --force to replace what gripline made there");
  if (edited != nullptr && edited->has_runs_there && edited->has_runs_there()) return;
  throw InputError(out.string() + " already holds another experiment" + what_differs(holder, edited) +
                   "; choose another --out, or --force to replace it");
}

bool is_number(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// Removes files of these names, whole or half written.
void remove_named(const fs::path& folder, std::span<const char* const> names) {
  std::error_code failed;
  for (const char* name : names) {
    fs::remove(folder / name, failed);
    fs::remove(folder / (name + std::string(half_written)), failed);
  }
}

/// What a run leaves: OUT/<stack>/<seed>/ or, half done, OUT/<stack>/.<seed>.partial/.
void remove_run(const fs::path& folder) {
  std::error_code failed;
  remove_named(folder, run_files::all);
  fs::remove(folder, failed);  // an empty one
}

bool is_run(const fs::path& folder) {
  std::string name = folder.filename().string();
  if (name.starts_with('.') && name.ends_with(".partial")) name = name.substr(1, name.size() - 9);
  return is_number(name);
}

/// Removes one folder of the results: the runs of a race's stack, a single run of a validation, or a diagnosed case
/// with its drives, its diagnosis and its round trip, which is a case again.
void remove_part(const fs::path& folder) {
  std::error_code failed;
  const auto is_recording = [&](const fs::path& place) {
    return fs::exists(place / run_files::steps, failed) && fs::exists(place / run_files::tyres, failed);
  };
  const bool diagnosed = fs::exists(folder / result_files::diagnosis, failed), recording = is_recording(folder);
  std::vector<fs::path> runs, parts;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    if (!entry.is_directory(failed) || entry.is_symlink(failed)) continue;
    if (is_run(entry.path()) || (diagnosed && is_recording(entry.path()))) runs.push_back(entry.path());
    if (diagnosed && entry.path().filename() == "round_trip") parts.push_back(entry.path());
  }
  for (const fs::path& run : runs) remove_run(run);
  for (const fs::path& part : parts) remove_part(part);
  if (recording) remove_run(folder);
  if (diagnosed) remove_named(folder, result_files::all);
  if (diagnosed || !runs.empty()) fs::remove(folder, failed);  // an empty one
}

/// All that gripline ever writes into a folder of results, and nothing else.
void remove_results(const fs::path& out) {
  std::error_code failed;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(out, failed))
    if (entry.is_directory(failed) && !entry.is_symlink(failed)) folders.push_back(entry.path());
  for (const fs::path& folder : folders) {
    if (folder.filename() != figures) {
      remove_part(folder);
      continue;
    }
    std::vector<fs::path> drawn;
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().extension() == ".svg") drawn.push_back(entry.path());
    for (const fs::path& figure : drawn) fs::remove(figure, failed);
    fs::remove(folder, failed);
  }
  remove_named(out, result_files::all);
}

void write_track(const fs::path& out, const Track& track) {
  std::string text;
  CsvWriter csv(text, "s_m,x_m,y_m,left_x_m,left_y_m,right_x_m,right_y_m");
  const int count = static_cast<int>(std::clamp(track.length() / 0.02, 200.0, 2000.0));
  for (int i = 0; i < count; ++i) {
    const CurvePoint p = track.at(track.length() * i / count);
    const double left = track.half_width_left(p.s), right = track.half_width_right(p.s);
    const double nx = -std::sin(p.yaw), ny = std::cos(p.yaw);
    csv << p.s << p.x << p.y << p.x + left * nx << p.y + left * ny << p.x - right * nx << p.y - right * ny;
    csv.end_row();
  }
  write_file(out / result_files::track, text);
}

Node describe_world(const RaceSpec& race) {
  const Car& car = race.world.car.car;
  Node scene = Node::empty_object();
  scene.set("name", Node(race.name));
  scene.set("kind", Node(experiment_kind(race.tree)));
  if (const Node* note = race.tree.find("note"); note != nullptr) scene.set("note", *note);
  if (!race.seeds_text.empty()) scene.set("seeds_from", Node(race.seeds_text));
  scene.set("world", Node(race.world.track->name()));
  scene.set("dt", Node(race.world.dt));
  scene.set("laps", Node(static_cast<double>(race.world.laps)));
  Node shape = Node::empty_object();
  for (const auto& [name, number] :
       {std::pair{"m", car.m}, {"lf", car.lf}, {"lr", car.lr}, {"length", car.length}, {"width", car.width}})
    shape.set(name, Node(number));
  scene.set("car", std::move(shape));
  Node::Array told;
  for (const StackSpec& stack : race.stacks)
    if (stack.needs_truth()) told.emplace_back(stack.name);
  scene.set("told", Node(std::move(told)));
  Node::Array limit;
  for (const auto& [factor, lap] : race.world.time_optimal.laps) {
    Node point = Node::empty_object();
    point.set("factor", Node(factor));
    point.set("lap_s", Node(lap));
    limit.push_back(std::move(point));
  }
  scene.set("time_optimal_laps", Node(std::move(limit)));
  return scene;
}

Node describe_origin(const RaceSpec& race, const Registry& registry) {
  Node origin = Node::empty_object();
  origin.set("gripline", Node(GRIPLINE_VERSION));
  origin.set("compiler", Node("g++ " __VERSION__));
  origin.set("plugin_abi", Node(static_cast<double>(abi::number)));
  Node::Array libraries;
  for (const fs::path& library : libraries_of(race.world, race.stacks)) {
    Node one = Node::empty_object();
    one.set("file", Node(library.filename().string()));
    one.set("sha256", Node(sha256_of_file(library)));
    Node::Array plugins;
    for (const PluginEntry& entry : registry.entries())
      if (entry.library == library) plugins.emplace_back(std::string(entry.decl->id) + " " + entry.decl->version);
    one.set("plugins", Node(std::move(plugins)));
    libraries.push_back(std::move(one));
  }
  origin.set("libraries", Node(std::move(libraries)));
  return origin;
}

/// What a lock file says of the process that holds it.
std::string holder_text(pid_t pid, std::uint64_t start) {
  return std::to_string(pid) + " " + std::to_string(start) + " " + this_machine() + "\n";
}

/// Where it cannot be written, the lock is one all the same.
void write_holder(int lock) {
  const std::optional<std::uint64_t> start = process_start(getpid());
  if (!start || ftruncate(lock, 0) != 0) return;
  const std::string text = holder_text(getpid(), *start);
  [[maybe_unused]] const ssize_t written = write(lock, text.data(), text.size());
}

}  // namespace

/// Handles of all locks of this process.
static std::set<int>& lock_handles() {
  static std::set<int> handles;
  return handles;
}

std::optional<pid_t> OutLock::holder_here(const fs::path& folder) {
  std::ifstream in(folder / lock_name);
  std::string line;
  std::getline(in, line);
  pid_t pid = 0;
  std::istringstream(line) >> pid;
  const std::optional<std::uint64_t> start = pid > 1 ? process_start(pid) : std::nullopt;
  if (!start || line + "\n" != holder_text(pid, *start)) return std::nullopt;
  return pid;
}

void OutLock::leave_to_parent() {
  for (const int handle : lock_handles()) close(handle);
  lock_handles().clear();
}

OutLock::OutLock(const fs::path& folder) : file_(folder / lock_name) {
  while (true) {
    handle_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (handle_ < 0) return;  // the first result that is written fails with the reason
    if (flock(handle_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      close(handle_);
      throw InputError(file_.parent_path().string() +
                       ": another gripline is writing there now; wait for its end or choose another --out");
    }
    // The holder before may have removed the file between the two calls: then the lock is on no file.
    struct stat held {
    }, named{};
    if (fstat(handle_, &held) == 0 && stat(file_.c_str(), &named) == 0 && held.st_ino == named.st_ino) {
      write_holder(handle_);
      lock_handles().insert(handle_);
      return;
    }
    close(handle_);
  }
}

OutLock::~OutLock() {
  if (handle_ < 0) return;
  const fs::path folder = file_.parent_path();
  if (std::uncaught_exceptions() > exceptions_ && made_here(folder) && !has_results(folder)) {
    std::error_code ignored;
    fs::remove(folder / marker, ignored);
    fs::remove(folder / half_marker, ignored);
  }
  lock_handles().erase(handle_);
  unlink(file_.c_str());
  close(handle_);
}

bool is_result_name(std::string_view name) {
  if (name.ends_with(half_written)) name.remove_suffix(half_written.size());
  return name == marker || name == figures || std::ranges::find(result_files::all, name) != result_files::all.end();
}

std::string experiment_identity(const Node& tree) {
  Node same = tree;
  for (const char* key : not_of_identity) same.erase(key);
  return sha256_hex(content_text(same));
}

OutLock open_out_folder(const fs::path& out, const std::string& identity, const OutFolderOptions& options) {
  const auto& [force, edited] = options;
  std::error_code failed;
  if (fs::exists(out, failed) && !fs::is_directory(out, failed))
    throw InputError(out.string() + " is a file; --out names a folder");
  // A folder of other files is refused before a lock is made in it.
  if (occupied(out) && !fs::exists(out / lock_name, failed)) refuse_others(out, identity, options);
  make_folders(out, failed);
  if (failed) throw InputError("cannot make " + out.string() + ": " + failed.message());
  OutLock lock(out);
  if (occupied(out)) {
    refuse_others(out, identity, options);
    if (edited != nullptr && !force)
      if (const Holder holder = holder_of(out); !holder.tree.is_null())
        edited->changes = differences(holder.tree, *edited->tree);
    if (force) remove_results(out);
  }
  Node node = Node::empty_object();
  node.set("identity", Node(identity));
  if (edited != nullptr) node.set("experiment", *edited->tree);
  write_file(out / marker, to_json_text(node));
  return lock;
}

void write_scene(const fs::path& out, const RaceSpec& race, const Registry& registry) {
  write_file(out / result_files::scene, to_json_text(describe_world(race)));
  write_file(out / result_files::provenance, to_json_text(describe_origin(race, registry)));
  write_track(out, *race.world.track);
}

void write_scene(const fs::path& out, const std::string& name, const std::string& kind, const Node& tree) {
  Node scene = Node::empty_object();
  scene.set("name", Node(name));
  scene.set("kind", Node(kind));
  if (const Node* note = tree.is_object() ? tree.find("note") : nullptr; note != nullptr) scene.set("note", *note);
  write_file(out / result_files::scene, to_json_text(scene));
}

}  // namespace gripline
