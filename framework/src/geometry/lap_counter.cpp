#include "geometry/lap_counter.hpp"

#include <algorithm>

namespace gripline {

LapCounter::LapCounter(const Track& track, const Pose& start, double t)
    : track_(track), place_(track.locate(start)), t_(t), x_(start.x), y_(start.y) {
  line_ = track.at(place_.s);
}

/// The place on the stretch that the car was on before, also for a car that slides over the edge onto a neighbouring
/// stretch. Only a car that is more than a whole width off its stretch,
/// and inside the road elsewhere, is taken to have rejoined there.
CurveLocation LapCounter::follow(double x, double y) const {
  const CurveLocation near = track_.locate(x, y, place_.s);
  const double half_width = near.n >= 0.0 ? track_.half_width_left(near.s) : track_.half_width_right(near.s);
  if (track_.beyond_edge(near) <= half_width) return near;
  const CurveLocation nearest = track_.locate(x, y);
  return track_.inside(nearest) ? nearest : near;
}

/// Distance in front of the centre-line normal at the start pose.
double LapCounter::ahead_of_line(double x, double y) const {
  return (x - line_.x) * std::cos(line_.yaw) + (y - line_.y) * std::sin(line_.yaw);
}

std::optional<double> LapCounter::advance(double t, double x, double y) {
  const CurveLocation place = follow(x, y);
  const double before = covered_;
  covered_ += wrap_difference(place.s - place_.s, track_.length());
  std::optional<double> ended;
  const double lap_end = (laps_ + 1) * track_.length();
  if (covered_ >= lap_end) {
    // The normal is crossed between the two positions; if follow()
    // moved the car to a place beyond it, interpolate by station.
    const double from = ahead_of_line(x_, y_), to = ahead_of_line(x, y);
    double share = (lap_end - before) / (covered_ - before);
    if (from <= 0.0 && to >= 0.0 && to > from) share = -from / (to - from);
    ended = t_ + std::clamp(share, 0.0, 1.0) * (t - t_);
    ++laps_;
  }
  place_ = place;
  t_ = t;
  x_ = x;
  y_ = y;
  return ended;
}

}  // namespace gripline
