#include "conformance/bench.hpp"

#include <array>
#include <numbers>

namespace gripline::conformance {
namespace {

StepOptions step_options() { return {.dt = dt, .hold = Hold::zoh, .integration = {find_tableau("rk4"), 1}}; }

}  // namespace

Track oval() {
  const std::array segments{Segment::line(2), Segment::arc(0.8, std::numbers::pi), Segment::line(2),
                            Segment::arc(0.8, std::numbers::pi)};
  TrackShape shape{.name = "oval", .centre = ClosedCurve::from_segments({}, segments, 1e-6)};
  shape.half_width_right = 0.3;
  shape.half_width_left = 0.3;
  shape.grade = 0.0;
  shape.bank = 0.0;
  return Track(std::move(shape));
}

double RecordedTruth::mu(Axle axle) const {
  const double other = axle == Axle::front ? car_.car.lr : car_.car.lf;
  const double load = car_.car.m * gravity * other / (car_.car.lf + car_.car.lr);
  return (axle == Axle::front ? car_.Df : car_.Dr) / load;
}

Bench::Bench(std::string cache_dir)
    : cache_dir_(std::move(cache_dir)),
      track_(oval()),
      course_(track_, small_car()),
      nominal_(StagedCar(rolling_, RollingCar::values()), step_options()),
      drive_(drive_bends(24, 3, [](double) { return 1.0; })) {
  CorrectedModel model = fresh_nominal();
  samples_.reserve(drive_.steps());
  for (std::size_t i = 0; i < drive_.steps(); ++i)
    samples_.push_back(make_sample(model, static_cast<std::int64_t>(i), drive_.x[i], drive_.u[i], drive_.x[i + 1]));
}

CorrectedModel Bench::fresh_nominal() const {
  return CorrectedModel(StagedCar(rolling_, RollingCar::values()), step_options());
}

PluginContext Bench::context(const PluginEntry& entry, bool always_truth) {
  PluginContext context;
  context.car = small_car();
  context.dt = dt;
  context.seed = 1;
  const abi::Kind kind = entry.decl->kind;
  if (kind == abi::Kind::estimator || kind == abi::Kind::planner || kind == abi::Kind::controller) {
    context.course = &course_;
    context.nominal = &nominal_;
    if (entry.needs_truth() || always_truth) context.truth = &truth_;
    if (!cache_dir_.empty()) context.cache_dir = cache_dir_.c_str();
  }
  return context;
}

Observation Bench::observe(const State& x, double d, std::int64_t step) const {
  Observation now;
  now.t = static_cast<double>(step) * dt;
  now.step = step;
  now.x = x;
  now.at = place_of(track_, track_.locate(x.x, x.y), now.t, x.x, x.y, x.yaw);
  now.d = d;
  return now;
}

std::vector<abi::ParamValue> nominal_values(const PluginEntry& entry) {
  std::vector<abi::ParamValue> values;
  for (const abi::ParamDecl& p : entry.params()) values.push_back({p.fit ? p.start : p.default_value, {}});
  return values;
}

}  // namespace gripline::conformance
