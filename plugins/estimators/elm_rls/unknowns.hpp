// Where the unknowns lie in theta, and so in a regressor and along both sides of the covariance:
//
//   front tyres [n] | rear tyres [n] | Cr0 | Cd | gain of drive, gain of brakes | arm of drive
//
// The gains are there only where they are learned, and so is the arm. What each is multiplied with: fill_rows() in
// elm_rls.cpp.
#pragma once

#include <Eigen/Core>
#include <gripline/types.hpp>

namespace gripline::elm_rls {

class Unknowns {
 public:
  Unknowns(Eigen::Index per_axle, bool has_gains, bool has_arm)
      : per_axle_(per_axle), has_gains_(has_gains), has_arm_(has_arm) {}

  Eigen::Index count() const { return arm() + (has_arm_ ? 1 : 0); }
  Eigen::Index per_axle() const { return per_axle_; }  // of tyres
  bool has_gains() const { return has_gains_; }
  bool has_arm() const { return has_arm_; }

  Eigen::Index first(Axle axle) const { return axle == Axle::front ? 0 : per_axle_; }
  Eigen::Index Cr0() const { return 2 * per_axle_; }                        // over m g
  Eigen::Index Cd() const { return 2 * per_axle_ + 1; }                     // times v_ref^2 over m g
  Eigen::Index drive_gain() const { return 2 * per_axle_ + 2; }             // relative to the nominal force
  Eigen::Index brake_gain() const { return 2 * per_axle_ + 3; }             // relative to the nominal force
  Eigen::Index arm() const { return drive_gain() + (has_gains_ ? 2 : 0); }  // [m]

  // Parts of a vector over all unknowns.
  template <class Vector>
  auto axle(Axle axle, Vector&& v) const {
    return v.segment(first(axle), per_axle_);
  }
  template <class Vector>
  auto tyres(Vector&& v) const {
    return v.head(2 * per_axle_);
  }
  template <class Vector>
  auto gains_and_arm(Vector&& v) const {
    return v.segment(drive_gain(), count() - drive_gain());
  }

  // Parts of a covariance.
  template <class Matrix>
  auto axles(Axle one, Axle other, Matrix&& m) const {
    return m.block(first(one), first(other), per_axle_, per_axle_);
  }
  template <class Matrix>
  auto all_tyres(Matrix&& m) const {
    return m.topLeftCorner(2 * per_axle_, 2 * per_axle_);
  }

 private:
  Eigen::Index per_axle_;
  bool has_gains_, has_arm_;
};

}  // namespace gripline::elm_rls
