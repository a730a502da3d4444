// Effects of Stage::reading: where on the car, and turned how, a measuring unit sits.
//
//   pose_lever      x += px cos(yaw) - py sin(yaw),  y += px sin(yaw) + py cos(yaw)   the point whose place is shown
//   pose_yaw        yaw += a                                                          the heading of its axis
//   velocity_lever  vx -= py omega,  vy += px omega                                   the point whose velocity is shown
//   velocity_yaw    (vx, vy) in axes turned to the left by a
//
// px is ahead of the centre of gravity, py to its left. Levers act before turns: their arms are in the car's own axes.
// Rigid-body kinematics; ISO 8855 axes.
#include <gripline/frames.hpp>
#include <gripline/plugin.hpp>

namespace {

using gripline::param;
using gripline::Place;
using gripline::Reading;

template <class T>
struct Arm {
  T px = T(0), py = T(0);
};
template <class T>
struct Turn {
  T a = T(0);
};

constexpr auto arm_parameters() {
  using P = Arm<double>;
  return std::tuple{param("px", &P::px, "m", {-20, 20}, "ahead of the centre of gravity").fit(0, 0.02, 0.05),
                    param("py", &P::py, "m", {-20, 20}, "to the left of the centre of gravity").fit(0, 0.02, 0.05)};
}
constexpr auto turn_parameters() {
  return std::tuple{param("a", &Turn<double>::a, "rad", {-3.2, 3.2}, "turned to the left").fit(0, 0.01, 0.02)};
}

class PoseLever final : public gripline::AutoDiffReading<PoseLever> {
 public:
  template <class T>
  using Params = Arm<T>;
  static constexpr auto parameters() { return arm_parameters(); }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    gripline::move_place_to_point(r, k.px, k.py);
  }
};

class PoseYaw final : public gripline::AutoDiffReading<PoseYaw> {
 public:
  template <class T>
  using Params = Turn<T>;
  static constexpr auto parameters() { return turn_parameters(); }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    r.yaw += k.a;
  }
};

class VelocityLever final : public gripline::AutoDiffReading<VelocityLever> {
 public:
  template <class T>
  using Params = Arm<T>;
  static constexpr auto parameters() { return arm_parameters(); }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    gripline::move_velocity_to_point(r, k.px, k.py);
  }
};

class VelocityYaw final : public gripline::AutoDiffReading<VelocityYaw> {
 public:
  template <class T>
  using Params = Turn<T>;
  static constexpr auto parameters() { return turn_parameters(); }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    gripline::turn_velocity_axes(r, k.a);
  }
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<PoseLever>("pose_lever", "1.0", "position sensor away from the centre of gravity").precedence(1),
    gripline::describe<VelocityLever>("velocity_lever", "1.0", "velocity sensor away from the centre of gravity")
        .precedence(2),
    gripline::describe<PoseYaw>("pose_yaw", "1.0", "heading sensor misaligned with the car").precedence(3),
    gripline::describe<VelocityYaw>("velocity_yaw", "1.0", "velocity sensor misaligned with the car").precedence(4))
