// Friction as it acts on a vehicle model: an effect of the tyre stage that comes before the car's own.
#pragma once

#include <gripline/plugin.hpp>

namespace gripline {

/// The world's friction factor as a change of the tyre stage: both peaks times the factor.
class FrictionFactor final : public AutoDiffEffect<FrictionFactor> {
 public:
  template <class T>
  struct Params {
    T factor = T(1);
  };
  static constexpr auto parameters() {
    return std::tuple{param("factor", &Params<double>::factor, "1", {0, 10}, "multiplies both axles' peak force")};
  }
  Stage stage() const noexcept override { return Stage::tyre; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.peak_front *= k.factor;
    p.q.peak_rear *= k.factor;
  }
};

}  // namespace gripline
