// A Gaussian process over the last `window` samples, slid by one sample at O(window^2).
//
// The lower Cholesky factor of the covariance moves along the diagonal of a larger buffer: the oldest sample leaves by
// a rank-one update of what remains (a positive one, hence stable), the newest enters as one more row.
#pragma once

#include <Eigen/Core>

#include "estimators/gp/kernel.hpp"

namespace gripline::gp {

class SlidingGp {
 public:
  explicit SlidingGp(int window);

  /// Starts over with this kernel and these samples (rows of standardised inputs; standardised targets). Costs rows^3.
  void reset(const Kernel& kernel, const Eigen::MatrixXd& x, const Eigen::VectorXd& y);
  /// Slides the window by one sample. Allocates nothing.
  void slide(const InputRow& x, double y);

  struct Mean {
    double value;
    InputRow gradient;
  };
  /// Mean and its gradient by the (standardised) inputs. Reentrant; allocates nothing.
  Mean mean(const InputRow& x) const;
  /// Mean at sample i of the window, oldest first: the target freed of its noise.
  double mean_at_sample(int i) const { return target_[first_ + i] - kernel_.noise * weight_[first_ + i]; }

  int count() const { return count_; }
  const Kernel& kernel() const { return kernel_; }

 private:
  void drop_oldest();
  void append(const InputRow& x, double y);
  void make_room();
  void solve();
  /// Covariance between x (scaled) and every sample, without noise.
  void correlate(const InputRow& scaled, Eigen::Ref<Eigen::VectorXd> out) const;

  int window_, capacity_;
  int first_ = 0, count_ = 0;
  Kernel kernel_;
  InputRow inverse_length_ = InputRow::Ones();
  Eigen::MatrixXd factor_;  // capacity x capacity, the window's block on the diagonal
  Eigen::MatrixXd scaled_;  // capacity x inputs, inputs over lengths
  Eigen::VectorXd target_, weight_, row_;
  double offset_ = 0;  // the constant's part of the mean
};

}  // namespace gripline::gp
