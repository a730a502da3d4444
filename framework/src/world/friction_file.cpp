#include "world/friction_file.hpp"

#include "config/json_file.hpp"
#include "config/reader.hpp"

namespace gripline {
namespace {

void read_points(std::span<const Node> nodes, FrictionSpec& spec, Errors& errors) {
  if (nodes.empty()) return;
  for (const Node& node : nodes) {
    const std::size_t before = errors.added();
    ObjectReader reader(node, errors);
    FrictionSpec::PointInTime point;
    point.t = reader.number("t", "s");
    point.factor = reader.number("factor", "1", NumberRange::positive());
    if (errors.added() != before) continue;  // a time that could not be read is neither early nor late
    if (!spec.points.empty() && point.t < spec.points.back().t) {
      reader.error_at("t", "the schedule goes back in time: " + number_text(point.t) + " s after " +
                               number_text(spec.points.back().t) + " s");
    }
    spec.points.push_back(point);
  }
}

FrictionSpec::PerStep read_per_step(ObjectReader reader) {
  FrictionSpec::PerStep rule;
  rule.start_step = reader.integer("start_step", {0, std::int64_t{1} << 40});
  rule.divide = reader.number("divide", "1", {1.0, std::numeric_limits<double>::infinity(), true, false});
  if (reader.find("end_step") != nullptr) rule.end_step = reader.integer("end_step", {0, std::int64_t{1} << 40});
  if (rule.end_step && *rule.end_step < rule.start_step) {
    reader.error_at("end_step", "the schedule goes back in time: end_step " + std::to_string(*rule.end_step) +
                                    " before start_step " + std::to_string(rule.start_step));
  }
  return rule;
}

void read_patches(std::span<const Node> nodes, FrictionSpec& spec, Errors& errors) {
  for (const Node& node : nodes) {
    ObjectReader reader(node, errors);
    FrictionSpec::Patch patch;
    patch.from_s = reader.number("from_s", "m", NumberRange::non_negative());
    patch.to_s = reader.number("to_s", "m", NumberRange::non_negative());
    patch.factor = reader.number("factor", "1", NumberRange::positive());
    patch.from_t = reader.number("from_t", "s", NumberRange::any(), 0.0);
    if (patch.from_s == patch.to_s) reader.error_at("to_s", "the patch begins and ends at the same station");
    spec.patches.push_back(patch);
  }
}

Node load_schedule(const Node& name) {
  if (const std::string why = why_no_input(name, json_ending); !why.empty())
    throw InputError(name.origin, name.describe() + ": " + why);
  return load_json(resolve_path(name));
}

FrictionSpec read_schedule(const Node& node, Errors& errors) {
  FrictionSpec spec;
  if (node.is_array()) {
    read_points(node.array(), spec, errors);
  } else if (node.is_object()) {
    ObjectReader reader(node, errors);
    read_points(reader.array("points", false), spec, errors);
    if (reader.find("per_step") != nullptr) spec.per_step = read_per_step(reader.object("per_step"));
    read_patches(reader.array("patches", false), spec, errors);
    spec.shift_per_seed = reader.number("shift_per_seed", "s", NumberRange::any(), 0.0);
  } else {
    errors.add(node.origin, "expected a friction schedule: a list of points, an object or the name of a file; found " +
                                node.describe());
  }
  return spec;
}

}  // namespace

FrictionSpec read_friction(const Node& node, Errors& errors) {
  const std::size_t before = errors.added();
  FrictionSpec spec;
  try {
    spec = node.is_text() ? read_schedule(load_schedule(node), errors) : read_schedule(node, errors);
  } catch (const InputError& error) {
    errors.add(error);
  }
  return errors.added() == before ? spec : FrictionSpec{};
}

}  // namespace gripline
