// The lateral force of a tyre or axle over its slip angle: D sin(C atan(B slip)).
// Source: Bakker, Nyborg, Pacejka (1987), "Tyre modelling for use in vehicle dynamics studies", with E = 0.
#pragma once

#include <cmath>
#include <limits>

namespace gripline::vehicle {

/// Stiffness factor B [1/rad], shape factor C [-], and the peak D, in the unit of the force.
struct MagicFormula {
  double B = 3, C = 1.3, D = 5;

  /// At a slip angle [rad]; T is double or a type of automatic differentiation.
  template <class T>
  T force(const T& slip) const {
    using std::atan, std::sin;
    return D * sin(C * atan(B * slip));
  }
  /// The slip angle up to the peak that gives `force`; infinite from the peak on.
  double slip(double force) const {
    if (!(force < D)) return std::numeric_limits<double>::infinity();
    return std::tan(std::asin(force / D) / C) / B;
  }
};

/// The curves of both axles.
struct AxleTyres {
  MagicFormula front, rear;
};

}  // namespace gripline::vehicle
