// Effects of Stage::load: mass, geometry and what presses on the axles (framework/doc/effects.md; u = vx / v_ref,
// L = lf + lr). A change of load multiplies the axle's peak force D.
//
//   mass            m *= 1 + k,  D *= 1 + k on both axles, Iz unchanged
//   yaw_inertia     Iz *= 1 + k
//   load_transfer   Df *= 1 - h (L / lr) a / g,  Dr *= 1 + h (L / lf) a / g,  a = Fd / m
//   cog_shift       lf += k L, lr -= k L;  Df *= lr_new / lr,  Dr *= lf_new / lf
//   downforce       D *= max(0, 1 + k u^2) on both axles
//
// No axle carries less than nothing: load_transfer ends where one axle carries the car (h L a / g is kept between -lf
// and lr), cog_shift a hundredth of L before an axle.
//
// mass acts first (forces act on the changed mass), cog_shift after load_transfer (whose L / lr is the nominal one).
#include <gripline/plugin.hpp>

namespace {

using gripline::max;
using gripline::min;
using gripline::param;
using gripline::Point;
using gripline::square;
using gripline::Stage;
using std::max;
using std::min;

/// A relative change k of one quantity or several.
template <class T>
struct Relative {
  T k = T(0);
};

class Mass final : public gripline::AutoDiffEffect<Mass> {
 public:
  template <class T>
  using Params = Relative<T>;
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {-0.9, 5}, "relative change of mass").fit(0, 0.03, 0.1)};
  }
  Stage stage() const noexcept override { return Stage::load; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T factor = k.k + 1.0;
    p.q.m *= factor;
    p.q.load_front *= factor;
    p.q.load_rear *= factor;
  }
};

class YawInertia final : public gripline::AutoDiffEffect<YawInertia> {
 public:
  template <class T>
  using Params = Relative<T>;
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-0.9, 5}, "relative change of yaw inertia").fit(0, 0.03, 0.1)};
  }
  Stage stage() const noexcept override { return Stage::load; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.Iz *= k.k + 1.0;
  }
};

class LoadTransfer final : public gripline::AutoDiffEffect<LoadTransfer> {
 public:
  template <class T>
  struct Params {
    T h_over_L = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("h_over_L", &Params<double>::h_over_L, "1", {-1, 1}, "height of the centre of gravity over the wheelbase")
            .fit(0, 0.03, 0.1)};
  }
  Stage stage() const noexcept override { return Stage::load; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T wanted = k.h_over_L * (p.q.lf + p.q.lr) * (p.q.drive_force / p.q.m) / gripline::gravity;
    const T shifted = max(-p.q.lf, min(p.q.lr, wanted));
    p.q.load_front *= T(1) - shifted / p.q.lr;
    p.q.load_rear *= T(1) + shifted / p.q.lf;
  }
};

class CogShift final : public gripline::AutoDiffEffect<CogShift> {
 public:
  template <class T>
  using Params = Relative<T>;
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {-0.4, 0.4},
                            "shift of the centre of gravity towards the rear over the wheelbase")
                          .fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::load; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T L = p.q.lf + p.q.lr;
    const T shift = max(0.01 * L - p.q.lf, min(p.q.lr - 0.01 * L, k.k * L));
    const T lf = p.q.lf + shift;
    const T lr = p.q.lr - shift;
    p.q.load_front *= lr / p.q.lr;
    p.q.load_rear *= lf / p.q.lf;
    p.q.lf = lf;
    p.q.lr = lr;
  }
};

class Downforce final : public gripline::AutoDiffEffect<Downforce> {
 public:
  template <class T>
  using Params = Relative<T>;
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-0.9, 5}, "relative gain of axle load at v_ref").fit(0, 0.02, 0.05)};
  }
  explicit Downforce(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}
  Stage stage() const noexcept override { return Stage::load; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T factor = max(T(0), T(1) + k.k * square(p.q.vx / v_ref_));
    p.q.load_front *= factor;
    p.q.load_rear *= factor;
  }

 private:
  double v_ref_;
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<Mass>("mass", "1.0", "mass differs from the nominal one").precedence(10),
    gripline::describe<YawInertia>("yaw_inertia", "1.0", "yaw inertia differs from the nominal one")
        .advice("a steering chirp up to 3 Hz at two speeds")
        .precedence(20),
    gripline::describe<LoadTransfer>("load_transfer", "1.0", "longitudinal load transfer between axles")
        .advice("power on and lift off in a steady corner, then brake in a turn")
        .precedence(30),
    gripline::describe<CogShift>("cog_shift", "1.0", "centre of gravity shifted along the car").precedence(40),
    gripline::describe<Downforce>("downforce", "1.0", "aerodynamic downforce: axle load grows with speed squared")
        .advice("the same corner at the limit slowly and fast, early and late")
        .precedence(50))
