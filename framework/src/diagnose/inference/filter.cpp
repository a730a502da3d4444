// Sequential updates, one reading after the other (the sensors are independent), so that nothing is inverted:
//
//   e = y - h - H z,  S = H P H' + r,  K = P H' / S,  z += K e,  P -= K S K',   cost = sum (e^2 / S + log S) / 2,
//
// with e the innovation and S its variance. The derivative J of the predicted reading by the parameters obeys the same
// recursion with the same gains (dz -= K J); how the gains themselves depend on parameters is left out, as in
// Gauss-Newton.
//
// Coloured noise v of a reading, v[k+1] = a v[k] + white, is whitened by differences (Bryson and Henrikson 1968): with
// y'[k+1] = y[k+1] - a y[k] only the white part is left, and
//
//   y'[k+1] = (H[k+1] F[k] - a H[k]) z[k] + H[k+1] f[k] + ...
//
// is read as a function of the state at k. Unknown accelerations reach readings after a sample at the earliest, so that
// the white part is independent of what they do within the step.
#include "diagnose/inference/filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/inference/adjoint_smoother.hpp"
#include "diagnose/inference/normal_accumulator.hpp"
#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {
namespace {

/// A scalar of the filter with its derivatives by the three process variances.
using WithGradient = Eigen::Array4d;
static_assert(noise_states == 3);

double value(double x) { return x; }
double value(const WithGradient& x) { return x[0]; }
double& value_of(double& x) { return x; }
double& value_of(WithGradient& x) { return x[0]; }
template <class T>
T constant(double x) {
  T all{};
  if constexpr (!std::is_same_v<T, double>) all.setZero();
  value_of(all) = x;
  return all;
}

/// One pass over a log with N states; T is double or WithGradient.
template <std::size_t N, class T>
class Pass {
 public:
  Pass(const LinearModel& model, const Noise& noise, const FilterOptions& options)
      : lm_(model),
        noise_(noise),
        options_(options),
        params_(options.regressors != nullptr ? options.regressors->size() : 0),
        normal_(params_),
        smoother_(model),
        coloured_(std::ranges::any_of(noise.colour, [](double rho) { return rho != 0.0; })) {
    for (std::size_t p = 0; p < params_; ++p) {
      const Regressor& r = *(*options.regressors)[p];
      if (!r.rate.empty()) in_rates_.push_back(p);
      if (!r.reading.empty()) in_readings_.push_back(p);
    }
  }

  Likelihood run() {
    start();
    for (std::size_t k = 0; k < lm_.n; ++k) {
      if (options_.restart > 0 && k > 0 && k % options_.restart == 0) restart(k);
      if (options_.smooth) keep(k);
      update(k);
      if (k + 1 < lm_.n && options_.predict) keep_predicted(k);
      if (k + 1 < lm_.n && coloured_) update_ahead(k);
      if (options_.block > 0 && ((k + 1) % options_.block == 0 || k + 1 == lm_.n)) end_block();
      if (k + 1 < lm_.n) predict(k);
    }
    finish();
    if (options_.smooth) out_.smoothed = smoother_.smooth();
    return std::move(out_);
  }

 private:
  static constexpr bool with_gradient = !std::is_same_v<T, double>;
  static constexpr std::size_t body = N - noise_states;
  using Matrix = std::array<T, N * N>;
  using Vector = std::array<T, N>;

  void start() {
    restart(0);
    for (std::size_t j = 0; j < lm_.memories(); ++j) P_[(channels + j) * (N + 1)] = constant<T>(lm_.memory_variance[j]);
    next_.assign(N * params_, 0.0);
    inputs_.assign(N * params_, 0.0);
    J_.assign(params_, 0.0);
    if (options_.predict) out_.predicted.assign(lm_.n * N, 0.0);
    if (options_.smooth) smoother_.reserve();
  }

  /// A diffuse start: nothing before it counts, in the regressors neither.
  void restart(std::size_t k) {
    P_.fill(constant<T>(0.0));
    z_.fill(constant<T>(0.0));
    for (std::size_t c = 0; c < channels; ++c)
      P_[c * (N + 1)] = constant<T>(std::pow(thresholds::diffuse_start * noise_.sensor[c], 2));
    for (std::size_t i = 0; i < noise_states; ++i) add_variance(i, 1.0);
    for (std::size_t i = 0; i < lm_.command_errors(); ++i)
      value_of(P_[command_error(i) * (N + 1)]) += lm_.rounding_error[k].variance[i];
    dtheta_.assign(N * params_, 0.0);
  }

  /// Place in the state of the error of a command.
  std::size_t command_error(std::size_t i) const { return body - lm_.command_errors() + i; }

  /// Adds a share of the stationary variance of unknown acceleration i.
  void add_variance(std::size_t i, double share) {
    T& to = P_[(body + i) * (N + 1)];
    value_of(to) += share * noise_.process[i];
    if constexpr (with_gradient) to[static_cast<Eigen::Index>(i) + 1] += share;
  }

  void keep(std::size_t k) {
    double *const P = smoother_.covariance(k), *const z = smoother_.state(k);
    for (std::size_t i = 0; i < N * N; ++i) P[i] = value(P_[i]);
    for (std::size_t i = 0; i < N; ++i) z[i] = value(z_[i]);
  }

  /// The state at k + 1 by all readings up to k. Differenced readings of k + 1 have not been read yet.
  void keep_predicted(std::size_t k) {
    const Vector z = predicted_from(k);
    for (std::size_t i = 0; i < N; ++i) out_.predicted[(k + 1) * N + i] = value(z[i]);
  }

  Vector predicted_from(std::size_t k) const {
    const double* const F = lm_.F.data() + k * N * N;
    Vector z;
    for (std::size_t i = 0; i < N; ++i) {
      T sum = constant<T>(i < body ? lm_.offset[k * body + i] : 0.0);
      for (std::size_t j = 0; j < N; ++j) sum += F[i * N + j] * z_[j];
      z[i] = sum;
    }
    return z;
  }

  void update(std::size_t k) {
    for (std::size_t c = 0; c < channels; ++c) {
      const double raw = lm_.innovation[k * channels + c];
      if (std::isnan(raw) || (coloured_ && is_differenced(k, c))) continue;
      const double r = noise_.sensor[c] * noise_.sensor[c];
      if (lm_.H.empty())
        scalar<Row::element>(k, c, raw, r, nullptr);
      else
        scalar<Row::motion>(k, c, raw, r, lm_.H.data() + (k * channels + c) * channels);
    }
  }

  /// Whether reading c of sample k is read as its difference to the sample before.
  bool is_differenced(std::size_t k, std::size_t c) const {
    if (noise_.colour[c] == 0.0 || k == 0 || (options_.restart > 0 && k % options_.restart == 0)) return false;
    if (std::isnan(lm_.innovation[k * channels + c]) || std::isnan(lm_.innovation[(k - 1) * channels + c]))
      return false;
    return !(k - 1 < lm_.interpolated.size() && lm_.interpolated[k - 1]);
  }

  /// The coloured readings of sample k + 1, differenced, as functions of the state at k.
  void update_ahead(std::size_t k) {
    if (params_ > 0) find_inputs(k);
    const double* const F = lm_.F.data() + k * N * N;
    for (std::size_t c = 0; c < channels; ++c) {
      if (!is_differenced(k + 1, c)) continue;
      const double rho = noise_.colour[c];
      std::array<double, channels> next{}, now{};  // rows of H at k + 1 and at k
      next[c] = now[c] = 1.0;
      if (!lm_.H.empty()) {
        std::copy_n(lm_.H.data() + ((k + 1) * channels + c) * channels, channels, next.begin());
        std::copy_n(lm_.H.data() + (k * channels + c) * channels, channels, now.begin());
      }
      double raw = lm_.innovation[(k + 1) * channels + c] - rho * lm_.innovation[k * channels + c];
      std::array<double, N> h{};
      for (std::size_t j = 0; j < channels; ++j) {
        h[j] -= rho * now[j];
        if (next[j] == 0.0) continue;
        raw -= next[j] * lm_.offset[k * body + j];
        for (std::size_t i = 0; i < N; ++i) h[i] += next[j] * F[j * N + i];
      }
      if (params_ > 0) find_inputs_read(k, c, rho, next);
      const double white = noise_.sensor[c] * noise_.sensor[c] * (1.0 - rho * rho);
      scalar<Row::whole>(k, c, raw, white + variance_of_commands(k, next), h.data());
    }
  }

  /// Variance of a command half-way through the step after sample k.
  double variance_of_command(std::size_t k, std::size_t i) const {
    return std::pow(noise_.command.steady[i], 2) + std::pow(noise_.command.moving[i] * lm_.command_variation[k][i], 2);
  }

  /// Variance of a reading at k + 1 by what commands may have done within the step; that it goes on in the state is
  /// left out.
  double variance_of_commands(std::size_t k, const std::array<double, channels>& row) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 2 && !lm_.by_command.empty(); ++i) {
      const double* const by = lm_.by_command.data() + (k * 2 + i) * N;
      double one = 0.0;
      for (std::size_t j = 0; j < channels; ++j) one += row[j] * by[j];
      sum += one * one * variance_of_command(k, i);
    }
    return sum;
  }

  /// What a unit of each parameter's rates adds to the state at k + 1, to `inputs_`.
  void find_inputs(std::size_t k) {
    const double* const in0 = lm_.input0.data() + k * N * 3;
    const double* const in1 = lm_.input1.data() + k * N * 3;
    for (const std::size_t p : in_rates_) {
      const double* const b0 = (*options_.regressors)[p]->rate.data() + k * 3;
      const double* const b1 = b0 + 3;
      for (std::size_t i = 0; i < N; ++i) {
        double sum = 0.0;
        for (std::size_t c = 0; c < 3; ++c) sum += in0[i * 3 + c] * b0[c] + in1[i * 3 + c] * b1[c];
        inputs_[i * params_ + p] = sum;
      }
    }
  }

  /// What a unit of each parameter adds to a differenced reading beside its part through the state at k, to `beside_`.
  void find_inputs_read(std::size_t k, std::size_t c, double rho, const std::array<double, channels>& next) {
    beside_.assign(params_, 0.0);
    for (std::size_t j = 0; j < channels; ++j)
      if (next[j] != 0.0)
        for (const std::size_t p : in_rates_) beside_[p] += next[j] * inputs_[j * params_ + p];
    for (const std::size_t p : in_readings_) {
      const std::vector<double>& reading = (*options_.regressors)[p]->reading;
      beside_[p] += reading[(k + 1) * channels + c] - rho * reading[k * channels + c];
    }
  }

  /// What a reading is a function of: one element of the state, its motion, or all of it.
  enum class Row { element, motion, whole };

  /// H v of reading c.
  template <Row kind>
  static T row(const T* v, std::size_t c, const double* h) {
    if constexpr (kind == Row::element) return v[c];
    T sum = constant<T>(0.0);
    for (std::size_t j = 0; j < (kind == Row::whole ? N : channels); ++j) sum += h[j] * v[j];
    return sum;
  }

  /// The update by one reading whose white noise has the variance r. Derivatives d go through the same formulas: that
  /// of the gain is (dPH - K dS) / S, and with the optimal gain dP becomes (I - K H) dP (I - K H)', which is dP less
  /// K half' + half K' with half = dPH - K dS / 2. For the values themselves half is PH / 2, and the same lines
  /// subtract K S K' from P.
  template <Row kind>
  void scalar(std::size_t k, std::size_t c, double raw, double r, const double* h) {
    Vector PH, half;
    for (std::size_t i = 0; i < N; ++i) PH[i] = row<kind>(P_.data() + i * N, c, h);
    const T S = row<kind>(PH.data(), c, h) + constant<T>(r);
    const T e = constant<T>(raw) - row<kind>(z_.data(), c, h);
    const double inverse = 1.0 / value(S), error = value(e);
    std::array<double, N> K;
    for (std::size_t i = 0; i < N; ++i) K[i] = value(PH[i]) * inverse;
    const double unit = kind == Row::whole ? noise_.sensor[c] * noise_.sensor[c] : r;
    out_.cost += 0.5 * (error * error * inverse + std::log(value(S) * (1.0 / unit)));
    ++out_.rows;
    if (options_.innovations) out_.innovations.push_back({c, error, value(S)});
    if constexpr (with_gradient) add_noise_gradient(S, e, inverse);
    if (params_ > 0) {
      param_row<kind>(k, c, h);
      normal_.add(J_.data(), error, inverse);
      for (std::size_t i = 0; i < N; ++i) {
        double* const d = dtheta_.data() + i * params_;
        const double gain = K[i];
        if (gain == 0.0) continue;
        for (std::size_t p = 0; p < params_; ++p) d[p] -= gain * J_[p];
      }
    }
    for (std::size_t i = 0; i < N; ++i) {
      half[i] = PH[i] - (0.5 * K[i]) * S;
      z_[i] += K[i] * e + (error * inverse) * (PH[i] - K[i] * S);
    }
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j) P_[i * N + j] -= K[i] * half[j] + K[j] * half[i];
    if (options_.smooth) smoother_.add(k, c, error, value(S), K, kind == Row::whole ? h : nullptr);
  }

  template <Row kind>
  void param_row(std::size_t k, std::size_t c, const double* h) {
    if constexpr (kind == Row::whole) {
      J_ = beside_;
      for (std::size_t j = 0; j < N; ++j)
        if (h[j] != 0.0)
          for (std::size_t p = 0; p < params_; ++p) J_[p] += h[j] * dtheta_[j * params_ + p];
      return;
    } else if constexpr (kind == Row::element) {
      std::copy_n(dtheta_.begin() + static_cast<std::ptrdiff_t>(c * params_), params_, J_.begin());
    } else {
      std::fill(J_.begin(), J_.end(), 0.0);
      for (std::size_t j = 0; j < channels; ++j)
        if (h[j] != 0.0)
          for (std::size_t p = 0; p < params_; ++p) J_[p] += h[j] * dtheta_[j * params_ + p];
    }
    for (const std::size_t p : in_readings_) J_[p] += (*options_.regressors)[p]->reading[k * channels + c];
  }

  /// Gradient and expected information by the process variances.
  void add_noise_gradient(const T& S, const T& e, double inverse) {
    const double ratio = e[0] * inverse;
    const T scaled = S * inverse;
    for (std::size_t i = 0; i < noise_states; ++i) {
      const auto a = static_cast<Eigen::Index>(i) + 1;
      out_.noise_gradient[i] += 0.5 * (scaled[a] - ratio * ratio * S[a]) + ratio * e[a];
      for (std::size_t j = 0; j < noise_states; ++j) {
        const auto b = static_cast<Eigen::Index>(j) + 1;
        out_.noise_information[i][j] += 0.5 * scaled[a] * scaled[b] + e[a] * e[b] * inverse;
      }
    }
  }

  void predict(std::size_t k) {
    const double* const F = lm_.F.data() + k * N * N;
    z_ = predicted_from(k);
    propagate(F);
    const double growth = 1.0 - std::exp(-2.0 * lm_.dt / lm_.noise_time);
    for (std::size_t i = 0; i < noise_states; ++i) add_variance(i, growth);
    if (!lm_.by_command.empty()) add_commands(k);
    for (std::size_t i = 0; i < lm_.command_errors(); ++i) {
      const double share = lm_.rounding_error[k].autoregression[i],
                   fresh = lm_.rounding_error[k + 1].variance[i] - share * share * lm_.rounding_error[k].variance[i];
      value_of(P_[command_error(i) * (N + 1)]) += std::max(0.0, fresh);
    }
    if (k < lm_.interpolated.size() && lm_.interpolated[k]) inflate_covariance();
    if (params_ > 0) predict_params(k, F);
  }

  /// What commands may have done between the samples.
  void add_commands(std::size_t k) {
    for (std::size_t c = 0; c < 2; ++c) {
      const double* const by = lm_.by_command.data() + (k * 2 + c) * N;
      const double variance = variance_of_command(k, c);
      if (variance == 0.0) continue;
      for (std::size_t i = 0; i < body; ++i)
        for (std::size_t j = 0; j < body; ++j) value_of(P_[i * N + j]) += variance * by[i] * by[j];
    }
  }

  /// After a command that was not recorded the speeds are known less well than the model says.
  void inflate_covariance() {
    for (std::size_t c = 3; c < channels; ++c)
      value_of(P_[c * (N + 1)]) += std::pow(thresholds::lost_command_jump * noise_.sensor[c], 2);
  }

  /// P = F P F', with F's structure: nothing depends on x and y, unknown accelerations depend only on themselves.
  void propagate(const double* F) {
    std::array<double, N * body> across;  // F's rows of the body transposed, so that both products run along rows
    for (std::size_t i = 0; i < body; ++i)
      for (std::size_t j = 0; j < N; ++j) across[j * body + i] = F[i * N + j];
    Matrix t;
    for (std::size_t i = 0; i < body; ++i) {
      Vector sum;
      for (std::size_t j = 0; j < N; ++j) sum[j] = i < 2 ? P_[i * N + j] : constant<T>(0.0);
      for (std::size_t l = 2; l < N; ++l) {
        const double f = F[i * N + l];
        for (std::size_t j = 0; j < N; ++j) sum[j] += f * P_[l * N + j];
      }
      std::copy_n(sum.begin(), N, t.begin() + static_cast<std::ptrdiff_t>(i * N));
    }
    for (std::size_t i = 0; i < body; ++i) {
      std::array<T, body> sum;
      for (std::size_t j = 0; j < body; ++j) sum[j] = j < 2 ? t[i * N + j] : constant<T>(0.0);
      for (std::size_t l = 2; l < N; ++l) {
        const T one = t[i * N + l];
        for (std::size_t j = 0; j < body; ++j) sum[j] += across[l * body + j] * one;
      }
      for (std::size_t j = i; j < body; ++j) P_[j * N + i] = P_[i * N + j] = sum[j];
    }
    for (std::size_t a = body; a < N; ++a) {
      const double decay = F[a * (N + 1)];
      for (std::size_t i = 0; i < body; ++i) P_[a * N + i] = P_[i * N + a] = decay * t[i * N + a];
      for (std::size_t j = body; j < N; ++j) P_[a * N + j] *= decay * F[j * (N + 1)];
    }
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
    if (!coloured_) find_inputs(k);
    for (const std::size_t p : in_rates_)
      for (std::size_t i = 0; i < N; ++i) dtheta_[i * params_ + p] += inputs_[i * params_ + p];
  }

  void end_block() {
    out_.block_cost.push_back(out_.cost - cost_before_);
    cost_before_ = out_.cost;
  }

  void finish() {
    out_.params = params_;
    if (params_ == 0) return;
    normal_.flush();
    const Eigen::MatrixXd full = normal_.N().selfadjointView<Eigen::Lower>();
    out_.N.assign(full.data(), full.data() + full.size());
    out_.g.assign(normal_.g().data(), normal_.g().data() + normal_.g().size());
  }

  const LinearModel& lm_;
  const Noise& noise_;
  const FilterOptions& options_;
  std::size_t params_;
  NormalAccumulator normal_;
  AdjointSmoother<N> smoother_;
  bool coloured_;  // the noise of some reading
  Likelihood out_;
  Matrix P_;
  Vector z_;
  std::vector<double> dtheta_, next_, J_, inputs_, beside_;
  std::vector<std::size_t> in_rates_, in_readings_;  // parameters with such regressors
  double cost_before_ = 0;
};

template <std::size_t N>
Likelihood run(const LinearModel& model, const Noise& noise, const FilterOptions& options) {
  const auto go = [&]<class T>(T) { return std::make_unique<Pass<N, T>>(model, noise, options)->run(); };
  return options.noise_gradient ? go(WithGradient{}) : go(0.0);
}

}  // namespace

Likelihood filter(const LinearModel& model, const Noise& noise, const FilterOptions& options) {
  switch (model.states) {
    case 9:
      return run<9>(model, noise, options);
    case 10:
      return run<10>(model, noise, options);
    case 11:
      return run<11>(model, noise, options);
    case 12:
      return run<12>(model, noise, options);
    case 13:
      return run<13>(model, noise, options);
    case 14:
      return run<14>(model, noise, options);
    default:
      return run<15>(model, noise, options);
  }
}

Likelihood filter_along(const LinearModel& model, const Noise& noise, std::span<const Regressor> regressors,
                        std::span<const Regressor> further) {
  std::vector<const Regressor*> list;
  for (const Regressor& d : regressors) list.push_back(&d);
  for (const Regressor& d : further) list.push_back(&d);
  FilterOptions options;
  options.regressors = &list;
  return filter(model, noise, options);
}

}  // namespace gripline::diagnose
