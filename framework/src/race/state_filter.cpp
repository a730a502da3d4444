#include "race/state_filter.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace gripline {
namespace {

constexpr std::array<double State::*, 6> members = {&State::x,  &State::y,  &State::yaw,
                                                    &State::vx, &State::vy, &State::omega};
constexpr double gate = 3.0;  // of an innovation, in its standard deviations

using Covariance = Eigen::Matrix<double, 6, 6>;

}  // namespace

StateFilterSpec read_state_filter(const Node& node, const Car& car, Errors& errors) {
  StateFilterSpec spec;
  ObjectReader r(node, errors);
  ObjectReader sigma = r.object("sigma");
  for (std::size_t i = 0; i < spec.sigma.size(); ++i)
    spec.sigma[i] = sigma.number(sensor_channels[i].name, sensor_channels[i].unit, NumberRange::non_negative(), 0.0);
  sigma.finish();
  constexpr double share = 0.1 * gravity;
  spec.drift = {share, share, share / (car.lf + car.lr)};
  if (r.has("drift")) {
    ObjectReader drift = r.object("drift");
    const std::array<const char*, 3> names = {"vx", "vy", "yaw_rate"}, units = {"m/s2", "m/s2", "rad/s2"};
    for (std::size_t i = 0; i < names.size(); ++i)
      spec.drift[i] = drift.number(names[i], units[i], NumberRange::non_negative(), spec.drift[i]);
    drift.finish();
  }
  r.finish();
  return spec;
}

StateFilter::StateFilter(const StateFilterSpec& spec) : spec_(spec) {}

void StateFilter::start(const State& reading) {
  x_ = reading;
  P_.fill(0.0);
  for (std::size_t i = 0; i < spec_.sigma.size(); ++i) P_[7 * i] = spec_.sigma[i] * spec_.sigma[i];
}

void StateFilter::predict(Prediction& model, const Input& u, const Place& at) {
  const auto n = static_cast<std::size_t>(model.states());
  row_.resize(n);
  next_.resize(n);
  A_.resize(n * n);
  B_.resize(2 * n);
  model.start(x_, row_);
  const double input[] = {u.d, u.ddelta};
  model.step(1, row_, input, std::span(&at, 1), next_, A_, B_);
  for (std::size_t i = 0; i < members.size(); ++i) x_.*members[i] = next_[i];
  const auto stride = Eigen::OuterStride<>(static_cast<Eigen::Index>(n));
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>, 0, Eigen::OuterStride<>> A(A_.data(), stride);
  Eigen::Map<Covariance> P(P_.data());
  const Covariance AP = A * P;
  P.noalias() = AP * A.transpose();
  for (int i = 0; i < 3; ++i) {
    const double drift = spec_.drift[static_cast<std::size_t>(i)] * model.dt();
    P(3 + i, 3 + i) += drift * drift;
  }
}

void StateFilter::update(const State& reading, const ChannelSet& read) {
  Eigen::Map<Covariance> P(P_.data());
  for (int i = 0; i < 6; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!read[at]) continue;
    const double noise = spec_.sigma[at] * spec_.sigma[at], off = reading.*members[at] - x_.*members[at];
    if (off * off > gate * gate * (P(i, i) + noise)) P(i, i) = off * off;
    const double total = P(i, i) + noise;
    if (!(total > 0.0)) {
      x_.*members[at] = reading.*members[at];
      continue;
    }
    const Eigen::Matrix<double, 6, 1> gain = P.col(i) / total;
    for (int j = 0; j < 6; ++j) x_.*members[static_cast<std::size_t>(j)] += gain[j] * off;
    const Eigen::Matrix<double, 1, 6> row = P.row(i);
    P.noalias() -= gain * row;
  }
  x_.delta = reading.delta;
}

}  // namespace gripline
