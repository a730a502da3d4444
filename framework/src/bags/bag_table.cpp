#include "bags/bag_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "bags/message_fields.hpp"
#include "config/errors.hpp"
#include "measured/table/formula.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::bags {
namespace {

using Values = std::vector<double>;

constexpr std::int64_t near_clock = 10'000'000'000;  // [ns] stamps farther from the time of recording: another clock
constexpr double shortest_gap = 0.25;                // [s] silence that is not bridged, at least
constexpr double gap_steps = 4.0;                    // and of the usual interval

[[noreturn]] void refuse_bag(const BagFile& bag, const std::string& message) {
  throw InputError({Diagnostic{bag.file().string(), 0, 0, "", message, {}}});
}

/// What is read of one topic.
struct Series {
  std::size_t topic = 0;
  std::vector<std::size_t> column;  // of the table, by path
  std::vector<std::string> path;
  std::unique_ptr<FieldReader> reader{};
  std::vector<std::int64_t> recorded{}, stamp{};
  std::vector<Values> value{};         // by path
  std::vector<double> time{};          // [s], rising
  std::vector<std::size_t> message{};  // by time: index of the message
};

/// Of messages in order those with rising times, as many as can be: one stamp that jumps ahead costs itself, not all
/// that are earlier than it (patience sorting: for each length the run that ends earliest).
std::vector<std::size_t> longest_rising(const std::vector<std::size_t>& order, const std::vector<std::int64_t>& clock) {
  constexpr std::size_t none = SIZE_MAX;
  std::vector<std::size_t> ends, before(clock.size(), none);
  for (const std::size_t i : order) {
    const auto at = std::lower_bound(ends.begin(), ends.end(), clock[i],
                                     [&](std::size_t e, std::int64_t t) { return clock[e] < t; });
    if (at != ends.begin()) before[i] = *(at - 1);
    if (at == ends.end())
      ends.push_back(i);
    else
      *at = i;
  }
  std::vector<std::size_t> run;
  for (std::size_t i = ends.empty() ? none : ends.back(); i != none; i = before[i]) run.push_back(i);
  std::reverse(run.begin(), run.end());
  return run;
}

class TableMaker {
 public:
  TableMaker(BagFile& bag, const std::vector<Wanted>& wanted, const measured::BagOptions& options)
      : bag_(bag), wanted_(wanted), options_(options) {}

  DelimitedTable make(std::size_t most_numbers) {
    table_.file = bag_.file();
    group_by_topic();
    choose_rows();
    read(most_numbers);
    for (Series& series : all_) set_times(series);
    fill();
    return std::move(table_);
  }

 private:
  std::string name_of(const Series& series) const { return bag_.topics()[series.topic].name; }

  std::vector<std::string> topic_names() const {
    std::vector<std::string> names;
    for (const Topic& topic : bag_.topics()) names.push_back(topic.name);
    return names;
  }

  std::size_t topic_named(const std::string& name, const Origin& origin) const {
    const auto names = topic_names();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw InputError(origin, "no topic \"" + name + "\" in " + bag_.file().string() + did_you_mean(name, names));
    if (std::find(found + 1, names.end(), name) != names.end())
      throw InputError(origin, "topic \"" + name + "\" has messages of several types in " + bag_.file().string());
    if (bag_.topics()[static_cast<std::size_t>(found - names.begin())].messages == 0)
      throw InputError(origin, "topic \"" + name + "\" has no messages in " + bag_.file().string());
    return static_cast<std::size_t>(found - names.begin());
  }

  Series& series_of(std::size_t topic) {
    for (Series& series : all_)
      if (series.topic == topic) return series;
    return all_.emplace_back(Series{topic, {}, {}});
  }

  void group_by_topic() {
    for (std::size_t c = 0; c < wanted_.size(); ++c) {
      const std::string& column = wanted_[c].column;
      const std::size_t dot = std::min(column.find('.'), column.size());
      Series& series = series_of(topic_named(column.substr(0, dot), wanted_[c].origin));
      series.column.push_back(c);
      series.path.push_back(dot == column.size() ? "" : column.substr(dot + 1));
    }
    if (!options_.rows.empty()) (void)series_of(topic_named(options_.rows, options_.origin));
    const Definitions others = definitions_for(options_);
    for (Series& series : all_) {
      const Origin origin = series.column.empty() ? options_.origin : wanted_[series.column[0]].origin;
      try {
        Schema schema = schema_of(bag_, bag_.topics()[series.topic], others);
        series.reader = std::make_unique<FieldReader>(std::move(schema), series.path, bag_.start());
      } catch (const InputError& problem) {
        throw InputError(origin,
                         "topic \"" + name_of(series) + "\": " + problem.what() + ", in " + bag_.file().string());
      }
      series.value.resize(series.path.size());
    }
  }

  void choose_rows() {
    if (all_.empty())
      refuse_bag(bag_,
                 "the map names no topic; expected columns as `/odom.pose.pose.position.x` (gripline import "
                 "--guess BAG writes a first map)");
    const auto messages = [&](const Series& s) { return bag_.topics()[s.topic].messages; };
    for (std::size_t s = 0; s < all_.size(); ++s)
      if (options_.rows.empty() ? messages(all_[s]) > messages(all_[rows_]) : name_of(all_[s]) == options_.rows)
        rows_ = s;
  }

  void read(std::size_t most_numbers) {
    std::vector<bool> wanted(bag_.topics().size(), false);
    std::vector<Series*> by_topic(bag_.topics().size(), nullptr);
    for (Series& series : all_) wanted[series.topic] = true, by_topic[series.topic] = &series;
    std::size_t numbers = 0;
    bag_.read(wanted, [&](const Message& message) {
      Series& series = *by_topic.at(message.topic);
      numbers += series.path.size() + 2;
      if (numbers > most_numbers) {
        table_.found.push_back("only the first " +
                               significant(1e-9 * static_cast<double>(message.recorded - bag_.start())) +
                               " s are looked at");
        return false;
      }
      take(series, message);
      return true;
    });
  }

  void take(Series& series, const Message& message) const {
    try {
      const std::span<const double> values = series.reader->read(message.bytes);
      for (std::size_t p = 0; p < values.size(); ++p)
        series.value[p].push_back(std::isfinite(values[p]) ? values[p] : not_a_number);
    } catch (const InputError& problem) {
      refuse_bag(bag_, "message " + std::to_string(series.recorded.size() + 1) + " of " + name_of(series) + ": " +
                           problem.what());
    }
    series.recorded.push_back(message.recorded);
    series.stamp.push_back(series.reader->stamp().value_or(0));
  }

  /// Messages by recording, without those whose stamp is of another clock (`stamped`).
  static std::vector<std::size_t> in_order(const Series& series, bool stamped) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < series.recorded.size(); ++i)
      if (!stamped || (series.stamp[i] > 0 && std::abs(series.stamp[i] - series.recorded[i]) < near_clock))
        order.push_back(i);
    const auto earlier = [&](std::size_t a, std::size_t b) { return series.recorded[a] < series.recorded[b]; };
    std::stable_sort(order.begin(), order.end(), earlier);
    return order;
  }

  /// The times of a topic's messages: stamps of headers where at most a tenth of them are wrong, else of recording.
  void set_times(Series& series) {
    bool stamped = !options_.recorded && series.reader->has_header();
    if (stamped) series.message = longest_rising(in_order(series, true), series.stamp);
    stamped = stamped && 10 * series.message.size() >= 9 * series.stamp.size();
    const auto& clock = stamped ? series.stamp : series.recorded;
    if (!stamped) series.message = longest_rising(in_order(series, false), clock);
    for (const std::size_t i : series.message)
      series.time.push_back(1e-9 * static_cast<double>(clock[i] - bag_.start()));
    std::string words = name_of(series) + ": " + std::to_string(clock.size()) + " messages";
    if (series.time.size() > 1)
      words += " at " +
               significant(static_cast<double>(series.time.size() - 1) / (series.time.back() - series.time.front())) +
               " Hz";
    words += stamped ? ", times of their headers" : ", times of recording";
    if (stamped) {
      Values late;
      for (std::size_t i = 0; i < clock.size(); ++i)
        late.push_back(1e-6 * static_cast<double>(series.recorded[i] - clock[i]));
      words += ", recorded " + significant(median(std::move(late)), 2) + " ms later";
    }
    if (series.time.size() < clock.size())
      words += ", " + std::to_string(clock.size() - series.time.size()) + " out of order left out";
    table_.found.push_back(std::move(words));
  }

  void fill() {
    const Series& rows = all_[rows_];
    if (all_.size() > 1) table_.found.push_back("rows are messages of " + name_of(rows));
    table_.name = {time_column};
    table_.column = {rows.time};
    for (std::size_t i = 0; i < rows.time.size(); ++i) table_.line.push_back(static_cast<int>(rows.message[i] + 1));
    for (const Wanted& one : wanted_) table_.name.push_back(one.column);
    table_.unit.resize(table_.name.size());
    table_.column.resize(table_.name.size());
    for (Series& series : all_)
      for (std::size_t p = 0; p < series.path.size(); ++p) {
        const Wanted& one = wanted_[series.column[p]];
        Values& to = table_.column[series.column[p] + 1];
        if (&series == &rows)
          for (const std::size_t m : series.message) to.push_back(series.value[p][m]);
        else
          to = at_rows(series, p, one, rows.time);
        series.value[p] = {};
      }
  }

  /// A number of one topic at the times of another's messages.
  Values at_rows(const Series& series, std::size_t path, const Wanted& one, const Values& rows) const {
    const Values& t = series.time;
    Values y;
    for (const std::size_t m : series.message) y.push_back(series.value[path][m]);
    const double longest = longest_step(t), jump = one.wraps ? wrap_of(y) : INFINITY;
    const bool turns = series.reader->turns(path);
    Values out;
    std::size_t next = 0;  // the first message after the row
    for (const double now : rows) {
      while (next < t.size() && t[next] <= now) ++next;
      if (next == 0) {
        out.push_back(not_a_number);
      } else if (one.held || t[next - 1] == now) {
        out.push_back(y[next - 1]);
      } else if (next == t.size() || t[next] - t[next - 1] > longest) {
        out.push_back(not_a_number);
      } else {
        double rise = y[next] - y[next - 1];
        if (turns) rise = std::remainder(rise, 2.0 * std::numbers::pi);
        const double share = (now - t[next - 1]) / (t[next] - t[next - 1]);
        out.push_back(std::abs(rise) > jump ? not_a_number : y[next - 1] + share * rise);
      }
    }
    return out;
  }

  static double longest_step(const Values& t) {
    Values steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    return std::max(shortest_gap, gap_steps * median(std::move(steps), 0.0));
  }

  /// Half of the range of an angle that goes around (radians or degrees); no jump counts where it stays within less.
  static double wrap_of(const Values& y) {
    double low = INFINITY, high = -INFINITY;
    for (const double v : y)
      if (!std::isnan(v)) low = std::min(low, v), high = std::max(high, v);
    return high - low > 6.0 ? 0.5 * (high - low) : INFINITY;
  }

  BagFile& bag_;
  const std::vector<Wanted>& wanted_;
  const measured::BagOptions& options_;
  std::vector<Series> all_;
  std::size_t rows_ = 0;  // index of the series that gives them
  DelimitedTable table_;
};

void add_wanted(std::vector<Wanted>& all, const std::string& formula, bool held, bool wraps, const Origin& origin) {
  for (const std::string& name : measured::quoted_names(formula)) {
    if (!name.starts_with('/')) continue;
    const auto known = std::find_if(all.begin(), all.end(), [&](const Wanted& w) { return w.column == name; });
    if (known == all.end())
      all.push_back({name, held, wraps, origin});
    else if (known->held != held)
      throw InputError(origin, "\"" + name + "\" is wanted held here and linear at " + known->origin.pointer +
                                   " (or the other way round); one column is read in one way");
    else
      known->wraps = known->wraps || wraps;
  }
}

}  // namespace

Definitions definitions_for(const measured::BagOptions& options) {
  Definitions all = common_definitions();
  if (!options.definitions.empty())
    for (auto& [type, text] : definitions_in(options.definitions)) all[type] = std::move(text);
  return all;
}

Schema schema_of(const BagFile& bag, const Topic& topic, const Definitions& others) {
  const std::string type = short_type(topic.type);
  const auto other = others.find(type);
  if (topic.definition.empty() && other != others.end()) return parse_schema(type, other->second, bag.wire(), others);
  if (topic.definition.empty())
    throw InputError("its type " + type +
                     " is not defined in the file, nor among the common ones; \"definitions\" in the map's \"bag\" "
                     "names a folder of .msg files");
  return parse_schema(type, topic.definition, bag.wire(), others);
}

DelimitedTable read_table(BagFile& bag, const std::vector<Wanted>& wanted, const measured::BagOptions& options,
                          std::size_t most_numbers) {
  return TableMaker(bag, wanted, options).make(most_numbers);
}

std::vector<Wanted> wanted_by(const measured::LogMap& map) {
  std::vector<Wanted> all;
  add_wanted(all, map.time.formula, false, false, map.time.origin);
  for (std::size_t s = 0; s < measured::source_count; ++s)
    if (const auto& channel = map.channel[s])
      add_wanted(all, channel->formula, channel->between.held(),
                 static_cast<measured::Source>(s) == measured::Source::yaw, channel->origin);
  for (const std::string& name : measured::quoted_names(map.valid)) {
    // A switch is held, unless a channel reads the column in its own way.
    const bool known = std::any_of(all.begin(), all.end(), [&](const Wanted& w) { return w.column == name; });
    if (!known && name.starts_with('/')) all.push_back({name, true, false, map.bag.origin});
  }
  return all;
}

DelimitedTable read_table(BagFile& bag, const measured::LogMap& map) {
  const std::vector<Wanted> wanted = wanted_by(map);
  DelimitedTable table = read_table(bag, wanted, map.bag);
  for (const Wanted& one : wanted) {
    const Values& values = table.column[static_cast<std::size_t>(table.find(one.column))];
    if (std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }))
      throw InputError(one.origin, "\"" + one.column + "\" is in no row of " + bag.file().string() +
                                       ": an element that its array never has, or a topic that is silent while that "
                                       "of the rows is recorded");
  }
  return table;
}

}  // namespace gripline::bags
