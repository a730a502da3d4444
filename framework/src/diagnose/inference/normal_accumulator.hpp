// Normal equations from rows of a Jacobian that come one by one.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>

namespace gripline::diagnose {

/// Normal matrix N = sum J J' / S and gradient g = sum J e / S over scalar readings with innovation e of variance S,
/// J the derivatives of the prediction by `params` parameters. Rows are collected and enter N a block at a time.
class NormalAccumulator {
 public:
  explicit NormalAccumulator(std::size_t params) : p_(params), rows_(static_cast<Eigen::Index>(params), capacity) {
    N_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(p_), static_cast<Eigen::Index>(p_));
    g_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(p_));
  }
  /// J: params numbers.
  void add(const double* J, double e, double inverse_S) {
    const double root = std::sqrt(inverse_S);
    double* const row = rows_.data() + static_cast<std::size_t>(used_) * p_;
    for (std::size_t i = 0; i < p_; ++i) row[i] = J[i] * root;
    const double scaled = e * root;
    for (std::size_t i = 0; i < p_; ++i) g_[static_cast<Eigen::Index>(i)] += row[i] * scaled;
    if (++used_ == capacity) flush();
  }
  /// Brings the rows collected into N: to be called before N() is read.
  void flush() {
    if (used_ > 0) N_.selfadjointView<Eigen::Lower>().rankUpdate(rows_.leftCols(used_));
    used_ = 0;
  }
  /// Its lower triangle only.
  const Eigen::MatrixXd& N() const { return N_; }
  const Eigen::VectorXd& g() const { return g_; }

 private:
  static constexpr Eigen::Index capacity = 256;
  std::size_t p_;
  Eigen::MatrixXd rows_;
  Eigen::MatrixXd N_;
  Eigen::VectorXd g_;
  Eigen::Index used_ = 0;
};

}  // namespace gripline::diagnose
