// Effects of Stage::command: what happens to a command between the stack and the wheels.
//
//   input_delay (and its synonym sensor_latency)   d(t) = d_cmd(t - T),  delta(t) = delta_cmd(t - T)
//   motor_lag                                      d' = (d_in - d) / tau
//   steer_lag                                      delta' = (delta_in - delta) / tau
//   steer_gain                                     delta = (1 + k) delta_in
//   steer_offset                                   delta = delta_in + d0
//
// They act in this order whatever the order of their names: delay, lag, gain, offset (framework/doc/effects.md).
// A lag vanishes as tau goes to 0, where its equation is singular; its parameter is bounded from below instead.
#include <gripline/plugin.hpp>

namespace {

using gripline::param;
using gripline::Point;
using gripline::Stage;

/// Commands as they were T seconds ago. If all six sensors lag by T, the commands seem early by T: the same model.
template <class D>
class Delay : public gripline::AutoDiffEffect<D> {
 public:
  template <class T>
  struct Params {
    T delay = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("T", &Params<double>::delay, "s", {0, 1}, "delay").fit(0, 0.02, 0.02)};
  }
  Stage stage() const noexcept override { return Stage::command; }
  double delay(const Params<double>& k) const noexcept { return k.delay; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    if (p.history == nullptr) return;
    const auto then = p.history->at(k.delay);
    p.q.d = then.d;
    p.q.delta = then.delta;
    p.q.delta_rate = then.delta_rate;
  }
};

class InputDelay final : public Delay<InputDelay> {};
class SensorLatency final : public Delay<SensorLatency> {};

class MotorLag final : public gripline::AutoDiffEffect<MotorLag> {
 public:
  template <class T>
  struct Params {
    T tau = T(0.1);
  };
  static constexpr auto parameters() {
    return std::tuple{param("tau", &Params<double>::tau, "s", {0.002, 5}, "time constant").fit(0, 0.04, 0.04)};
  }
  Stage stage() const noexcept override { return Stage::command; }
  int memory() const noexcept override { return 1; }
  void initial(const Point<double>& p, const Params<double>&, std::span<double> memory) const { memory[0] = p.q.d; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.memory_rate[0] = (p.q.d - p.memory[0]) / k.tau;
    p.q.d = p.memory[0];
  }
};

class SteerLag final : public gripline::AutoDiffEffect<SteerLag> {
 public:
  template <class T>
  struct Params {
    T tau = T(0.05);
  };
  static constexpr auto parameters() {
    return std::tuple{param("tau", &Params<double>::tau, "s", {0.002, 5}, "time constant").fit(0, 0.02, 0.02)};
  }
  Stage stage() const noexcept override { return Stage::command; }
  int memory() const noexcept override { return 1; }
  void initial(const Point<double>& p, const Params<double>&, std::span<double> memory) const { memory[0] = p.q.delta; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    const T rate = (p.q.delta - p.memory[0]) / k.tau;
    p.memory_rate[0] = rate;
    p.q.delta = p.memory[0];
    p.q.delta_rate = rate;
  }
};

class SteerGain final : public gripline::AutoDiffEffect<SteerGain> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("k", &Params<double>::k, "1", {-0.95, 5}, "relative change").fit(0, 0.02, 0.05)};
  }
  Stage stage() const noexcept override { return Stage::command; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.delta *= k.k + 1.0;
    p.q.delta_rate *= k.k + 1.0;
  }
};

class SteerOffset final : public gripline::AutoDiffEffect<SteerOffset> {
 public:
  template <class T>
  struct Params {
    T d0 = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("d0", &Params<double>::d0, "rad", {-1, 1}, "offset to the left").fit(0, 0.005, 0.01)};
  }
  Stage stage() const noexcept override { return Stage::command; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.delta += k.d0;
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<InputDelay>("input_delay", "1.0", "delay of both commands")
                     .advice("a steering chirp up to 3 Hz at two speeds; "
                             "steps of throttle on a straight")
                     .precedence(10),
                 gripline::describe<SensorLatency>("sensor_latency", "1.0",
                                                   "latency of all sensors: equivalent to a delay of the commands")
                     .advice("a steering chirp up to 3 Hz at two speeds")
                     .precedence(11),
                 gripline::describe<MotorLag>("motor_lag", "1.0", "first-order lag of the drive behind the throttle")
                     .advice("steps of throttle on a straight")
                     .precedence(20),
                 gripline::describe<SteerLag>("steer_lag", "1.0", "first-order lag of the wheels behind the steering")
                     .advice("a steering chirp up to 3 Hz at two speeds")
                     .precedence(21),
                 gripline::describe<SteerGain>("steer_gain", "1.0", "gain error of the steering").precedence(30),
                 gripline::describe<SteerOffset>("steer_offset", "1.0", "zero offset of the steering").precedence(40))
