/// \file
/// The equations of a library's plugins, for `gripline plugins describe`. Optional, and no part of the ABI: what races
/// never reads it.
#pragma once

namespace gripline {

/// The equation of one plugin, as text.
struct Equation {
  const char* id;    ///< of the plugin
  const char* text;  ///< such as "ax -= a (vx / v_ref)^2"
};

}  // namespace gripline

/// Name of the equations' symbol: an array of Equation that ends with nulls.
#define GRIPLINE_EQUATIONS_SYMBOL gripline_equations1
/// Exports equations, once per library: GRIPLINE_EQUATIONS({"my_drag", "ax -= a (vx / v_ref)^2"})
#define GRIPLINE_EQUATIONS(...)                                                                         \
  extern "C" {                                                                                          \
  __attribute__((visibility("default"))) extern const ::gripline::Equation GRIPLINE_EQUATIONS_SYMBOL[]; \
  }                                                                                                     \
  constexpr ::gripline::Equation GRIPLINE_EQUATIONS_SYMBOL[] = {__VA_ARGS__, {nullptr, nullptr}};
