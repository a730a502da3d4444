// Three Gaussian processes for what the nominal model leaves unexplained, as in BayesRace and the paper's comparison.
//
//   (vx', vy', omega') = f_nom(x, u) + (g_1, g_2, g_3)(d, delta', delta, vx, vy, omega),   g_i ~ GP (kernel.hpp)
//
// A step is one sample: its mean rates against the nominal model's at the middle of the step, so that the mean
// functions may be integrated like any other rate. Throttle and steering are those that act there, as in the
// prediction: behind the commands where the nominal model knows lags, gains or delays. Samples wait until the first
// `tune_at` are there; then the inputs and targets are standardised, the kernels fitted to at most `tune_points` of
// them, and from there on the window slides by one sample per step. Kernels are fitted again when the window is full
// for the first time and then every `tune_every` steps (0: never). A step with a fit, by default those of samples 150
// and 410, allocates and takes as long as the fit does: a simulated race waits for it, a car could not. Derivatives are
// analytic.
//
// `gp` is given the true friction, as in the published comparison. `gp_own_mu` knows no more than the others: it
// inverts the lateral and yaw equations of step_path.hpp at its samples for the axle forces under the learned means,
// and takes mu from the visited slip angle with the largest mean force.
//
// Sources: Jain, O'Kelly, Chaudhari, Morari, BayesRace (2020); Kalaria, Lin, Dolan, section on baselines.
#include <algorithm>
#include <array>
#include <cmath>
#include <gripline/plugin.hpp>
#include <stdexcept>
#include <vector>

#include "common/learning/single_track.hpp"
#include "common/learning/straight_drive.hpp"
#include "estimators/gp/sliding_gp.hpp"
#include "estimators/gp/slip_bins.hpp"

namespace {

using namespace gripline;
using namespace gripline::gp;
using learning::BodyVelocity;
using learning::Slips;
using learning::StraightDrive;
constexpr int channels = 3;

struct GpParams {
  int window = 410, tune_at = 150, tune_every = 0, tune_points = 150, tune_iterations = 40;
};

class Gp : public Estimator {
 public:
  using Params = GpParams;
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple{
        param("window", &P::window, "1", {10, 5000}, "samples kept by the processes"),
        param("tune_at", &P::tune_at, "1", {5, 5000}, "samples before the first fit of the kernels"),
        param("tune_every", &P::tune_every, "1", {0, 1e6}, "steps between later fits; 0: only when the window fills"),
        param("tune_points", &P::tune_points, "1", {5, 2000}, "samples a fit looks at, evenly chosen"),
        param("tune_iterations", &P::tune_iterations, "1", {0, 1000}, "steps of a fit")};
  }

  Gp(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        nominal_(context.nominal),
        straight_(context),
        processes_{SlidingGp(params.window), SlidingGp(params.window), SlidingGp(params.window)} {
    if (params.tune_at > params.window) throw std::runtime_error("gp: tune_at is larger than window");
    samples_.resize(params.window);
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < car_.v_min || k.dt <= 0.0) return;
    const TrainingSample& one = remember(k);
    ++seen_;
    const bool full = seen_ == params_.window && params_.window > params_.tune_at;
    const bool again = params_.tune_every > 0 && seen_ > params_.tune_at && since_tune_ + 1 >= params_.tune_every;
    if (seen_ == params_.tune_at || full || again) {
      tune();
    } else if (tuned_) {
      ++since_tune_;
      const InputRow x = (one.input - input_mean_).cwiseQuotient(input_scale_);
      for (int c = 0; c < channels; ++c) processes_[c].slide(x, (one.target[c] - target_mean_[c]) / target_scale_[c]);
    }
  }

  void apply(const Points<double>& points) const override { correct(points); }
  void apply(const Points<Dual8>& points) const override { correct(points); }

 protected:
  struct TrainingSample {
    InputRow input = InputRow::Zero();
    std::array<double, channels> target = {};
    BodyVelocity rate, middle;  // measured over the step; mean of its ends
    Slips slip;
    double delta = 0, bank_rate = 0;
  };

  bool tuned() const { return tuned_; }
  const Car& car() const { return car_; }
  std::int64_t seen() const { return seen_; }
  int count() const { return static_cast<int>(std::min<std::int64_t>(seen_, params_.window)); }
  /// Sample i of the window, oldest first.
  const TrainingSample& sample(int i) const { return samples_[(seen_ - count() + i) % params_.window]; }
  /// Rate of channel c at sample i with its noise taken off.
  double smoothed_target(int c, int i) const {
    return target_mean_[c] + target_scale_[c] * processes_[c].mean_at_sample(i);
  }

 private:
  const TrainingSample& remember(const Sample& k) {
    TrainingSample& one = samples_[seen_ % params_.window];
    one.middle = {0.5 * (k.x.vx + k.x_next.vx), 0.5 * (k.x.vy + k.x_next.vy), 0.5 * (k.x.omega + k.x_next.omega)};
    one.delta = k.x_next.delta - k.delta_lag;
    const Input acting = {k.u.d - k.d_lag, k.u.ddelta - k.ddelta_lag};
    one.rate = {(k.x_next.vx - k.x.vx) / k.dt, (k.x_next.vy - k.x.vy) / k.dt, (k.x_next.omega - k.x.omega) / k.dt};
    one.target = unexplained(k, one);
    one.input << acting.d, acting.ddelta, one.delta, one.middle.vx, one.middle.vy, one.middle.omega;
    one.slip = learning::slips(one.middle, one.delta, car_);
    one.bank_rate = straight_.at(one.middle.vx, acting.d, k.at).side;
    return one;
  }

  /// What the nominal model leaves of a step's rates. Prediction::rates() takes commands as having always been given:
  /// where others act, only the residual of the step knows what the model made of them.
  std::array<double, channels> unexplained(const Sample& k, const TrainingSample& one) const {
    const bool as_commanded = k.d_lag == 0.0 && k.delta_lag == 0.0 && k.ddelta_lag == 0.0;
    if (!as_commanded) return {k.e_vx, k.e_vy, k.e_omega};
    State x = k.x;
    x.vx = one.middle.vx;
    x.vy = one.middle.vy;
    x.omega = one.middle.omega;
    x.delta = one.delta;
    const auto nominal = nominal_->rates(x, k.u, k.at);
    return {one.rate.vx - nominal.vx, one.rate.vy - nominal.vy, one.rate.omega - nominal.omega};
  }

  /// A thousandth of what each input ranges over. By less, the noise of one that stood still would be all that counts,
  /// and where it moves at all nothing would be known.
  InputRow least_input_scales() const {
    const double turn = 2 * car_.v_ref * std::tan(car_.delta_max) / (car_.lf + car_.lr);
    InputRow ranges;
    ranges << car_.d_max - car_.d_min, 2 * car_.ddelta_max, 2 * car_.delta_max, car_.v_ref, car_.v_ref, turn;
    return 1e-3 * ranges;
  }

  /// Standardises, fits the kernels to an even choice of the window, and puts the whole window in.
  void tune() {
    const int n = count();
    Eigen::MatrixXd x(n, inputs);
    Eigen::MatrixXd y(n, channels);
    for (int i = 0; i < n; ++i) {
      x.row(i) = sample(i).input;
      for (int c = 0; c < channels; ++c) y(i, c) = sample(i).target[c];
    }
    const auto spread = [](const auto& column, double least) {
      return std::max(least, std::sqrt((column.array() - column.mean()).square().mean()));
    };
    const InputRow least = least_input_scales();
    for (int d = 0; d < inputs; ++d) {
      input_mean_[d] = x.col(d).mean();
      input_scale_[d] = spread(x.col(d), least[d]);
      x.col(d) = (x.col(d).array() - input_mean_[d]) / input_scale_[d];
    }
    const int chosen = std::min(n, params_.tune_points);
    Eigen::MatrixXd few(chosen, inputs);
    Eigen::VectorXd few_targets(chosen);
    for (int c = 0; c < channels; ++c) {
      target_mean_[c] = y.col(c).mean();
      target_scale_[c] = spread(y.col(c), 1e-9);
      y.col(c) = (y.col(c).array() - target_mean_[c]) / target_scale_[c];
      for (int i = 0; i < chosen; ++i) {
        const int from = static_cast<int>((static_cast<std::int64_t>(i) * n) / chosen);
        few.row(i) = x.row(from);
        few_targets[i] = y(from, c);
      }
      const auto kernel = fit_kernel(processes_[c].kernel(), few, few_targets, params_.tune_iterations);
      processes_[c].reset(kernel, x, y.col(c));
    }
    tuned_ = true;
    since_tune_ = 0;
  }

  template <class T>
  void correct(const Points<T>& points) const {
    if (!tuned_) return;
    for (std::size_t i = 0; i < points.n; ++i) {
      auto& q = points.q[i];
      const std::array<T, inputs> z = {q.d, q.delta_rate, q.delta, q.vx, q.vy, q.omega};
      InputRow x;
      for (int d = 0; d < inputs; ++d) x[d] = (value(z[d]) - input_mean_[d]) / input_scale_[d];
      T* const rates[channels] = {&q.ax, &q.ay, &q.aw};
      for (int c = 0; c < channels; ++c) {
        const auto mean = processes_[c].mean(x);
        T correction(target_mean_[c] + target_scale_[c] * mean.value);
        if constexpr (!std::is_same_v<T, double>) {
          for (int d = 0; d < inputs; ++d) {
            const double slope = target_scale_[c] * mean.gradient[d] / input_scale_[d];
            for (int j = 0; j < 8; ++j) correction.d[j] += slope * z[d].d[j];
          }
        }
        *rates[c] += correction;
      }
    }
  }

  Params params_;
  Car car_;
  Prediction* nominal_;
  StraightDrive straight_;
  std::array<SlidingGp, channels> processes_;
  std::vector<TrainingSample> samples_;
  std::int64_t seen_ = 0, since_tune_ = 0;
  bool tuned_ = false;
  InputRow input_mean_ = InputRow::Zero(), input_scale_ = InputRow::Ones();
  std::array<double, channels> target_mean_ = {}, target_scale_ = {1, 1, 1};
};

class PrivilegedGp final : public Gp {
 public:
  using Params = GpParams;
  PrivilegedGp(const PluginContext& context, const Params& params) : Gp(context, params), truth_(context.truth) {
    if (truth_ == nullptr) throw std::runtime_error("gp needs the truth of a world; there is none here");
  }
  Belief belief() const override { return {truth_->mu(Axle::front), truth_->mu(Axle::rear)}; }

 private:
  const Truth* truth_;
};

class OwnMuGp final : public Gp {
 public:
  using Params = GpParams;
  OwnMuGp(const PluginContext& context, const Params& params)
      : Gp(context, params), belief_{context.mu_init, context.mu_init} {}
  void update(const Sample& k) override {
    const auto before = seen();
    Gp::update(k);
    if (!tuned() || seen() == before) return;
    for (int i = judged_window_ ? count() - 1 : 0; i < count(); ++i) judge(i);
    judged_window_ = true;
    const double weight = car().m * gravity, L = car().lf + car().lr;
    if (front_.peak() > 0) {
      belief_.mu_front = front_.peak() * L / (weight * car().lr);
      belief_.sigma_front = front_.deviation() * L / (weight * car().lr);
    }
    if (rear_.peak() > 0) {
      belief_.mu_rear = rear_.peak() * L / (weight * car().lf);
      belief_.sigma_rear = rear_.deviation() * L / (weight * car().lf);
    }
  }
  Belief belief() const override { return belief_; }

 private:
  /// Axle forces of sample i under the learned means. They replace the measured residual: rate less target is the
  /// nominal model's.
  void judge(int i) {
    const Car& c = car();
    const TrainingSample& s = sample(i);
    const double side =
        c.m * (s.rate.vy - s.target[1] + smoothed_target(1, i) + s.middle.vx * s.middle.omega - s.bank_rate);
    const double moment = c.Iz * (s.rate.omega - s.target[2] + smoothed_target(2, i));
    front_.add(s.slip.front, (side * c.lr + moment) / ((c.lf + c.lr) * std::cos(s.delta)));
    rear_.add(s.slip.rear, (side * c.lf - moment) / (c.lf + c.lr));
  }

  SlipBins front_, rear_;
  Belief belief_;
  bool judged_window_ = false;  // the samples before the first fit are in the bins
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<PrivilegedGp>("gp", "1.0",
                                                  "Gaussian processes on the residual, given the true friction")
                     .needs_truth(),
                 gripline::describe<OwnMuGp>("gp_own_mu", "1.0",
                                             "Gaussian processes on the residual, friction from their forces"))
