// How the structs, enumerations and virtual functions of abi_layout.hpp are listed and turned into numbers.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include <gripline/abi.h>
#include <gripline/detail/for_each.hpp>

namespace gripline::abi::detail {

/// FNV-1a, 64 bits (Fowler, Noll, Vo).
class Hash {
 public:
  constexpr Hash& add(std::uint64_t number) {
    for (int byte = 0; byte < 8; ++byte) step(number >> (8 * byte) & 0xff);
    return *this;
  }
  constexpr Hash& add(const char* text) {
    do step(static_cast<unsigned char>(*text));
    while (*text++ != '\0');
    return *this;
  }
  constexpr std::uint64_t value() const { return hash_; }

 private:
  constexpr void step(std::uint64_t byte) { hash_ = (hash_ ^ byte) * 1099511628211ull; }
  std::uint64_t hash_ = 14695981039346656037ull;
};
template <class... N>
constexpr std::uint64_t hash_of(const char* what, N... numbers) {
  Hash hash;
  hash.add(what);
  (hash.add(static_cast<std::uint64_t>(numbers)), ...);
  return hash.value();
}

/// A member of a struct, or a value of an enumeration.
struct Member {
  const char* name;
  std::size_t at;      // offset, or value
  std::uint64_t code;  // of its type
};

/// The members of a struct or the values of an enumeration, specialised below.
template <class T>
struct Layout;
template <class T>
concept Listed = requires {
  Layout<T>::name;
};

template <class... I>
struct Interfaces {
  template <class T>
  static constexpr bool contains = (std::is_same_v<T, I> || ...);
};
/// Every class with virtual functions that crosses.
using AllInterfaces = Interfaces<VehicleModel, Effect, TyreCurve, Estimator, Prediction, Course, SpeedPlanner,
                                 Controller, Truth, Ground, Plant>;

template <class T>
constexpr std::uint64_t layout_code() {
  Hash hash;
  hash.add(Layout<T>::name).add(sizeof(T)).add(alignof(T));
  for (const Member& member : Layout<T>::members) hash.add(member.name).add(member.at).add(member.code);
  return hash.value();
}

/// A number for a type: the same for every compiler, different for types that are passed or read differently.
template <class T>
struct Code {
  static constexpr std::uint64_t value() {
    if constexpr (std::is_void_v<T>) {
      return hash_of("void");
    } else if constexpr (std::is_arithmetic_v<T>) {
      return hash_of(std::is_same_v<T, bool>       ? "bool"
                     : std::is_floating_point_v<T> ? "float"
                                                   : "integer",
                     sizeof(T), std::is_signed_v<T>);
    } else if constexpr (std::is_polymorphic_v<T>) {
      static_assert(AllInterfaces::contains<T>, "an interface that crosses is not in AllInterfaces");
      return hash_of("interface");
    } else {
      static_assert(Listed<T>, "a struct or an enumeration that crosses is not listed in abi_layout.hpp");
      return layout_code<T>();
    }
  }
};
template <class T>
struct Code<const T> {
  static constexpr std::uint64_t value() { return hash_of("const", Code<T>::value()); }
};
template <class T>
struct Code<T*> {
  static constexpr std::uint64_t value() { return hash_of("pointer", Code<T>::value()); }
};
template <class T>
struct Code<T&> {
  static constexpr std::uint64_t value() { return hash_of("reference", Code<T>::value()); }
};
template <class T>
struct Code<std::span<T>> {
  static constexpr std::uint64_t value() { return hash_of("span", sizeof(std::span<T>), Code<T>::value()); }
};
template <class R, class... A>
struct Code<R(A...)> {
  static constexpr std::uint64_t value() { return hash_of("function", Code<R>::value(), Code<A>::value()...); }
};
template <class R, class... A>
struct Code<R(A...) const> : Code<R(A...)> {};
template <class R, class... A>
struct Code<R(A...) noexcept> : Code<R(A...)> {};
template <class R, class... A>
struct Code<R(A...) const noexcept> : Code<R(A...)> {};

/// Anything that a member could be initialised with.
struct Anything {
  template <class T>
  constexpr operator T() const noexcept;  // NOLINT(google-explicit-constructor): only to count members
};
template <class T, std::size_t N>
constexpr bool takes() {
  return []<std::size_t... I>(std::index_sequence<I...>) {
    return requires { T{(static_cast<void>(I), Anything{})...}; };
  }
  (std::make_index_sequence<N>{});
}
/// Whether the struct T has N members.
template <class T, std::size_t N>
inline constexpr bool has_members = takes<T, N>() && !takes<T, N + 1>();

#define GRIPLINE_ABI_MEMBER(S, m) Member{#m, offsetof(S, m), Code<decltype(S::m)>::value()},
#define GRIPLINE_ABI_MEMBERS(S, ...)                                                            \
  static constexpr const char* name = #S;                                                       \
  static constexpr Member members[] = {GRIPLINE_FOR_EACH(GRIPLINE_ABI_MEMBER, S, __VA_ARGS__)}; \
  static_assert(has_members<S, std::size(members)>, "a member of " #S " is not listed in abi_layout.hpp");
#define GRIPLINE_ABI_STRUCT(S, ...)      \
  template <>                            \
  struct Layout<S> {                     \
    GRIPLINE_ABI_MEMBERS(S, __VA_ARGS__) \
  };
#define GRIPLINE_ABI_TEMPLATE(S, ...)       \
  template <class T>                        \
  struct Layout<S<T>> {                     \
    GRIPLINE_ABI_MEMBERS(S<T>, __VA_ARGS__) \
  };
#define GRIPLINE_ABI_VALUE(E, v) Member{#v, static_cast<std::size_t>(E::v), 0},
#define GRIPLINE_ABI_CASE(E, v) case E::v:
#define GRIPLINE_ABI_ENUM(E, ...)                                                                \
  template <>                                                                                    \
  struct Layout<E> {                                                                             \
    static constexpr const char* name = #E;                                                      \
    static constexpr Member members[] = {GRIPLINE_FOR_EACH(GRIPLINE_ABI_VALUE, E, __VA_ARGS__)}; \
    static constexpr bool complete(E e) {                                                        \
      switch (e) { GRIPLINE_FOR_EACH(GRIPLINE_ABI_CASE, E, __VA_ARGS__) return true; }           \
      return false;                                                                              \
    }                                                                                            \
  };

/// Objects of several types, one behind the other.
template <class... T>
struct Chain {};
template <class T, class... Rest>
struct Chain<T, Rest...> {
  T first;
  Chain<Rest...> rest;
};
constexpr Chain<> chain() { return {}; }
template <class T, class... Rest>
constexpr Chain<T, Rest...> chain(T first, Rest... rest) {
  return {first, chain(rest...)};
}
template <class F, class I>
struct Code<F I::*> {
  static constexpr std::uint64_t value() { return hash_of("virtual", Code<F>::value()); }
};
template <class... T>
struct Code<Chain<T...>> {
  static constexpr std::uint64_t value() { return hash_of("chain", Code<T>::value()...); }
};

/// A class derived from I with one virtual function more: it stands behind all of I's.
template <class I>
struct Extended : I {
  virtual void one_more() const = 0;
};
/// The virtual functions of an interface in the order of their declaration, and where the next one would stand.
template <class I, class... F>
constexpr auto virtuals(F... functions) {
  return chain(functions..., &Extended<I>::one_more);
}
/// An overload, chosen by its signature.
template <class F, class I>
constexpr auto overload(F I::*function) {
  return function;
}

}  // namespace gripline::abi::detail
