// The published 1:43 car (conformance/published_car.hpp): what `dynamic` must be told to be it.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <utility>

#include "conformance/published_car.hpp"
#include "plugin/registry.hpp"

namespace gripline::testing_support {

inline constexpr std::pair<std::string_view, double> published_tyres[] = {
    {"Bf", conformance::published::Bf},   {"Cf", conformance::published::Cf}, {"Df", conformance::published::Df},
    {"Br", conformance::published::Br},   {"Cr", conformance::published::Cr}, {"Dr", conformance::published::Dr},
    {"Cr0", conformance::published::Cr0}, {"Cd", conformance::published::Cd}};

/// The published tyres and resistance as a JSON object of `dynamic`'s parameters.
inline const std::string published_tyres_json = [] {
  std::string text;
  for (const auto& [name, value] : published_tyres) {
    std::array<char, 32> number{};
    const char* const end = std::to_chars(number.data(), number.data() + number.size(), value).ptr;
    text.append(text.empty() ? "{\"" : ", \"").append(name).append("\": ");
    text.append(number.data(), static_cast<std::size_t>(end - number.data()));
  }
  return text + "}";
}();

/// A parameter's value: the published one where `dynamic` has it, else the default.
inline double published(const PluginEntry& entry, const abi::ParamDecl& param) {
  if (std::string_view(entry.decl->id) == "dynamic")
    for (const auto& [name, value] : published_tyres)
      if (name == param.name) return value;
  return param.default_value;
}

}  // namespace gripline::testing_support
