// What fixed_speed and friction_speed share: one minimum-curvature line, speed profiles over mu, the paper's sampling.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <gripline/plugin.hpp>

#include "common/planning/car_limits.hpp"
#include "common/planning/closed_line.hpp"
#include "common/planning/join_path.hpp"
#include "common/planning/line_follower.hpp"
#include "common/planning/planner_context.hpp"
#include "common/planning/recovery_path.hpp"
#include "common/planning/speed_profile.hpp"

namespace gripline::planning {

struct LineParams {
  int line = 0;                      // choice: minimum_curvature
  double margin = 0.0;               // [m]
  double max_curvature = 0.0;        // [1/m]
  double spacing = 0.0;              // [m]
  double pace = 1.0;                 // [-]
  bool from_car_speed = true;        //
  double rolling = 0.0, drag = 0.0;  // [m/s2, 1/m]
  double combined = 1.0;             // [-]
  double tyre_B = 3.0, tyre_C = 1.3;
};

/// Declarations of LineParams for a plugin's Params P that derives from it.
template <class P>
constexpr auto line_parameters() {
  return std::tuple{
      choice("line", static_cast<int P::*>(&P::line), "minimum_curvature", "where the driving line comes from"),
      param("margin", static_cast<double P::*>(&P::margin), "m", {0, 10},
            "metres kept between the car's side and both edges by the line (time_optimal: widths of the car)"),
      param("max_curvature", static_cast<double P::*>(&P::max_curvature), "1/m", {0, 1e3},
            "soft bound of the line's curvature; 0: 0.8 of what the car can steer"),
      param("spacing", static_cast<double P::*>(&P::spacing), "m", {0, 10},
            "between samples of the line; 0: a sixth of the wheelbase"),
      param("pace", static_cast<double P::*>(&P::pace), "1", {0.05, 3}, "factor on all planned speeds"),
      param("from_car_speed", static_cast<bool P::*>(&P::from_car_speed), "1", {0, 1},
            "references gain speed only as fast as the car can; false: they drive the profile at once, as published"),
      param("rolling", static_cast<double P::*>(&P::rolling), "m/s2", {0, 100},
            "rolling resistance over mass that the nominal model lacks"),
      param("drag", static_cast<double P::*>(&P::drag), "1/m", {0, 10},
            "drag over mass and squared speed that the nominal model lacks"),
      param("combined", static_cast<double P::*>(&P::combined), "1", {0, 1},
            "share of drive and brake forces that counts in the friction circle"),
      param("tyre_B", static_cast<double P::*>(&P::tyre_B), "1/rad", {0.1, 1e3},
            "stiffness factor of the generic tyre, for the steering limit and the drag of turns"),
      param("tyre_C", static_cast<double P::*>(&P::tyre_C), "1", {1.0, 3}, "shape factor of the generic tyre")};
}

/// The driving line of these parameters. Throws std::invalid_argument when there is no course, and see sample_count().
inline ClosedLine minimum_curvature_line(const PluginContext& context, const LineParams& params) {
  const Course& course = course_of(context);
  const Car& car = context.car;
  const double spacing = params.spacing > 0 ? params.spacing : (car.lf + car.lr) / 6.0;
  LineOptions options;
  options.margin = params.margin;
  options.max_curvature = params.max_curvature > 0 ? params.max_curvature : drivable_curvature(car);
  std::vector<LinePoint> samples(sample_count(std::ceil(course.length() / spacing)));
  course.minimum_curvature(options, samples);
  return ClosedLine(std::move(samples));
}

/// Follows one line at profiles over the given grid of mu.
class LinePlanner {
 public:
  LinePlanner(const PluginContext& context, const LineParams& params, std::span<const double> mus)
      : dt_(context.dt),
        pace_(params.pace),
        from_car_speed_(params.from_car_speed),
        limits_(nominal_of(context), context.car, params.rolling, params.drag),
        road_(minimum_curvature_line(context, params), *context.course),
        profiles_(road_.line(), context.car, limits_, {params.tyre_B, params.tyre_C, params.combined}, mus),
        join_(context.car, road_.line().length()),
        recovery_(context.car, road_.line()) {}

  void plan(const Observation& now, double mu, std::span<RefPoint> horizon) {
    const ClosedLine& line = road_.line();
    const ProfileLibrary::AtFriction at_mu = profiles_.select(mu);
    const double foot = follower_.locate(line, now.x.x, now.x.y, now.x.yaw);
    const auto planned = [&](double s) { return pace_ * profiles_.speed(at_mu, line.bracket(s)); };
    const auto reach = [&](double v) {
      return from_car_speed_ ? std::max(0.0, limits_.coast(v) + limits_.drive(v))
                             : std::numeric_limits<double>::infinity();
    };
    const auto reference = [&](double s) { return road_.at(s, now.x.yaw); };
    if (recovery_.update(now, foot, mu, reference)) {
      join_.forget();
      recovery_.fill(now, dt_, reference, planned, reach, horizon);
      return;
    }
    join_.update(now, foot, mu, static_cast<double>(horizon.size()) * dt_, reference);
    const auto speed = [&](double s) { return std::min(planned(s), join_.speed(s)); };
    sample_horizon(road_, foot, now, dt_, speed, reach, horizon);
    join_.move(horizon);
  }

  const ClosedLine& line() const { return road_.line(); }

 private:
  double dt_, pace_;
  bool from_car_speed_;
  DriveLimits limits_;
  RoadLine road_;
  ProfileLibrary profiles_;
  LineFollower follower_;
  JoinPath join_;
  RecoveryPath recovery_;
};

}  // namespace gripline::planning
