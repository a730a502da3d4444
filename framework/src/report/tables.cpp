#include "report/tables.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "report/packing.hpp"
#include "util/resampling.hpp"
#include "util/statistics.hpp"

namespace gripline::report {
namespace {

bool is_measure(const std::string& column) {
  static const std::set<std::string, std::less<>> others{"stack", "seed", "status", "needs_truth"};
  return !others.contains(column);
}

std::size_t index_of(const Inputs& inputs, const std::string& stack) {
  const auto found =
      std::find_if(inputs.stacks.begin(), inputs.stacks.end(), [&](const StackEntry& s) { return s.name == stack; });
  return static_cast<std::size_t>(found - inputs.stacks.begin());
}

/// The values of one column of runs.csv that belong to one stack.
std::vector<double> of_stack(const Columns& runs, const std::string& column, const std::string& stack) {
  std::vector<double> values;
  for (std::size_t i = 0; i < runs.rows(); ++i)
    if (runs.text("stack", i) == stack && std::isfinite(runs.number(column, i)))
      values.push_back(runs.number(column, i));
  return values;
}

std::string readable(const nlohmann::json& value) {
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::size_t stack_of_row(const Inputs& inputs, std::size_t row) {
  return index_of(inputs, inputs.table.text("stack", row));
}

CarShape car_shape(const nlohmann::json& scene) {
  CarShape car;
  if (!scene.is_object() || !scene.contains("car") || !scene["car"].is_object()) return car;
  const nlohmann::json& from = scene["car"];
  const auto read = [&](const char* key) {
    const auto found = from.find(key);
    return found != from.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  return {read("length"), read("width"), read("lf"), read("lr"), read("m")};
}

nlohmann::json table_json(const Inputs& inputs) {
  const Columns& source = inputs.table.empty() ? inputs.runs_table : inputs.table;
  std::vector<std::string> columns;
  const auto& names = source.names();
  const auto is_there = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto is_end = [&](const std::string& name) {
    return (name.ends_with("_lo") || name.ends_with("_hi")) && is_there(name.substr(0, name.size() - 3));
  };
  std::copy_if(names.begin(), names.end(), std::back_inserter(columns),
               [&](const std::string& name) { return is_measure(name) && !is_end(name); });
  nlohmann::json rows = nlohmann::json::array();
  // An experiment that was cut short has runs, but no table.
  for (std::size_t stack = 0; !columns.empty() && stack < inputs.stacks.size(); ++stack) {
    const std::string& name = inputs.stacks[stack].name;
    nlohmann::json row = {{"stack", stack}};
    std::size_t at = 0;
    while (at < inputs.table.rows() && inputs.table.text("stack", at) != name) ++at;
    for (const std::string& column : columns) {
      const std::vector<double> values = of_stack(inputs.runs_table, column, name);
      const bool stated = !inputs.table.empty() && is_there(column + "_lo") && is_there(column + "_hi");
      const MedianInterval interval =
          stated ? MedianInterval{inputs.table.number(column + "_lo", at), inputs.table.number(column + "_hi", at)}
                 : bootstrap_median_interval(values);
      row["values"].push_back(
          number_or_null(inputs.table.empty() ? median_of_numbers(values) : inputs.table.number(column, at)));
      row["low"].push_back(number_or_null(interval.lo));
      row["high"].push_back(number_or_null(interval.hi));
      // Runs that are equal to the last bit are one in table.csv.
      const double distinct = stated && is_there("runs") ? inputs.table.number("runs", at) : NAN;
      row["n"].push_back(distinct < static_cast<double>(values.size()) ? static_cast<std::size_t>(distinct)
                                                                       : values.size());
    }
    rows.push_back(std::move(row));
  }
  return {{"columns", columns}, {"rows", std::move(rows)}};
}

nlohmann::json pairs_json(const Inputs& inputs) {
  nlohmann::json rows = nlohmann::json::array();
  const Columns& pairs = inputs.pairs;
  for (std::size_t i = 0; i < pairs.rows(); ++i) {
    if (!(pairs.number("draws", i) > 0)) continue;
    nlohmann::json row = {{"stack", index_of(inputs, pairs.text("stack", i))},
                          {"baseline", index_of(inputs, pairs.text("baseline", i))},
                          {"column", pairs.text("column", i)}};
    for (const char* name : {"difference", "lo", "hi", "p", "draws"}) row[name] = number_or_null(pairs.number(name, i));
    rows.push_back(std::move(row));
  }
  return rows;
}

nlohmann::json runs_json(const Inputs& inputs) {
  nlohmann::json runs = nlohmann::json::array();
  for (std::size_t i = 0; i < inputs.runs.size(); ++i) {
    const RunName& run = inputs.runs[i];
    nlohmann::json values = nlohmann::json::object();
    if (i < inputs.runs_table.rows())
      for (const std::string& column : inputs.runs_table.names())
        if (is_measure(column) && std::isfinite(inputs.runs_table.number(column, i)))
          values[column] = inputs.runs_table.number(column, i);
    runs.push_back({{"stack", index_of(inputs, run.stack)},
                    {"seed", run.seed},
                    {"status", run.status},
                    {"message", run.message},
                    {"values", std::move(values)}});
  }
  return runs;
}

nlohmann::json claims_json(const nlohmann::json& claims) {
  nlohmann::json out = nlohmann::json::array();
  const auto add = [&](const nlohmann::json& list) {
    if (!list.is_array()) return;
    for (const nlohmann::json& claim : list) {
      if (!claim.is_object()) continue;
      const auto holds = claim.find("holds");
      const bool decided = holds != claim.end() && holds->is_boolean();
      out.push_back({{"text", claim.contains("text") ? readable(claim["text"]) : std::string()},
                     {"holds", decided ? *holds : nlohmann::json(nullptr)},
                     {"values", claim.contains("values") ? claim["values"] : nlohmann::json(nullptr)},
                     {"why", claim.contains("why") ? readable(claim["why"]) : std::string()}});
    }
  };
  if (claims.is_array()) add(claims);
  if (claims.is_object())
    for (const char* key : {"claims", "skipped"})
      if (claims.contains(key)) add(claims[key]);
  return out;
}

void TimeHistogram::add(double milliseconds) {
  if (!std::isfinite(milliseconds) || milliseconds < 0) return;
  const double decades = std::log10(std::max(milliseconds, first_ms) / first_ms);
  ++bins_[std::min(static_cast<int>(decades * bins_per_decade), bin_count - 1)];
  values_.push_back(static_cast<float>(milliseconds));
}

nlohmann::json TimeHistogram::json() const {
  const std::vector<double> values(values_.begin(), values_.end());
  const auto share = [&](double p) { return number_or_null(nearest_rank_quantile(values, p)); };
  nlohmann::json bins = nlohmann::json::array();
  for (const auto& [index, count] : bins_) bins.push_back({index, count});
  return {{"n", values.size()}, {"median", share(0.5)}, {"p95", share(0.95)},
          {"p99", share(0.99)}, {"max", share(1)},      {"bins", std::move(bins)}};
}

}  // namespace gripline::report
