// The road as stacks see it: a Track behind the SDK's Course.
#pragma once

#include <gripline/interfaces.hpp>

#include "geometry/track.hpp"

namespace gripline {

class TrackCourse final : public Course {
 public:
  TrackCourse(const Track& track, const Car& car) : track_(track), car_(car) {}
  double length() const noexcept override { return track_.length(); }
  CoursePoint at(double s) const override;
  CoursePoint locate(double x, double y, double hint_s) const override;
  void minimum_curvature(const LineOptions& options, std::span<LinePoint> line) const override;

 private:
  CoursePoint fill(double s, double n) const;
  const Track& track_;
  Car car_;
};

/// Place of a car; grade and bank along its direction of travel: against the order of the file they change sign.
Place place_of(const Track& track, const CurveLocation& location, double t, double x, double y, double yaw);

}  // namespace gripline
