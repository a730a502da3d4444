#include "out_folder.hpp"

#include <cmath>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "csv_writer.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

constexpr const char* marker = "experiment.json";

std::string identity_in(const fs::path& out) {
  std::error_code ignored;
  if (!fs::exists(out / marker, ignored)) return {};
  try {
    const Node node = parse_file(out / marker);
    const Node* const identity = node.find("identity");
    return identity != nullptr && identity->is_text() ? identity->text() : "";
  } catch (const std::exception&) {
    return {};
  }
}

void write_track(const fs::path& out, const Track& track) {
  CsvWriter csv(out / "track.csv", "s_m,x_m,y_m,left_x_m,left_y_m,right_x_m,right_y_m");
  const int count = static_cast<int>(std::clamp(track.length() / 0.02, 200.0, 2000.0));
  for (int i = 0; i < count; ++i) {
    const CurvePoint p = track.at(track.length() * i / count);
    const double left = track.half_width_left(p.s), right = track.half_width_right(p.s);
    const double nx = -std::sin(p.yaw), ny = std::cos(p.yaw);
    csv << p.s << p.x << p.y << p.x + left * nx << p.y + left * ny << p.x - right * nx << p.y - right * ny;
    csv.end_row();
  }
}

Node describe_world(const RaceSpec& race) {
  const Car& car = race.world.car.car;
  Node scene{Node::Object{}};
  scene.set("name", Node(race.name));
  scene.set("kind", Node(experiment_kind(race.tree)));
  if (const Node* note = race.tree.find("note"); note != nullptr) scene.set("note", *note);
  scene.set("world", Node(race.world.track->name()));
  scene.set("dt", Node(race.world.dt));
  scene.set("laps", Node(static_cast<double>(race.world.laps)));
  Node shape{Node::Object{}};
  for (const auto& [name, number] :
       {std::pair{"m", car.m}, {"lf", car.lf}, {"lr", car.lr}, {"length", car.length}, {"width", car.width}})
    shape.set(name, Node(number));
  scene.set("car", std::move(shape));
  Node::Array limit;
  for (const auto& [factor, lap] : race.world.time_optimal) {
    Node point{Node::Object{}};
    point.set("factor", Node(factor));
    point.set("lap_s", Node(lap));
    limit.push_back(std::move(point));
  }
  scene.set("time_optimal_laps", Node(std::move(limit)));
  return scene;
}

Node describe_origin(const RaceSpec& race, const Registry& registry) {
  Node origin{Node::Object{}};
  origin.set("gripline", Node(GRIPLINE_VERSION));
  origin.set("compiler", Node("g++ " __VERSION__));
  origin.set("plugin_abi", Node(static_cast<double>(abi::number)));
  Node::Array libraries;
  for (const fs::path& library : libraries_of(race.world, race.stacks)) {
    Node one{Node::Object{}};
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

}  // namespace

void open_out_folder(const fs::path& out, const std::string& identity, bool force) {
  std::error_code failed;
  if (fs::exists(out, failed) && !fs::is_directory(out, failed))
    throw InputError(out.string() + " is a file; --out names a folder");
  const bool occupied = fs::exists(out, failed) && !fs::is_empty(out, failed);
  const std::string found = identity_in(out);
  if (occupied && found != identity) {
    if (!force)
      throw InputError(out.string() + " already holds " + (found.empty() ? "something else" : "another experiment") +
                       "; choose another --out, or --force to replace it");
    if (found.empty())
      throw InputError(out.string() + " was not made by gripline; --force does not empty it, choose another --out");
  }
  if (occupied && force)
    for (const auto& entry : fs::directory_iterator(out)) fs::remove_all(entry.path());
  fs::create_directories(out, failed);
  if (failed) throw InputError("cannot make " + out.string() + ": " + failed.message());
  Node node{Node::Object{}};
  node.set("identity", Node(identity));
  write_file(out / marker, to_json_text(node));
}

void write_scene(const fs::path& out, const RaceSpec& race, const Registry& registry) {
  write_file(out / "scene.json", to_json_text(describe_world(race)));
  write_file(out / "provenance.json", to_json_text(describe_origin(race, registry)));
  write_track(out, *race.world.track);
}

}  // namespace gripline
