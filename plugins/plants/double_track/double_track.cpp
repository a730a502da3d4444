// A full-size car with more physics than any model a stack may use: four wheels, load transfer, combined slip, tyre
// relaxation, an engine with gears, slope. The equations stand in car.hpp, tyre.hpp and drivetrain.hpp.
#include <gripline/plugin.hpp>

#include "plants/double_track/car.hpp"

namespace {

using gripline::Axle;
using gripline::Ground;
using gripline::State;

class DoubleTrack final : public gripline::Plant {
 public:
  using Params = gripline::double_track::Params;
  static constexpr auto parameters() { return gripline::double_track::declare_parameters(); }

  DoubleTrack(const gripline::PluginContext&, const Params& params) : car_(params) {}

  void reset(const State& x, const Ground& ground) override { car_.reset(x, ground); }

  State advance(double d, double delta, double dt, const Ground& ground) override {
    car_.advance(d, delta, dt, ground);
    const gripline::double_track::Motion& z = car_.motion();
    return {z.x, z.y, z.yaw, z.vx, z.vy, z.omega, delta};
  }

  double mu(Axle) const override { return car_.params().mu_y; }
  double tyre_force(Axle axle, double slip) const override {
    const auto& tyre = car_.tyre(axle);
    return 2.0 * tyre.lateral(tyre.static_load(), slip);
  }
  double axle_force(Axle axle) const override { return car_.axle_force(axle); }

 private:
  gripline::double_track::DoubleTrackCar car_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<DoubleTrack>(
    "double_track", "1.0", "full-size car: four wheels, load transfer, combined slip, engine and gears, slope"))
