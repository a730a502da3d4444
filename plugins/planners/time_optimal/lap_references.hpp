// Reference points along a lap that is planned, at the pace at which it is driven. Speeds are stated along the car's
// axis, v cos(beta).
#pragma once

#include <gripline/interfaces.hpp>
#include <span>

#include "common/planning/join_path.hpp"
#include "planners/time_optimal/lap_parameters.hpp"
#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/pace_reserve.hpp"

namespace gripline::time_optimal {

class LapReferences {
 public:
  /// What they are taken from; all of it changes from step to step, and outlives this object.
  struct Sources {
    const LapSetup* setup;
    const PlanFollower* line;
    const PaceReserve* reserve;
    const planning::JoinPath* join;
  };
  /// What holds in a control step.
  struct Step {
    MagicFormula rear;              // tyre that is planned for, up to its friction
    SpecificResistance resistance;  // that is learned
    double tightened = 0;           // taken from the room stated [m]
  };
  /// `at_own_speed`: on the way to the line references advance as fast as they are planned, not as fast as the line
  /// beside them.
  LapReferences(const PluginContext& context, const LapParams& params, bool at_own_speed, const Sources& from);

  void set(const Step& step) { step_ = step; }
  /// What is driven where v is planned [m/s].
  double driven_speed(double v) const { return from_.reserve->pace(v) * v; }
  /// The acceleration by which references may gain speed [m/s2].
  double gain(double v) const;
  /// The reference at a station of the base line; its heading is the one nearest to `yaw_near`, its grip 1.
  RefPoint at(double station, double yaw_near) const { return at(station, from_.line->at(station), yaw_near); }
  /// Fills the horizon with references from a station of the base line on, one per control step; their grip is 1.
  void sample(const Observation& now, double station, std::span<RefPoint> horizon) const;

 private:
  RefPoint at(double s, const PlanPoint& p, double yaw_near) const;
  double sideslip(const PlanPoint& p) const;
  double way_stretch(double s, const PlanPoint& p) const;

  Car car_;
  double dt_;
  const Course* course_;
  bool from_car_speed_, at_own_speed_;
  Sources from_;
  Step step_;
};

}  // namespace gripline::time_optimal
