#include "plugin/plugin_spec.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "config/json_file.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace {

/// A table is [[a, b], ...], rows of equal length, the first column rising; or the name of a CSV file of that shape.
Table read_table(const Node& node, const abi::ParamDecl& decl, PluginSpec& spec, Errors& errors) {
  const auto shared = std::make_shared<std::vector<double>>();
  std::vector<double>& data = *shared;
  std::size_t cols = 0;
  const auto refuse = [&](const std::string& text) {
    errors.add(node.origin, std::string(decl.name) + ": " + text);
    return Table{};
  };
  if (node.is_text()) {
    if (const std::string why = why_no_input(node, csv_ending); !why.empty())
      return refuse(node.describe() + ": " + why);
    try {
      const CsvTable csv = read_csv(resolve_path(node));
      cols = csv.columns;
      data = csv.values;
    } catch (const std::exception& e) {
      return refuse(e.what());
    }
  } else {
    if (!node.is_array())
      return refuse("expected a table: [[x, y], ...] or the name of a CSV file, found " + node.describe());
    for (const Node& row : node.array()) {
      const std::vector<double> numbers = read_numbers(row, "1", NumberRange::any(), std::nullopt, errors);
      if (cols == 0) cols = numbers.size();
      if (numbers.size() != cols) return refuse("rows of a table must be equally long");
      data.insert(data.end(), numbers.begin(), numbers.end());
    }
  }
  if (cols == 0) return refuse("a table must not be empty");
  spec.tables.push_back(shared);
  const Table table = {data.data(), data.size() / cols, cols};
  for (std::size_t row = 1; row < table.rows; ++row)
    if (!(table.at(row, 0) > table.at(row - 1, 0)))
      return refuse("the first column must rise; row " + std::to_string(row + 1) + " goes back from " +
                    number_text(table.at(row - 1, 0)) + " to " + number_text(table.at(row, 0)));
  for (const double number : data)
    if (!(number >= decl.lo && number <= decl.hi))
      return refuse(number_text(number) + " is outside [" + number_text(decl.lo) + ", " + number_text(decl.hi) + "]");
  return table;
}

abi::ParamValue read_value(const Node& node, const abi::ParamDecl& decl, PluginSpec& spec, Errors& errors) {
  const auto range = NumberRange::closed(decl.lo, decl.hi);
  switch (decl.type) {
    case abi::ParamType::boolean:
      return {read_boolean(node, errors) ? 1.0 : 0.0, {}};
    case abi::ParamType::integer: {
      const IntegerRange whole = {static_cast<std::int64_t>(decl.lo), static_cast<std::int64_t>(decl.hi)};
      return {static_cast<double>(read_integer(node, whole, errors)), {}};
    }
    case abi::ParamType::choice:
      return {static_cast<double>(read_choice(node, choice_names(decl), errors)), {}};
    case abi::ParamType::table:
      return {0.0, read_table(node, decl, spec, errors)};
    case abi::ParamType::number:
      break;
  }
  return {read_number(node, decl.unit, range, errors), {}};
}

/// What read_table reads as this table.
Node table_node(const Table& table) {
  if (table.rows == 0) return Node::null();
  Node::Array rows;
  for (std::size_t r = 0; r < table.rows; ++r) {
    Node::Array row;
    for (std::size_t c = 0; c < table.cols; ++c) row.emplace_back(table.at(r, c));
    rows.emplace_back(std::move(row));
  }
  return Node(std::move(rows));
}

/// What is known of the car under a parameter's name. Nobody held it to the parameter: a number that is no whole one
/// would be made one in the plugin.
double known_value(double known, const abi::ParamDecl& decl, ObjectReader& reader) {
  if (decl.type == abi::ParamType::number || decl.type == abi::ParamType::table) return known;
  if (known >= decl.lo && known <= decl.hi && std::trunc(known) == known) return known;
  reader.error_at("plugin", std::string(decl.name) + " is known of the car as " + number_text(known) +
                                "; expected a whole number from " + number_text(decl.lo) + " to " +
                                number_text(decl.hi));
  return decl.default_value;
}

/// Registry::find, its error with the place in the file where the plugin is named; null after it.
const PluginEntry* find_at(const Registry& registry, abi::Kind kind, const Node& name, Errors& errors) {
  try {
    return &registry.find(kind, name.text());
  } catch (const PluginError& error) {
    errors.add(name.origin, error.what(), [](const std::string& lines) { throw PluginError(lines); });
    return nullptr;
  }
}

const abi::ParamDecl* find_param(const PluginEntry& entry, const std::string& name) {
  const auto params = entry.params();
  const auto found = std::ranges::find_if(params, [&](const abi::ParamDecl& decl) { return name == decl.name; });
  return found == params.end() ? nullptr : &*found;
}

/// The object that a plugin's name stands in.
Origin part_of(const Node& name) {
  Origin part = name.origin;
  part.pointer = part.pointer.substr(0, part.pointer.rfind('/'));
  return part;
}

/// Whether a parameter stands beside the plugin's name, in one part of one file.
bool is_beside(const Node& param, const Node& name) {
  return param.origin.source == name.origin.source &&
         param.origin.pointer.starts_with(part_of(name).pointer + "/params/");
}

/// Refuses parameters of the plugin that a merge put this one in the place of, in one message: a near name among the
/// new one's parameters is not what was meant.
void refuse_inherited(ObjectReader& values, const Node& name, const PluginEntry& entry, const Registry& registry) {
  if (!name.replaced || !values.node().is_object()) return;
  const auto before = std::ranges::find_if(registry.entries(), [&](const PluginEntry& one) {
    return one.decl->kind == entry.decl->kind && name.replaced->text() == one.decl->id;
  });
  if (before == registry.entries().end()) return;
  std::vector<std::string> inherited;
  for (const Member& one : values.node().object()) {
    const bool old = find_param(*before, one.key) != nullptr && find_param(entry, one.key) == nullptr;
    if (!old || one.value.is_null() || is_beside(one.value, name)) continue;
    (void)values.find(one.key);  // told here
    inherited.push_back(one.key);
  }
  if (inherited.empty()) return;
  constexpr std::size_t most = 4;
  std::string list;
  for (std::size_t i = 0; i < std::min(most, inherited.size()); ++i) list += (i > 0 ? ", " : "") + inherited[i];
  if (inherited.size() > most) list += ", ...";
  values.errors().add(part_of(name), '"' + name.text() + "\" inherits parameters of \"" + name.replaced->text() +
                                         "\" that it does not have (" + list +
                                         "); write \"params\": null beside \"plugin\" to drop them");
}

}  // namespace

std::vector<std::string> choice_names(const abi::ParamDecl& decl) {
  std::vector<std::string> names;
  std::stringstream stream(decl.choices);
  for (std::string name; std::getline(stream, name, '|');) names.push_back(name);
  return names;
}

Node param_node(const abi::ParamDecl& decl, const abi::ParamValue& value) {
  switch (decl.type) {
    case abi::ParamType::boolean:
      return Node(value.number != 0.0);
    case abi::ParamType::choice:
      return Node(choice_names(decl).at(static_cast<std::size_t>(value.number)));
    case abi::ParamType::table:
      return table_node(value.table);
    case abi::ParamType::number:
    case abi::ParamType::integer:
      break;
  }
  return number_or_null(value.number);
}

std::vector<double> PluginSpec::numbers() const {
  std::vector<double> out;
  out.reserve(values.size());
  for (const abi::ParamValue& value : values) out.push_back(value.number);
  return out;
}

PluginSpec read_plugin(ObjectReader& reader, abi::Kind kind, const Registry& registry, const KnownParams& known) {
  PluginSpec spec;
  const std::string id = reader.text("plugin");
  const Node* const params = reader.find("params");
  if (id.empty()) {
    const Node* const name = reader.find("plugin");
    if (name != nullptr && name->is_text())
      reader.error_at("plugin", "expected the id of a plugin (" + std::string(kind_name(kind)) + "), found \"\"");
    return spec;
  }
  const Node& name = *reader.node().find("plugin");
  spec.entry = find_at(registry, kind, name, reader.errors());
  if (spec.entry == nullptr) return spec;
  static const Node no_params = Node::empty_object();
  const Node& given = params != nullptr && !params->is_null() ? *params : no_params;
  ObjectReader values(given, reader.errors());
  for (const abi::ParamDecl& decl : spec.entry->params()) {
    const Node* const node = values.find(decl.name);
    spec.defaulted.push_back(node == nullptr && !known.contains(decl.name));
    if (node != nullptr) {
      spec.values.push_back(read_value(*node, decl, spec, reader.errors()));
    } else {
      const auto from_car = known.find(decl.name);
      spec.values.push_back(
          {from_car != known.end() ? known_value(from_car->second, decl, reader) : decl.default_value, {}});
    }
  }
  refuse_inherited(values, name, *spec.entry, registry);
  values.finish();
  return spec;
}

}  // namespace gripline
