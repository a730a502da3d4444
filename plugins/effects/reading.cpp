// Effects of Stage::reading: what sensors show of a state (framework/doc/effects.md).
//
//   vx_scale, vx_bias   reading = (1 + k) vx + b
//   yawrate_bias        reading = omega + b
#include <gripline/plugin.hpp>

namespace {

using gripline::param;
using gripline::Place;
using gripline::Reading;

class VxScale final : public gripline::AutoDiffReading<VxScale> {
 public:
  template <class T>
  struct Params {
    T k = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{
        param("k", &Params<double>::k, "1", {-0.5, 0.5}, "relative error of the speed").fit(0, 0.01, 0.02)};
  }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    r.vx *= k.k + 1.0;
  }
};

class VxBias final : public gripline::AutoDiffReading<VxBias> {
 public:
  template <class T>
  struct Params {
    T b = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("b", &Params<double>::b, "m/s", {-10, 10}, "offset of the speed").fit(0, 0.02, 0.05)};
  }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    r.vx += k.b;
  }
};

class YawrateBias final : public gripline::AutoDiffReading<YawrateBias> {
 public:
  template <class T>
  struct Params {
    T b = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("b", &Params<double>::b, "rad/s", {-5, 5}, "offset of the yaw rate").fit(0, 0.01, 0.02)};
  }
  template <class T>
  void sense(Reading<T>& r, const Place&, const Params<T>& k) const {
    r.omega += k.b;
  }
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<VxScale>("vx_scale", "1.0", "scale error of the speed sensor")
                     .advice("two straights at constant speeds a factor of two apart")
                     .precedence(10),
                 gripline::describe<VxBias>("vx_bias", "1.0", "bias of the speed sensor")
                     .advice("two straights at constant speeds a factor of two apart")
                     .precedence(20),
                 gripline::describe<YawrateBias>("yawrate_bias", "1.0", "bias of the yaw-rate sensor").precedence(30))
