// The paper's e-kinematic car: the kinematic single track linearised in the steering angle, written in the velocities
// of the dynamic model, so that a learned correction can be added to it.
//
//   vx'    = (Fd - Fres) / m - g sin(grade)
//   vy'    = lr / L (delta' vx + delta vx')
//   omega' =  1 / L (delta' vx + delta vx'),   L = lf + lr
//
// Source: Kalaria, Lin, Dolan, eq. (ekin_model), with lr / L (centre of gravity to rear axle) where the paper prints
// lf / L, and 1 / L where the published code multiplies. The vx' inside the last two rows leaves the slope out.
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
