// Effects of the host's own that a forecaster adds to a car. Disturbances: what a model leaves unexplained shortly
// before a prediction starts, carried on, a force along the car and a steering angle, each decaying with a time
// constant and set by the observer from what it last saw. Frames: where a log's units sit, as its map states it.
#pragma once

#include <gripline/frames.hpp>
#include <gripline/plugin.hpp>

namespace gripline::calibrate {

/// q.ax += b (at Stage::body) or q.delta += b (at Stage::command),  b' = -b / tau
template <Stage acts_at>
class Disturbance final : public AutoDiffEffect<Disturbance<acts_at>> {
  static_assert(acts_at == Stage::body || acts_at == Stage::command);

 public:
  template <class T>
  struct Params {
    T tau = T(2);  // [s]
  };
  static constexpr auto parameters() {
    return std::tuple{param("tau", &Params<double>::tau, "s", {0.05, 60}, "time constant of the decay").fit(2, 2, 1)};
  }
  Stage stage() const noexcept override { return acts_at; }
  int memory() const noexcept override { return 1; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.memory_rate[0] = -p.memory[0] / k.tau;
    (acts_at == Stage::body ? p.q.ax : p.q.delta) += p.memory[0];
  }
};
using ForceDisturbance = Disturbance<Stage::body>;
using SteerDisturbance = Disturbance<Stage::command>;

/// Readings of units at the points and in the axes that a map states: place, heading, velocity.
class StatedFrames final : public AutoDiffReading<StatedFrames> {
 public:
  template <class T>
  struct Params {
    T pose_x = T(0), pose_y = T(0), pose_yaw = T(0);              // [m], [m], [rad]
    T velocity_x = T(0), velocity_y = T(0), velocity_yaw = T(0);  // likewise
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("pose_x", &P::pose_x, "m", {-20, 20}, "ahead of the centre of gravity"),
                      param("pose_y", &P::pose_y, "m", {-20, 20}, "to its left"),
                      param("pose_yaw", &P::pose_yaw, "rad", {-3.2, 3.2}, "turned to the left"),
                      param("velocity_x", &P::velocity_x, "m", {-20, 20}, "ahead of the centre of gravity"),
                      param("velocity_y", &P::velocity_y, "m", {-20, 20}, "to its left"),
                      param("velocity_yaw", &P::velocity_yaw, "rad", {-3.2, 3.2}, "turned to the left")};
  }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    move_place_to_point(r, k.pose_x, k.pose_y);
    r.yaw += k.pose_yaw;
    move_velocity_to_point(r, k.velocity_x, k.velocity_y);
    turn_velocity_axes(r, k.velocity_yaw);
  }
};

}  // namespace gripline::calibrate
