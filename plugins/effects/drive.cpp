// Effects of Stage::drive: motor and brakes (framework/doc/effects.md; u = vx / v_ref).
//
//   back_emf     Cm2 -> Cm2 + k Cm1 / v_ref
//   drive_gain   Cm1 -> Cm1 (1 + k)
//   brake_gain   Cb -> Cb (1 + k)
//   brake_fade   Cb -> Cb max(0, 1 - k E),  E' = 0.5 max(-d, 0) |u| - E / 20 s,  E(0) = 0
//
// back_emf acts before drive_gain, because its Cm1 is the nominal one. Cb stands for what the car brakes with: of a
// model with Cb = 0 that is Cm1 - Cm2 vx of the bare model, which brake_gain and brake_fade change and the others
// leave.
#include <gripline/plugin.hpp>

namespace {

using gripline::max;
using gripline::param;
using gripline::Point;
using gripline::Stage;
using std::abs;
using std::max;

class DriveEffect {
 public:
  explicit DriveEffect(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}

 protected:
  double v_ref_;
};

class BackEmf final : public gripline::AutoDiffEffect<BackEmf>, DriveEffect {
 public:
  using DriveEffect::DriveEffect;
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-2, 2}, "share of the drive force lost at v_ref").fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::drive; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.emf += k.k * p.q.motor / v_ref_;
  }
};

class DriveGain final : public gripline::AutoDiffEffect<DriveGain> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-0.95, 5}, "relative change of the drive force").fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::drive; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.motor *= k.k + 1.0;
  }
};

class BrakeGain final : public gripline::AutoDiffEffect<BrakeGain> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-0.95, 5}, "relative change of the brake force").fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::drive; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.brake *= k.k + 1.0;
  }
};

class BrakeFade final : public gripline::AutoDiffEffect<BrakeFade>, DriveEffect {
 public:
  using DriveEffect::DriveEffect;
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {0, 20}, "loss per unit of brake heat").fit(0, 0.1, 0.1)};
  }
  Stage stage() const noexcept override { return Stage::drive; }
  int memory() const noexcept override { return 1; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T heat = p.memory[0];
    p.memory_rate[0] = max(-p.q.d, T(0)) * (abs(p.q.vx) / v_ref_) * 0.5 - heat / 20.0;
    p.q.brake *= max(T(0), T(1) - k.k * heat);
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<BackEmf>("back_emf", "1.0", "back-EMF: additional loss of drive force with speed")
                     .advice("full throttle from a quarter of top speed to top speed")
                     .precedence(10),
                 gripline::describe<DriveGain>("drive_gain", "1.0", "gain error of the drive force")
                     .advice("drive the same lap in the other direction, and coast down once; "
                             "full throttle from a quarter of top speed to top speed")
                     .precedence(20),
                 gripline::describe<BrakeGain>("brake_gain", "1.0", "gain error of the brake force")
                     .advice("brake hard ten times in a row, then once after a minute")
                     .precedence(30),
                 gripline::describe<BrakeFade>("brake_fade", "1.0", "brake fade: loss of brake force with heat")
                     .advice("brake hard ten times in a row, then once after a minute")
                     .precedence(40))
