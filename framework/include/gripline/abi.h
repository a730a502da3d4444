/// \file
/// The manifest of a plugin library: constant data behind one symbol whose name carries the ABI number, so that a host
/// can refuse another ABI by reading the file, before any of its code is loaded. What must agree beside the number is
/// in abi_layout.hpp. It is C++20 as all of the SDK; the suffix stays because plugins may include it by name.
#pragma once

#include <cstddef>
#include <cstdint>

#include <gripline/interfaces.hpp>

/// The plugin ABI: number, kinds, declarations and the manifest. Authors use plugin.hpp and need none of it.
namespace gripline::abi {

/// To be raised, here and in the symbol's name, with every change of what crosses (test_abi_layout.cpp says when).
inline constexpr std::uint32_t number = 6;
/// Name of the manifest's symbol.
#define GRIPLINE_MANIFEST_SYMBOL gripline_plugins_abi6

/// The role of a plugin, one for each interface that plugins implement.
enum class Kind : std::uint32_t {
  vehicle,     ///< VehicleModel
  effect,      ///< Effect
  estimator,   ///< Estimator
  planner,     ///< SpeedPlanner
  controller,  ///< Controller
  plant        ///< Plant
};
/// Number of kinds.
inline constexpr int kind_count = 6;

/// What a parameter holds.
enum class ParamType : std::uint32_t {
  number,   ///< a real number with a unit
  integer,  ///< a whole number
  boolean,  ///< 0 or 1
  choice,   ///< the index of one of some names
  table     ///< a Table
};

/// Bits of PluginDecl::flags.
enum Flags : std::uint32_t {
  none = 0,              ///< nothing special
  needs_truth = 1u << 0  ///< gets Truth, and is marked * wherever it is shown
};

/// A declared parameter. Texts are never null unless said so, and live as long as the library.
struct ParamDecl {
  const char* name;      ///< its JSON key
  const char* unit;      ///< "m/s2"; "1" when pure
  const char* doc;       ///< one sentence
  ParamType type;        ///< what it holds
  double default_value;  ///< choice: index; table: unused
  double lo;             ///< least value allowed; table: of all its numbers
  double hi;             ///< largest value allowed
  const char* choices;   ///< "a|b|c" for a choice, else null
  bool fit;              ///< whether diagnose may fit it
  double neutral;        ///< if so: the value at which the effect vanishes,
  double start;          ///< a value to start a fit from,
  double scale;          ///< and how large a change of it is typical
  bool periodic;         ///< a place along the lap, as a lap fraction: values a whole number apart are the same place
};

/// The value of a parameter, as given to a constructor.
struct ParamValue {
  double number;  ///< of every type but table
  Table table;    ///< of a table
};

/// A plugin of a library. Texts are never null and live as long as the library.
struct PluginDecl {
  Kind kind;                ///< its role
  std::uint32_t flags;      ///< bits of Flags
  const char* id;           ///< what JSON calls it, unique among its kind
  const char* version;      ///< free text
  const char* summary;      ///< one sentence
  const ParamDecl* params;  ///< in the order in which values are passed
  std::size_t param_count;  ///< of them
  int precedence;           ///< order in which diagnose puts effects of one stage into a chain; lower acts first
  /// What to drive so that a log distinguishes this effect from similar ones, as an imperative ("coast down from top
  /// speed"); "" when there is no advice. `diagnose` prints it.
  const char* advice;
  /// Makes an instance from param_count values. Returns a pointer to the interface of the kind (VehicleModel*,
  /// Effect*, ...) as void*, or null with a message in error (at most error_size bytes, terminated).
  void* (*create)(const PluginContext*, const ParamValue*, char* error, std::size_t error_size);
  void (*destroy)(void*);  ///< ends what create returned
};

/// What a library offers, and what it was built against.
struct Manifest {
  std::uint32_t abi;          ///< number
  std::uint32_t size;         ///< sizeof(Manifest) as the plugin saw it
  std::uint64_t layout_hash;  ///< layout_hash() as the plugin saw it
  const void* virtual_slots;  ///< virtual_slots as the plugin saw them; comparable once the hash agrees
  const char* compiler;       ///< for messages
  const PluginDecl* plugins;  ///< what it offers
  std::size_t plugin_count;   ///< of them
};

}  // namespace gripline::abi
