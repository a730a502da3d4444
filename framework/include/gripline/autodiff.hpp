/// \file
/// Formulas written once: bases that call an author's template with double and with Dual8, so that the host gets values
/// and exact derivatives from the same lines.
///
/// Two classic mistakes. A `double` intermediate drops the derivative: the compiler refuses Dual8 -> double, so do not
/// force it with value(). And std::sin(x) is for double alone: write `using std::sin;` and call sin(x), which finds
/// gripline's for Dual8. For max, min, hypot and abs say `using gripline::max;` and the like beside it.
#pragma once

#include <exception>
#include <span>
#include <vector>

#include <gripline/detail/bind.hpp>

namespace gripline {

/// One instant, as an effect or a model sees it. `memory` and `memory_rate` are this instance's own.
template <class T>
struct Point {
  Quantities<T>& q;           ///< read and written
  const Place& at;            ///< when and where
  const T* memory;            ///< the effect's own states; null when it has none
  T* memory_rate;             ///< their rates [per s], to be written
  const History<T>* history;  ///< commands up to this instant; null when there are none
};

/// \cond
namespace detail {

struct WrongBase : std::exception {
  const char* what() const noexcept override { return "an effect of Stage::reading derives from AutoDiffReading"; }
};

/// Tables of a template Params, kept from the constructor's values: they are not among Points::params.
struct KeptTables {
  std::vector<Table> kept_tables_;
};
template <class D>
constexpr bool has_tables() {
  if constexpr (!HasParamTemplate<D>)
    return false;
  else
    return first_breach<D>([](const abi::ParamDecl& d, std::size_t) { return d.type != abi::ParamType::table; }) <
           param_count<D>();
}

template <class D>
concept HasInitialWithParams = HasParamTemplate<D> &&
    requires(const D& d, const Point<double>& p, const ParamsOf<D>& k, std::span<double> m) {
  d.initial(p, k, m);
};
template <class D>
concept HasInitial = !HasParamTemplate<D> && requires(const D& d, const Point<double>& p, std::span<double> m) {
  d.initial(p, m);
};
template <class D>
concept HasDelay = HasParamTemplate<D> && requires(const D& d, const ParamsOf<D>& k) {
  d.delay(k);
};

template <class D, class T>
auto bind_kept(const KeptTables& kept, const T* values) {
  return bind<D, T>(values, kept.kept_tables_.empty() ? nullptr : kept.kept_tables_.data());
}

}  // namespace detail
/// \endcond

/// An effect (or, with Base = Estimator, an estimator) whose formula is written once for any scalar T. D supplies
/// \code
///   template <class T> void act(Point<T>& p, const Params<T>& k) const;   // without a template Params: act(p)
/// \endcode
///
/// which is called for each point. An effect with memory() > 0 writes p.memory_rate there, and may supply
/// \code
///   void initial(const Point<double>& p, const Params<double>& k, std::span<double> memory) const;
/// \endcode
///
/// which fills its memory at the start of a run (else zero). One that reads p.history supplies
/// \code
///   double delay(const Params<double>& k) const noexcept;   // the longest delay at which it does [s]
/// \endcode
template <class D, class Base = Effect>
class AutoDiffEffect : public Base, public detail::KeptTables {
 public:
  void apply(const Points<double>& points) const final { run(points); }
  void apply(const Points<Dual8>& points) const final { run(points); }

  void start_memory(const Points<double>& points, double* memory) const override {
    const D& self = static_cast<const D&>(*this);
    const auto count = static_cast<std::size_t>(self.memory());
    if constexpr (detail::HasInitialWithParams<D>) {
      const auto params = detail::bind_kept<D>(*this, points.params);
      for (std::size_t i = 0; i < points.n; ++i)
        self.initial(point(points, i), params, std::span(memory + i * points.memory_stride, count));
    } else if constexpr (detail::HasInitial<D>) {
      for (std::size_t i = 0; i < points.n; ++i)
        self.initial(point(points, i), std::span(memory + i * points.memory_stride, count));
    } else {
      static_assert(
          !requires { &D::initial; },
          "it is: void initial(const Point<double>&, const Params<double>&, "
          "std::span<double> memory) const; without a template Params two of them");
    }
  }

  double look_back(std::span<const double> params) const noexcept override {
    const D& self = static_cast<const D&>(*this);
    if constexpr (detail::HasDelay<D>)
      return self.delay(detail::bind_kept<D>(*this, params.data()));
    else
      static_assert(
          !requires { &D::delay; }, "it is: double delay(const Params<double>&) const noexcept");
    return 0.0;
  }

 private:
  template <class T>
  static Point<T> point(const Points<T>& points, std::size_t i) {
    return {points.q[i], points.at[i], points.memory ? points.memory + i * points.memory_stride : nullptr,
            points.memory_rate ? points.memory_rate + i * points.memory_stride : nullptr,
            points.history ? points.history + i : nullptr};
  }
  template <class T>
  void run(const Points<T>& points) const {
    const D& self = static_cast<const D&>(*this);
    if (points.q == nullptr) throw detail::WrongBase{};
    if constexpr (detail::HasParamTemplate<D>) {
      const auto params = detail::bind_kept<D>(*this, points.params);
      for (std::size_t i = 0; i < points.n; ++i) {
        Point<T> p = point(points, i);
        self.act(p, params);
      }
    } else {
      for (std::size_t i = 0; i < points.n; ++i) {
        Point<T> p = point(points, i);
        self.act(p);
      }
    }
  }
};

/// An effect of Stage::reading: what a sensor shows. D supplies
/// \code
///   template <class T> void sense(Reading<T>& r, const Place& at, const Params<T>& k) const;
/// \endcode
template <class D>
class AutoDiffReading : public Effect, public detail::KeptTables {
 public:
  Stage stage() const noexcept final { return Stage::reading; }
  void apply(const Points<double>& points) const final { run(points); }
  void apply(const Points<Dual8>& points) const final { run(points); }

 private:
  template <class T>
  void run(const Points<T>& points) const {
    const D& self = static_cast<const D&>(*this);
    const auto params = detail::bind_kept<D>(*this, points.params);
    for (std::size_t i = 0; i < points.n; ++i) self.sense(points.reading[i], points.at[i], params);
  }
};

/// \cond
namespace detail {

// Whether D supplies a stage, and whether it has a function of that name at all.
template <class D>
concept HasDrive = requires(const D& d, Point<double>& p, const ParamsOf<D>& k) {
  d.drive(p, k);
};
template <class D>
concept HasLoad = requires(const D& d, Point<double>& p, const ParamsOf<D>& k) {
  d.load(p, k);
};
template <class D>
concept HasTyre = requires(const D& d, Point<double>& p, const ParamsOf<D>& k) {
  d.tyre(p, k);
};
template <class D>
concept HasForce = requires(const D& d, Point<double>& p, const ParamsOf<D>& k) {
  d.force(p, k);
};
template <class D>
concept HasBody = requires(const D& d, Point<double>& p, const ParamsOf<D>& k) {
  d.body(p, k);
};

/// A function of a stage's name that cannot be called would be left out in silence.
template <class D>
struct CheckedStages {
  static_assert((HasDrive<D> || !requires { &D::template drive<double>; }) &&
                    (HasLoad<D> || !requires { &D::template load<double>; }) &&
                    (HasTyre<D> || !requires { &D::template tyre<double>; }) &&
                    (HasForce<D> || !requires { &D::template force<double>; }),
                "a stage of a vehicle model is: template <class T> void drive(Point<T>&, const Params<T>&) const");
  static_assert(HasBody<D>,
                "a vehicle model supplies: template <class T> void body(Point<T>&, const Params<T>&) const");
  static constexpr unsigned bits =
      stage_bit(Stage::command) | stage_bit(Stage::reading) | stage_bit(Stage::body) |
      (HasDrive<D> ? stage_bit(Stage::drive) : 0u) | (HasLoad<D> ? stage_bit(Stage::load) : 0u) |
      (HasTyre<D> ? stage_bit(Stage::tyre) : 0u) | (HasForce<D> ? stage_bit(Stage::force) : 0u);
};

}  // namespace detail
/// \endcond

/// A vehicle model written once for any scalar T. D supplies, for each stage that the model has (`body` always),
/// \code
///   template <class T> void drive(Point<T>& p, const Params<T>& k) const;   // likewise load, tyre, force, body
/// \endcode
///
/// which fills that stage's quantities of p.q.
template <class D>
class AutoDiffVehicle : public VehicleModel, public detail::KeptTables {
 public:
  unsigned stages() const noexcept final { return detail::CheckedStages<D>::bits; }
  void evaluate(Stage first, Stage last, const Points<double>& points) const final { run(first, last, points); }
  void evaluate(Stage first, Stage last, const Points<Dual8>& points) const final { run(first, last, points); }

 private:
  template <class T>
  void run(Stage first, Stage last, const Points<T>& points) const {
    const D& self = static_cast<const D&>(*this);
    const auto params = detail::bind_kept<D>(*this, points.params);
    const auto wanted = [&](Stage stage) { return first <= stage && stage <= last; };
    for (std::size_t i = 0; i < points.n; ++i) {
      Point<T> p{points.q[i], points.at[i], nullptr, nullptr, nullptr};
      if constexpr (detail::HasDrive<D>)
        if (wanted(Stage::drive)) self.drive(p, params);
      if constexpr (detail::HasLoad<D>)
        if (wanted(Stage::load)) self.load(p, params);
      if constexpr (detail::HasTyre<D>)
        if (wanted(Stage::tyre)) self.tyre(p, params);
      if constexpr (detail::HasForce<D>)
        if (wanted(Stage::force)) self.force(p, params);
      if (wanted(Stage::body)) self.body(p, params);
    }
  }
};

/// Drive force Fd [N] from the quantities of Stage::drive: the motor for d >= 0, the brakes below.
template <class T>
T drive_force(const Quantities<T>& q) {
  return q.d < T(0) ? q.brake * q.d : (q.motor - q.emf * q.vx) * q.d;
}

}  // namespace gripline
