#include "exports/foxglove.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

#include "exports/mcap.hpp"

namespace gripline::exports {
namespace {

using nlohmann::json;
using report::Columns;

constexpr std::string_view world = "world";

json time_json(double t_s) {
  const auto nanoseconds = static_cast<std::int64_t>(std::llround(t_s * 1e9));
  return {{"sec", nanoseconds / 1'000'000'000}, {"nsec", nanoseconds % 1'000'000'000}};
}

json vector_json(double x, double y, double z = 0) { return {{"x", x}, {"y", y}, {"z", z}}; }

json rotation_json(double yaw) { return {{"x", 0}, {"y", 0}, {"z", std::sin(yaw / 2)}, {"w", std::cos(yaw / 2)}}; }

json pose_json(double x, double y, double yaw) {
  return {{"position", vector_json(x, y)}, {"orientation", rotation_json(yaw)}};
}

// --- JSON schemas --------------------------------------------------------------------------------------------------

json object_schema(json properties) { return {{"type", "object"}, {"properties", std::move(properties)}}; }

json numbers_schema(std::initializer_list<const char*> names) {
  json properties = json::object();
  for (const char* name : names) properties[name] = {{"type", "number"}};
  return object_schema(properties);
}

json time_schema() { return object_schema({{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}); }

json pose_schema() {
  return object_schema(
      {{"position", numbers_schema({"x", "y", "z"})}, {"orientation", numbers_schema({"x", "y", "z", "w"})}});
}

json text_schema() { return {{"type", "string"}}; }
json list_schema(json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

json pose_in_frame_schema() {
  return object_schema({{"timestamp", time_schema()}, {"frame_id", text_schema()}, {"pose", pose_schema()}});
}

json transform_schema() {
  return object_schema({{"timestamp", time_schema()},
                        {"parent_frame_id", text_schema()},
                        {"child_frame_id", text_schema()},
                        {"translation", numbers_schema({"x", "y", "z"})},
                        {"rotation", numbers_schema({"x", "y", "z", "w"})}});
}

/// Of a SceneUpdate the parts that are used here.
json scene_schema() {
  const json colour = numbers_schema({"r", "g", "b", "a"});
  const json cube =
      object_schema({{"pose", pose_schema()}, {"size", numbers_schema({"x", "y", "z"})}, {"color", colour}});
  const json line = object_schema({{"type", {{"type", "integer"}}},
                                   {"pose", pose_schema()},
                                   {"thickness", {{"type", "number"}}},
                                   {"scale_invariant", {{"type", "boolean"}}},
                                   {"points", list_schema(numbers_schema({"x", "y", "z"}))},
                                   {"color", colour}});
  const json entity = object_schema({{"timestamp", time_schema()},
                                     {"frame_id", text_schema()},
                                     {"id", text_schema()},
                                     {"lifetime", time_schema()},
                                     {"frame_locked", {{"type", "boolean"}}},
                                     {"cubes", list_schema(cube)},
                                     {"lines", list_schema(line)}});
  return object_schema({{"deletions", list_schema(object_schema(json::object()))}, {"entities", list_schema(entity)}});
}

json step_schema(const Columns& steps) {
  json properties = json::object();
  for (const std::string& name : steps.names()) properties[name] = {{"type", "number"}};
  return object_schema(properties);
}

// --- What is drawn once ----------------------------------------------------------------------------------------------

/// Colours for readers with any colour vision (Okabe, Ito), one a row.
json colour_json(std::size_t row) {
  static constexpr std::array<std::array<double, 3>, 6> colours = {{{0, 0.447, 0.698},
                                                                    {0.835, 0.369, 0},
                                                                    {0, 0.62, 0.451},
                                                                    {0.8, 0.475, 0.655},
                                                                    {0.902, 0.624, 0},
                                                                    {0.337, 0.706, 0.914}}};
  const auto& c = colours[row % colours.size()];
  return {{"r", c[0]}, {"g", c[1]}, {"b", c[2]}, {"a", 1}};
}

json entity_json(const std::string& id, std::string_view frame) {
  return {{"timestamp", time_json(0)}, {"frame_id", frame},          {"id", id},
          {"lifetime", time_json(0)},  {"frame_locked", true},       {"cubes", json::array()},
          {"lines", json::array()},    {"metadata", json::array()},  {"arrows", json::array()},
          {"spheres", json::array()},  {"cylinders", json::array()}, {"triangles", json::array()},
          {"texts", json::array()},    {"models", json::array()}};
}

json edge_json(const Columns& track, const std::string& side) {
  constexpr int line_loop = 1;
  json points = json::array();
  for (std::size_t i = 0; i < track.rows(); ++i) {
    const double x = track.number(side + "x_m", i), y = track.number(side + "y_m", i);
    if (std::isfinite(x) && std::isfinite(y)) points.push_back(vector_json(x, y));
  }
  return {{"type", line_loop},       {"pose", pose_json(0, 0, 0)},
          {"thickness", 2},          {"scale_invariant", true},
          {"points", points},        {"color", {{"r", 0.5}, {"g", 0.5}, {"b", 0.5}, {"a", 1}}},
          {"colors", json::array()}, {"indices", json::array()}};
}

json track_scene(const Columns& track) {
  json entity = entity_json("track", world);
  for (const char* side : {"left_", "right_"}) entity["lines"].push_back(edge_json(track, side));
  return {{"deletions", json::array()}, {"entities", {entity}}};
}

double car_number(const json& scene, const char* name, double otherwise) {
  if (!scene.is_object() || !scene.contains("car") || !scene["car"].is_object()) return otherwise;
  const auto found = scene["car"].find(name);
  return found != scene["car"].end() && found->is_number() ? found->get<double>() : otherwise;
}

json cars_scene(const Results& results) {
  const double length = car_number(results.scene, "length", 4), width = car_number(results.scene, "width", 2);
  json entities = json::array();
  for (std::size_t row = 0; row < results.runs.size(); ++row) {
    json entity = entity_json(results.runs[row].name, results.runs[row].name);
    entity["cubes"].push_back(
        {{"pose", pose_json(0, 0, 0)}, {"size", vector_json(length, width, 0.5 * width)}, {"color", colour_json(row)}});
    entities.push_back(std::move(entity));
  }
  return {{"deletions", json::array()}, {"entities", entities}};
}

// --- What is drawn at every step -----------------------------------------------------------------------------------

struct Topics {
  std::uint16_t pose = 0, step = 0;
};

/// A step of a run among all steps, in order of time.
struct Instant {
  double t;
  std::size_t run, row;
};

std::vector<Instant> instants(const Results& results) {
  std::vector<Instant> all;
  for (std::size_t run = 0; run < results.runs.size(); ++run) {
    const std::span<const double> t = results.runs[run].steps.numbers("t_s");
    for (std::size_t row = 0; row < t.size(); ++row)
      if (std::isfinite(t[row]) && t[row] >= 0) all.push_back({t[row], run, row});
  }
  std::stable_sort(all.begin(), all.end(), [](const Instant& a, const Instant& b) { return a.t < b.t; });
  return all;
}

/// The true pose where it was logged, else the measured one.
std::array<double, 3> pose_at(const Columns& steps, std::size_t row) {
  const bool truth = steps.has("x_true_m");
  return {steps.number(truth ? "x_true_m" : "x_m", row), steps.number(truth ? "y_true_m" : "y_m", row),
          steps.number(truth ? "yaw_true_rad" : "yaw_rad", row)};
}

json step_json(const Columns& steps, std::size_t row) {
  json out = json::object();
  for (const std::string& name : steps.names())
    if (const double v = steps.number(name, row); std::isfinite(v)) out[name] = v;
  return out;
}

class Recording {
 public:
  explicit Recording(const Results& results) : results_(results) {
    const std::uint16_t scene = file_.schema("foxglove.SceneUpdate", scene_schema().dump());
    if (!results.track.empty()) file_.message(file_.channel(scene, "/track"), 0, track_scene(results.track).dump());
    file_.message(file_.channel(scene, "/cars"), 0, cars_scene(results).dump());
    transform_ = file_.channel(file_.schema("foxglove.FrameTransform", transform_schema().dump()), "/tf");
    const std::uint16_t pose = file_.schema("foxglove.PoseInFrame", pose_in_frame_schema().dump());
    for (const NamedRun& run : results.runs) {
      const std::uint16_t step = file_.schema("gripline.Step", step_schema(run.steps).dump());
      topics_.push_back({file_.channel(pose, "/" + run.name + "/pose"), file_.channel(step, "/" + run.name + "/step")});
    }
  }
  void write(const Instant& at) {
    const NamedRun& run = results_.runs[at.run];
    const auto [x, y, yaw] = pose_at(run.steps, at.row);
    if (std::isfinite(x) && std::isfinite(y) && std::isfinite(yaw)) {
      const json time = time_json(at.t), pose = pose_json(x, y, yaw);
      file_.message(transform_, at.t,
                    json{{"timestamp", time},
                         {"parent_frame_id", world},
                         {"child_frame_id", run.name},
                         {"translation", pose["position"]},
                         {"rotation", pose["orientation"]}}
                        .dump());
      file_.message(topics_[at.run].pose, at.t, json{{"timestamp", time}, {"frame_id", world}, {"pose", pose}}.dump());
    }
    file_.message(topics_[at.run].step, at.t, step_json(run.steps, at.row).dump());
  }
  std::string finish() && { return std::move(file_).finish(); }

 private:
  const Results& results_;
  McapWriter file_{"gripline " GRIPLINE_VERSION};
  std::uint16_t transform_ = 0;
  std::vector<Topics> topics_;
};

}  // namespace

std::string foxglove_mcap(const Results& results) {
  Recording recording(results);
  for (const Instant& at : instants(results)) recording.write(at);
  return std::move(recording).finish();
}

}  // namespace gripline::exports
