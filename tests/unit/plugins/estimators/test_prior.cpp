#include "estimators/elm_rls/prior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace gripline::elm_rls {
namespace test_prior {

TEST(Unknowns, EachHasAPlaceOfItsOwn) {
  for (const bool gains : {false, true})
    for (const bool arm : {false, true}) {
      const Unknowns u(5, gains, arm);
      std::set<Eigen::Index> places;
      for (Eigen::Index i = 0; i < u.per_axle(); ++i)
        places.insert({u.first(Axle::front) + i, u.first(Axle::rear) + i});
      places.insert({u.Cr0(), u.Cd()});
      if (gains) places.insert({u.drive_gain(), u.brake_gain()});
      if (arm) places.insert(u.arm());
      EXPECT_EQ(u.count(), 12 + (gains ? 2 : 0) + (arm ? 1 : 0));
      EXPECT_EQ(static_cast<Eigen::Index>(places.size()), u.count());
      EXPECT_EQ(*places.rbegin(), u.count() - 1);
    }
}

TEST(Unknowns, PartsAreWhatTheySay) {
  const Unknowns u(2, true, true);
  Eigen::VectorXd v = Eigen::VectorXd::LinSpaced(u.count(), 0, static_cast<double>(u.count() - 1));
  EXPECT_EQ(u.axle(Axle::rear, v), Eigen::Vector2d(2, 3));
  EXPECT_EQ(u.tyres(v), Eigen::Vector4d(0, 1, 2, 3));
  EXPECT_EQ(u.gains_and_arm(v), Eigen::Vector3d(6, 7, 8));
  u.axle(Axle::front, v).setZero();
  EXPECT_EQ(v[1], 0);
  EXPECT_EQ(v[2], 2);
  EXPECT_EQ(Unknowns(2, false, false).gains_and_arm(v).size(), 0);
}

/// Mean and variance of both axles' force over load at a slip, and their covariance.
struct Forces {
  double front, rear, front_variance, rear_variance, covariance;
};
Forces forces_at(double slip, const Params& params, double friction) {
  const auto tyres = draw_tyres(params, friction, 1);
  const Unknowns u(tyres[0].nodes(), params.learns_gains(), params.learns_arm());
  const Prior prior = make_prior(tyres, u, params, friction);
  Eigen::VectorXd front = Eigen::VectorXd::Zero(u.count()), rear = front;
  const auto n = static_cast<std::size_t>(u.per_axle());
  tyres[0].add(slip, 1.0, {u.axle(Axle::front, front).data(), n});
  tyres[1].add(slip, 1.0, {u.axle(Axle::rear, rear).data(), n});
  return {front.dot(prior.mean), rear.dot(prior.mean), front.dot(prior.covariance * front),
          rear.dot(prior.covariance * rear), front.dot(prior.covariance * rear)};
}

// Near the peak of most generic tyres.
TEST(Prior, ForcesAreThoseOfGenericTyresAtTheFrictionThatIsExpected) {
  const Forces forces = forces_at(0.4, {}, 1.3);
  for (const double mean : {forces.front, forces.rear}) EXPECT_NEAR(mean, 0.95 * 1.3, 0.05 * 1.3);
  for (const double variance : {forces.front_variance, forces.rear_variance})
    EXPECT_NEAR(std::sqrt(variance), 0.3 * 1.3, 0.05 * 1.3);
}

TEST(Prior, AxlesHaveTheShareOfFrictionsVarianceInCommonThatIsTold) {
  EXPECT_EQ(forces_at(0.4, {}, 1.0).covariance, 0.0);
  Params params;
  params.common = 0.9;
  const Forces forces = forces_at(0.4, params, 1.0);
  EXPECT_NEAR(forces.covariance, 0.9 * 0.09 * forces.front * forces.rear, 1e-6);
}

TEST(Prior, StandardDeviationsOfTheOthersAreAsTold) {
  Params params;
  params.drive_spread = 0.2;
  params.brake_spread = 0.3;
  params.arm_spread = 0.4;
  const auto tyres = draw_tyres(params, 1.0, 1);
  const Unknowns u(tyres[0].nodes(), params.learns_gains(), params.learns_arm());
  const Prior prior = make_prior(tyres, u, params, 1.0);
  const auto deviation = [&](Eigen::Index i) { return std::sqrt(prior.covariance(i, i)); };
  EXPECT_NEAR(deviation(u.Cr0()), 0.1, 1e-12);
  EXPECT_NEAR(deviation(u.Cd()), 0.1, 1e-12);
  EXPECT_NEAR(deviation(u.drive_gain()), 0.2, 1e-12);
  EXPECT_NEAR(deviation(u.brake_gain()), 0.3, 1e-12);
  EXPECT_NEAR(deviation(u.arm()), 0.4, 1e-12);
  EXPECT_EQ(prior.mean[u.Cr0()], 0.0);
  EXPECT_TRUE(prior.covariance.isApprox(prior.covariance.transpose(), 1e-12));
}

}  // namespace test_prior
}  // namespace gripline::elm_rls
