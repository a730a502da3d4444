// A primal-dual interior-point method with Mehrotra's predictor and corrector.
//
// Every finite bound is an inequality c v - s + t = d with distance t >= 0 and multiplier lam >= 0, t lam -> 0, where c
// is +1 for an upper and -1 for a lower bound; a hard one has no slack s. The slack of a soft one satisfies Z s + z -
// lam - nu = 0, s nu -> 0; with z = 0 that is s = lam / Z and nu = 0. So in a Newton step every slack is rho lam +
// sigma, and the term that the step gets along the constraint follows from t, lam, rho, sigma alone:
//   Gamma = lam / (t + rho lam),   lam+ = Gamma (c v+ - d - sigma + t) + m / (t + rho lam),
// where m is the complementarity aimed at. The equality constraints hold exactly at the step's end.
// Source: Mehrotra (1992), "On the implementation of a primal-dual interior point method"; Wright (1997), "Primal-dual
// interior-point methods".
#pragma once

#include <vector>

#include "controllers/mpc_sqp/active_set.hpp"

namespace gripline::mpc_sqp {

class InteriorPoint {
 public:
  InteriorPoint(int N, int nx);

  /// Starts near the point's ux.
  void start(const OcpQp& qp, Riccati& riccati, QpPoint& point);
  enum class Status { active_set_repeats, converged, failed };
  /// Goes on until the active set seems to be known, or until of every pair t, lam one is below `tolerance` in the
  /// constraint's units and infeasibility has shrunk to that share of what it was. May be called again after an active
  /// set that turned out to be wrong.
  Status iterate(const OcpQp& qp, Riccati& riccati, QpPoint& point, double tolerance, int iterations);
  int iterations() const { return iterations_; }
  /// The active set that the constraints tend to, with multipliers.
  void get_active_set(QpPoint& point) const;
  /// The iterate itself, and its multipliers.
  void get_solution(QpPoint& point) const;

 private:
  /// Aims every pair at complementarity `target`, less `second_order` times the product of the predictor's steps.
  void set_terms(double target, double second_order);
  void set_slack_terms(double target, double second_order);
  void set_full_step(const QpPoint& point);
  bool solve(const OcpQp& qp, Riccati& riccati, QpPoint& point, double target, double second_order);
  bool active_set_repeats();
  void set_bounds(const OcpQp& qp, QpPoint& point);
  double set_pairs(const QpPoint& point);
  void set_soft_pairs(double mu);
  void shift_inside();
  double worst_pair() const;
  Status stalled() const;
  double step_length() const;
  double mean_complementarity(double alpha) const;
  void advance(const QpPoint& point, double alpha);

  // Per stage the four lower bounds, then the four upper ones. A bound that is not there has c = 0, t = lam = 1, Gamma
  // = 0.
  struct Bounds {
    Buffer c, d;
    Buffer t_unit, lam_unit;  // units of a distance and of a multiplier
  };
  struct Pairs {
    Buffer t, lam;  // distances and multipliers
    Buffer s, nu;   // of soft bounds with z > 0: slacks and their multipliers
  };
  /// A Newton step in terms of the constraints' values.
  struct StepTerms {
    Buffer rho, sigma;     // s = rho lam + sigma
    Buffer Gamma, offset;  // lam+ = Gamma c v+ + offset
  };

  QpPoint iterate_;
  ConstraintTerms terms_;
  Bounds bounds_;
  Pairs now_, next_;  // at the iterate and after a full step
  StepTerms step_;
  std::vector<BoundStatus> last_status_;  // to which the last predictor moved the constraints
  int N_, pairs_ = 0, iterations_ = 0;
  double Z_ = 2, z_ = 0;
  bool repeated_ = false;
  double mu_ = 0, infeasibility_ = 1;  // mean complementarity; share of the first residual of the inequalities
};

}  // namespace gripline::mpc_sqp
