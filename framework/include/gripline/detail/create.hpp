// From an author's class to its entry in the manifest.
#pragma once

#include <cstring>
#include <exception>

#include <gripline/abi_layout.hpp>
#include <gripline/autodiff.hpp>

namespace gripline::detail {

template <abi::Kind K, class I>
struct Role {
  static constexpr abi::Kind kind = K;
  using Interface = I;
};
/// The interface that D implements.
template <class D>
constexpr auto role_of() {
  if constexpr (std::is_base_of_v<VehicleModel, D>)
    return Role<abi::Kind::vehicle, VehicleModel>{};
  else if constexpr (std::is_base_of_v<Estimator, D>)
    return Role<abi::Kind::estimator, Estimator>{};
  else if constexpr (std::is_base_of_v<Effect, D>)
    return Role<abi::Kind::effect, Effect>{};
  else if constexpr (std::is_base_of_v<SpeedPlanner, D>)
    return Role<abi::Kind::planner, SpeedPlanner>{};
  else if constexpr (std::is_base_of_v<Controller, D>)
    return Role<abi::Kind::controller, Controller>{};
  else if constexpr (std::is_base_of_v<Plant, D>)
    return Role<abi::Kind::plant, Plant>{};
}
template <class D>
using RoleOf = decltype(role_of<D>());

template <class D>
D* construct(const PluginContext& context, const abi::ParamValue* values) {
  if constexpr (HasParamStruct<D>) {
    return new D(context, bind_struct<D>(values));
  } else {
    std::vector<Table> tables;
    if constexpr (has_tables<D>())
      for (std::size_t i = 0; i < param_count<D>(); ++i) tables.push_back(values[i].table);
    D* made = nullptr;
    if constexpr (std::is_constructible_v<D, const PluginContext&>)
      made = new D(context);
    else
      made = new D();
    if constexpr (has_tables<D>()) made->kept_tables_ = std::move(tables);
    return made;
  }
}

template <class D, class Interface>
void* create(const PluginContext* context, const abi::ParamValue* values, char* error, std::size_t size) {
  const auto fail = [&](const char* text) -> void* {
    if (size > 0) {
      std::strncpy(error, text, size - 1);
      error[size - 1] = '\0';
    }
    return nullptr;
  };
  try {
    return static_cast<Interface*>(construct<D>(*context, values));
  } catch (const std::exception& e) {
    return fail(e.what());
  } catch (...) {
    return fail("threw something that is not a std::exception");
  }
}
template <class Interface>
void destroy(void* instance) {
  delete static_cast<Interface*>(instance);
}

/// Refuses at compile time what could not be made or filled.
template <class D>
struct CheckedPlugin {
  static_assert(!std::is_void_v<RoleOf<D>>,
                "a plugin derives from VehicleModel, Effect, Estimator, SpeedPlanner, Controller or Plant");
  static_assert(!std::is_abstract_v<D>, "a pure virtual function of the plugin's interface is not written");
  static constexpr bool made_from_struct() {
    if constexpr (HasParamStruct<D>)
      return std::is_abstract_v<D> || std::is_constructible_v<D, const PluginContext&, const typename D::Params&>;
    else
      return true;
  }
  static_assert(made_from_struct(),
                "a plugin with a struct Params has a constructor (const PluginContext&, const Params&)");
  static_assert(std::is_abstract_v<D> || HasParamStruct<D> || std::is_constructible_v<D, const PluginContext&> ||
                    std::is_default_constructible_v<D>,
                "a plugin has a constructor (const PluginContext&), or one without arguments");
  static constexpr bool is_effect = std::is_same_v<RoleOf<D>, Role<abi::Kind::effect, Effect>>;
  static_assert(
      !HasParamTemplate<D> || is_effect || std::is_base_of_v<VehicleModel, D>,
      "Params is a template in effects and vehicle models only: elsewhere nothing fits it, so make it a plain "
      "struct that the constructor takes");
  static_assert(CheckedDeclarations < D, is_effect&& HasParamTemplate < D >> ::good);
  static constexpr bool in_order() {
    if constexpr (HasParamTemplate<D>)
      return CheckedOrder<D>::good;
    else
      return true;
  }
  static_assert(in_order());
  static constexpr bool good = true;
};

template <class D>
constexpr abi::PluginDecl describe_as(const char* id, const char* version, const char* summary) {
  static_assert(CheckedPlugin<D>::good);
  using Interface = typename RoleOf<D>::Interface;
  static_assert(abi::detail::AllInterfaces::contains<Interface>, "an interface of plugins is not in AllInterfaces");
  abi::PluginDecl decl{};
  decl.kind = RoleOf<D>::kind;
  decl.id = id;
  decl.version = version;
  decl.summary = summary;
  decl.params = param_decls<D>.data();
  decl.param_count = param_count<D>();
  decl.advice = "";
  decl.create = &create<D, Interface>;
  decl.destroy = &destroy<Interface>;
  return decl;
}

constexpr const char* compiler_name() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "g++ " __VERSION__;
#else
  return "unknown";
#endif
}

}  // namespace gripline::detail
