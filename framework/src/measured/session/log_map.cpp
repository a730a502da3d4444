#include "measured/session/log_map.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "config/json_file.hpp"
#include "config/units.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

/// The sources that are no channel.
constexpr std::array<SourceInfo, source_count - channels> other_sources = {{{"d", "1", "d"},
                                                                            {"delta", "rad", "delta_rad"},
                                                                            {"latitude", "rad", "latitude"},
                                                                            {"longitude", "rad", "longitude"}}};
constexpr std::array<SourceInfo, source_count> infos = [] {
  std::array<SourceInfo, source_count> all{};
  for (std::size_t c = 0; c < channels; ++c)
    all[c] = {channel_info[c].name, channel_info[c].unit, channel_info[c].column};
  std::copy(other_sources.begin(), other_sources.end(), all.begin() + channels);
  return all;
}();
constexpr double longest_delay = 2.0;  // [s]
constexpr double least_along = 0.5;    // share of the speed that a velocity's own axis shows

std::string quoted(const std::string& column) {
  const bool plain = std::all_of(column.begin(), column.end(),
                                 [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.'; });
  return plain && !column.empty() && std::isdigit(static_cast<unsigned char>(column.front())) == 0 ? column
                                                                                                   : "`" + column + "`";
}

/// `against`: why what is read cannot be late; null where it can.
void read_delay(ObjectReader& r, const char* against, MappedChannel& channel) {
  channel.delay = 0.0;
  const Node* const delay = r.find("delay");
  if (delay == nullptr) return;
  if (delay->is_text() && delay->text() == "find")
    channel.delay.reset();
  else
    channel.delay = read_number(*delay, "s", NumberRange::closed(-longest_delay, longest_delay), r.errors());
  if (against != nullptr && channel.delay != 0.0) r.error_at("delay", against);
}

/// Why a source has no delay, null where it has one. Of the time `map` is null.
const char* why_never_late(const LogMap* map, Source source) {
  if (map == nullptr) return "the time itself is not late; expected delays of channels";
  if (source == Source::d || source == Source::delta)
    return "delays count from the commands; expected delays of the measurements, below 0 where the command is written "
           "late; where the car answers late, an effect of the world";
  return nullptr;
}

/// A number of a frame, which each of the unit's channels may state.
void read_coordinate(ObjectReader& frame, const char* key, const char* unit, double limit, double& to, bool& given) {
  if (!frame.has(key)) return;
  const double number = frame.number(key, unit, NumberRange::closed(-limit, limit));
  if (given && number != to)
    frame.error_at(key, "another channel of this unit states " + significant(to) + ' ' + unit + "; expected the same");
  to = number;
  given = true;
}

void read_frame(ObjectReader& r, Source source, LogMap& map) {
  if (!r.has("frame")) return;
  ObjectReader frame = r.object("frame");
  const bool pose = source == Source::x || source == Source::y || source == Source::yaw;
  if (!pose && source != Source::vx && source != Source::vy) {
    frame.error("only x, y, yaw, vx and vy have a frame");
    return;
  }
  Frame& to = pose ? map.pose : map.velocity;
  read_coordinate(frame, "x", "m", 20.0, to.x, to.x_given);
  read_coordinate(frame, "y", "m", 20.0, to.y, to.y_given);
  read_coordinate(frame, "yaw", "rad", 3.2, to.yaw, to.yaw_given);
  if (!pose && frame.has("yaw") && std::abs(std::cos(to.yaw)) < least_along)
    frame.error_at("yaw",
                   "turned by more than 60 and less than 120 deg, vx hardly shows the speed; expected formulas that "
                   "turn the columns A and B: vx = cos(a)*A - sin(a)*B, vy = sin(a)*A + cos(a)*B, at 90 deg -B and A");
}

void check_unit(const MappedChannel& channel, const char* unit, Errors& errors) {
  if (channel.unit.empty()) return;
  try {
    (void)to_si("1 " + channel.unit, unit);
  } catch (const UnitError& problem) {
    errors.add(channel.origin, std::string("unit: ") + problem.what());
  }
}

/// `may_be_paced`: whether the channel is one that can be read every so often.
BetweenRows read_between_rows(ObjectReader& r, bool may_be_paced) {
  using enum BetweenRows::Kind;
  BetweenRows between;
  between.used = r.choice<BetweenRows::Kind>("hold", {{"held", held}, {"sampled", linear}}, linear);
  between.every = r.number("every", "s", NumberRange::closed(0.0, 1.0), 0.0);
  between.stated = r.has("hold") || between.every > 0.0;
  if (!(between.every > 0.0)) return between;
  if (!may_be_paced)
    r.error_at("every", "only d and delta are read every so often; a measurement that repeats is \"held\"");
  if (between.held())
    r.error_at("every", "a command that is held jumps to each reading; one read every so often moves to it");
  between.used = paced;
  return between;
}

/// `map` takes the channel's frame; null for the time.
MappedChannel read_channel(const Node& node, const char* unit, Errors& errors, LogMap* map = nullptr,
                           Source source = Source::x) {
  MappedChannel channel;
  channel.origin = node.origin;
  channel.delay = 0.0;
  if (node.is_text()) {
    channel.formula = node.text();
    return channel;
  }
  ObjectReader r(node, errors);
  const bool column = r.has("column"), formula = r.has("formula");
  if (column == formula) r.error("expected either \"column\" or \"formula\"");
  if (column) channel.formula = quoted(r.text("column"));
  if (channel.formula == quoted(unnamed_column))
    r.error_at(
        "column",
        "\"?\" is to be filled in: write the name of the log's column here (the note beside it has those in question)");
  if (formula) channel.formula = r.text("formula");
  channel.unit = r.text("unit", std::string());
  channel.sign = r.number("sign", "1", NumberRange::closed(-1.0, 1.0), 1.0);
  if (channel.sign != 1.0 && channel.sign != -1.0) r.error_at("sign", "expected 1 or -1");
  channel.command = r.choice<bool>("kind", {{"command", true}, {"measurement", false}}, false);
  channel.between = read_between_rows(r, map == nullptr || source == Source::d || source == Source::delta);
  read_delay(r, why_never_late(map, source), channel);
  if (map != nullptr) read_frame(r, source, *map);
  r.finish();
  check_unit(channel, unit, errors);
  return channel;
}

void read_bag_options(ObjectReader r, BagOptions& to) {
  to.origin = r.node().origin;
  to.rows = r.text("rows", std::string());
  to.recorded = r.choice<bool>("time", {{"recorded", true}, {"header", false}}, false);
  if (r.has("definitions")) to.definitions = r.path("definitions");
  r.finish();
}

void check_groups(const LogMap& map, Errors& errors) {
  const auto one_delay = [&](std::size_t first) {
    const auto &a = map.channel[first], &b = map.channel[first + 1];
    if (a && b && a->delay != b->delay)
      errors.add(b->origin, std::string("its delay differs from that of ") + infos[first].name +
                                "; channels of one unit share it");
  };
  for (std::size_t c = 0; c + 1 < channels; ++c)
    if (delay_group[c] == delay_group[c + 1]) one_delay(c);
  one_delay(static_cast<std::size_t>(Source::latitude));
}

void check_channels(const LogMap& map, const Node& node, Errors& errors) {
  const auto missing = [&](const char* what) { errors.add(child_of(node.origin, "channels"), what); };
  const bool place = (map[Source::x] && map[Source::y]) || (map[Source::latitude] && map[Source::longitude]);
  if (map[Source::x].has_value() != map[Source::y].has_value()) missing("x and y go together");
  if (map[Source::latitude].has_value() != map[Source::longitude].has_value())
    missing("latitude and longitude go together");
  if (!place && !map[Source::vx]) missing("neither x and y nor vx: nothing says how the car moved");
  if (!map[Source::yaw_rate] && !map[Source::yaw] && !place) missing("neither yaw nor yaw_rate nor x and y");
  if (!map[Source::delta]) missing("delta is missing: without the steering nothing can be predicted");
}

}  // namespace

const SourceInfo& source_info(Source source) { return infos[static_cast<std::size_t>(source)]; }

std::optional<double> LogMap::delay(std::size_t group) const {
  for (std::size_t c = 0; c < channels; ++c)
    if (delay_group[c] == group && channel[c]) return channel[c]->delay;
  if (group == 0 && (*this)[Source::latitude]) return (*this)[Source::latitude]->delay;
  return 0.0;
}

void LogMap::find_delay(std::size_t group, double start) {
  delay_start[group] = start;
  for (std::size_t c = 0; c < channels; ++c)
    if (delay_group[c] == group && channel[c]) channel[c]->delay.reset();
  for (const Source degrees : {Source::latitude, Source::longitude})
    if (auto& one = channel[static_cast<std::size_t>(degrees)]; group == 0 && one) one->delay.reset();
}

LogMap gripline_map() {
  LogMap map;
  map.time.formula = "t_s";
  for (std::size_t s = 0; s <= static_cast<std::size_t>(Source::delta); ++s) {
    MappedChannel channel;
    channel.formula = infos[s].column;
    channel.delay = 0.0;
    channel.command = s >= static_cast<std::size_t>(Source::d);
    channel.between.stated = channel.command;
    map.channel[s] = channel;
  }
  return map;
}

LogMap read_log_map(const Node& node, Errors& errors) {
  LogMap map;
  ObjectReader r(node, errors);
  if (const Node* time = r.require("time", "the column of the time"); time != nullptr)
    map.time = read_channel(*time, "s", errors);
  ObjectReader all = r.object("channels");
  for (std::size_t s = 0; s < source_count; ++s) {
    const Node* const one = all.find(infos[s].name);
    if (one == nullptr) continue;
    map.channel[s] = read_channel(*one, infos[s].unit, errors, &map, static_cast<Source>(s));
  }
  all.finish();
  map.valid = r.text("valid", std::string());
  map.bag.origin = node.origin;
  if (r.has("bag")) read_bag_options(r.object("bag"), map.bag);
  r.finish();
  check_groups(map, errors);
  check_channels(map, node, errors);
  return map;
}

LogMap load_log_map(const std::filesystem::path& file) {
  const Node node = load_json(file);
  Errors errors;
  LogMap map = read_log_map(node, errors);
  errors.throw_if_any();
  map.file = file;
  return map;
}

}  // namespace gripline::measured
