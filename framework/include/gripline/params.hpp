/// \file
/// Parameters of a plugin: how they are declared, and how values reach the author's struct.
///
/// A plugin lists its parameters in `static constexpr auto parameters()`, a tuple of param(...) and choice(...). Values
/// reach it in one of two ways.
/// - `struct Params { double rate = 0.05; int count = 3; bool on = true; Table curve; };` is passed to the constructor,
///   `D(const PluginContext&, const Params&)`. Its members may stand in any order.
/// - `template <class T> struct Params { T k = T(0); std::array<T, 5> c = {}; Table map; };` is given to each call of a
///   formula (AutoDiffEffect::act, ...), because `diagnose` fits its values: numbers are T, which carries derivatives;
///   int, bool and Table members stay what they are. Its members stand in the order of parameters(), all of them
///   declared: it is filled by position, since a pointer to a member of Params<double> does not apply to Params<Dual8>.
#pragma once

#include <array>
#include <tuple>
#include <type_traits>
#include <utility>

#include <gripline/abi.h>

namespace gripline {

/// The values that a parameter may take, both ends included.
struct Range {
  double lo;  ///< least
  double hi;  ///< largest
};

/// A declared member of the author's struct P and all that the outside knows of it: one parameter, or for a
/// std::array<V, N> member N of them.
template <class P, class M, std::size_t N = 1>
struct Param {
  M P::*member;                         ///< where its value lives
  std::array<abi::ParamDecl, N> decls;  ///< what is declared, one per parameter
  /// Marks it as one that `diagnose` may fit (numbers of effects only): the value at which the effect vanishes, a value
  /// to start a fit from, and how large a change of it is typical.
  constexpr Param fit(double neutral, double start, double scale) const {
    Param copy = *this;
    for (abi::ParamDecl& decl : copy.decls) {
      decl.fit = true;
      decl.neutral = neutral;
      decl.start = start;
      decl.scale = scale;
    }
    return copy;
  }
  /// Marks it as a place along the lap, a lap fraction: values a whole number apart are the same place.
  constexpr Param periodic() const {
    Param copy = *this;
    for (abi::ParamDecl& decl : copy.decls) decl.periodic = true;
    return copy;
  }
};

/// \cond
namespace detail {

template <class V>
constexpr abi::ParamDecl declare(const char* name, const V& fallback, const char* unit, Range range, const char* doc) {
  abi::ParamDecl decl{name, unit, doc, abi::ParamType::number, 0, range.lo, range.hi, nullptr, false, 0, 0, 1, false};
  if constexpr (std::is_same_v<V, Table>) {
    decl.type = abi::ParamType::table;
  } else {
    static_assert(std::is_arithmetic_v<V>,
                  "a parameter is a number (in Params<T>: a T), an int, a bool, a Table, or a "
                  "std::array of one of them");
    if (std::is_same_v<V, bool>)
      decl.type = abi::ParamType::boolean;
    else if (std::is_integral_v<V>)
      decl.type = abi::ParamType::integer;
    decl.default_value = static_cast<double>(fallback);
  }
  return decl;
}

}  // namespace detail
/// \endcond

/// Declares a parameter: its JSON key, where it lives, its unit ("1" when pure), the values it may take, one sentence.
/// The member's type says what it is: a number, a whole number (int), a switch (bool) or a table (Table). The default
/// is the member's initializer.
template <class P, class V>
constexpr Param<P, V> param(const char* name, V P::*member, const char* unit, Range range, const char* doc) {
  return {member, {detail::declare(name, P{}.*member, unit, range, doc)}};
}

/// Declares the elements of an array as parameters that share unit, range and sentence: one JSON key for each.
template <class P, class V, std::size_t N>
constexpr Param<P, std::array<V, N>, N> param(const char* const (&names)[N], std::array<V, N> P::*member,
                                              const char* unit, Range range, const char* doc) {
  Param<P, std::array<V, N>, N> declared{member, {}};
  for (std::size_t i = 0; i < N; ++i) declared.decls[i] = detail::declare(names[i], (P{}.*member)[i], unit, range, doc);
  return declared;
}

/// Declares a choice among names, "slow|fast"; the member is an int that holds the index, from 0.
template <class P>
constexpr Param<P, int> choice(const char* name, int P::*member, const char* choices, const char* doc) {
  abi::ParamDecl decl = detail::declare(name, P{}.*member, "1", {0, 1e9}, doc);
  decl.type = abi::ParamType::choice;
  decl.choices = choices;
  return {member, {decl}};
}

}  // namespace gripline
