#include "race/sample.hpp"

namespace gripline {

Sample residual_sample(CorrectedModel& nominal, const Observation& before, const Input& u, const Observation& after) {
  Sample sample;
  sample.t = before.t;
  sample.dt = nominal.dt();
  sample.step = before.step;
  sample.x = before.x;
  sample.u = u;
  sample.at = before.at;
  sample.x_next = after.x;
  sample.at_next = after.at;
  const Quantities<double> begin = nominal.quantities(before.x, u, before.at);
  const State predicted = nominal.advance(before.x, u, before.at);
  const Quantities<double> end = nominal.quantities_after(after.x, u, after.at);
  sample.d_lag = u.d - 0.5 * (begin.d + end.d);
  sample.delta_lag = after.x.delta - 0.5 * (begin.delta + end.delta);
  sample.ddelta_lag = u.ddelta - 0.5 * (begin.delta_rate + end.delta_rate);
  sample.e_vx = (after.x.vx - predicted.vx) / sample.dt;
  sample.e_vy = (after.x.vy - predicted.vy) / sample.dt;
  sample.e_omega = (after.x.omega - predicted.omega) / sample.dt;
  return sample;
}

}  // namespace gripline
