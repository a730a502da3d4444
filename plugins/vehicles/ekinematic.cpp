// The paper's e-kinematic car: the kinematic single track linearised in the steering angle, written in the velocities
// of the dynamic model, so that a learned correction can be added to it.
//
//   vx'    = (Fd - Fres) / m - g sin(grade)
//   vy'    = lr / L (delta' vx + delta vx')
//   omega' =  1 / L (delta' vx + delta vx') yaw_gain,   L = lf + lr
//
// yaw_gain = 1 is the formula. The published code multiplies by L where it should divide, which is yaw_gain = L^2
// (0.003844 for the 1:43 car): the observed yaw rate then holds over the horizon. All rows of
// experiments/table1.json, `elm` among them, state that value; with 1 the paper's controller swings from edge to edge
// until it adapts (framework/doc/models.md). no_slip_car.hpp applies it to all models without slip.
//
// Source: Kalaria, Lin, Dolan, their e-kinematic model, with lr / L (centre of gravity to rear axle) where the paper
// prints lf / L, and 1 / L where the published code multiplies. The vx' inside the last two rows leaves the slope out.
#include "common/vehicle/no_slip_car.hpp"

namespace {

class EKinematic final : public gripline::NoSlipCar<EKinematic> {
 public:
  template <class T>
  void motion(gripline::Quantities<T>& q, const T& drive_rate) const {
    const T L = q.lf + q.lr;
    const T turn = q.delta_rate * q.vx + q.delta * drive_rate;
    q.ax = drive_rate;
    q.ay = q.lr / L * turn;
    q.aw = turn / L;
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<EKinematic>("ekinematic", "1.0",
                                                "kinematic single track, linear in the steering angle, as the paper's"))
