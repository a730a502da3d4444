// Where on a track a car is, as effects see it.
#pragma once

#include <memory>

#include <gripline/interfaces.hpp>

#include "geometry/track.hpp"

namespace gripline::measured {

/// Places along a track: lap fraction by the file's points, slopes, direction.
class Road {
 public:
  explicit Road(std::shared_ptr<const Track> track) : track_(std::move(track)) {}
  /// `hint` is a station nearby or NaN; it is moved to the one found.
  Place at(double t, double x, double y, double yaw, double& hint) const;
  const Track& track() const { return *track_; }

 private:
  std::shared_ptr<const Track> track_;
};

}  // namespace gripline::measured
