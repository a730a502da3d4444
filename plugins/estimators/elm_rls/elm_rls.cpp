// Extreme learning machine per axle by recursive least squares, with an uncertainty.
//
//   F_axle(slip) = axle load * sum_j theta_j h_j(slip),   h: generic tyres at random (generic_tyres.hpp), in the few
//                  coordinates in which they differ (reduced_layer.hpp)
//
// The unknowns (both axles' theta, Cr0, Cd, by how much drive and brakes exceed the stack's values of them and the
// arm at which drive turns the car: unknowns.hpp) enter the equations of step_path.hpp linearly; each step is three
// rates with the noise of differenced readings (difference_rls.hpp). Odd, saturating nodes and their prior (prior.hpp)
// carry what was measured at the visited slips on to the peak, so that mu = peak / load is not biased by the slips
// visited, and the covariance says how well it is known.
//
// Forgetting is directional: friction multiplies a tyre's whole curve, so between steps the covariance grows along the
// present curves (both axles together, and each alone) and, very slowly, in all directions, by the prior's in every
// `shape_memory`. The shape that was learned at large slips is kept on a straight. Nothing bounds the covariance: where
// no sample tells anything it grows beyond the prior's.
//
// After a sudden change (sudden_change.hpp) uncertainty is added along the curves, the last reading's noise estimate is
// reset, and the next samples set the new scale.
//
// Neither the readings' noise nor the model error of the equations is given; both are matched to the innovations, from
// a start and between bounds (noise_matching.hpp). Slips are taken on the path predicted from the readings freed of
// their estimated noise. A slow car's tyres take back a lateral speed within a step or two (m v / (2 C), 20 ms for the
// full-size car at 5 m/s), and with it the noise that was estimated of a reading: slow samples can be left out
// (`slowest`).
//
// Side forces beside large drive or brake forces are less well known than others (`sharing_spread`): so a car that
// brakes hard into a turn still learns that friction has fallen. Of small side forces under hard braking it learns
// nothing: what brakes leave of them is known too badly, for as long as the pedal is down. Under much drive side forces
// are tested for a change, and teach for a while after one. What is wrong with the sharing lasts as long as the pedal
// is where it is: it does not average out as noise does, and so counts for more where a tyre's shape is learned
// (`sharing_lasts`). Whatever an equation leaves out lasts for 20 ms: shorter samples say no more of tyres in a second.
#include <algorithm>
#include <array>
#include <cmath>
#include <gripline/plugin.hpp>
#include <stdexcept>

#include "common/learning/axle_table.hpp"
#include "common/learning/difference_rls.hpp"
#include "common/learning/step_path.hpp"
#include "common/learning/tyre_correction.hpp"
#include "common/vehicle/axle_loads.hpp"
#include "estimators/elm_rls/noise_matching.hpp"
#include "estimators/elm_rls/parameters.hpp"
#include "estimators/elm_rls/prior.hpp"
#include "estimators/elm_rls/sudden_change.hpp"
#include "estimators/elm_rls/unknowns.hpp"

namespace {

using namespace gripline;
using namespace gripline::learning;
using elm_rls::channels;
using elm_rls::NoiseMatching;
using elm_rls::SuddenChange;
using elm_rls::Tyres;
using elm_rls::Unknowns;

class ElmRls : public AutoDiffEffect<ElmRls, Estimator> {
 public:
  using Params = elm_rls::Params;
  static constexpr auto parameters() { return elm_rls::declare_parameters(); }

  ElmRls(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        drive_(context),
        expected_(elm_rls::expected_friction(params, context.mu_init)),
        tyres_(elm_rls::draw_tyres(params, expected_, context.seed)),
        nodes_{TabulatedLayer(tyres_[0]), TabulatedLayer(tyres_[1])},
        unknowns_(tyres_[0].nodes(), params.learns_gains(), params.learns_arm()),
        prior_(elm_rls::make_prior(tyres_, unknowns_, params, expected_)),
        rls_(unknowns_.count(), channels),
        load_(vehicle::static_axle_loads(car_)),
        gyration_(std::sqrt(car_.Iz / car_.m)),
        change_(params.alarm),
        noise_({{params.sigma_v, params.sigma_v, params.sigma_omega},
                {params.misfit, params.misfit, params.misfit / gyration_}}),
        rows_(Eigen::MatrixXd::Zero(unknowns_.count(), channels)),
        terms_{.model_has_tyres = drive_.model_has_tyres(),
               .v_min = car_.v_min,
               .ellipse = {params.ellipse, params.drive_front, params.brake_front}} {
    start_over();
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < std::max(car_.v_min, params_.slowest) || k.dt <= 0.0) {
      break_sequence();
      return;
    }
    if (!continues_) rls_.break_sequence(noise_.sigma());
    continues_ = true;
    steps_of_error_ = elm_rls::error_time / k.dt;
    fill_rows(predicted(k));
    forget(k.dt);
    rls_.begin_step(noise_.sigma());
    const StraightDrive::Rates drive = drive_.at(k.x.vx, k.u.d - k.d_lag, k.at);
    const bool shares = params_.sharing_spread > 0;
    if (shares) set_sharing_misfit(drive.on_road(road_load(k)));
    change_.pass(k.dt);
    // Without a misfit of the sharing, what drive and brakes take off side forces would pass for a change.
    if (shares || !uses_much(drive.drive_force)) test_for_change(k.dt);
    const Teaches what = taught(drive.drive_force);
    keep_only(what);
    for (int c = 0; c < channels; ++c) {
      auto innovation = rls_.innovation(c, rows_.col(c), rates_[c], k.dt, misfit(c));
      if (shares && what != Teaches::all)
        noise_.break_sequence(c);
      else if (settled())
        noise_.match(c, innovation, k.dt);
      innovation.variance += correlated_misfit(c);
      rls_.update(innovation);
    }
    seen_ += k.dt;
    read_theta();
    if (!plausible()) start_over();
  }

  Belief belief() const override { return belief_; }

  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    tables_.forces(axle, slip, force);
    for (std::size_t i = 0; i < sigma.size(); ++i) sigma[i] = deviation(axle, slip[i]);
    return true;
  }

  template <class T>
  void act(Point<T>& p) const {
    correct_body(p.q, p.at, terms_, [this](Axle axle, const T& slip) { return tables_.of(axle).force(slip); });
  }

 private:
  static constexpr double peak_reach = 1.6;  // [rad]: where mu looks for the peak
  static constexpr double settling = 0.99;   // [s] before the innovations are taken as evidence: 50 samples at 20 ms
  static constexpr double least_side_used = 0.4;  // where a sample under hard braking teaches of tyres

  /// What a step is taken to tell of.
  enum class Teaches {
    all,              // tyres, drive and resistance
    side_force,       // of tyres, by side force and moment, and resistance
    resistance_alone  // as far as tyres, gains and arm are believed to leave it
  };

  bool settled() const { return seen_ >= settling; }
  /// Standard deviation of what a channel's equation leaves out in this step, that of the sharing of friction included.
  double misfit(int channel) const {
    return std::sqrt(samples_as_one(1)) * std::hypot(noise_.misfit(channel), sharing_misfit_[channel]);
  }
  /// Variance that is added to an innovation's own: where friction sharing errs alike for `sharing_lasts` times 20 ms,
  /// the samples within weigh as one. 0 after a sudden change, which has to be learned from few samples.
  double correlated_misfit(int channel) const {
    if (change_.recent()) return 0.0;
    return (samples_as_one(params_.sharing_lasts) - samples_as_one(1)) * square(sharing_misfit_[channel]);
  }
  /// Samples of this length that weigh as one, where what is wrong with them lasts for so many times error_time: each
  /// has as many times the variance. They would else say more in a second the shorter the control step is.
  double samples_as_one(double error_times) const { return std::max(1.0, error_times * steps_of_error_); }
  /// What the tyres are believed to contribute to a rate of this step.
  double tyre_part(int channel) const { return unknowns_.tyres(rows_.col(channel)).dot(unknowns_.tyres(rls_.theta())); }

  /// The step's path, from its first reading freed of noise on.
  StepPath predicted(const Sample& k) const {
    const BodyVelocity begin = {k.x.vx - rls_.noise(0), k.x.vy - rls_.noise(1), k.x.omega - rls_.noise(2)};
    const auto force = [this](Axle axle, double slip) { return tables_.of(axle).at(slip).force; };
    return predicted_path(begin, k, LearnedCar{car_, drive_, terms_, force});
  }

  /// Rates and their regressors: one column per channel.
  void fill_rows(const StepPath& path) {
    const Unknowns& u = unknowns_;
    rows_.setZero();
    auto forward = rows_.col(0), side = rows_.col(1), turn = rows_.col(2);
    auto front = u.axle(Axle::front, side), rear = u.axle(Axle::rear, side);
    const auto n = static_cast<std::size_t>(u.per_axle());
    for (int i = 0; i < path_points; ++i) {
      const double w = path_weights[i];
      tyres_[0].add(path.slip[i].front, w * path.load_front, {front.data(), n});
      tyres_[1].add(path.slip[i].rear, w * path.load_rear, {rear.data(), n});
    }
    u.axle(Axle::front, forward) = front * (-path.sine * load_.front / car_.m);
    forward[u.Cr0()] = -gravity;
    forward[u.Cd()] = -gravity * path.mean_square_speed() / square(car_.v_ref);
    if (u.has_gains()) forward[path.drive_force < 0 ? u.brake_gain() : u.drive_gain()] = path.drive_force / car_.m;
    u.axle(Axle::front, turn) = front * (path.cosine * load_.front * car_.lf / car_.Iz);
    u.axle(Axle::rear, turn) = rear * (-load_.rear * car_.lr / car_.Iz);
    front *= path.cosine * load_.front / car_.m;
    rear *= load_.rear / car_.m;
    side_used_ =
        car_.m * std::abs(tyre_part(1)) / (path.load_front * terms_.peaks.front + path.load_rear * terms_.peaks.rear);
    rates_ = {path.drive_loss / car_.m, path.side / car_.m, path.moment / car_.Iz};
    if (u.has_arm()) {
      const double drive_force = path.drive_force + terms_.gains.missing(path.drive_force);
      const double side_force = car_.m * tyre_part(1);
      turn[u.arm()] = DriveGains{.arm = 1}.turning_moment(drive_force, side_force, car_.m) / car_.Iz;
    }
  }

  void forget(double dt) {
    spread_along_curves(params_.drift * std::sqrt(dt), params_.axle_drift * std::sqrt(dt));
    rls_.covariance() += prior_.covariance * (dt / params_.shape_memory);
  }

  /// Uncertainty of friction: standard deviations relative to it, of both axles together and of each alone.
  void spread_along_curves(double together, double each) {
    const auto curves = unknowns_.tyres(rls_.theta());
    unknowns_.all_tyres(rls_.covariance()).noalias() += (square(together) * curves) * curves.transpose();
    for (const Axle axle : {Axle::front, Axle::rear}) {
      const auto curve = unknowns_.axle(axle, rls_.theta());
      unknowns_.axles(axle, axle, rls_.covariance()).noalias() += (square(each) * curve) * curve.transpose();
    }
  }

  /// Whether a drive or brake force [N] uses much of the friction.
  bool uses_much(double force) const {
    return std::abs(force / car_.m) > params_.most_drive * gravity * std::min(belief_.mu_front, belief_.mu_rear);
  }

  /// How well the equations of side force and moment hold where drive and brakes share friction with them. A side force
  /// is F sqrt(1 - u) with the share u of the square that drive or brakes use; where u is known to a share s of itself,
  /// its relative standard deviation is s u / (1 - u) / 2. The correlation of the two errors is neglected.
  void set_sharing_misfit(const StraightDrive::Rates& drive) {
    const double drive_force = drive.drive_force + terms_.gains.missing(drive.drive_force);
    const auto sigma = [&](Axle axle, double load, double peak) {
      const double kept = terms_.ellipse.side_share(axle, drive_force, load, peak);
      const double force = unknowns_.axle(axle, rows_.col(1)).dot(unknowns_.axle(axle, rls_.theta()));
      return 0.5 * params_.sharing_spread * (1.0 / square(kept) - 1.0) * force;
    };
    const double front = sigma(Axle::front, drive.load_front, terms_.peaks.front);
    const double rear = sigma(Axle::rear, drive.load_rear, terms_.peaks.rear);
    sharing_misfit_ = {0.0, std::hypot(front, rear), std::hypot(front * car_.lf, rear * car_.lr) / square(gyration_)};
  }

  void test_for_change(double dt) {
    if (!SuddenChange::tests(std::abs(tyre_part(1)), belief_.mu_front, belief_.mu_rear)) return;
    std::array<SuddenChange::Rate, 2> rates;  // side force and moment
    for (const int c : {1, 2}) {
      const auto innovation = rls_.innovation(c, rows_.col(c), rates_[c], dt, misfit(c));
      rates[c - 1] = {innovation.error, innovation.variance, tyre_part(c)};
    }
    change_.add(rates, dt);
    if (!change_.alarms() || !settled()) return;
    spread_along_curves(params_.change, 0.3 * params_.change);
    rls_.reset_older_noise(noise_.sigma());
    change_.begin_change();
  }

  /// What a step under this drive or brake force [N] teaches, once it was tested for a sudden change. Where drive or
  /// brakes use much of the friction, slip control, their split and the ellipse decide what arrives on the road and
  /// what is left for side forces, and none of them is known well. Where that uncertainty is modelled
  /// (sharing_spread), side forces teach all the same: large ones under brakes, and all while a new friction is being
  /// found.
  Teaches taught(double force) const {
    if (!uses_much(force)) return Teaches::all;
    if (!(params_.sharing_spread > 0)) return Teaches::resistance_alone;
    const bool brakes = force < 0;
    return (brakes && side_used_ > least_side_used) || change_.recent() ? Teaches::side_force
                                                                        : Teaches::resistance_alone;
  }

  /// Takes off this step's rates what is believed of the contributions that it is not to teach of.
  void keep_only(Teaches what) {
    if (what == Teaches::all) return;
    const Unknowns& u = unknowns_;
    const auto take_off = [this](int c, auto part, const auto& believed) {
      rates_[c] -= part.dot(believed);
      part.setZero();
    };
    for (int c = 0; c < channels; ++c) {
      if (c == 0 || what != Teaches::side_force) take_off(c, u.tyres(rows_.col(c)), u.tyres(rls_.theta()));
      take_off(c, u.gains_and_arm(rows_.col(c)), u.gains_and_arm(rls_.theta()));
    }
  }

  void read_theta() {
    const Unknowns& u = unknowns_;
    const auto theta = rls_.theta();
    nodes_[0].fill(tables_.front, u.axle(Axle::front, theta), load_.front);
    nodes_[1].fill(tables_.rear, u.axle(Axle::rear, theta), load_.rear);
    const double weight = car_.m * gravity;
    terms_.resistance = {weight * theta[u.Cr0()], weight * theta[u.Cd()] / square(car_.v_ref)};
    if (u.has_gains()) {
      terms_.gains.drive = theta[u.drive_gain()];
      terms_.gains.brake = theta[u.brake_gain()];
    }
    if (u.has_arm()) terms_.gains.arm = theta[u.arm()];
    terms_.peaks = {std::max(tables_.front.peak(peak_reach), 1e-3 * load_.front),
                    std::max(tables_.rear.peak(peak_reach), 1e-3 * load_.rear)};
    belief_.mu_front = tables_.front.peak(peak_reach) / load_.front;
    belief_.mu_rear = tables_.rear.peak(peak_reach) / load_.rear;
    belief_.sigma_front = deviation(Axle::front, tables_.front.peak_slip(peak_reach)) / load_.front;
    belief_.sigma_rear = deviation(Axle::rear, tables_.rear.peak_slip(peak_reach)) / load_.rear;
  }

  /// Standard deviation of an axle's curve at a slip [N].
  double deviation(Axle axle, double slip) const {
    const Eigen::Index n = unknowns_.per_axle(), first = unknowns_.first(axle);
    const auto i = static_cast<std::size_t>(axle);
    std::array<double, Tyres::most_nodes> values;
    Eigen::Map<Eigen::VectorXd> h(values.data(), n);
    nodes_[i].read(slip, h);
    const auto covariance = rls_.covariance();
    double variance = 0;
    for (Eigen::Index a = 0; a < n; ++a) variance += h[a] * covariance.block(first, first + a, n, 1).col(0).dot(h);
    return load_.of(axle) * std::sqrt(std::max(0.0, variance));
  }

  /// False after a spin or a contact with a wall, which the equations do not cover: what was learned is discarded. A
  /// friction of 0.1 to 4 is that of some road and tyre, however far it is from the one expected.
  bool plausible() const {
    const double least = std::min(0.05 * expected_, 0.1), most = std::max(4 * expected_, 4.0);
    const auto fair = [&](double mu) { return mu > least && mu < most; };
    return fair(belief_.mu_front) && fair(belief_.mu_rear) && std::min(terms_.gains.drive, terms_.gains.brake) > -0.9;
  }

  void start_over() {
    seen_ = 0.0;
    continues_ = false;
    noise_.start_over();
    change_.start_over();
    sharing_misfit_ = {};
    rls_.theta() = prior_.mean;
    rls_.reset_covariance(prior_.covariance);
    read_theta();
    // The mean of curves that peak at different slips has a lower peak than each: scaled to the expected friction.
    unknowns_.axle(Axle::front, rls_.theta()) *= expected_ / belief_.mu_front;
    unknowns_.axle(Axle::rear, rls_.theta()) *= expected_ / belief_.mu_rear;
    read_theta();
  }

  /// What comes next does not follow what came before.
  void break_sequence() {
    continues_ = false;
    noise_.break_sequence();
    change_.break_sequence();
  }

  Params params_;
  Car car_;
  StraightDrive drive_;
  double expected_;             // friction, to begin with
  std::array<Tyres, 2> tyres_;  // front, rear
  std::array<TabulatedLayer, 2> nodes_;
  Unknowns unknowns_;
  elm_rls::Prior prior_;
  DifferenceRls rls_;
  vehicle::AxleLoads load_;  // static [N]
  double gyration_;          // radius [m]
  SuddenChange change_;
  NoiseMatching noise_;
  // of this step
  Eigen::MatrixXd rows_;
  std::array<double, channels> rates_ = {}, sharing_misfit_ = {};
  double side_used_ = 0;       // side force over the largest that drive and brakes leave
  double steps_of_error_ = 1;  // of this length in error_time
  // as believed
  AxleTables tables_;
  CorrectionTerms terms_;
  Belief belief_;
  double seen_ = 0;  // [s] of samples
  bool continues_ = false;
};

/// The same learned tyres, but the friction that plans are made for is the true one: the upper bound for a world whose
/// car is a black box.
class PrivilegedElmRls final : public ElmRls {
 public:
  PrivilegedElmRls(const PluginContext& context, const Params& params)
      : ElmRls(context, params), truth_(context.truth) {
    if (truth_ == nullptr) throw std::runtime_error("elm_rls_told needs the truth of a world; there is none here");
  }
  Belief belief() const override { return {truth_->mu(Axle::front), truth_->mu(Axle::rear)}; }

 private:
  const Truth* truth_;
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<ElmRls>("elm_rls", "1.0", "generic tyres per axle by recursive least squares"),
    gripline::describe<PrivilegedElmRls>("elm_rls_told", "1.0", "as elm_rls, given the true friction").needs_truth())
