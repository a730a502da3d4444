// Kinematic single-track car: the wheels roll where they point.
//
// With the speed v of the centre of gravity and its angle to the car's axis,
//   beta = atan(lr / L tan(delta)),   v' = (Fd - Fres) / m,   L = lf + lr,
// the velocities of this project are
//   vx = v cos(beta),   vy = v sin(beta) = vx lr / L tan(delta),   omega = v sin(beta) / lr = vx tan(delta) / L,
// and the accelerations are the derivative of that map, with v = vx / cos(beta) read off the state:
//   beta'  = lr / L (1 + tan(delta)^2) delta' / (1 + (lr / L tan(delta))^2)
//   vx'    = v' cos(beta) - v sin(beta) beta' - g sin(grade)
//   vy'    = v' sin(beta) + v cos(beta) beta'
//   omega' = vy' / lr
//
// On level ground a state that starts on the map stays on it. A grade changes vx alone, so that a steered car leaves
// the map there. Source: Rajamani, Vehicle Dynamics and Control, section 2.2; the paper's kinematic model with lr, not
// lf, in beta. The drive force acts along v, as there.
#include "common/vehicle/no_slip_car.hpp"

namespace {

using gripline::square;
using std::atan;
using std::cos;
using std::sin;
using std::tan;

class Kinematic final : public gripline::NoSlipCar<Kinematic> {
 public:
  template <class T>
  void motion(gripline::Quantities<T>& q, const T& drive_rate) const {
    const T share = q.lr / (q.lf + q.lr);
    const T tangent = tan(q.delta);
    const T beta = atan(share * tangent);
    const T beta_rate = share * (1.0 + square(tangent)) * q.delta_rate / (1.0 + square(share * tangent));
    const T v = q.vx / cos(beta);
    q.ax = drive_rate * cos(beta) - v * sin(beta) * beta_rate;
    q.ay = drive_rate * sin(beta) + v * cos(beta) * beta_rate;
    q.aw = q.ay / q.lr;
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<Kinematic>("kinematic", "1.0",
                                               "kinematic single track: wheels roll where they point"))
