// A plugin as JSON writes it, {"plugin": id, "params": {...}}, checked against what the plugin declares.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/reader.hpp"
#include "plugin/registry.hpp"

namespace gripline {

/// A plugin chosen and its parameters, in the order of its declaration. Tables point into `tables`, which copies share.
struct PluginSpec {
  const PluginEntry* entry = nullptr;
  std::vector<abi::ParamValue> values;
  std::vector<bool> defaulted;  // whether a value is the declared default, which nothing stated; empty: all are stated
  std::vector<std::shared_ptr<const std::vector<double>>> tables;
  /// Of an effect: its index in the list it was read from, where that list has its id more than once. It stays when
  /// others are taken out of a spec.
  std::optional<std::size_t> index_in_list;

  bool empty() const { return entry == nullptr; }
  std::string id() const { return entry == nullptr ? "" : entry->decl->id; }
  /// What names it in the list it was read from, and in pointers: its id, or its index where the id says too little.
  std::string name_in_list() const { return index_in_list ? std::to_string(*index_in_list) : id(); }
  /// The numbers alone, as effects and vehicle models take them.
  std::vector<double> numbers() const;
};

/// Values for parameters that the JSON does not give, by name: what a car states of itself.
using KnownParams = std::map<std::string, double>;

/// The words of a parameter that is a choice; its numbers are their indices, from 0.
std::vector<std::string> choice_names(const abi::ParamDecl& decl);

/// A value as read_plugin reads it: a word for a choice, rows for a table, wherever it was read from. Null, which is read
/// as the default, for a table without rows and a number that is not finite.
Node param_node(const abi::ParamDecl& decl, const abi::ParamValue& value);

/// Reads "plugin" and "params" from an object; other keys are the caller's. A parameter not given takes its value from
/// `known`, else its default. Where there is no such plugin the spec is empty, its parameters are not checked, and
/// throw_if_any() of the reader's errors throws PluginError if nothing else is wrong.
PluginSpec read_plugin(ObjectReader& reader, abi::Kind kind, const Registry& registry, const KnownParams& known = {});

}  // namespace gripline
