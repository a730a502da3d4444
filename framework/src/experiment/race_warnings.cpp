#include "experiment/race_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "experiment/race_columns.hpp"
#include "util/child_process.hpp"

namespace gripline {
namespace {

std::string milliseconds(double time) {
  constexpr double per_second = 1000.0, decimals = 1e6;  // whole steps of a decimal dt are decimal again
  return number_text(std::round(time * per_second * decimals) / decimals) + " ms";
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// What the sensors show late.
struct Lateness {
  int steps = 0;         // the longest delay
  bool of_all = true;    // whether all channels have it
  std::string channels;  // "x 20 ms, y 20 ms"
};

Lateness lateness_of(const WorldSpec& world) {
  Lateness late;
  for (const SensorSpec::Channel& channel : world.sensors.channels) late.steps = std::max(late.steps, channel.delay);
  std::vector<std::string> channels;
  for (std::size_t i = 0; i < world.sensors.channels.size(); ++i) {
    const int delay = world.sensors.channels[i].delay;
    late.of_all = late.of_all && delay == late.steps;
    if (delay > 0) channels.push_back(sensor_channels[i].name + (" " + milliseconds(delay * world.dt)));
  }
  late.channels = list_of(channels);
  return late;
}

/// Whether the stack's model states no delay.
bool lacks_delay(const StackSpec& stack, const WorldSpec& world) {
  constexpr double timeout_s = 10.0;
  if (stack.model.effects.empty()) return true;
  PluginContext context = plugin_context(world);
  context.car = stack.car.value_or(context.car);
  try {
    const ChildResult result = run_in_child(timeout_s, [&](const SendMessage& send) {
      const Vehicle vehicle(stack.model, context);
      if (!(vehicle.car().look_back() > 0.0)) send("none");
    });
    return result.completed && !result.messages.empty();
  } catch (const std::runtime_error&) {  // no process can be started: what cannot be asked is not warned of
    return false;
  }
}

const Origin& place_of_delays(const Node& tree) {
  const Node* const delays = find_pointer(tree, "/world/sensors/delay");
  return (delays != nullptr ? *delays : tree).origin;
}

bool is_never_driven(const ClaimTerm& term, const WorldSpec& world) {
  if (term.stack.empty()) return false;
  const std::string_view whole = interval_of(term.column);
  const std::optional<NamedColumn> column = find_race_column(whole.empty() ? std::string_view(term.column) : whole);
  return column && column->lap >= static_cast<std::size_t>(world.laps);
}

std::string laps_in_words(int laps) {
  if (laps == 1) return "the world ends after 1 lap, lap 0";
  return "the world ends after " + std::to_string(laps) + " laps, 0 to " + std::to_string(laps - 1);
}

}  // namespace

std::vector<Diagnostic> late_sensor_warnings(const RaceSpec& race, const std::vector<std::string>& stacks,
                                             std::string_view effect) {
  const Lateness late = lateness_of(race.world);
  if (late.steps == 0) return {};
  std::vector<std::string> unaware;
  for (const StackSpec& stack : race.stacks)
    if (std::ranges::find(stacks, stack.name) != stacks.end() && lacks_delay(stack, race.world))
      unaware.push_back(stack.name);
  if (unaware.empty()) return {};
  const std::string longest = milliseconds(late.steps * race.world.dt);
  const std::string name(effect);
  const std::string who = (unaware.size() == 1 ? "the model of stack " : "the models of stacks ") + list_of(unaware) +
                          (unaware.size() == 1 ? " does" : " do") + " not know";
  const std::string text = late.of_all
                               ? "the sensors show the car " + longest + " late, and " + who + ": add {\"plugin\": \"" +
                                     name + "\", \"params\": {\"T\": \"" + longest + "\"}} to the model's \"effects\""
                               : "the sensors are late (" + late.channels + "), and " + who + "; the effect \"" + name +
                                     "\" takes one time for all channels and cannot state this";
  return {diagnostic_at(place_of_delays(race.tree), text)};
}

std::vector<Diagnostic> claim_warnings(const RaceSpec& race) {
  std::vector<Diagnostic> warnings;
  if (race.world.laps == 0) return warnings;  // who knows how many laps a duration is
  for (const Claim& claim : race.claims)
    for (const ClaimTerm* term : {&claim.left, &claim.right})
      if (is_never_driven(*term, race.world)) {
        warnings.push_back(diagnostic_at(claim.at, "\"" + term->column + "\" is of a lap that is never driven (" +
                                                       laps_in_words(race.world.laps) + "): the claim will fail"));
        break;
      }
  return warnings;
}

}  // namespace gripline
