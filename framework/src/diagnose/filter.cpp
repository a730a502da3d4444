// One reading after the other (the sensors are independent), so nothing is inverted:
//
//   e = y - h - H z,  S = H P H' + r,  K = P H' / S,  z += K e,  P -= K S K',   cost = sum (e^2 / S + log S) / 2.
//
// The derivative J of the predicted reading by the parameters obeys the same recursion with the same gains
// (dz -= K J); how the gains themselves depend on parameters is left out, as in Gauss-Newton. Smoothing follows Bryson
// and Frazier: the adjoint of the filter, without inverses.
#include "filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace gripline::diagnose {
namespace {

constexpr double diffuse = 300.0;  // standard deviations of a sensor in which the start is unknown

/// Collects weighted rows of the parameter Jacobian and adds J J' to the normal matrix in blocks of rows.
class Normal {
 public:
  explicit Normal(std::size_t params) : p_(params), rows_(static_cast<Eigen::Index>(params), capacity) {
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
  void clear() {
    N_.setZero();
    g_.setZero();
  }

 private:
  static constexpr Eigen::Index capacity = 256;
  std::size_t p_;
  Eigen::MatrixXd rows_;
  Eigen::MatrixXd N_;
  Eigen::VectorXd g_;
  Eigen::Index used_ = 0;
};

/// What the adjoint needs of one reading.
struct Update {
  std::size_t k, channel;
  double e, S;
};

template <std::size_t N>
class Pass {
 public:
  Pass(const LinearModel& model, const Noise& noise, const FilterWants& wants)
      : lm_(model),
        noise_(noise),
        wants_(wants),
        params_(wants.directions != nullptr ? wants.directions->size() : 0),
        normal_(params_) {}

  Likelihood run() {
    start();
    for (std::size_t k = 0; k < lm_.n; ++k) {
      if (wants_.restart > 0 && k > 0 && k % wants_.restart == 0) forget();
      if (wants_.smooth) keep(k);
      update(k);
      if (wants_.block > 0 && ((k + 1) % wants_.block == 0 || k + 1 == lm_.n)) end_block();
      if (k + 1 < lm_.n) predict(k);
    }
    finish();
    if (wants_.smooth) smooth();
    return std::move(out_);
  }

 private:
  using Matrix = std::array<double, N * N>;
  using Vector = std::array<double, N>;

  void start() {
    P_.fill(0.0);
    z_.fill(0.0);
    for (std::size_t c = 0; c < channels; ++c) {
      const double s = diffuse * noise_.sensor[c];
      P_[c * N + c] = s * s;
    }
    for (std::size_t i = 0; i < noise_states; ++i) {
      const std::size_t a = N - noise_states + i;
      P_[a * N + a] = noise_.process[i];
      if (!wants_.process_slope) continue;
      dP_[i].fill(0.0);
      dz_[i].fill(0.0);
      dP_[i][a * N + a] = 1.0;
    }
    dtheta_.assign(N * params_, 0.0);
    next_.assign(N * params_, 0.0);
    J_.assign(params_, 0.0);
    if (wants_.smooth) {
      kept_P_.resize(lm_.n * N * N);
      kept_z_.resize(lm_.n * N);
      updates_.reserve(lm_.n * channels);
    }
  }

  /// A new window with a free start. The directions' past is forgotten too.
  void forget() {
    P_.fill(0.0);
    z_.fill(0.0);
    for (std::size_t c = 0; c < channels; ++c) P_[c * N + c] = std::pow(diffuse * noise_.sensor[c], 2);
    for (std::size_t i = 0; i < noise_states; ++i) P_[(N - noise_states + i) * (N + 1)] = noise_.process[i];
    std::fill(dtheta_.begin(), dtheta_.end(), 0.0);
  }

  void keep(std::size_t k) {
    std::copy(P_.begin(), P_.end(), kept_P_.begin() + static_cast<std::ptrdiff_t>(k * N * N));
    std::copy(z_.begin(), z_.end(), kept_z_.begin() + static_cast<std::ptrdiff_t>(k * N));
  }

  void update(std::size_t k) {
    for (std::size_t c = 0; c < channels; ++c) {
      const double raw = lm_.innovation[k * channels + c];
      if (std::isnan(raw)) continue;
      if (lm_.H.empty())
        scalar<true>(k, c, raw, nullptr);
      else
        scalar<false>(k, c, raw, lm_.H.data() + (k * channels + c) * channels);
    }
  }

  /// H v of a vector with stride: the plain case picks one element.
  template <bool plain>
  static double row(const double* v, std::size_t stride, std::size_t c, const double* h) {
    if constexpr (plain) return v[c * stride];
    double sum = 0.0;
    for (std::size_t j = 0; j < channels; ++j) sum += h[j] * v[j * stride];
    return sum;
  }

  template <bool plain>
  void scalar(std::size_t k, std::size_t c, double raw, const double* h) {
    Vector PH, K;
    for (std::size_t i = 0; i < N; ++i) PH[i] = row<plain>(P_.data() + i * N, 1, c, h);
    const double r = noise_.sensor[c] * noise_.sensor[c];
    const double S = row<plain>(PH.data(), 1, c, h) + r;
    const double inverse = 1.0 / S;
    const double e = raw - row<plain>(z_.data(), 1, c, h);
    for (std::size_t i = 0; i < N; ++i) K[i] = PH[i] * inverse;
    out_.cost += 0.5 * (e * e * inverse + std::log(S * (1.0 / r)));
    ++out_.rows;
    if (wants_.process_slope) slope_update<plain>(c, h, K, e, S);
    if (params_ > 0) {
      param_row<plain>(k, c, h);
      normal_.add(J_.data(), e, inverse);
      for (std::size_t i = 0; i < N; ++i) {
        double* const d = dtheta_.data() + i * params_;
        const double gain = K[i];
        if (gain == 0.0) continue;
        for (std::size_t p = 0; p < params_; ++p) d[p] -= gain * J_[p];
      }
    }
    for (std::size_t i = 0; i < N; ++i) {
      z_[i] += K[i] * e;
      for (std::size_t j = 0; j < N; ++j) P_[i * N + j] -= K[i] * PH[j];
    }
    if (wants_.smooth) updates_.push_back({k, c, e, S});
    if (wants_.smooth) gains_.insert(gains_.end(), K.begin(), K.end());
  }

  template <bool plain>
  void param_row(std::size_t k, std::size_t c, const double* h) {
    if constexpr (plain) {
      std::copy_n(dtheta_.begin() + static_cast<std::ptrdiff_t>(c * params_), params_, J_.begin());
    } else {
      std::fill(J_.begin(), J_.end(), 0.0);
      for (std::size_t j = 0; j < channels; ++j)
        if (h[j] != 0.0)
          for (std::size_t p = 0; p < params_; ++p) J_[p] += h[j] * dtheta_[j * params_ + p];
    }
    for (const std::size_t p : readers_) J_[p] += (*wants_.directions)[p]->reading[k * channels + c];
  }

  template <bool plain>
  void slope_update(std::size_t c, const double* h, const Vector& K, double e, double S) {
    std::array<double, noise_states> dS{}, de{};
    std::array<Vector, noise_states> dPH;
    for (std::size_t i = 0; i < noise_states; ++i) {
      for (std::size_t r = 0; r < N; ++r) dPH[i][r] = row<plain>(dP_[i].data() + r * N, 1, c, h);
      dS[i] = row<plain>(dPH[i].data(), 1, c, h);
      de[i] = -row<plain>(dz_[i].data(), 1, c, h);
    }
    for (std::size_t i = 0; i < noise_states; ++i) {
      out_.slope[i] += 0.5 * (dS[i] / S - e * e * dS[i] / (S * S) + 2.0 * e * de[i] / S);
      for (std::size_t j = 0; j < noise_states; ++j)
        out_.information[i][j] += 0.5 * dS[i] * dS[j] / (S * S) + de[i] * de[j] / S;
      // With the best gain dP becomes (I - K H) dP (I - K H)'.
      Vector half;
      for (std::size_t r = 0; r < N; ++r) {
        half[r] = dPH[i][r] - 0.5 * dS[i] * K[r];
        dz_[i][r] += (dPH[i][r] - K[r] * dS[i]) / S * e + K[r] * de[i];
      }
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t q = 0; q < N; ++q) dP_[i][r * N + q] -= K[r] * half[q] + half[r] * K[q];
    }
  }

  void predict(std::size_t k) {
    const double* const F = lm_.F.data() + k * N * N;
    Vector z{};
    for (std::size_t i = 0; i < N; ++i) {
      double sum = i < N - noise_states ? lm_.offset[k * (N - noise_states) + i] : 0.0;
      for (std::size_t j = 0; j < N; ++j) sum += F[i * N + j] * z_[j];
      z[i] = sum;
    }
    z_ = z;
    Matrix across;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j) across[j * N + i] = F[i * N + j];
    propagate(F, across.data(), P_);
    const double growth = 1.0 - std::exp(-2.0 * lm_.dt / noise_time);
    for (std::size_t i = 0; i < noise_states; ++i) {
      const std::size_t a = N - noise_states + i;
      P_[a * N + a] += growth * noise_.process[i];
      if (!wants_.process_slope) continue;
      Vector dz{};
      for (std::size_t r = 0; r < N; ++r)
        for (std::size_t q = 0; q < N; ++q) dz[r] += F[r * N + q] * dz_[i][q];
      dz_[i] = dz;
      propagate(F, across.data(), dP_[i]);
      dP_[i][a * N + a] += growth;
    }
    if (k < lm_.guessed.size() && lm_.guessed[k]) jolt();
    if (params_ > 0) predict_params(k, F);
  }

  /// A command that was not recorded may have been anything between its neighbours or beyond: speeds are not known
  /// afterwards as they would be. A quick move of the steering for 20 ms is worth some twenty deviations of a gyroscope.
  void jolt() {
    constexpr double size = 20.0;
    for (std::size_t c = 3; c < channels; ++c) P_[c * N + c] += std::pow(size * noise_.sensor[c], 2);
  }

  /// P = F P F'. Nothing depends on x and y, the unknown accelerations only on themselves. `across` is F transposed, so
  /// that both products run along rows.
  static void propagate(const double* F, const double* across, Matrix& P) {
    constexpr std::size_t body = N - noise_states;
    Matrix T;
    for (std::size_t i = 0; i < N; ++i) {
      Vector sum{};
      if (i < 2) std::copy_n(P.data() + i * N, N, sum.begin());
      const std::size_t first = i < body ? 2 : i, last = i < body ? N : i + 1;
      for (std::size_t l = first; l < last; ++l) {
        const double f = F[i * N + l];
        for (std::size_t j = 0; j < N; ++j) sum[j] += f * P[l * N + j];
      }
      std::copy_n(sum.begin(), N, T.data() + i * N);
    }
    for (std::size_t i = 0; i < N; ++i) {
      Vector sum{};
      for (std::size_t l = 2; l < N; ++l) {
        const double t = T[i * N + l];
        for (std::size_t j = 0; j < N; ++j) sum[j] += t * across[l * N + j];
      }
      sum[0] += T[i * N];
      sum[1] += T[i * N + 1];
      for (std::size_t j = i; j < N; ++j) P[i * N + j] = sum[j];
    }
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < i; ++j) P[i * N + j] = P[j * N + i];
  }

  void predict_params(std::size_t k, const double* F) {
    for (std::size_t i = 0; i < N; ++i) {
      double* const to = next_.data() + i * params_;
      std::fill_n(to, params_, 0.0);
      for (std::size_t l = 0; l < N; ++l) {
        const double f = F[i * N + l];
        if (f == 0.0) continue;
        const double* const from = dtheta_.data() + l * params_;
        for (std::size_t p = 0; p < params_; ++p) to[p] += f * from[p];
      }
    }
    dtheta_.swap(next_);
    const double* const in0 = lm_.input0.data() + k * N * 3;
    const double* const in1 = lm_.input1.data() + k * N * 3;
    for (const std::size_t p : movers_) {
      const double* const b0 = (*wants_.directions)[p]->rate.data() + k * 3;
      const double* const b1 = b0 + 3;
      for (std::size_t i = 0; i < N; ++i) {
        double sum = 0.0;
        for (std::size_t c = 0; c < 3; ++c) sum += in0[i * 3 + c] * b0[c] + in1[i * 3 + c] * b1[c];
        dtheta_[i * params_ + p] += sum;
      }
    }
  }

  void end_block() {
    normal_.flush();
    const auto n = static_cast<Eigen::Index>(params_);
    const Eigen::MatrixXd full = normal_.N().selfadjointView<Eigen::Lower>();
    out_.block_N.insert(out_.block_N.end(), full.data(), full.data() + n * n);
    out_.block_g.insert(out_.block_g.end(), normal_.g().data(), normal_.g().data() + n);
    out_.block_cost.push_back(out_.cost - cost_before_);
    cost_before_ = out_.cost;
    ++out_.blocks;
    total_N_ = total_N_.size() == 0 ? full : Eigen::MatrixXd(total_N_ + full);
    total_g_ = total_g_.size() == 0 ? normal_.g() : Eigen::VectorXd(total_g_ + normal_.g());
    normal_.clear();
  }

  void finish() {
    out_.params = params_;
    if (params_ == 0) return;
    normal_.flush();
    Eigen::MatrixXd full = normal_.N().selfadjointView<Eigen::Lower>();
    Eigen::VectorXd g = normal_.g();
    if (wants_.block > 0) {
      full = total_N_;
      g = total_g_;
    }
    out_.N.assign(full.data(), full.data() + full.size());
    out_.g.assign(g.data(), g.data() + g.size());
  }

  /// x_s = x_f + P_f lambda with lambda running backwards through updates and predictions.
  void smooth() {
    out_.smoothed.resize(lm_.n * N);
    Vector lambda{};
    std::size_t u = updates_.size();
    for (std::size_t k = lm_.n; k-- > 0;) {
      while (u > 0 && updates_[u - 1].k == k) {
        --u;
        const Update& one = updates_[u];
        const double* const K = gains_.data() + u * N;
        double along = 0.0;
        for (std::size_t i = 0; i < N; ++i) along += K[i] * lambda[i];
        const double push = one.e / one.S - along;
        if (lm_.H.empty()) {
          lambda[one.channel] += push;
        } else {
          const double* const h = lm_.H.data() + (k * channels + one.channel) * channels;
          for (std::size_t j = 0; j < channels; ++j) lambda[j] += h[j] * push;
        }
      }
      for (std::size_t i = 0; i < N; ++i) {
        double sum = kept_z_[k * N + i];
        for (std::size_t j = 0; j < N; ++j) sum += kept_P_[(k * N + i) * N + j] * lambda[j];
        out_.smoothed[k * N + i] = sum;
      }
      if (k == 0) break;
      const double* const F = lm_.F.data() + (k - 1) * N * N;
      Vector back{};
      for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j) back[j] += F[i * N + j] * lambda[i];
      lambda = back;
    }
  }

 public:
  void sort_directions() {
    for (std::size_t p = 0; p < params_; ++p) {
      const Direction& d = *(*wants_.directions)[p];
      if (!d.rate.empty()) movers_.push_back(p);
      if (!d.reading.empty()) readers_.push_back(p);
    }
  }

 private:
  const LinearModel& lm_;
  const Noise& noise_;
  const FilterWants& wants_;
  std::size_t params_;
  Normal normal_;
  Likelihood out_;
  Matrix P_{};
  Vector z_{};
  std::array<Matrix, noise_states> dP_;
  std::array<Vector, noise_states> dz_;
  std::vector<double> dtheta_, next_, J_, kept_P_, kept_z_, gains_;
  std::vector<Update> updates_;
  std::vector<std::size_t> movers_, readers_;
  double cost_before_ = 0;
  Eigen::MatrixXd total_N_;
  Eigen::VectorXd total_g_;
};

template <std::size_t N>
Likelihood run(const LinearModel& model, const Noise& noise, const FilterWants& wants) {
  auto pass = std::make_unique<Pass<N>>(model, noise, wants);
  pass->sort_directions();
  return pass->run();
}

}  // namespace

Likelihood filter(const LinearModel& model, const Noise& noise, const FilterWants& wants) {
  switch (model.states) {
    case 9:
      return run<9>(model, noise, wants);
    case 10:
      return run<10>(model, noise, wants);
    case 11:
      return run<11>(model, noise, wants);
    case 12:
      return run<12>(model, noise, wants);
    default:
      return run<13>(model, noise, wants);
  }
}

Likelihood filter_along(const LinearModel& model, const Noise& noise, const std::vector<Direction>& directions) {
  std::vector<const Direction*> list;
  for (const Direction& d : directions) list.push_back(&d);
  FilterWants wants;
  wants.directions = &list;
  return filter(model, noise, wants);
}

}  // namespace gripline::diagnose
