// What plugin authors include.
//
//   class Drag final : public gripline::AutoDiffEffect<Drag> {
//    public:
//     template <class T> struct Params { T a = T(0); };
//     static constexpr auto parameters() {
//       return std::tuple{gripline::param("a", &Params<double>::a, "m/s2", {-5, 5}, "drag at v_ref").fit(0, 0.1, 0.3)};
//     }
//     explicit Drag(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}
//     gripline::Stage stage() const noexcept override { return gripline::Stage::body; }
//     template <class T> void act(gripline::Point<T>& p, const Params<T>& k) const {
//       p.q.ax -= k.a * gripline::square(p.q.vx / v_ref_);
//     }
//    private:
//     double v_ref_;
//   };
//   GRIPLINE_PLUGINS(gripline::describe<Drag>("demo.drag", "1.0", "quadratic drag"))
//
// `act` is written once for any scalar T: double, or a number that carries its derivatives. Two classic mistakes: a
// `double` intermediate (drops the derivative; the compiler refuses Dual -> double, so do not force it with value()),
// and std::sin(x) instead of sin(x) (write `using std::sin;` or call it unqualified).
//
// Params is a template when its values may be fitted (all members T, declared in the same order as in parameters()),
// and a plain struct otherwise (double, int, bool, Table members).
#pragma once

#include <array>
#include <concepts>
#include <cstring>
#include <exception>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>

#include <gripline/abi.h>

namespace gripline {

/// One instant, as an effect or a model sees it. `memory` and `memory_rate` are this instance's own.
template <class T>
struct Point {
  Quantities<T>& q;
  const Place& at;
  const T* memory;
  T* memory_rate;
  const History<T>* history;
};

struct Range {
  double lo, hi;
};

/// A declared parameter: where it lives in the author's struct and everything the outside knows of it.
template <class P, class V>
struct Param {
  V P::*member;
  abi::ParamDecl decl;
  /// Marks the parameter as one that `diagnose` may fit.
  constexpr Param fit(double neutral, double start, double scale) const {
    Param copy = *this;
    copy.decl.fit = true;
    copy.decl.neutral = neutral;
    copy.decl.start = start;
    copy.decl.scale = scale;
    return copy;
  }
  /// Marks the parameter as a place along the lap, a lap fraction: values a whole number apart are the same place.
  constexpr Param periodic() const {
    Param copy = *this;
    copy.decl.periodic = true;
    return copy;
  }
};

template <class P, class V>
constexpr Param<P, V> param(const char* name, V P::*member, const char* unit, Range range, const char* doc) {
  abi::ParamType type = abi::ParamType::number;
  double fallback = 0.0;
  if constexpr (std::is_same_v<V, bool>) {
    type = abi::ParamType::boolean;
    fallback = P{}.*member ? 1.0 : 0.0;
  } else if constexpr (std::is_integral_v<V>) {
    type = abi::ParamType::integer;
    fallback = static_cast<double>(P{}.*member);
  } else if constexpr (std::is_same_v<V, Table>) {
    type = abi::ParamType::table;
  } else {
    fallback = P{}.*member;
  }
  return {member, {name, unit, doc, type, fallback, range.lo, range.hi, nullptr, false, 0, 0, 1, false}};
}

/// A choice among names; the member is an int that holds the index.
template <class P>
constexpr Param<P, int> choice(const char* name, int P::*member, const char* choices, const char* doc) {
  return {member,
          {name, "1", doc, abi::ParamType::choice, static_cast<double>(P{}.*member), 0, 1e9, choices, false, 0, 0, 1,
           false}};
}

namespace detail {

template <class D>
concept HasParamTemplate = requires {
  typename D::template Params<double>;
};
template <class D>
concept HasParamStruct = !HasParamTemplate<D> && requires {
  typename D::Params;
};
template <class D>
concept HasParams = HasParamTemplate<D> || HasParamStruct<D>;

template <class D>
constexpr std::size_t param_count() {
  if constexpr (HasParams<D>) {
    return std::tuple_size_v<decltype(D::parameters())>;
  } else {
    return 0;
  }
}

/// The author's Params<T>, members in order of declaration taken from `values`.
template <class D, class T>
typename D::template Params<T> bind(const T* values) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) { return typename D::template Params<T>{values[I]...}; }
  (std::make_index_sequence<param_count<D>()>{});
}

template <class D>
auto bind_struct(const abi::ParamValue* values) {
  typename D::Params params{};
  std::size_t i = 0;
  std::apply(
      [&](const auto&... p) {
        const auto set = [&]<class P, class V>(const Param<P, V>& one) {
          if constexpr (std::is_same_v<V, Table>) {
            params.*one.member = values[i++].table;
          } else {
            params.*one.member = static_cast<V>(values[i++].number);
          }
        };
        (set(p), ...);
      },
      D::parameters());
  return params;
}

template <class D, std::size_t... I>
constexpr std::array<abi::ParamDecl, sizeof...(I)> decls(std::index_sequence<I...>) {
  return {std::get<I>(D::parameters()).decl...};
}
template <class D>
constexpr auto make_param_decls() {
  if constexpr (param_count<D>() == 0) {
    return std::array<abi::ParamDecl, 1>{};
  } else {
    return decls<D>(std::make_index_sequence<param_count<D>()>{});
  }
}
template <class D>
inline constexpr auto param_decls = make_param_decls<D>();

template <class D>
std::unique_ptr<D> construct(const PluginContext& context, const abi::ParamValue* values) {
  if constexpr (HasParamStruct<D>) {
    return std::make_unique<D>(context, bind_struct<D>(values));
  } else if constexpr (std::is_constructible_v<D, const PluginContext&>) {
    return std::make_unique<D>(context);
  } else {
    return std::make_unique<D>();
  }
}

template <class D, class Base>
void* create(const PluginContext* context, const abi::ParamValue* values, char* error, std::size_t size) {
  const auto fail = [&](const char* text) -> void* {
    if (size > 0) {
      std::strncpy(error, text, size - 1);
      error[size - 1] = '\0';
    }
    return nullptr;
  };
  try {
    return static_cast<Base*>(construct<D>(*context, values).release());
  } catch (const std::exception& e) {
    return fail(e.what());
  } catch (...) {
    return fail("threw something that is not a std::exception");
  }
}
template <class Base>
void destroy(void* instance) {
  delete static_cast<Base*>(instance);
}

template <class D>
constexpr abi::Kind kind_of() {
  if constexpr (std::is_base_of_v<VehicleModel, D>)
    return abi::Kind::vehicle;
  else if constexpr (std::is_base_of_v<Estimator, D>)
    return abi::Kind::estimator;
  else if constexpr (std::is_base_of_v<Effect, D>)
    return abi::Kind::effect;
  else if constexpr (std::is_base_of_v<SpeedPlanner, D>)
    return abi::Kind::planner;
  else if constexpr (std::is_base_of_v<Controller, D>)
    return abi::Kind::controller;
  else
    return abi::Kind::plant;
}

template <class D>
constexpr abi::PluginDecl describe_as(const char* id, const char* version, const char* summary, std::uint32_t flags) {
  const auto fill = [&]<class Base>(std::type_identity<Base>) -> abi::PluginDecl {
    return {kind_of<D>(),     flags, id, version,          summary,       param_decls<D>.data(),
            param_count<D>(), 0,     "", &create<D, Base>, &destroy<Base>};
  };
  if constexpr (std::is_base_of_v<VehicleModel, D>)
    return fill(std::type_identity<VehicleModel>{});
  else if constexpr (std::is_base_of_v<Estimator, D>)
    return fill(std::type_identity<Estimator>{});
  else if constexpr (std::is_base_of_v<Effect, D>)
    return fill(std::type_identity<Effect>{});
  else if constexpr (std::is_base_of_v<SpeedPlanner, D>)
    return fill(std::type_identity<SpeedPlanner>{});
  else if constexpr (std::is_base_of_v<Controller, D>)
    return fill(std::type_identity<Controller>{});
  else
    return fill(std::type_identity<Plant>{});
}

}  // namespace detail

/// A plugin's entry in the manifest.
struct Described {
  abi::PluginDecl decl;
  constexpr Described needs_truth() const {
    Described copy = *this;
    copy.decl.flags |= abi::needs_truth;
    return copy;
  }
  constexpr Described precedence(int value) const {
    Described copy = *this;
    copy.decl.precedence = value;
    return copy;
  }
  /// What to drive so that a log tells this effect from others that look like it.
  constexpr Described advice(const char* text) const {
    Described copy = *this;
    copy.decl.advice = text;
    return copy;
  }
};

template <class D>
constexpr Described describe(const char* id, const char* version, const char* summary) {
  return {detail::describe_as<D>(id, version, summary, 0)};
}

/// An effect (or, with Base = Estimator, an estimator) whose `act(Point<T>&, const Params<T>&)` is written once for any
/// scalar T. Without a Params template, `act(Point<T>&)`.
template <class D, class Base = Effect>
class AutoDiffEffect : public Base {
 public:
  void apply(const Points<double>& points) const final { run(points); }
  void apply(const Points<Dual8>& points) const final { run(points); }

 private:
  template <class T>
  void run(const Points<T>& points) const {
    const D& self = static_cast<const D&>(*this);
    const auto each = [&](auto&& act) {
      for (std::size_t i = 0; i < points.n; ++i) {
        Point<T> p{points.q[i], points.at[i], points.memory ? points.memory + i * points.memory_stride : nullptr,
                   points.memory_rate ? points.memory_rate + i * points.memory_stride : nullptr,
                   points.history ? points.history + i : nullptr};
        act(p);
      }
    };
    if constexpr (detail::HasParamTemplate<D>) {
      const auto params = detail::bind<D, T>(points.params);
      each([&](Point<T>& p) { self.act(p, params); });
    } else {
      each([&](Point<T>& p) { self.act(p); });
    }
  }
};

/// An effect of Stage::reading: `sense(Reading<T>&, const Place&, const Params<T>&)`.
template <class D>
class AutoDiffReading : public Effect {
 public:
  Stage stage() const noexcept final { return Stage::reading; }
  void apply(const Points<double>&) const final {}
  void apply(const Points<Dual8>&) const final {}
  void read(const Readings<double>& readings) const final { run(readings); }
  void read(const Readings<Dual8>& readings) const final { run(readings); }

 private:
  template <class T>
  void run(const Readings<T>& readings) const {
    const D& self = static_cast<const D&>(*this);
    const auto params = detail::bind<D, T>(readings.params);
    for (std::size_t i = 0; i < readings.n; ++i) self.sense(readings.r[i], readings.at[i], params);
  }
};

/// A vehicle model written once for any scalar: `drive(Point<T>&, const Params<T>&)`, `load`, `tyre`, `force`, `body`,
/// each for the stage of that name; a missing one means the model lacks the stage.
template <class D>
class AutoDiffVehicle : public VehicleModel {
 public:
  unsigned stages() const noexcept final {
    using P = typename D::template Params<double>;
    unsigned bits = stage_bit(Stage::command) | stage_bit(Stage::reading);
    if constexpr (requires(const D& d, Point<double>& p, const P& k) { d.drive(p, k); })
      bits |= stage_bit(Stage::drive);
    if constexpr (requires(const D& d, Point<double>& p, const P& k) { d.load(p, k); }) bits |= stage_bit(Stage::load);
    if constexpr (requires(const D& d, Point<double>& p, const P& k) { d.tyre(p, k); }) bits |= stage_bit(Stage::tyre);
    if constexpr (requires(const D& d, Point<double>& p, const P& k) { d.force(p, k); })
      bits |= stage_bit(Stage::force);
    if constexpr (requires(const D& d, Point<double>& p, const P& k) { d.body(p, k); }) bits |= stage_bit(Stage::body);
    return bits;
  }
  void evaluate(Stage first, Stage last, const Points<double>& points) const final { run(first, last, points); }
  void evaluate(Stage first, Stage last, const Points<Dual8>& points) const final { run(first, last, points); }

 private:
  template <class T>
  void run(Stage first, Stage last, const Points<T>& points) const {
    const D& self = static_cast<const D&>(*this);
    const auto params = detail::bind<D, T>(points.params);
    const auto wanted = [&](Stage stage) { return first <= stage && stage <= last; };
    for (std::size_t i = 0; i < points.n; ++i) {
      Point<T> p{points.q[i], points.at[i], nullptr, nullptr, nullptr};
      if constexpr (requires { self.drive(p, params); }) {
        if (wanted(Stage::drive)) self.drive(p, params);
      }
      if constexpr (requires { self.load(p, params); }) {
        if (wanted(Stage::load)) self.load(p, params);
      }
      if constexpr (requires { self.tyre(p, params); }) {
        if (wanted(Stage::tyre)) self.tyre(p, params);
      }
      if constexpr (requires { self.force(p, params); }) {
        if (wanted(Stage::force)) self.force(p, params);
      }
      if constexpr (requires { self.body(p, params); }) {
        if (wanted(Stage::body)) self.body(p, params);
      }
    }
  }
};

/// Fd [N] from the drive quantities: the motor for d >= 0, the brakes below.
template <class T>
T drive_force(const Quantities<T>& q) {
  return q.d < T(0) ? q.brake * q.d : (q.motor - q.emf * q.vx) * q.d;
}

namespace detail {
constexpr const char* compiler_name() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "g++ " __VERSION__;
#else
  return "unknown";
#endif
}
template <class... E>
constexpr std::array<abi::PluginDecl, sizeof...(E)> collect(const E&... entries) {
  return {entries.decl...};
}
}  // namespace detail

}  // namespace gripline

/// The library's manifest: constant data, so that loading the library runs none of its code.
#define GRIPLINE_PLUGINS(...)                                                                                       \
  namespace {                                                                                                       \
  constexpr auto gripline_entries = ::gripline::detail::collect(__VA_ARGS__);                                       \
  }                                                                                                                 \
  extern "C"                                                                                                        \
      __attribute__((visibility("default"))) constinit const ::gripline::abi::Manifest GRIPLINE_MANIFEST_SYMBOL = { \
          ::gripline::abi::number,        sizeof(::gripline::abi::Manifest),                                        \
          ::gripline::abi::layout_hash(), ::gripline::detail::compiler_name(),                                      \
          gripline_entries.data(),        gripline_entries.size()};
