#include "experiment/perturb.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/reader.hpp"
#include "experiment/experiment.hpp"
#include "geometry/track_checks.hpp"

namespace gripline {
namespace {

/// The place of a planner's parameter "pace".
std::optional<std::size_t> pace_index(const PluginSpec& planner) {
  for (std::size_t i = 0; i < planner.values.size(); ++i)
    if (std::string_view(planner.entry->decl->params[i].name) == "pace") return i;
  return std::nullopt;
}

/// Whether there is a start to move: a bad one is told as the world is read, and once.
bool stands_on_road(const WorldSpec& world) { return world.track && check_start(*world.track, world.start).empty(); }

/// What is wrong with the starts that the extremes give, `beyond` further out to each side [m]; empty if nothing is.
std::string check_extremes(const PerturbSpec& spec, const WorldSpec& world, double beyond) {
  for (int corner = 0; corner < 8; ++corner) {
    const auto end = [&](int bit, double width) { return (corner >> bit & 1) != 0 ? width : -width; };
    const Pose start = moved_start(
        world.start,
        {.along = end(0, spec.position), .across = end(1, spec.position + beyond), .heading = end(2, spec.heading)});
    if (std::string problem = check_start(*world.track, start); !problem.empty()) return problem;
  }
  return {};
}

/// The largest `position`, no more than it is, at which a car that is askew by `heading` has its corners on a straight
/// road; 0 if there is none.
double position_within_road(PerturbSpec spec, const WorldSpec& world) {
  const Car& car = world.car.car;
  const double corners = 0.5 * (car.width * std::cos(spec.heading) + car.length * std::sin(spec.heading));
  const auto fits = [&](double position) {
    spec.position = position;
    return check_extremes(spec, world, corners).empty();
  };
  double least = 0, most = spec.position;
  if (fits(most)) return most;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (least + most);
    (fits(middle) ? least : most) = middle;
  }
  return least;
}

void check_starts(const PerturbSpec& spec, const Node& node, const WorldSpec& world, Errors& errors) {
  if (spec.speed > world.start_speed)
    errors.add(node.find("speed")->origin, "the start's speed is " + number_text(world.start_speed) +
                                               " m/s; expected at most that as \"speed\", found " +
                                               number_text(spec.speed));
  if (!stands_on_road(world)) return;
  std::string problem = check_extremes(spec, world, 0);
  if (problem.empty()) return;
  PerturbSpec in_place = spec;
  in_place.position = 0;
  if (spec.position > 0 && check_extremes(in_place, world, 0).empty())
    problem += "; expected a smaller \"position\", or \"within_road\": true for what leaves the car's body on the road";
  errors.add(node.origin, "at its extremes: " + problem);
}

void check_paces(const PerturbSpec& spec, const Node& node, const std::vector<StackSpec>& stacks, Errors& errors) {
  const Origin& pace_at = node.find("pace")->origin;
  for (const StackSpec& stack : stacks) {
    if (stack.planner.empty()) continue;  // already reported
    const std::optional<std::size_t> at = pace_index(stack.planner);
    if (!at) {
      errors.add(pace_at,
                 "the planner of stack " + stack.name + ", " + stack.planner.id() + ", has no parameter of that name");
      continue;
    }
    const abi::ParamDecl& declared = stack.planner.entry->decl->params[*at];
    const double pace = stack.planner.values[*at].number;
    if (pace * (1.0 - spec.pace) < declared.lo || pace * (1.0 + spec.pace) > declared.hi)
      errors.add(pace_at, "that of stack " + stack.name + " would leave " + number_text(declared.lo) + " to " +
                              number_text(declared.hi));
  }
}

/// Calls use(where it says so, seconds) for every friction schedule in a tree that shifts with the seed; those that
/// stand in files of their own are read.
template <class Use>
void each_seed_shift(const Node& node, const Use& use) {
  if (node.is_array())
    for (const Node& one : node.array()) each_seed_shift(one, use);
  if (!node.is_object()) return;
  for (const Member& member : node.object()) {
    Errors ignored;  // what is no number of seconds is reported when the experiment is read
    const bool shifts = member.key == "shift_per_seed" && !member.value.is_null();
    const double shift = shifts ? read_number(member.value, "s", NumberRange::any(), ignored) : 0.0;
    if (shift != 0.0) use(member.value, shift);
    if (member.key == "friction" && member.value.is_text()) {
      Node schedule = member.value;
      inline_file(schedule);
      each_seed_shift(schedule, use);
    } else {
      each_seed_shift(member.value, use);
    }
  }
}

}  // namespace

PerturbSpec read_perturb(const Node& node, const WorldSpec& world, const std::vector<StackSpec>& stacks,
                         Errors& errors) {
  PerturbSpec spec;
  const std::size_t before = errors.size();
  ObjectReader r(node, errors);
  spec.position = r.number("position", "m", NumberRange::closed(0.0, 100.0), 0.0);
  spec.heading = r.number("heading", "rad", NumberRange::closed(0.0, 0.5 * std::numbers::pi), 0.0);
  spec.speed = r.number("speed", "m/s", NumberRange::closed(0.0, 100.0), 0.0);
  spec.pace = r.number("pace", "1", NumberRange::closed(0.0, 0.5), 0.0);
  const bool within_road = r.boolean("within_road", false);
  r.finish();
  if (errors.size() != before) return spec;
  if (within_road && stands_on_road(world) && spec.position > 0) {
    spec.position = position_within_road(spec, world);
    if (spec.position == 0) {
      errors.add(node.find("position")->origin,
                 "the car's body is not on the road at the start itself; expected another start, or no \"position\"");
      return spec;
    }
  }
  if (!spec.any()) errors.add(node.origin, "perturbs nothing; expected position, heading, speed or pace above 0");
  check_starts(spec, node, world, errors);
  if (spec.pace > 0) check_paces(spec, node, stacks, errors);
  return spec;
}

Draw draw_of(const PerturbSpec& spec, std::uint64_t seed) {
  // Makes the draws independent of those of sensors and learners, which start from the seed itself.
  constexpr std::uint32_t stream = 0x73746172;
  std::seed_seq both{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
  std::mt19937_64 random(both);
  const auto uniform = [&] { return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0; };
  Draw draw;
  draw.along = spec.position * uniform();
  draw.across = spec.position * uniform();
  draw.heading = spec.heading * uniform();
  draw.speed = spec.speed * uniform();
  draw.pace = 1.0 + spec.pace * uniform();
  return draw;
}

Pose moved_start(const Pose& start, const Draw& draw) {
  const double c = std::cos(start.yaw), s = std::sin(start.yaw);
  return {start.x + draw.along * c - draw.across * s, start.y + draw.along * s + draw.across * c,
          start.yaw + draw.heading};
}

std::optional<Draw> perturb(const PerturbSpec& spec, std::uint64_t seed, WorldSpec& world, StackSpec& stack) {
  if (!spec.any()) return std::nullopt;
  const Draw draw = draw_of(spec, seed);
  world.start = moved_start(world.start, draw);
  world.start_speed += draw.speed;
  if (const std::optional<std::size_t> at = pace_index(stack.planner)) stack.planner.values[*at].number *= draw.pace;
  return draw;
}

std::vector<std::uint64_t> seeds_from(std::string_view text, std::size_t count) {
  std::vector<std::uint64_t> seeds;
  for (std::size_t i = 0; seeds.size() < count; ++i) {
    const std::string digits = sha256_hex(std::string(text) + " " + std::to_string(i)).substr(0, 15);
    std::uint64_t number = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), number, 16);
    const std::uint64_t seed = number % (static_cast<std::uint64_t>(largest_seed) + 1);
    if (std::find(seeds.begin(), seeds.end(), seed) == seeds.end()) seeds.push_back(seed);
  }
  return seeds;
}

void require_drawn_seeds_fit(const Node& experiment, std::string_view text) {
  each_seed_shift(experiment, [&](const Node& at, double shift) {
    const std::uint64_t seed = seeds_from(text, 1).front();
    throw InputError(at.origin,
                     "--seeds-from \"" + std::string(text) + "\" draws seed " + std::to_string(seed) +
                         ", which shifts this friction by " + number_text(shift * (static_cast<double>(seed) - 1.0)) +
                         " s, beyond any race; leave it out and choose small seeds with --set /seeds/first=2");
  });
}

}  // namespace gripline
