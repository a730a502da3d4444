#include "measured/session/log_guess.hpp"

#include <utility>

#include "measured/clock_steps.hpp"
#include "measured/session/guess_commands.hpp"
#include "measured/session/guess_draft.hpp"
#include "measured/session/guess_motion.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

/// What log_map.hpp asks of every map.
void name_what_is_missing(GuessDraft& draft) {
  const bool place = (draft.found("x") && draft.found("y")) || draft.found("latitude");
  if (!draft.found("delta")) {
    Node node = draft.unnamed("delta",
                              "the front wheels' angle, positive to the left (the steering wheel's as \"formula\": "
                              "\"COLUMN / RATIO\")",
                              "rad");
    node.set("kind", Node("command"));
    draft.channels.set("delta", std::move(node));
  }
  if (!place && !draft.found("vx")) draft.channels.set("vx", draft.unnamed("vx", "the speed along the car", "m/s"));
  if (!place && !draft.found("yaw") && !draft.found("yaw_rate"))
    draft.channels.set("yaw_rate", draft.unnamed("yaw_rate", "the yaw rate, positive to the left", "rad/s"));
  if (draft.time.is_null()) draft.time = draft.unnamed("time", "the time", "s", true);
}

void guess_time(GuessDraft& draft) {
  const int c = draft.column("time");
  if (c < 0) return;
  std::string unit = draft.unit_of(c, "s");
  std::vector<double> steps;
  const std::vector<double>& t = draft.values(c);
  for (std::size_t i = 1; i < t.size(); ++i)
    if (t[i] > t[i - 1]) steps.push_back(t[i] - t[i - 1]);
  const double step = quantile_of_size(steps, 0.5);
  constexpr double a_day = 86400.0;
  if (unit == "s" && !draft.table.is_clock(static_cast<std::size_t>(c)) && may_be_seconds_or_milliseconds(step)) {
    if (draft.unit_of_name(c, "s").empty() && step * static_cast<double>(steps.size()) > a_day) unit = "ms";
    draft.remarks.push_back("time: steps of " + significant(step) + " are " + significant(1.0 / step) +
                            " Hz in s and " + significant(1e3 / step, 4) + " Hz in ms; taken for " + unit);
  }
  for (const auto& [name_of, factor] : {std::pair("ms", 1e3), {"us", 1e6}, {"ns", 1e9}})
    if (!draft.table.is_clock(static_cast<std::size_t>(c)) && unit == "s" && step > 0.9e-3 * factor &&
        step < 0.3 * factor && step >= least_count) {
      unit = name_of;
      draft.remarks.push_back("time: steps of " + significant(step) + ", taken for " + name_of);
    }
  draft.time = guessed_channel("column", draft.name(c), unit, false);
}

/// What the table holds beside what the map reads: a column that was missed should not be so unseen.
void name_what_is_unused(GuessDraft& draft, const Node& map) {
  const Node* const valid = map.find("valid");
  constexpr std::size_t most = 30;
  std::string all;
  std::size_t count = 0;
  for (std::size_t c = 0; c < draft.table.name.size(); ++c) {
    const int column = static_cast<int>(c);
    if (draft.taken(column) || !draft.varies(c) ||
        (valid != nullptr && valid->text().starts_with(draft.quoted(column))))
      continue;
    if (++count <= most) all += (all.empty() ? "" : ", ") + draft.table.name[c];
  }
  if (count == 0) return;
  if (count > most) all += " and " + std::to_string(count - most) + " more";
  draft.remarks.push_back("columns not used: " + all);
}

}  // namespace

Guess guess_map(const DelimitedTable& table) {
  GuessDraft draft(table);
  guess_time(draft);
  guess_motion(draft);
  guess_commands(draft);
  name_what_is_missing(draft);
  Node map = Node::empty_object();
  map.set("note", Node("A first guess from names, units and numbers. Read every line; units and signs are checked "
                       "when the log is read."));
  map.set("time", draft.time);
  map.set("channels", draft.channels);
  if (const int valid = draft.column("valid"); valid >= 0) map.set("valid", Node(draft.quoted(valid) + " > 0.5"));
  name_what_is_unused(draft, map);
  return {std::move(map), std::move(draft.remarks), std::move(draft.open)};
}

}  // namespace gripline::measured
