// The normal equations of linear least squares over a sliding window: A = sum w row row^T, b = sum w target row.
//
// A sample's weight shrinks by `retain` with every later sample; after `window` samples it is taken out. Adding and
// taking out are rank-one updates, so a step costs unknowns^2 whatever the window. Rounding errors do not accumulate: a
// second sum is built from additions alone and replaces the first whenever it has seen exactly one window.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gripline::learning {

class WindowGram {
 public:
  WindowGram(Eigen::Index unknowns, int rows, int window, double retain)
      : rows_(rows), window_(window), retain_(retain), expiry_(std::pow(retain, window)) {
    ring_.setZero(unknowns, static_cast<Eigen::Index>(rows) * window);
    ring_target_.setZero(static_cast<Eigen::Index>(rows) * window);
    for (Sum* sum : {&now_, &fresh_}) {
      sum->gram.setZero(unknowns, unknowns);
      sum->moment.setZero(unknowns);
    }
  }

  /// `rows`: one regression row per column; `targets`: as many.
  template <class Rows, class Targets>
  void add(const Rows& rows, const Targets& targets) {
    now_.age(retain_);
    fresh_.age(retain_);
    const Eigen::Index place = static_cast<Eigen::Index>(next_) * rows_;
    for (int i = 0; i < rows_; ++i) {
      auto kept = ring_.col(place + i);
      double& target = ring_target_[place + i];
      if (count_ == window_) now_.add(kept, target, -expiry_);
      kept = rows.col(i);
      target = targets[i];
      now_.add(kept, target, 1.0);
      fresh_.add(kept, target, 1.0);
    }
    if (count_ == window_)
      now_.weight -= expiry_;
    else
      ++count_;
    now_.weight += 1.0;
    fresh_.weight += 1.0;
    next_ = (next_ + 1) % window_;
    if (next_ == 0) {
      std::swap(now_, fresh_);
      fresh_.clear();
    }
  }

  int count() const { return count_; }
  double weight() const { return now_.weight; }
  const Eigen::MatrixXd& gram() const { return now_.gram; }
  const Eigen::VectorXd& moment() const { return now_.moment; }

  /// Weighted sum of squared residuals of `solution`.
  double residual(const Eigen::VectorXd& solution, Eigen::VectorXd& work) const {
    work.noalias() = now_.gram * solution;
    return std::max(0.0, now_.energy - 2.0 * solution.dot(now_.moment) + solution.dot(work));
  }

 private:
  struct Sum {
    Eigen::MatrixXd gram;
    Eigen::VectorXd moment;
    double energy = 0, weight = 0;

    template <class Row>
    void add(const Row& row, double target, double factor) {
      gram.noalias() += (factor * row) * row.transpose();
      moment += factor * target * row;
      energy += factor * target * target;
    }
    void age(double retain) {
      if (retain == 1.0) return;
      gram *= retain;
      moment *= retain;
      energy *= retain;
      weight *= retain;
    }
    void clear() {
      gram.setZero();
      moment.setZero();
      energy = weight = 0;
    }
  };

  int rows_, window_;
  double retain_, expiry_;
  Eigen::MatrixXd ring_;
  Eigen::VectorXd ring_target_;
  Sum now_, fresh_;
  int next_ = 0, count_ = 0;
};

}  // namespace gripline::learning
