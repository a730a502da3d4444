// The published 1:43 car (Liniger, Domahidi, Morari 2015; the paper's plant): what `dynamic` must be told to be it.
#pragma once

#include <string_view>
#include <utility>

#include "plugin/registry.hpp"

namespace gripline::testing_support {

inline constexpr std::pair<std::string_view, double> published_tyres[] = {
    {"Bf", 2.579},  {"Cf", 1.2},    {"Df", 0.192},   {"Br", 3.3852},
    {"Cr", 1.2691}, {"Dr", 0.1737}, {"Cr0", 0.0518}, {"Cd", 0.00035}};

/// A parameter's value: the published one where `dynamic` has it, else the default.
inline double published(const PluginEntry& entry, const abi::ParamDecl& param) {
  if (std::string_view(entry.decl->id) == "dynamic")
    for (const auto& [name, value] : published_tyres)
      if (name == param.name) return value;
  return param.default_value;
}

}  // namespace gripline::testing_support
