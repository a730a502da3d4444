// Effects of Stage::tyre: peak force D and stiffness factor B per axle (framework/doc/effects.md).
//
//   friction_scale   D *= 1 + k on both axles
//   friction_drift   D *= max(0, 1 + k t / 60 s) on both axles: friction that fades away does not turn round
//   friction_patch   D *= 1 + k W(f; s0, w) on both axles, f the lap fraction,
//                    W = (tanh((q + w/2) / 0.012) - tanh((q - w/2) / 0.012)) / 2,  q = f - s0 wrapped to [-0.5, 0.5)
//   front_grip, rear_grip     D of one axle *= 1 + k
//   front_stiff, rear_stiff   B of one axle *= 1 + k
//   comb_slip        Dr *= sqrt(max(0.05, 1 - k (Fd / Dr)^2)), after all other factors of Dr
#include <gripline/plugin.hpp>

namespace {

using gripline::max;
using gripline::param;
using gripline::Point;
using gripline::square;
using gripline::Stage;
using std::max;
using std::sqrt;
using std::tanh;

/// An effect with one relative change k, written as a function of the point.
template <class D>
class RelativeTyre : public gripline::AutoDiffEffect<D> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {-0.95, 10}, "relative change").fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::tyre; }
};

class FrictionScale final : public RelativeTyre<FrictionScale> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.peak_front *= k.k + 1.0;
    p.q.peak_rear *= k.k + 1.0;
  }
};

class FrictionDrift final : public RelativeTyre<FrictionDrift> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T factor = max(T(0), k.k * (p.at.t / 60.0) + 1.0);
    p.q.peak_front *= factor;
    p.q.peak_rear *= factor;
  }
};

class FrictionPatch final : public gripline::AutoDiffEffect<FrictionPatch> {
 public:
  template <class T>
  struct Params {
    T k = T(0), s0 = T(0.5), w = T(0.14);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{
        param("k", &P::k, "1", {-0.95, 5}, "relative change of friction").fit(0, -0.1, 0.1),
        param("s0", &P::s0, "1", {-1, 2}, "centre of the patch, as a lap fraction").fit(0.5, 0.5, 0.05).periodic(),
        param("w", &P::w, "1", {0.02, 0.6}, "length of the patch over the lap").fit(0.14, 0.14, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::tyre; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    constexpr double edge = 0.012;
    T q = T(p.at.lap_fraction) - k.s0;
    q -= std::floor(gripline::value(q) + 0.5);
    const T window = (tanh((q + k.w * 0.5) / edge) - tanh((q - k.w * 0.5) / edge)) * 0.5;
    const T factor = k.k * window + 1.0;
    p.q.peak_front *= factor;
    p.q.peak_rear *= factor;
  }
};

class FrontGrip final : public RelativeTyre<FrontGrip> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.peak_front *= k.k + 1.0;
  }
};

class RearGrip final : public RelativeTyre<RearGrip> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.peak_rear *= k.k + 1.0;
  }
};

class FrontStiff final : public RelativeTyre<FrontStiff> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.stiff_front *= k.k + 1.0;
  }
};

class RearStiff final : public RelativeTyre<RearStiff> {
 public:
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.stiff_rear *= k.k + 1.0;
  }
};

class CombSlip final : public gripline::AutoDiffEffect<CombSlip> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {0, 3}, "weight of the drive force in the friction ellipse")
                          .fit(0, 0.2, 0.2)};
  }
  Stage stage() const noexcept override { return Stage::tyre; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T used = square(p.q.drive_force / p.q.peak_rear);
    p.q.peak_rear *= sqrt(max(T(0.05), T(1) - k.k * used));
  }
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<FrictionScale>("friction_scale", "1.0", "friction of both axles scaled")
        .advice("the same corner at the limit slowly and fast, early and late")
        .precedence(10),
    gripline::describe<FrictionDrift>("friction_drift", "1.0", "friction changes with time")
        .advice("the same corner at the limit slowly and fast, early and late")
        .precedence(11),
    gripline::describe<FrictionPatch>("friction_patch", "1.0", "friction differs on one stretch of the lap")
        .advice("the same place at two speeds, for three laps or more")
        .precedence(12),
    gripline::describe<FrontGrip>("front_grip", "1.0", "peak lateral force of the front axle scaled")
        .advice("a slow ramp of steering into saturation, twice; "
                "power on and lift off in a steady corner, then brake in a turn")
        .precedence(20),
    gripline::describe<RearGrip>("rear_grip", "1.0", "peak lateral force of the rear axle scaled")
        .advice("a slow ramp of steering into saturation, twice; "
                "power on and lift off in a steady corner, then brake in a turn")
        .precedence(21),
    gripline::describe<FrontStiff>("front_stiff", "1.0", "cornering stiffness of the front axle scaled, peak unchanged")
        .advice("a slow ramp of steering into saturation, twice")
        .precedence(22),
    gripline::describe<RearStiff>("rear_stiff", "1.0", "cornering stiffness of the rear axle scaled, peak unchanged")
        .advice("a slow ramp of steering into saturation, twice")
        .precedence(23),
    gripline::describe<CombSlip>("comb_slip", "1.0",
                                 "combined slip: drive force reduces lateral force of the rear axle")
        .advice("power on and lift off in a steady corner, then brake in a turn")
        .precedence(90))
