// What is believed of the unknowns before the first sample.
//
// Each axle has one of the generic tyres drawn for it (generic_tyres.hpp). Both drive one road: `common` is the share
// of friction's variance that they have in common,
//
//   cov(w_front, w_rear) = common (friction friction_spread / n)^2 1 1^T
//
// for the weights w of n generic tyres per axle. All else is expected to be as the nominal model says: mean 0.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "common/learning/generic_tyres.hpp"
#include "common/learning/hidden_layer.hpp"
#include "common/learning/reduced_layer.hpp"
#include "estimators/elm_rls/parameters.hpp"
#include "estimators/elm_rls/unknowns.hpp"

namespace gripline::elm_rls {

using Tyres = learning::ReducedLayer<learning::GenericTyres>;

inline double expected_friction(const Params& params, double mu_init) {
  return params.friction > 0 ? params.friction : mu_init;
}

/// Tyres of the front and the rear axle, in as many directions as the one needs that needs more.
inline std::array<Tyres, 2> draw_tyres(const Params& params, double friction, std::uint64_t seed) {
  const learning::TyrePrior prior{params.stiffness, params.stiffness_spread, params.shape, params.shape_spread,
                                  friction,         params.friction_spread};
  learning::SplitMix64 random(seed);
  learning::GenericTyres front(params.hidden, prior, random);
  learning::GenericTyres rear(params.hidden, prior, random);
  const learning::CurveDirections of_front(front), of_rear(rear);
  const Eigen::Index count = std::max(of_front.count(), of_rear.count());
  return {Tyres(std::move(front), of_front.leading(count)), Tyres(std::move(rear), of_rear.leading(count))};
}

struct Prior {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

inline Prior make_prior(const std::array<Tyres, 2>& tyres, const Unknowns& unknowns, const Params& params,
                        double friction) {
  constexpr double resistance = 0.1;  // standard deviation of Cr0 and of Cd v_ref^2, over m g
  Prior prior{Eigen::VectorXd::Zero(unknowns.count()), Eigen::MatrixXd::Zero(unknowns.count(), unknowns.count())};
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(params.hidden);
  const std::array<Eigen::VectorXd, 2> all = {tyres[0].reduced(ones), tyres[1].reduced(ones)};  // weights that are 1
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const auto i = static_cast<std::size_t>(axle);
    unknowns.axle(axle, prior.mean) = tyres[i].layer().prior_mean() * all[i];
    unknowns.axles(axle, axle, prior.covariance) = tyres[i].reduced_covariance(tyres[i].layer().prior_covariance());
  }
  const double common = params.common * square(friction * params.friction_spread / params.hidden);
  auto between = unknowns.axles(Axle::front, Axle::rear, prior.covariance);
  between = common * all[0] * all[1].transpose();
  unknowns.axles(Axle::rear, Axle::front, prior.covariance) = between.transpose();
  auto variance = prior.covariance.diagonal();
  variance[unknowns.Cr0()] = variance[unknowns.Cd()] = square(resistance);
  if (unknowns.has_gains()) {
    variance[unknowns.drive_gain()] = square(params.drive_spread);
    variance[unknowns.brake_gain()] = square(params.brake_spread);
  }
  if (unknowns.has_arm()) variance[unknowns.arm()] = square(params.arm_spread);
  return prior;
}

}  // namespace gripline::elm_rls
