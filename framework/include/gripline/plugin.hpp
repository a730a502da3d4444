/// \file
/// What plugin authors include. A plugin is a class that derives from one of six interfaces, its parameters, and a line
/// that exports it; it links no library of gripline.
///
/// An estimator, whole: it learns one drag coefficient from what the nominal model leaves unexplained.
/// \code
///   #include <gripline/plugin.hpp>
///
///   class LearnedDrag final : public gripline::AutoDiffEffect<LearnedDrag, gripline::Estimator> {
///    public:
///     struct Params {
///       double rate = 0.05;                                   // the initializer is the default
///     };
///     static constexpr auto parameters() {                    // JSON key, member, unit, range, one sentence
///       return std::tuple{gripline::param("rate", &Params::rate, "1", {0, 2}, "step of normalised LMS")};
///     }
///     LearnedDrag(const gripline::PluginContext& context, const Params& params)
///         : rate_(params.rate), belief_{.mu_front = context.mu_init, .mu_rear = context.mu_init} {}
///
///     void update(const gripline::Sample& k) override {       // every step: what happened, what the model missed
///       const double regressor = -k.x.vx * k.x.vx;
///       c_ += rate_ * (k.e_vx - c_ * regressor) * regressor / (1e-6 + regressor * regressor);
///     }
///     gripline::Belief belief() const override { return belief_; }   // it does not learn friction
///
///     template <class T>                                      // the correction: T is double, or carries derivatives
///     void act(gripline::Point<T>& p) const {
///       p.q.ax -= c_ * gripline::square(p.q.vx);
///     }
///
///    private:
///     double rate_, c_ = 0;
///     gripline::Belief belief_;
///   };
///
///   GRIPLINE_PLUGINS(gripline::describe<LearnedDrag>("demo.learned_drag", "1.0", "one drag coefficient by NLMS"))
/// \endcode
///
/// An effect, whole: its parameter may be fitted by `diagnose`, so Params is a template and comes with every call.
/// \code
///   class Drag final : public gripline::AutoDiffEffect<Drag> {
///    public:
///     template <class T>
///     struct Params {
///       T a = T(0);
///     };
///     static constexpr auto parameters() {
///       return std::tuple{gripline::param("a", &Params<double>::a, "m/s2", {-5, 5}, "at v_ref").fit(0, 0.1, 0.3)};
///     }
///     explicit Drag(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}
///     gripline::Stage stage() const noexcept override { return gripline::Stage::body; }
///     template <class T>
///     void act(gripline::Point<T>& p, const Params<T>& k) const {
///       p.q.ax -= k.a * gripline::square(p.q.vx / v_ref_);
///     }
///
///    private:
///     double v_ref_;
///   };
///   GRIPLINE_PLUGINS(gripline::describe<Drag>("demo.drag", "1.0", "quadratic drag"))
/// \endcode
///
/// Where to read on:
/// - interfaces.hpp: the six interfaces, the contract of each call, what a plugin is given;
/// - types.hpp: states, quantities and stages, samples, references, with units and signs;
/// - params.hpp: parameters of every type; autodiff.hpp: effects with memory, readings, vehicle models, the two classic
///   mistakes with derivatives; dual.hpp: the functions that T knows.
///
/// The compiler refuses, with a sentence, what would bind a value to the wrong member, parameters that would never be
/// filled or fitted, and classes that cannot be made.
#pragma once

#include <gripline/abi_layout.hpp>
#include <gripline/detail/create.hpp>

namespace gripline {

/// A plugin's entry in the manifest, made by describe.
struct Description {
  abi::PluginDecl decl;  ///< what the manifest will say

  /// Estimators, planners and controllers: PluginContext::truth is given, and the plugin is marked * wherever it is
  /// shown.
  constexpr Description needs_truth() const {
    Description copy = *this;
    copy.decl.flags |= abi::needs_truth;
    return copy;
  }
  /// Effects: order in which `diagnose` puts effects of one stage into a chain; lower acts first.
  constexpr Description precedence(int value) const {
    Description copy = *this;
    copy.decl.precedence = value;
    return copy;
  }
  /// Effects: what to drive so that a log distinguishes this effect from similar ones, as an imperative.
  constexpr Description advice(const char* text) const {
    Description copy = *this;
    copy.decl.advice = text;
    return copy;
  }
};

/// Describes the plugin of class D: what JSON calls it (unique among its kind), its version, one sentence.
template <class D>
constexpr Description describe(const char* id, const char* version, const char* summary) {
  return {detail::describe_as<D>(id, version, summary)};
}

/// \cond
namespace detail {

template <class... E>
constexpr std::array<abi::PluginDecl, sizeof...(E)> collect(const E&... entries) {
  return {entries.decl...};
}

}  // namespace detail
/// \endcond
}  // namespace gripline

/// Exports the plugins described, once per library: its manifest, which is constant data, so that loading the library
/// runs none of its code.
#define GRIPLINE_PLUGINS(...)                                                                                       \
  namespace {                                                                                                       \
  constexpr auto gripline_entries = ::gripline::detail::collect(__VA_ARGS__);                                       \
  }                                                                                                                 \
  extern "C"                                                                                                        \
      __attribute__((visibility("default"))) constinit const ::gripline::abi::Manifest GRIPLINE_MANIFEST_SYMBOL = { \
          ::gripline::abi::number,         sizeof(::gripline::abi::Manifest),   ::gripline::abi::layout_hash(),     \
          &::gripline::abi::virtual_slots, ::gripline::detail::compiler_name(), gripline_entries.data(),            \
          gripline_entries.size()};
