// How values reach an author's Params, and what is refused at compile time about them.
#pragma once

#include <limits>

#include <gripline/params.hpp>

namespace gripline::detail {

template <class D>
concept HasParamTemplate = requires {
  typename D::template Params<double>;
};
template <class D, class T = double>
using ParamsOf = typename D::template Params<T>;
template <class D>
concept HasParamStruct = !HasParamTemplate<D> && requires {
  typename D::Params;
};
template <class D>
concept HasParams = HasParamTemplate<D> || HasParamStruct<D>;

/// What D declares, as one type; an empty tuple without Params.
template <class D>
constexpr auto declared() {
  if constexpr (HasParams<D>)
    return D::parameters();
  else
    return std::tuple<>{};
}
template <class D>
using Declared = decltype(declared<D>());
/// How many members of Params are declared.
template <class D>
inline constexpr std::size_t member_count = std::tuple_size_v<Declared<D>>;

template <class P>
inline constexpr std::size_t width = 0;
template <class P, class M, std::size_t N>
inline constexpr std::size_t width<Param<P, M, N>> = N;

/// Number of the first parameter of member J; for J = member_count, of all parameters.
template <class D, std::size_t J>
constexpr std::size_t first_param() {
  return []<std::size_t... I>(std::index_sequence<I...>) {
    return (std::size_t{0} + ... + width<std::tuple_element_t<I, Declared<D>>>);
  }
  (std::make_index_sequence<J>{});
}
template <class D>
constexpr std::size_t param_count() {
  return first_param<D, member_count<D>>();
}

/// All declarations of D in a row; one empty one when there are none, so that there is an address.
template <class D>
constexpr auto make_param_decls() {
  std::array<abi::ParamDecl, param_count<D>() == 0 ? 1 : param_count<D>()> decls{};
  std::size_t i = 0;
  std::apply(
      [&](const auto&... one) { ((std::apply([&](const auto&... d) { ((decls[i++] = d), ...); }, one.decls)), ...); },
      declared<D>());
  return decls;
}
template <class D>
inline constexpr auto param_decls = make_param_decls<D>();

/// Declaration of member J of D's Params.
template <class D, std::size_t J>
using DeclaredMember = std::tuple_element_t<J, Declared<D>>;
template <class P, class M, std::size_t N>
M member_type(const Param<P, M, N>&);
/// Its type in Params<double>, or in the plain struct.
template <class D, std::size_t J>
using MemberType = decltype(member_type(std::declval<DeclaredMember<D, J>>()));

template <class M>
struct ArrayTraits {
  static constexpr bool is_array = false;
};
template <class V, std::size_t N>
struct ArrayTraits<std::array<V, N>> {
  static constexpr bool is_array = true;
  using Element = V;
};

/// One value as it stands in Params<T>: numbers carry T, everything else stays what it is.
template <class V, class T>
constexpr auto element(const T* values, const Table* tables, std::size_t i) {
  if constexpr (std::is_same_v<V, Table>)
    return tables == nullptr ? Table{} : tables[i];
  else if constexpr (std::is_floating_point_v<V>)
    return T(values[i]);
  else
    return static_cast<V>(value(values[i]));
}
template <class D, class T, std::size_t J>
constexpr auto member(const T* values, const Table* tables) {
  using M = MemberType<D, J>;
  constexpr std::size_t first = first_param<D, J>();
  if constexpr (ArrayTraits<M>::is_array) {
    using V = typename ArrayTraits<M>::Element;
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      return std::array<decltype(element<V>(values, tables, 0)), sizeof...(I)>{
          element<V>(values, tables, first + I)...};
    }
    (std::make_index_sequence<std::tuple_size_v<M>>{});
  } else {
    return element<M>(values, tables, first);
  }
}

/// A value that marks a member, or one that does not.
template <class M>
constexpr M mark(bool on) {
  if constexpr (std::is_same_v<M, Table>) {
    return {nullptr, on ? std::size_t{1} : std::size_t{0}, 0};
  } else if constexpr (ArrayTraits<M>::is_array) {
    M all{};
    for (auto& one : all) one = mark<typename ArrayTraits<M>::Element>(on);
    return all;
  } else {
    return static_cast<M>(on ? 1 : 0);
  }
}
template <class M>
constexpr bool is_marked(const M& m) {
  if constexpr (std::is_same_v<M, Table>) {
    return m.rows == 1;
  } else if constexpr (ArrayTraits<M>::is_array) {
    for (const auto& one : m)
      if (!is_marked(one)) return false;
    return true;
  } else {
    return m == static_cast<M>(1);
  }
}

/// Whether Params<double> takes the declared members in this order, by their types.
template <class D, std::size_t... J>
constexpr bool fits_by_type(std::index_sequence<J...>) {
  return requires { ParamsOf<D>{mark<MemberType<D, J>>(false)...}; };
}
/// Whether a member follows after the declared ones.
template <class D, std::size_t... J>
constexpr bool has_more(std::index_sequence<J...>) {
  return requires { ParamsOf<D>{mark<MemberType<D, J>>(false)..., {}}; };
}
/// Whether Params<Dual8> takes what its declared members become.
template <class D, std::size_t... J>
constexpr bool carries_derivatives(std::index_sequence<J...>) {
  return requires(const Dual8* values) { ParamsOf<D, Dual8>{member<D, Dual8, J>(values, nullptr)...}; };
}
/// How many members stand where parameters() has them, counted until the first that does not: with only the J-th value
/// marked, the member declared J-th must be the one that is marked.
template <class D, std::size_t... J>
constexpr std::size_t members_in_place(std::index_sequence<J...> members) {
  if constexpr (!fits_by_type<D>(members)) {
    return 0;
  } else {
    const auto in_place = [&]<std::size_t K>(std::integral_constant<std::size_t, K>) {
      const ParamsOf<D> params{mark<MemberType<D, J>>(J == K)...};
      return is_marked(params.*(std::get<K>(D::parameters()).member));
    };
    std::size_t count = 0;
    static_cast<void>(((in_place(std::integral_constant<std::size_t, J>{}) && (++count, true)) && ...));
    return count;
  }
}

/// Refuses at compile time what would bind a value to the wrong member.
template <class D>
struct CheckedOrder {
  static constexpr auto members = std::make_index_sequence<member_count<D>>{};
  static_assert(!has_more<D>(members), "Params has a member that parameters() does not declare");
  static_assert(members_in_place<D>(members) == member_count<D>,
                "the members of Params must be declared in the order of parameters(): Params<T> is filled by position");
  static_assert(!fits_by_type<D>(members) || carries_derivatives<D>(members),
                "the numbers of Params<T> must be T, not double: they carry derivatives");
  static constexpr bool good = true;
};

/// The author's Params<T>. `values` has one entry for each parameter, `tables` too, or is null.
template <class D, class T>
ParamsOf<D, T> bind(const T* values, const Table* tables) {
  static_assert(CheckedOrder<D>::good);
  return [&]<std::size_t... J>(std::index_sequence<J...>) { return ParamsOf<D, T>{member<D, T, J>(values, tables)...}; }
  (std::make_index_sequence<member_count<D>>{});
}

/// The author's plain Params.
template <class D>
auto bind_struct(const abi::ParamValue* values) {
  typename D::Params params{};
  std::size_t i = 0;
  const auto take = [&](auto& place) {
    using V = std::remove_reference_t<decltype(place)>;
    if constexpr (std::is_same_v<V, Table>)
      place = values[i++].table;
    else
      place = static_cast<V>(values[i++].number);
  };
  const auto set = [&](auto& place) {
    if constexpr (ArrayTraits<std::remove_reference_t<decltype(place)>>::is_array)
      for (auto& one : place) take(one);
    else
      take(place);
  };
  std::apply([&](const auto&... one) { (set(params.*one.member), ...); }, D::parameters());
  return params;
}

/// The first parameter that breaks a rule, or their number.
template <class D, class Rule>
constexpr std::size_t first_breach(const Rule& rule) {
  for (std::size_t i = 0; i < param_count<D>(); ++i)
    if (!rule(param_decls<D>[i], i)) return i;
  return param_count<D>();
}
constexpr bool has_text(const char* text) { return text != nullptr && *text != '\0'; }
constexpr bool same_text(const char* a, const char* b) {
  while (*a != '\0' && *a == *b) ++a, ++b;
  return *a == *b;
}
template <class D>
constexpr bool named_once(const abi::ParamDecl& decl, std::size_t at) {
  if (!has_text(decl.name)) return false;
  for (std::size_t i = 0; i < at; ++i)
    if (same_text(param_decls<D>[i].name, decl.name)) return false;
  return true;
}
constexpr bool default_allowed(const abi::ParamDecl& decl) {
  if (decl.type == abi::ParamType::table) return true;
  if (decl.type != abi::ParamType::choice) return decl.lo <= decl.default_value && decl.default_value <= decl.hi;
  double names = 1;
  for (const char* c = decl.choices; *c != '\0'; ++c) names += *c == '|' ? 1 : 0;
  return 0 <= decl.default_value && decl.default_value < names;
}

/// Whether a whole number of type V can be whatever its declared range allows. The host holds whole numbers to an
/// int's.
template <class V>
constexpr bool holds_range(const abi::ParamDecl& decl) {
  if constexpr (std::is_integral_v<V> && !std::is_same_v<V, bool>) {
    using Own = std::numeric_limits<V>;
    using Int = std::numeric_limits<int>;
    return max(static_cast<double>(Own::min()), static_cast<double>(Int::min())) <= decl.lo &&
           decl.hi <= min(static_cast<double>(Own::max()), static_cast<double>(Int::max()));
  }
  return true;
}
template <class D, std::size_t J>
constexpr bool member_holds_range() {
  using M = MemberType<D, J>;
  for (std::size_t i = first_param<D, J>(); i < first_param<D, J>() + width<DeclaredMember<D, J>>; ++i) {
    if constexpr (ArrayTraits<M>::is_array) {
      if (!holds_range<typename ArrayTraits<M>::Element>(param_decls<D>[i])) return false;
    } else {
      if (!holds_range<M>(param_decls<D>[i])) return false;
    }
  }
  return true;
}
template <class D, std::size_t... J>
constexpr bool members_hold_ranges(std::index_sequence<J...>) {
  return (member_holds_range<D, J>() && ...);
}

/// Refuses declarations that contradict themselves. Where a compiler says that a comparison "reduces to (i == n)", i is
/// the parameter, from 0.
template <class D, bool may_be_fitted>
struct CheckedDeclarations {
  using Decl = abi::ParamDecl;
  static constexpr std::size_t count = param_count<D>();
  static_assert(first_breach<D>(named_once<D>) == count, "parameters() must name every parameter, each differently");
  static_assert(first_breach<D>([](const Decl& d, std::size_t) { return has_text(d.unit) && has_text(d.doc); }) ==
                    count,
                "a parameter needs a unit (\"1\" when pure) and a sentence");
  static_assert(first_breach<D>([](const Decl& d, std::size_t) { return d.lo <= d.hi; }) == count,
                "the range of a parameter is empty");
  static_assert(first_breach<D>([](const Decl& d, std::size_t) { return default_allowed(d); }) == count,
                "the default of a parameter is outside its range");
  static_assert(members_hold_ranges<D>(std::make_index_sequence<member_count<D>>{}),
                "the range of a whole number must lie within its type's and within an int's");
  static_assert(may_be_fitted || first_breach<D>([](const Decl& d, std::size_t) { return !d.fit; }) == count,
                ".fit() is for effects with a template Params: nothing fits the parameters of other plugins");
  static_assert(first_breach<D>([](const Decl& d, std::size_t) {
                  return d.type == abi::ParamType::number || !(d.fit || d.periodic);
                }) == count,
                ".fit() and .periodic() are for numbers: not for whole numbers, switches, choices and tables");
  static_assert(first_breach<D>([](const Decl& d, std::size_t) {
                  return !d.fit || (d.lo <= d.start && d.start <= d.hi && d.scale > 0);
                }) == count,
                ".fit() needs a start inside the parameter's range and a positive scale");
  static constexpr bool good = true;
};

}  // namespace gripline::detail
