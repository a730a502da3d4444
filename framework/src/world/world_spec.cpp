#include "world/world_spec.hpp"

#include <algorithm>

#include "config/file_kind.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "geometry/racing_line.hpp"
#include "geometry/track_checks.hpp"
#include "geometry/track_file.hpp"
#include "util/child_process.hpp"
#include "util/csv.hpp"
#include "world/friction_file.hpp"

namespace gripline {
namespace {

constexpr double fastest_start = 150.0;  // [m/s]; faster is beyond these cars, most likely a wrong unit

bool has_plugin(const Registry& registry, abi::Kind kind, const std::string& id) {
  const auto entries = registry.entries();
  return std::any_of(entries.begin(), entries.end(),
                     [&](const PluginEntry& entry) { return entry.decl->kind == kind && id == entry.decl->id; });
}

/// Makes the plant once, so that what it says against its parameters is reported at their place in the file.
void check_plant(const WorldSpec& world, const Node& node, Errors& errors) {
  if (!errors.empty()) return;
  const PluginContext context = plugin_context(world);
  // In a process of its own: a plant that crashes is reported by the run.
  const ChildResult result = run_in_child(10.0, [&](const SendMessage& send) {
    try {
      create<Plant>(*world.plant.entry, context, world.plant.values);
    } catch (const PluginError& problem) {
      send(problem.what());
    }
  });
  const Node* const params = node.find("params");
  for (const std::string& problem : result.messages) errors.add((params != nullptr ? *params : node).origin, problem);
}

void read_plant(const Node& node, const Registry& registry, WorldSpec& world, Errors& errors) {
  world.plant_at = node.origin;
  const Node* const id = node.find("plugin");
  if (id != nullptr && id->is_text() && has_plugin(registry, abi::Kind::plant, id->text())) {
    ObjectReader r(node, errors);
    world.plant = read_plugin(r, abi::Kind::plant, registry, world.car.known);
    if (world.hold != Hold::zoh)
      errors.add(node.origin,
                 "\"" + id->text() + "\" moves by itself under held commands; expected input_hold \"zoh\"");
    r.finish();
    check_plant(world, node, errors);
  } else {
    world.vehicle = read_vehicle(node, registry, world.car, "rk6", errors);
  }
}

/// Where a start that cannot be is told: at a member that was merged over those of another file, else at the whole.
const Origin& place_of_start(const Node& start) {
  for (const char* key : {"x", "y", "yaw"})
    if (const Node* const one = start.find(key); one != nullptr && one->origin.source != start.origin.source)
      return one->origin;
  return start.origin;
}

void read_start(ObjectReader& r, WorldSpec& world, Errors& errors) {
  if (world.track) world.start = world.track->start();
  if (!r.has("start")) return;
  const std::size_t before = errors.added();
  ObjectReader start = r.object("start");
  world.start.x = start.number("x", "m", NumberRange::any(), world.start.x);
  world.start.y = start.number("y", "m", NumberRange::any(), world.start.y);
  world.start.yaw = start.number("yaw", "rad", NumberRange::any(), world.start.yaw);
  world.start_speed = start.number("speed", "m/s", NumberRange::closed(0.0, fastest_start), world.start_speed);
  start.finish();
  if (!world.track || errors.added() != before) return;
  if (const std::string problem = check_start(*world.track, world.start); !problem.empty())
    errors.add(place_of_start(start.node()), problem);
}

/// Where friction patches beyond the road's length are told: at the station, else at the schedule.
const Origin& place_of_patch(const Node& friction, const FrictionSpec& spec, double length) {
  const Node* const patches = friction.find("patches");
  for (std::size_t i = 0; patches != nullptr && i < spec.patches.size(); ++i)
    for (const auto& [key, s] : {std::pair("from_s", spec.patches[i].from_s), {"to_s", spec.patches[i].to_s}})
      if (s > length) return patches->array()[i].find(key)->origin;
  return friction.origin;
}

/// Why a car cannot drive this road; empty if it can.
std::string check_car_on(const Track& track, const Car& car) {
  if (std::string narrow = check_car_fits(track, car.width); !narrow.empty()) return narrow;
  return check_car_turns(track, car.width, least_turning_radius(car));
}

/// Whether a key is meant to be one of those that say when the race ends; finish() names it.
bool misspells_end(const Node& node) {
  const std::vector<std::string> keys = {"laps", "duration", "timeout"};
  return node.is_object() && std::ranges::any_of(node.object(), [&](const Member& one) {
           return std::ranges::find(keys, one.key) == keys.end() && nearest(one.key, keys).has_value();
         });
}

/// When the race ends. A world without a road is compared with logs only and has no end.
void read_end(ObjectReader& r, WorldSpec& world, const Errors& errors) {
  const std::size_t before = errors.added();
  world.duration = r.optional_number("duration", "s", NumberRange::positive());
  world.laps = static_cast<int>(r.integer("laps", {0, 10000}, 0));
  world.timeout = r.number("timeout", "s", NumberRange::positive(), world.duration.value_or(0.0) + 1e-9);
  if (errors.added() != before || misspells_end(r.node()) || r.lacks_replaced_file())
    return;  // what is missing would follow from that
  if (world.laps == 0 && !world.duration && r.has("track"))
    r.error("a world ends after \"laps\" or after a \"duration\"; neither is given");
  if (world.laps > 0 && !world.duration && !r.has("timeout"))
    r.error("a world that ends after laps needs a \"timeout\", for the car that never completes them");
}

/// A table as `gripline limit` writes it.
void read_limit_table(const Node& node, WorldSpec& world, Errors& errors) {
  if (const std::string why = why_no_input(node, csv_ending); !why.empty())
    return errors.add(node.origin, node.describe() + ": " + why);
  try {
    const CsvTable table = read_csv(resolve_path(node));
    if (table.find("patches") >= 0)
      return errors.add(node.origin, node.text() +
                                         " is of a road with patches (gripline limit --patches), which "
                                         "\"time_optimal_laps\" does not know: factors are means of a lap");
    const std::vector<double> factor = table.column("factor"), lap = table.column("lap_s");
    const std::vector<double> error = table.column("error_s"), body = table.column("body");
    for (std::size_t i = 0; i < factor.size(); ++i) {
      LapTable& of = body[i] != 0.0 ? world.time_optimal_body : world.time_optimal;
      if (!of.laps.empty() && !(factor[i] > of.laps.back().first))
        errors.add(node.origin, "the factors of " + node.text() + " must rise");
      of.laps.emplace_back(factor[i], lap[i]);
      of.error = std::max(of.error, error[i]);
    }
  } catch (const InputError& problem) {
    errors.add(node.origin, problem.what());
  }
}

void read_limit(ObjectReader& r, WorldSpec& world, Errors& errors) {
  const Node* const limit = r.find("time_optimal_laps");
  if (limit != nullptr && limit->is_text()) return read_limit_table(*limit, world, errors);
  double last = 0.0;
  for (const Node& point : r.array("time_optimal_laps", false)) {
    ObjectReader one(point, errors);
    const double factor = one.number("factor", "1", NumberRange::positive());
    const double lap = one.number("lap", "s", NumberRange::positive());
    LapTable& of = world.time_optimal;
    of.error = std::max(of.error, one.number("error", "s", NumberRange::non_negative(), 0.0));
    one.finish();
    if (!of.laps.empty() && !(factor > last)) errors.add(point.origin, "factors must rise");
    last = factor;
    of.laps.emplace_back(factor, lap);
  }
}

}  // namespace

std::optional<double> LapTable::at(double factor) const {
  // Nothing is extrapolated.
  constexpr double rounding = 1e-9;
  if (laps.empty() || factor < laps.front().first - rounding || factor > laps.back().first + rounding)
    return std::nullopt;
  auto above = std::find_if(laps.begin(), laps.end(), [&](const auto& p) { return p.first >= factor; });
  if (laps.size() == 1) return laps.front().second;
  if (above == laps.begin()) ++above;
  if (above == laps.end()) --above;
  const auto& [f1, lap1] = *above;
  const auto& [f0, lap0] = *(above - 1);
  return lap0 + (lap1 - lap0) * (factor - f0) / (f1 - f0);
}

WorldSpec read_world(const Node& node, const Registry& registry, Errors& errors, RoadRule road) {
  ObjectReader r(node, errors);
  WorldSpec world;
  const std::size_t before = errors.added();
  if (const Node* car = r.require("car", "a car file or an object"); car != nullptr) {
    world.car = read_car(*car, errors);
    check_known_params(*car, registry, errors);
  }
  const bool car_known = errors.added() == before;
  const Node* const track =
      road == RoadRule::required ? r.require("track", "a track file or an object") : r.find("track");
  if (track != nullptr)
    if (std::optional<Track> read = read_track(*track, errors))
      world.track = std::make_shared<const Track>(*std::move(read));
  world.dt = r.number("dt", "s", {1e-4, 1.0, false, false}, 0.02);
  world.hold = r.choice<Hold>("input_hold", {{"zoh", Hold::zoh}, {"foh", Hold::foh}, {"rate", Hold::rate}}, Hold::zoh);
  if (const Node* plant = r.require("plant", "a vehicle model or a plant"); plant != nullptr)
    read_plant(*plant, registry, world, errors);
  const Node* const friction = r.find("friction");
  if (friction != nullptr) {
    world.friction = read_friction(*friction, errors);
    if (const std::string problem = check_shift_per_seed(world.friction, world.dt); !problem.empty()) {
      const Node* const shift = friction->is_object() ? friction->find("shift_per_seed") : nullptr;
      errors.add((shift != nullptr ? *shift : *friction).origin, problem);
    }
  }
  if (const Node* sensors = r.find("sensors"); sensors != nullptr)
    world.sensors = read_sensors(*sensors, world.dt, errors);
  (void)r.find("nominal_uncertainty");  // how far diagnose trusts the model's parameters
  (void)r.find("unknowns");             // what fit looks for (calibrate/fit/unknowns.hpp)
  (void)r.find("calibration");          // what fit found of a log's clock and how to start from it
  read_end(r, world, errors);
  read_limit(r, world, errors);
  read_start(r, world, errors);
  if (world.track) {
    const std::string problem = car_known ? check_car_on(*world.track, world.car.car) : "";
    if (!problem.empty()) r.error_at("track", problem);
    const double length = world.track->length();
    if (const std::string problem = check_friction(world.friction, length); !problem.empty())
      errors.add(place_of_patch(*friction, world.friction, length), problem);
  }
  r.finish();
  return world;
}

PluginContext plugin_context(const WorldSpec& world) {
  PluginContext context;
  context.car = world.car.car;
  context.dt = world.dt;
  context.hold = world.hold;
  return context;
}

void require_vehicle_model(const WorldSpec& world, std::string_view who) {
  if (world.plant.empty()) return;
  throw InputError(world.plant_at, '"' + world.plant.id() + "\" is a black box; " + std::string(who) +
                                       " needs a vehicle model (example: worlds/diagnose_full.json)");
}

Node load_world(const std::filesystem::path& file, const std::optional<std::filesystem::path>& track) {
  if (file.extension() == ".csv" && why_unreadable(file).empty())
    throw InputError(
        {Diagnostic{.file = shown(file), .message = "is a table, expected a world; a road is the \"track\" of one"}});
  Node tree = load_json(file);
  expect_kind(tree, FileKind::world);
  if (track) {
    if (!tree.is_object()) throw InputError(tree.origin, "expected a world, an object; found " + tree.describe());
    tree.set("track", Node(std::filesystem::absolute(*track).string()));
  }
  inline_world_files(tree);
  return tree;
}

void inline_world_files(Node& world) {
  for (const auto& [key, kind] :
       {std::pair{"car", FileKind::car}, {"track", FileKind::track}, {"friction", FileKind::friction}}) {
    Node* const node = world.find(key);
    const bool json = node != nullptr && node->is_text() && node->text().ends_with(".json");
    if (json) inline_file_of(*node, kind);
  }
  drop_removed(world);
}

}  // namespace gripline
