#include "measured/log/road.hpp"

#include <cmath>

#include "geometry/course_adapter.hpp"

namespace gripline::measured {

Place Road::at(double t, double x, double y, double yaw, double& hint) const {
  const CurveLocation found = std::isnan(hint) ? track_->locate(Pose{x, y, yaw}) : track_->locate(x, y, hint);
  hint = found.s;
  return place_of(*track_, found, t, x, y, yaw);
}

}  // namespace gripline::measured
