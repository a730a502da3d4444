/// \file
/// What must agree between a host and a plugin beside the ABI number: where every member lies, what it is, and in which
/// order virtual functions stand. A plugin carries both as constants, and the host refuses it when they differ from its
/// own; so an edit of what crosses is noticed even when the number was not raised.
///
/// - layout_hash() covers every struct and enumeration that can be reached from the manifest and the interfaces: names,
///   offsets and types of members, and the signatures of virtual functions.
/// - virtual_slots holds a pointer to each virtual function. Under the Itanium C++ ABI, which Linux compilers follow,
///   that pointer is the function's place in the table of virtual functions (section 2.3), so that constant data says
///   in which order a header declared them. After the functions of an interface stands one that a class derived from it
///   would add: it moves when a virtual function was added anywhere, listed here or not.
///
/// Forgetting to list something does not compile: a struct must list all its members (they are counted), an enumeration
/// all its values (-Wswitch is an error here), and a type that is reached but not listed has no code. A virtual
/// function that is not listed is found by test_abi_layout.cpp, which also holds the hash of the present ABI number.
#pragma once

#include <gripline/detail/layout.hpp>

namespace gripline::abi {
/// \cond
namespace detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"
GRIPLINE_ABI_ENUM(Axle, front, rear)
GRIPLINE_ABI_ENUM(Stage, command, drive, load, tyre, force, body, reading)
GRIPLINE_ABI_ENUM(Hold, zoh, foh, rate)
GRIPLINE_ABI_ENUM(Kind, vehicle, effect, estimator, planner, controller, plant)
GRIPLINE_ABI_ENUM(ParamType, number, integer, boolean, choice, table)
GRIPLINE_ABI_ENUM(Flags, none, needs_truth)
#pragma GCC diagnostic pop

template <int N>
struct Layout<Dual<N>> {
  static constexpr const char* name = "Dual";
  static constexpr Member members[] = {{"v", offsetof(Dual<N>, v), Code<double>::value()},
                                       {"d", offsetof(Dual<N>, d), Code<double>::value()}};
  static_assert(sizeof(Dual<N>) == (N + 1) * sizeof(double), "a member of Dual is not listed in abi_layout.hpp");
};
GRIPLINE_ABI_STRUCT(State, x, y, yaw, vx, vy, omega, delta)
GRIPLINE_ABI_STRUCT(Input, d, ddelta)
GRIPLINE_ABI_STRUCT(Place, t, s, n, lap_fraction, yaw_line, kappa, grade, bank, direction, grip)
GRIPLINE_ABI_STRUCT(Car, m, Iz, lf, lr, length, width, d_min, d_max, delta_max, ddelta_max, v_ref, v_min)
GRIPLINE_ABI_TEMPLATE(Quantities, yaw, vx, vy, omega, d, delta, delta_rate, motor, emf, brake, rolling, drag,
                      drive_force, m, Iz, lf, lr, load_front, load_rear, slip_front, slip_rear, peak_front, peak_rear,
                      stiff_front, stiff_rear, force_front, force_rear, ax, ay, aw, grade, bank)
GRIPLINE_ABI_TEMPLATE(Reading, x, y, yaw, vx, vy, omega)
GRIPLINE_ABI_TEMPLATE(CommandSample, d, delta)
GRIPLINE_ABI_TEMPLATE(History, samples, count, t0, dt, now, hold)
GRIPLINE_ABI_TEMPLATE(Points, n, q, at, params, memory, memory_rate, memory_stride, history, reading)
GRIPLINE_ABI_STRUCT(Observation, t, step, x, at, d)
GRIPLINE_ABI_STRUCT(Sample, t, dt, step, x, u, at, x_next, at_next, e_vx, e_vy, e_omega, d_lag, delta_lag, ddelta_lag)
GRIPLINE_ABI_STRUCT(Belief, mu_front, mu_rear, sigma_front, sigma_rear, trusted)
GRIPLINE_ABI_STRUCT(RefPoint, s, x, y, yaw, kappa, v, left, right, at, beta)
GRIPLINE_ABI_STRUCT(Command, u, iterations, solved, cost)
GRIPLINE_ABI_STRUCT(CoursePoint, s, n, x, y, yaw, kappa, left, right, grade, bank, lap_fraction)
GRIPLINE_ABI_STRUCT(LinePoint, s, x, y, yaw, kappa, left, right, station, grade, bank)
GRIPLINE_ABI_STRUCT(Table, data, rows, cols)
GRIPLINE_ABI_STRUCT(LineOptions, margin, max_curvature)
GRIPLINE_ABI_STRUCT(Prediction::Rates, vx, vy, omega, load_front, load_rear, drive_force, d, delta)
GRIPLINE_ABI_STRUCT(Ground::Patch, grade, bank, factor)
GRIPLINE_ABI_STRUCT(PluginContext, car, dt, hold, seed, mu_init, course, nominal, truth, cache_dir, progress,
                    progress_context)
GRIPLINE_ABI_STRUCT(ParamDecl, name, unit, doc, type, default_value, lo, hi, choices, fit, neutral, start, scale,
                    periodic)
GRIPLINE_ABI_STRUCT(ParamValue, number, table)
GRIPLINE_ABI_STRUCT(PluginDecl, kind, flags, id, version, summary, params, param_count, precedence, advice, create,
                    destroy)
GRIPLINE_ABI_STRUCT(Manifest, abi, size, layout_hash, virtual_slots, compiler, plugins, plugin_count)

#undef GRIPLINE_ABI_MEMBER
#undef GRIPLINE_ABI_MEMBERS
#undef GRIPLINE_ABI_STRUCT
#undef GRIPLINE_ABI_TEMPLATE
#undef GRIPLINE_ABI_VALUE
#undef GRIPLINE_ABI_CASE
#undef GRIPLINE_ABI_ENUM

/// The virtual functions of each interface, without destructors and without those of its bases.
template <class I>
struct Virtuals;
template <>
struct Virtuals<VehicleModel> {
  static constexpr auto list = virtuals<VehicleModel>(
      &VehicleModel::stages, overload<void(Stage, Stage, const Points<double>&) const>(&VehicleModel::evaluate),
      overload<void(Stage, Stage, const Points<Dual8>&) const>(&VehicleModel::evaluate));
};
template <>
struct Virtuals<Effect> {
  static constexpr auto list =
      virtuals<Effect>(&Effect::stage, &Effect::memory, &Effect::look_back, &Effect::start_memory,
                       overload<void(const Points<double>&) const>(&Effect::apply),
                       overload<void(const Points<Dual8>&) const>(&Effect::apply));
};
template <>
struct Virtuals<TyreCurve> {
  static constexpr auto list = virtuals<TyreCurve>(&TyreCurve::tyre_force);
};
template <>
struct Virtuals<Estimator> {
  static constexpr auto list = virtuals<Estimator>(&Estimator::update, &Estimator::belief, &Estimator::tyre_force);
};
template <>
struct Virtuals<Prediction> {
  static constexpr auto list = virtuals<Prediction>(&Prediction::states, &Prediction::dt, &Prediction::start,
                                                    &Prediction::step, &Prediction::rates);
};
template <>
struct Virtuals<Course> {
  static constexpr auto list =
      virtuals<Course>(&Course::length, &Course::at, &Course::locate, &Course::minimum_curvature);
};
template <>
struct Virtuals<SpeedPlanner> {
  static constexpr auto list = virtuals<SpeedPlanner>(&SpeedPlanner::plan, &SpeedPlanner::line, &SpeedPlanner::latency);
};
template <>
struct Virtuals<Controller> {
  static constexpr auto list = virtuals<Controller>(&Controller::horizon, &Controller::control, &Controller::predicted);
};
template <>
struct Virtuals<Truth> {
  static constexpr auto list = virtuals<Truth>(&Truth::factor, &Truth::mu, &Truth::tyre_force,
                                               overload<bool(const Points<double>&) const>(&Truth::accelerations),
                                               overload<bool(const Points<Dual8>&) const>(&Truth::accelerations));
};
template <>
struct Virtuals<Ground> {
  static constexpr auto list = virtuals<Ground>(&Ground::at);
};
template <>
struct Virtuals<Plant> {
  static constexpr auto list =
      virtuals<Plant>(&Plant::reset, &Plant::advance, &Plant::mu, &Plant::tyre_force, &Plant::axle_force);
};

template <class... I>
constexpr auto virtuals_of(Interfaces<I...>) {
  return chain(Virtuals<I>::list...);
}

}  // namespace detail
/// \endcond

/// The places of all virtual functions, as pointers to them.
inline constexpr auto virtual_slots = detail::virtuals_of(detail::AllInterfaces{});

/// A number over all structs, enumerations and signatures that cross.
constexpr std::uint64_t layout_hash() {
  return detail::hash_of("gripline", detail::Code<Manifest>::value(), detail::Code<Kind>::value(),
                         detail::Code<Flags>::value(),
                         detail::Code<std::remove_const_t<decltype(virtual_slots)>>::value());
}

}  // namespace gripline::abi
