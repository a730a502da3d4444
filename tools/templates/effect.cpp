// Air drag, from zero at rest: change it to what your model misses.
#include <gripline/equation.hpp>
#include <gripline/plugin.hpp>

namespace {

class NewPlugin final : public gripline::AutoDiffEffect<NewPlugin> {
 public:
  template <class T>
  struct Params {  // filled by position: in the order of parameters()
    T a = T(0.2);
  };
  static constexpr auto parameters() {
    // JSON key, member, unit, range, one sentence. fit: `diagnose` may fit it; the value at which the effect vanishes,
    // one to start from, how large a change of it is typical.
    return std::tuple{gripline::param("a", &Params<double>::a, "m/s2", {-5, 5}, "drag at v_ref").fit(0, 0.1, 0.3)};
  }
  // v_ref is the car's typical speed; nominal and truth are null here.
  explicit NewPlugin(const gripline::PluginContext& context) : v_ref_(context.car.v_ref) {}

  // After this stage of the vehicle model it acts; it changes quantities of this stage only (types.hpp lists them).
  gripline::Stage stage() const noexcept override { return gripline::Stage::body; }

  // T is double, or carries derivatives: no double between, and `using std::sin;` before sin(x).
  template <class T>
  void act(gripline::Point<T>& p, const Params<T>& k) const {
    p.q.ax -= k.a * gripline::square(p.q.vx / v_ref_);
  }

 private:
  double v_ref_;
};

}  // namespace

GRIPLINE_EQUATIONS({"new_plugin", "ax -= a (vx / v_ref)^2"})
GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "drag that grows with the square of speed")
                     .advice("coast down from top speed on a level straight"))
