// A primal-dual interior-point method with Mehrotra's predictor and corrector.
//
// Every finite bound is an inequality c z - eps + t = b with t >= 0 and multiplier l >= 0, t l -> 0; a hard one has no eps.
// The slack of a soft one satisfies 2 S eps + s - l - n = 0, eps n -> 0; with s = 0 that is eps = l / 2S and n = 0. So in a
// Newton step every eps is rho l + e, and the step's row term follows from t, l, rho, e alone:
//   weight w = l / (t + rho l),   multiplier after the step l+ = w (c z+ - b - e + t) + r / (t + rho l),
// where r is the complementarity aimed at. The equality constraints hold exactly at z+.
#pragma once

#include "controllers/mpc_sqp/active_set.hpp"

namespace gripline::ocp {

class InteriorPoint {
 public:
  InteriorPoint(int horizon, int states);

  /// Starts near the point's z.
  void start(const OcpQp& qp, Riccati& riccati, Point& point);
  enum class State { suggests, converged, failed };
  /// Goes on until the active set seems to be known, or until of every pair the distance or the multiplier is below
  /// `tolerance` in the row's units and infeasibility has shrunk to that share of what it was. May be called again after a suggestion that led nowhere.
  State iterate(const OcpQp& qp, Riccati& riccati, Point& point, double tolerance, int iterations);
  int iterations() const { return iterations_; }
  /// The sides that the rows tend to, with multipliers.
  void suggestion(Point& point) const;
  /// The iterate itself, and its multipliers.
  void solution(Point& point) const;

 private:
  /// Aims every pair at complementarity `target`, less `second_order` times the product of the predictor's steps.
  void set_terms(double target, double second_order);
  void set_slack_terms(double target, double second_order);
  void set_candidate(const Point& point);
  bool solve(const OcpQp& qp, Riccati& riccati, Point& point, double target, double second_order);
  bool sides_repeat();
  void set_bounds(const OcpQp& qp, Point& point);
  double set_pairs(const Point& point);
  double worst_pair() const;
  State stalled() const;
  double step_length() const;
  double complementarity(double step) const;
  void advance(const Point& point, double step);

  Point iterate_;
  RowTerms terms_;
  // Per stage the four lower bounds, then the four upper ones. A bound that is not there has c = 0, t = l = 1, w = 0.
  Buffer sign_, bound_;                 // c: -1 lower, +1 upper; b
  Buffer width_, force_;                // units of a distance and of a multiplier
  Buffer t_, l_, t_next_, l_next_;      // distance and multiplier, at the iterate and after a full step
  Buffer rho_, e_;                      // eps = rho l + e
  Buffer eps_, n_, eps_next_, n_next_;  // of soft bounds, if their penalty has a linear part
  Buffer w_, g_;                        // multiplier after a full step: w c z+ + g
  std::vector<Side> side_;              // where the last predictor moved the rows
  int horizon_, pairs_ = 0, iterations_ = 0;
  double soft_quadratic_ = 1, soft_linear_ = 0;
  bool suggested_ = false;
  bool kinked_ = false;  // the soft penalty has a linear part
  double complementarity_ = 0, infeasibility_ = 1;
};

}  // namespace gripline::ocp
