// What is left of the delays of a pose that were taken off a log: a model's reading that is a little late.
#pragma once

#include <gripline/plugin.hpp>
#include <tuple>

namespace gripline::diagnose {

/// Place and heading are shown as they were a moment ago, to first order in that time; negative: they are early.
///
///   x -= place (vx cos(yaw) - vy sin(yaw)),  y -= place (vx sin(yaw) + vy cos(yaw)),  yaw -= heading omega
class PoseLatency final : public AutoDiffReading<PoseLatency> {
 public:
  template <class T>
  struct Params {
    T place = T(0), heading = T(0);  // [s]
  };
  static constexpr auto parameters() {
    return std::tuple{param("place", &Params<double>::place, "s", {-1, 1}, "by which the place is late"),
                      param("heading", &Params<double>::heading, "s", {-1, 1}, "by which the heading is late")};
  }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    using std::cos;
    using std::sin;
    const T c = cos(r.yaw), s = sin(r.yaw);
    r.x -= k.place * (r.vx * c - r.vy * s);
    r.y -= k.place * (r.vx * s + r.vy * c);
    r.yaw -= k.heading * r.omega;
  }
};

}  // namespace gripline::diagnose
