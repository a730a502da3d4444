#include "estimators/gp/sliding_gp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gripline::gp {

SlidingGp::SlidingGp(int window) : window_(window), capacity_(window + 1 + window / 3) {
  factor_.setZero(capacity_, capacity_);
  scaled_.setZero(capacity_, inputs);
  target_.setZero(capacity_);
  weight_.setZero(capacity_);
  row_.setZero(capacity_);
}

void SlidingGp::reset(const Kernel& kernel, const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  kernel_ = kernel;
  for (int i = 0; i < inputs; ++i) inverse_length_[i] = 1.0 / kernel.length[i];
  first_ = 0;
  count_ = static_cast<int>(x.rows());
  target_.head(count_) = y;
  auto block = factor_.topLeftCorner(count_, count_);
  for (int i = 0; i < count_; ++i) scaled_.row(i) = x.row(i).cwiseProduct(inverse_length_);
  for (int i = 0; i < count_; ++i) {
    correlate(scaled_.row(i), block.col(i));
    block(i, i) += kernel_.noise;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(block);
  if (in_place.info() != Eigen::Success) throw std::runtime_error("gp: the covariance is not positive definite");
  solve();
}

void SlidingGp::slide(const InputRow& x, double y) {
  if (count_ == window_) drop_oldest();
  if (first_ + count_ == capacity_) make_room();
  append(x, y);
  solve();
}

/// L L^T without its first row and column: the rest gains the first column's outer product. (Golub, Van Loan, 6.5.4.)
void SlidingGp::drop_oldest() {
  const int n = count_ - 1;
  auto w = row_.head(n);
  w = factor_.col(first_).segment(first_ + 1, n);
  ++first_;
  --count_;
  for (int j = 0; j < n; ++j) {
    double* const column = factor_.data() + static_cast<std::ptrdiff_t>(first_ + j) * capacity_ + first_;
    const double diagonal = std::hypot(column[j], w[j]);
    const double c = diagonal / column[j], s = w[j] / column[j], inverse = 1.0 / c;
    column[j] = diagonal;
    double* const rest = w.data();
    for (int i = j + 1; i < n; ++i) {
      column[i] = (column[i] + s * rest[i]) * inverse;
      rest[i] = c * rest[i] - s * column[i];
    }
  }
}

void SlidingGp::append(const InputRow& x, double y) {
  const InputRow scaled = x.cwiseProduct(inverse_length_);
  auto row = row_.head(count_);
  correlate(scaled, row);
  factor_.block(first_, first_, count_, count_).triangularView<Eigen::Lower>().solveInPlace(row);
  const int last = first_ + count_;
  factor_.row(last).segment(first_, count_) = row.transpose();
  const double rest = kernel_.signal + kernel_.constant + kernel_.noise - row.squaredNorm();
  factor_(last, last) = std::sqrt(std::max(rest, 1e-3 * kernel_.noise));
  scaled_.row(last) = scaled;
  target_[last] = y;
  ++count_;
}

/// Moves the window back to the buffer's corner, column by column: the ranges overlap.
void SlidingGp::make_room() {
  for (int j = 0; j < count_; ++j) {
    for (int i = j; i < count_; ++i) factor_(i, j) = factor_(first_ + i, first_ + j);
    target_[j] = target_[first_ + j];
  }
  for (int d = 0; d < inputs; ++d)
    for (int i = 0; i < count_; ++i) scaled_(i, d) = scaled_(first_ + i, d);
  first_ = 0;
}

void SlidingGp::solve() {
  auto weights = weight_.segment(first_, count_);
  weights = target_.segment(first_, count_);
  const auto lower = factor_.block(first_, first_, count_, count_).triangularView<Eigen::Lower>();
  lower.solveInPlace(weights);
  lower.transpose().solveInPlace(weights);
  offset_ = kernel_.constant * weights.sum();
}

namespace {
constexpr int chunk = 64;  // samples at once: their intermediate results stay in the nearest cache
using Chunk = Eigen::Array<double, Eigen::Dynamic, 1, 0, chunk, 1>;
}  // namespace

void SlidingGp::correlate(const InputRow& scaled, Eigen::Ref<Eigen::VectorXd> out) const {
  for (int begin = 0; begin < count_; begin += chunk) {
    const int n = std::min(chunk, count_ - begin);
    Chunk distance = (scaled_.col(0).segment(first_ + begin, n).array() - scaled[0]).square();
    for (int d = 1; d < inputs; ++d)
      distance += (scaled_.col(d).segment(first_ + begin, n).array() - scaled[d]).square();
    out.segment(begin, n).array() = kernel_.signal * (-0.5 * distance).exp() + kernel_.constant;
  }
}

SlidingGp::Mean SlidingGp::mean(const InputRow& x) const {
  const InputRow scaled = x.cwiseProduct(inverse_length_);
  double sum = 0;
  InputRow pull = InputRow::Zero();
  for (int begin = first_; begin < first_ + count_; begin += chunk) {
    const int n = std::min(chunk, first_ + count_ - begin);
    Chunk distance = (scaled_.col(0).segment(begin, n).array() - scaled[0]).square();
    for (int d = 1; d < inputs; ++d) distance += (scaled_.col(d).segment(begin, n).array() - scaled[d]).square();
    const Chunk share = (-0.5 * distance).exp() * weight_.segment(begin, n).array();
    sum += share.sum();
    for (int d = 0; d < inputs; ++d) pull[d] += (share * scaled_.col(d).segment(begin, n).array()).sum();
  }
  Mean mean;
  mean.value = kernel_.signal * sum + offset_;
  mean.gradient = kernel_.signal * (pull - sum * scaled).cwiseProduct(inverse_length_);
  return mean;
}

}  // namespace gripline::gp
