// Normal equations from rows of a Jacobian that come one by one.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>

namespace gripline::diagnose {

/// Collects weighted rows of the parameter Jacobian and adds J J' to the normal matrix in blocks of rows.
class NormalAccumulator {
 public:
  explicit NormalAccumulator(std::size_t params) : p_(params), rows_(static_cast<Eigen::Index>(params), capacity) {
    N_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(p_), static_cast<Eigen::Index>(p_));
    g_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(p_));
  }
  void add(const double* J, double e, double inverse_S) {
    const double root = std::sqrt(inverse_S);
    double* const row = rows_.data() + static_cast<std::size_t>(used_) * p_;
    for (std::size_t i = 0; i < p_; ++i) row[i] = J[i] * root;
    const double scaled = e * root;
    for (std::size_t i = 0; i < p_; ++i) g_[static_cast<Eigen::Index>(i)] += row[i] * scaled;
    if (++used_ == capacity) flush();
  }
  void flush() {
    if (used_ > 0) N_.selfadjointView<Eigen::Lower>().rankUpdate(rows_.leftCols(used_));
    used_ = 0;
  }
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
