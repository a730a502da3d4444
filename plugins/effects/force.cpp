// Effect of Stage::force: tyre forces build up over a distance sigma (framework/doc/effects.md).
//
//   Ff' = (|vx| / sigma) (Ff_static - Ff),  Fr likewise; the static value at the start
//
// or, where an axle slides by more than 45 degrees, with its speed across, |vy + lf omega| and |vy - lr omega|, in
// place of |vx|: else a car that slides straight across would be pushed by the forces of a moment ago for ever.
#include <gripline/plugin.hpp>

namespace {

using gripline::max;
using gripline::param;
using gripline::Point;
using gripline::Stage;
using std::abs;
using std::max;

class Relaxation final : public gripline::AutoDiffEffect<Relaxation> {
 public:
  template <class T>
  struct Params {
    T sigma = T(0.1);
  };
  // The length that counts is relative to v_ref: 2 cm for the 1:43 car, 25 cm for a real one.
  static constexpr auto parameters() {
    return std::tuple{param("sigma", &Params<double>::sigma, "m", {0.002, 20}, "relaxation length").fit(0, 0.05, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::force; }
  int memory() const noexcept override { return 2; }
  void initial(const Point<double>& p, const Params<double>&, std::span<double> memory) const {
    memory[0] = p.q.force_front;
    memory[1] = p.q.force_rear;
  }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T along = abs(p.q.vx);
    const T front = max(along, T(abs(p.q.vy + p.q.lf * p.q.omega))) / k.sigma;
    const T rear = max(along, T(abs(p.q.vy - p.q.lr * p.q.omega))) / k.sigma;
    p.memory_rate[0] = front * (p.q.force_front - p.memory[0]);
    p.memory_rate[1] = rear * (p.q.force_rear - p.memory[1]);
    p.q.force_front = p.memory[0];
    p.q.force_rear = p.memory[1];
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<Relaxation>("relaxation", "1.0",
                                                "tyre relaxation: lateral force builds up over a length driven")
                     .advice("a steering chirp up to 3 Hz at two speeds")
                     .precedence(10))
