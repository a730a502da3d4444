// The manifest of a plugin library: constant data behind one symbol whose name carries the ABI number, so that a host
// can refuse another ABI by reading the file, before any of its code is loaded.
#pragma once

#include <cstddef>
#include <cstdint>

#include <gripline/interfaces.hpp>

namespace gripline::abi {

inline constexpr std::uint32_t number = 2;
#define GRIPLINE_MANIFEST_SYMBOL gripline_plugins_abi2

enum class Kind : std::uint32_t { vehicle, effect, estimator, planner, controller, plant };
inline constexpr int kind_count = 6;

enum class ParamType : std::uint32_t { number, integer, boolean, choice, table };

/// needs_truth: gets Truth, and is marked * wherever it is shown.
enum Flags : std::uint32_t { none = 0, needs_truth = 1u << 0 };

struct ParamDecl {
  const char* name;
  const char* unit;  // "1" when pure
  const char* doc;
  ParamType type;
  double default_value;  // choice: index; table: unused
  double lo, hi;         // inclusive; table: of the values
  const char* choices;   // "a|b|c" for a choice, else null
  // A parameter that may be fitted: the value at which the effect vanishes, a value to start a fit from, its scale.
  bool fit;
  double neutral, start, scale;
  // A place along the lap, as a lap fraction: values a whole number apart are the same place.
  bool periodic;
};

struct ParamValue {
  double number;
  Table table;
};

struct PluginDecl {
  Kind kind;
  std::uint32_t flags;
  const char* id;
  const char* version;
  const char* summary;
  const ParamDecl* params;
  std::size_t param_count;
  /// Order in which diagnose puts effects of one stage into a chain; lower acts first.
  int precedence;
  /// What to drive so that a log tells this effect from others that look like it, as an imperative ("coast down from top
  /// speed"); "" when nothing is advised. `diagnose` prints it. Never null.
  const char* advice;
  /// Returns a pointer to the interface of the kind (VehicleModel*, Effect*, ...) as void*, or null with a message in
  /// error (at most error_size bytes, terminated).
  void* (*create)(const PluginContext*, const ParamValue*, char* error, std::size_t error_size);
  void (*destroy)(void*);
};

struct Manifest {
  std::uint32_t abi;
  std::uint32_t size;         // sizeof(Manifest) as the plugin saw it
  std::uint64_t layout_hash;  // of every struct that crosses, as the plugin saw them
  const char* compiler;
  const PluginDecl* plugins;
  std::size_t plugin_count;
};

/// A hash over the sizes of the structs that cross the boundary: most edits are noticed even when the number is forgotten.
constexpr std::uint64_t layout_hash() {
  constexpr std::size_t sizes[] = {sizeof(State),
                                   sizeof(Input),
                                   sizeof(Place),
                                   sizeof(Car),
                                   sizeof(Dual8),
                                   sizeof(Quantities<double>),
                                   sizeof(Quantities<Dual8>),
                                   sizeof(Reading<double>),
                                   sizeof(History<double>),
                                   sizeof(Points<double>),
                                   sizeof(Points<Dual8>),
                                   sizeof(Readings<double>),
                                   sizeof(Observation),
                                   sizeof(Sample),
                                   sizeof(Belief),
                                   sizeof(RefPoint),
                                   sizeof(Command),
                                   sizeof(CoursePoint),
                                   sizeof(LinePoint),
                                   sizeof(Table),
                                   sizeof(LineOptions),
                                   sizeof(PluginContext),
                                   sizeof(ParamDecl),
                                   sizeof(ParamValue),
                                   sizeof(PluginDecl),
                                   sizeof(Ground::Patch),
                                   sizeof(Prediction::Rates)};
  std::uint64_t hash = 14695981039346656037ull;
  for (const std::size_t size : sizes) hash = (hash ^ size) * 1099511628211ull;
  return hash;
}

}  // namespace gripline::abi
