// Extreme learning machine per axle by recursive least squares, with an uncertainty.
//
//   F_axle(slip) = axle load * sum_j theta_j h_j(slip),   h: generic tyres at random (generic_tyres.hpp), in the few
//                  coordinates in which they differ (reduced_layer.hpp)
//
// The unknowns (both axles' theta, Cr0, Cd, by how much drive and brakes exceed what the stack was told of them and the
// arm at which drive turns the car) enter the equations of step_path.hpp linearly; each step is three rates with the
// noise of differenced readings (difference_rls.hpp). Odd, saturating nodes and their prior carry what was measured at the visited slips on to the
// peak, so that mu = peak / load is not biased by the slips visited, and the covariance says how well it is known.
//
// Forgetting is directional: friction multiplies a tyre's whole curve, so between steps the covariance grows along the
// present curves (both axles together, and each alone) and, very slowly, back towards the prior. The shape that was
// learned at large slips is kept on a straight, and the covariance stays bounded.
//
// A sudden change is a likelihood-ratio test: over the last samples, do the innovations correlate with the predicted
// forces? If so, uncertainty is added along the curves, what was taken for noise of the last reading is doubted, and
// the next samples set the new scale.
//
// Neither the readings' noise nor how well the equations hold is told; both are matched to the innovations, from a
// start and between bounds. Slips are taken on the path predicted from the readings freed of their estimated noise.
// A slow car's tyres take back a lateral speed within a step or two (m v / (2 C), 20 ms for the full-size car at 5 m/s), and
// with it the noise that was estimated of a reading: slow samples can be left out (`slowest`).
// Side forces beside large drive or brake forces are less well known than others (`sharing_spread`): so a car that brakes
// hard into a turn still learns that friction has fallen. Of small side forces under hard braking it learns nothing: what
// brakes leave of them is known too badly, for as long as the pedal is down. Under much drive they are tested for a change, and teach for a
// while after one. What is wrong with the sharing lasts as long as the pedal is where it is: it does not average out as
// noise does, and so counts for more where a tyre's shape is learned (`sharing_lasts`).
#include <algorithm>
#include <array>
#include <cmath>
#include <gripline/plugin.hpp>
#include <stdexcept>

#include "common/learning/axle_table.hpp"
#include "common/learning/difference_rls.hpp"
#include "common/learning/generic_tyres.hpp"
#include "common/learning/reduced_layer.hpp"
#include "common/learning/step_path.hpp"
#include "common/learning/tyre_correction.hpp"

namespace {

using namespace gripline;
using namespace gripline::learning;
constexpr int channels = 3;

class ElmRls : public AutoDiffEffect<ElmRls, Estimator> {
 public:
  struct Params {
    int hidden = 40;
    double stiffness = 6.0, stiffness_spread = 0.7, shape = 1.4, shape_spread = 0.2;
    double friction = 0, friction_spread = 0.3, common = 0, most_drive = 10, sharing_spread = 0, sharing_lasts = 1;
    double drive_spread = 0, brake_spread = 0, arm_spread = 0;
    double drift = 0.015, axle_drift = 0.005, shape_memory = 1000;
    double alarm = 4.5, change = 0.3;
    double sigma_v = 0.02, sigma_omega = 0.05, misfit = 0.02;
    double slowest = 0;
    double ellipse = 0, drive_front = 0, brake_front = 0;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple_cat(
        std::tuple{
            param("hidden", &P::hidden, "1", {2, 400}, "hidden nodes per axle: generic tyres"),
            param("stiffness", &P::stiffness, "1/rad", {0.1, 100}, "stiffness factor B of a tyre: median of the prior"),
            param("stiffness_spread", &P::stiffness_spread, "1", {0.01, 2}, "standard deviation of log B"),
            param("shape", &P::shape, "1", {1.05, 2}, "shape factor C of a tyre: mean of the prior"),
            param("shape_spread", &P::shape_spread, "1", {0.001, 1}, "standard deviation of C"),
            param("friction", &P::friction, "1", {0, 5}, "friction that the prior expects; 0: the stack's mu_init"),
            param("friction_spread", &P::friction_spread, "1", {0.01, 2}, "standard deviation of that, relative to it"),
            param("common", &P::common, "1", {0, 1},
                  "share of that variance which both axles have in common, as they drive one road"),
            param("most_drive", &P::most_drive, "1", {0, 10},
                  "drive or brake force, as a share of friction, above which a sample teaches nothing of drive, nor of "
                  "tyres but what sharing_spread leaves"),
            param("sharing_spread", &P::sharing_spread, "1", {0, 10},
                  "standard deviation of what drive and brakes take off the square of a side force, relative to it; "
                  "above 0 braking beyond most_drive teaches of tyres what that leaves, and drive after a change"),
            param("sharing_lasts", &P::sharing_lasts, "1", {1, 1e4},
                  "samples in a row whose sharing errs alike, so that they teach of tyres no more than one does"),
            param("drive_spread", &P::drive_spread, "1", {0, 1},
                  "standard deviation of the drive force, relative to what the model says; 0: it is known"),
            param("brake_spread", &P::brake_spread, "1", {0, 1}, "the same of the brake force"),
            param("arm_spread", &P::arm_spread, "m", {0, 1},
                  "standard deviation of the arm at which drive turns the car into a turn, under a side force as large "
                  "as its weight: between 0 (left and right wheels push alike) and the height of the centre of gravity "
                  "(as they carry); 0: there is none"),
            param("drift", &P::drift, "1/s^0.5", {0, 1}, "random walk of friction, both axles together"),
            param("axle_drift", &P::axle_drift, "1/s^0.5", {0, 1}, "random walk of each axle's friction"),
            param("shape_memory", &P::shape_memory, "s", {1, 1e9}, "time in which the prior's uncertainty returns"),
            param("alarm", &P::alarm, "1", {1, 100}, "score above which friction is taken to have changed suddenly"),
            param("change", &P::change, "1", {0, 2}, "relative uncertainty of friction after such a change"),
            param("sigma_v", &P::sigma_v, "m/s", {1e-6, 10}, "noise of vx and vy to begin with"),
            param("sigma_omega", &P::sigma_omega, "rad/s", {1e-6, 10}, "noise of the yaw rate to begin with"),
            param("misfit", &P::misfit, "m/s2", {1e-6, 10}, "accuracy of the equations at best"),
            param("slowest", &P::slowest, "m/s", {0, 100}, "speed below which samples teach nothing")},
        ellipse_parameters<P>());
  }

  ElmRls(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        drive_(context),
        tyres_(draw(context, params)),
        nodes_{TabulatedLayer(tyres_[0]), TabulatedLayer(tyres_[1])},
        n_(tyres_[0].nodes()),
        rls_(unknowns(), channels),
        load_{car_.m * gravity * car_.lr / (car_.lf + car_.lr), car_.m * gravity * car_.lf / (car_.lf + car_.lr)},
        expected_(expected(context, params)),
        gyration_(std::sqrt(car_.Iz / car_.m)),
        ellipse_{params.ellipse, params.drive_front, params.brake_front},
        largest_sigma_{10 * params.sigma_v, 10 * params.sigma_v, 10 * params.sigma_omega},
        rows_(Eigen::MatrixXd::Zero(unknowns(), channels)),
        prior_mean_(2 * n_),
        prior_covariance_(Eigen::MatrixXd::Zero(unknowns(), unknowns())) {
    const Eigen::Index n = n_;
    for (const int i : {0, 1}) {
      prior_mean_.segment(i * n, n) = tyres_[i].layer().prior_mean() * all_weights(i);
      prior_covariance_.block(i * n, i * n, n, n) = tyres_[i].reduced_covariance(tyres_[i].layer().prior_covariance());
    }
    const double common = params.common * square(expected_ * params.friction_spread / params.hidden);
    prior_covariance_.block(0, n, n, n) = common * all_weights(0) * all_weights(1).transpose();
    prior_covariance_.block(n, 0, n, n) = prior_covariance_.block(0, n, n, n).transpose();
    prior_covariance_(2 * n, 2 * n) = square(0.1);          // Cr0 over m g
    prior_covariance_(2 * n + 1, 2 * n + 1) = square(0.1);  // Cd v_ref^2 over m g
    if (learns_drive())
      prior_covariance_.diagonal().segment(2 * n + 2, 2) << square(params.drive_spread), square(params.brake_spread);
    if (learns_arm()) prior_covariance_(unknowns() - 1, unknowns() - 1) = square(params.arm_spread);
    start_over();
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < std::max(car_.v_min, params_.slowest) || k.dt <= 0.0) {
      break_sequence();
      return;
    }
    if (!continues_) rls_.break_sequence(sigma_.data());
    continues_ = true;
    const BodyVelocity begin = {k.x.vx - rls_.noise(0), k.x.vy - rls_.noise(1), k.x.omega - rls_.noise(2)};
    const auto force = [this](Axle axle, double slip) { return tables_.of(axle).at(slip).force; };
    const LearnedCar car{car_, drive_, resistance_, ellipse_, peaks_, force, gains_};
    fill_rows(predicted_path(begin, k, car));
    forget(k.dt);
    rls_.begin_step(sigma_.data());
    const double drive = drive_of(k);
    const bool hard = std::abs(drive) > params_.most_drive * gravity * std::min(belief_.mu_front, belief_.mu_rear);
    const bool shares = params_.sharing_spread > 0;
    if (shares) doubt_sharing(k);
    // Without a doubt of the sharing, what drive and brakes take off side forces would pass for a change.
    if (hard && !shares) leave_drive_and_tyres(false);
    since_change_ += k.dt;
    test_for_change(k.dt);
    if (hard && shares) leave_drive_and_tyres((drive < 0 && side_used_ > tested_share) || since_change_ < change_lasts);
    for (int c = 0; c < channels; ++c) {
      auto innovation = rls_.innovation(c, rows_.col(c), rates_[c], k.dt, misfit(c));
      if (!hard || !shares)
        adapt_noise(c, innovation);
      else
        last_error_[c] = 0;  // what comes next does not follow it
      innovation.variance += lasting_doubt(c);
      rls_.update(innovation);
    }
    ++seen_;
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
    correct_body(
        p.q, p.at, drive_.model_has_tyres(), car_.v_min, resistance_, ellipse_, peaks_,
        [this](Axle axle, const T& slip) { return tables_.of(axle).force(slip); }, gains_);
  }

 private:
  static constexpr double peak_reach = 1.6;       // [rad]: where mu looks for the peak
  static constexpr double score_memory = 0.9;     // per step, of the likelihood ratio
  static constexpr double noise_gain = 0.01;      // per step, of matching the noise
  static constexpr double smallest_sigma = 2e-3;  // of largest_sigma_: 0.02 of what the filter starts from
  static constexpr double misfit_gain = 0.02;     // per step, of matching the misfit
  static constexpr double tested_share = 0.4;     // of friction: least side force of samples that are tested for change
  // After a change samples under much drive teach of tyres, and an error of the sharing is taken for noise, for so long
  // [s]: the new friction is found from some 20 samples at 20 ms, well before a car at the limit of grip runs wide.
  static constexpr double change_lasts = 0.5;

  static double expected(const PluginContext& context, const Params& params) {
    return params.friction > 0 ? params.friction : context.mu_init;
  }
  using Tyres = ReducedLayer<GenericTyres>;
  static TyrePrior prior(const PluginContext& context, const Params& p) {
    return {p.stiffness, p.stiffness_spread, p.shape, p.shape_spread, expected(context, p), p.friction_spread};
  }
  /// Tyres of the front and the rear axle, in as many directions as the one needs that needs more.
  static std::array<Tyres, 2> draw(const PluginContext& context, const Params& params) {
    SplitMix64 random(context.seed);
    GenericTyres front(params.hidden, prior(context, params), random);
    GenericTyres rear(params.hidden, prior(context, params), random);
    const CurveDirections of_front(front), of_rear(rear);
    const Eigen::Index count = std::max(of_front.count(), of_rear.count());
    return {Tyres(std::move(front), of_front.leading(count)), Tyres(std::move(rear), of_rear.leading(count))};
  }
  /// The weights of an axle that are all one.
  Eigen::VectorXd all_weights(int axle) const { return tyres_[axle].reduced(Eigen::VectorXd::Ones(params_.hidden)); }
  bool learns_drive() const { return params_.drive_spread > 0 || params_.brake_spread > 0; }
  bool learns_arm() const { return params_.arm_spread > 0; }
  Eigen::Index unknowns() const { return 2 * n_ + 2 + (learns_drive() ? 2 : 0) + (learns_arm() ? 1 : 0); }
  Eigen::Index first(Axle axle) const { return axle == Axle::front ? 0 : n_; }
  /// Of this step.
  double misfit(int channel) const { return std::hypot(misfit_[channel], sharing_misfit_[channel]); }
  /// Variance of a rate, beside what its innovation shows: an error of the sharing that lasts for n samples leaves of them
  /// what one teaches. Not after a sudden change, which is learned from few.
  double lasting_doubt(int channel) const {
    return since_change_ < change_lasts ? 0.0 : (params_.sharing_lasts - 1.0) * square(sharing_misfit_[channel]);
  }

  /// Rates and their regressors: one column per channel.
  void fill_rows(const StepPath& path) {
    const Eigen::Index n = n_;
    rows_.setZero();
    double* const h = rows_.col(1).data();
    for (int i = 0; i < path_points; ++i) {
      const double w = path_weights[i];
      tyres_[0].add(path.slip[i].front, w * path.load_front, {h, static_cast<std::size_t>(n)});
      tyres_[1].add(path.slip[i].rear, w * path.load_rear, {h + n, static_cast<std::size_t>(n)});
    }
    rows_.col(0).head(n) = rows_.col(1).head(n) * (-path.sine * load_[0] / car_.m);
    rows_(2 * n, 0) = -gravity;
    rows_(2 * n + 1, 0) = -gravity * path.mean_square_speed() / square(car_.v_ref);
    if (learns_drive()) rows_(2 * n + (path.drive_force < 0 ? 3 : 2), 0) = path.drive_force / car_.m;
    rows_.col(2).head(n) = rows_.col(1).head(n) * (path.cosine * load_[0] * car_.lf / car_.Iz);
    rows_.col(2).segment(n, n) = rows_.col(1).segment(n, n) * (-load_[1] * car_.lr / car_.Iz);
    rows_.col(1).head(n) *= path.cosine * load_[0] / car_.m;
    rows_.col(1).segment(n, n) *= load_[1] / car_.m;
    const double left = path.load_front * peaks_.front + path.load_rear * peaks_.rear;
    side_used_ = car_.m * std::abs(rows_.col(1).head(2 * n).dot(rls_.theta().head(2 * n))) / left;
    rates_ = {path.drive_loss / car_.m, path.side / car_.m, path.moment / car_.Iz};
    if (learns_arm()) {
      const double drive_force = path.drive_force + gains_.missing(path.drive_force);
      const double side_force = car_.m * rows_.col(1).head(2 * n).dot(rls_.theta().head(2 * n));
      rows_(unknowns() - 1, 2) = DriveGains{.arm = 1}.turning_moment(drive_force, side_force, car_.m) / car_.Iz;
    }
  }

  /// Drive force over mass, negative of brakes [m/s2].
  double drive_of(const Sample& k) const { return drive_.at(k.x.vx, k.u.d - k.d_lag, k.at).drive_force / car_.m; }

  /// How well the equations of side force and moment hold where drive and brakes share friction with them. A side force
  /// is F sqrt(1 - u) with the share u of the square that drive or brakes use; where u is known to a share s of itself,
  /// its relative standard deviation is s u / (1 - u) / 2. That both are doubted for one reason is not said of them.
  void doubt_sharing(const Sample& k) {
    StraightDrive::Rates drive = drive_.at(k.x.vx, k.u.d - k.d_lag, k.at).on_road(road_load(k));
    drive.drive_force += gains_.missing(drive.drive_force);
    const auto doubt = [&](Axle axle, double load, double peak) {
      const Eigen::Index i = first(axle), n = n_;
      const double kept = ellipse_.side_share(axle, drive.drive_force, load, peak);
      const double force = rows_.col(1).segment(i, n).dot(rls_.theta().segment(i, n));
      return 0.5 * params_.sharing_spread * (1.0 / square(kept) - 1.0) * force;
    };
    const double front = doubt(Axle::front, drive.load_front, peaks_.front);
    const double rear = doubt(Axle::rear, drive.load_rear, peaks_.rear);
    sharing_misfit_ = {0.0, std::hypot(front, rear), std::hypot(front * car_.lf, rear * car_.lr) / square(gyration_)};
  }

  /// Takes the tyres, and the gains and the arm of drive and brakes, as they are believed to be in this step. Where drive or brakes
  /// use much of the friction, slip control, their split and the ellipse decide what arrives on the road and what is
  /// left for side forces, and none of them is known well. `side`: side force and moment go on teaching.
  void leave_drive_and_tyres(bool side) {
    const auto leave = [this](int c, Eigen::Index from, Eigen::Index count) {
      rates_[c] -= rows_.col(c).segment(from, count).dot(rls_.theta().segment(from, count));
      rows_.col(c).segment(from, count).setZero();
    };
    for (int c = 0; c < channels; ++c) {
      if (c == 0 || !side) leave(c, 0, 2 * n_);
      leave(c, 2 * n_ + 2, unknowns() - 2 * n_ - 2);
    }
  }

  /// What comes next does not follow what came before.
  void break_sequence() {
    continues_ = false;
    last_error_ = {};
    since_change_ = INFINITY;
  }

  void start_over() {
    const Eigen::Index n = n_;
    seen_ = 0;
    break_sequence();
    score_ = score_variance_ = 0;
    sigma_ = {params_.sigma_v, params_.sigma_v, params_.sigma_omega};
    misfit_ = {params_.misfit, params_.misfit, params_.misfit / gyration_};
    sharing_misfit_ = {};
    rls_.theta().setZero();
    rls_.theta().head(2 * n) = prior_mean_;
    rls_.reset_covariance(prior_covariance_);
    read_theta();
    // The mean of curves that peak at different slips has a lower peak than each: scaled to the expected friction.
    rls_.theta().head(n) *= expected_ / belief_.mu_front;
    rls_.theta().segment(n, n) *= expected_ / belief_.mu_rear;
    read_theta();
  }

  /// False after a spin or a contact with a wall, which the equations do not cover: what was learned is discarded.
  bool plausible() const {
    const auto fair = [this](double mu) { return mu > 0.05 * expected_ && mu < 4 * expected_; };
    return fair(belief_.mu_front) && fair(belief_.mu_rear) && std::min(gains_.drive, gains_.brake) > -0.9;
  }

  void forget(double dt) {
    spread_along_curves(params_.drift * std::sqrt(dt), params_.axle_drift * std::sqrt(dt));
    rls_.covariance() += prior_covariance_ * (dt / params_.shape_memory);
  }

  /// Uncertainty of friction: standard deviations relative to it, of both axles together and of each alone.
  void spread_along_curves(double together, double each) {
    const Eigen::Index n = n_;
    const auto curves = rls_.theta().head(2 * n);
    rls_.covariance().topLeftCorner(2 * n, 2 * n).noalias() += (square(together) * curves) * curves.transpose();
    for (const Eigen::Index i : {Eigen::Index{0}, n}) {
      const auto curve = rls_.theta().segment(i, n);
      rls_.covariance().block(i, i, n, n).noalias() += (square(each) * curve) * curve.transpose();
    }
  }

  /// Score test for a sudden change of friction: a common scale on the forces, over the last samples with large forces.
  /// At small ones an offset of the steering looks like a change.
  void test_for_change(double dt) {
    const Eigen::Index n = n_;
    const double side = std::abs(rows_.col(1).head(2 * n).dot(rls_.theta().head(2 * n)));
    if (side < tested_share * gravity * std::min(belief_.mu_front, belief_.mu_rear)) return;
    score_ *= score_memory;
    score_variance_ *= score_memory;
    for (int c : {1, 2}) {
      const auto innovation = rls_.innovation(c, rows_.col(c), rates_[c], dt, misfit(c));
      const double force = rows_.col(c).head(2 * n).dot(rls_.theta().head(2 * n));
      score_ += innovation.error * force / innovation.variance;
      score_variance_ += square(force) / innovation.variance;
    }
    if (square(score_) <= square(params_.alarm) * score_variance_ || seen_ < settling) return;
    spread_along_curves(params_.change, 0.3 * params_.change);
    rls_.doubt_noise(sigma_.data());
    score_ = score_variance_ = 0;
    since_change_ = 0;
  }

  /// Moves the assumed noise of a channel until the innovations have the variance they are said to have, and the
  /// assumed misfit until they are no longer correlated: what the equations leave out lasts, noise does not.
  void adapt_noise(int c, const DifferenceRls::Innovation& innovation) {
    if (seen_ < settling) return;
    const double ratio = std::min(4.0, square(innovation.error) / innovation.variance);
    sigma_[c] = std::clamp(sigma_[c] * std::exp(0.5 * noise_gain * (ratio - 1.0)), smallest_sigma * largest_sigma_[c],
                           largest_sigma_[c]);
    const double product = innovation.error * last_error_[c] / innovation.variance;
    last_error_[c] = innovation.error;
    const double least = c == 2 ? params_.misfit / gyration_ : params_.misfit;
    misfit_[c] =
        std::clamp(misfit_[c] * std::exp(misfit_gain * (std::clamp(product, -2.0, 2.0) - 0.1)), least, 100 * least);
  }

  double deviation(Axle axle, double slip) const {
    const Eigen::Index n = n_, i = first(axle);
    std::array<double, Tyres::most_nodes> values;
    Eigen::Map<Eigen::VectorXd> h(values.data(), n);
    nodes_[axle == Axle::front ? 0 : 1].read(slip, h);
    const auto covariance = rls_.covariance();
    double variance = 0;
    for (Eigen::Index a = 0; a < n; ++a) variance += h[a] * covariance.block(i, i + a, n, 1).col(0).dot(h);
    return load_[axle == Axle::front ? 0 : 1] * std::sqrt(std::max(0.0, variance));
  }

  void read_theta() {
    const Eigen::Index n = n_;
    nodes_[0].fill(tables_.front, rls_.theta().segment(0, n), load_[0]);
    nodes_[1].fill(tables_.rear, rls_.theta().segment(n, n), load_[1]);
    const double weight = car_.m * gravity;
    resistance_ = {weight * rls_.theta()[2 * n], weight * rls_.theta()[2 * n + 1] / square(car_.v_ref)};
    if (learns_drive()) {
      gains_.drive = rls_.theta()[2 * n + 2];
      gains_.brake = rls_.theta()[2 * n + 3];
    }
    if (learns_arm()) gains_.arm = rls_.theta()[unknowns() - 1];
    peaks_ = {std::max(tables_.front.peak(peak_reach), 1e-3 * load_[0]),
              std::max(tables_.rear.peak(peak_reach), 1e-3 * load_[1])};
    belief_.mu_front = tables_.front.peak(peak_reach) / load_[0];
    belief_.mu_rear = tables_.rear.peak(peak_reach) / load_[1];
    belief_.sigma_front = deviation(Axle::front, tables_.front.peak_slip(peak_reach)) / load_[0];
    belief_.sigma_rear = deviation(Axle::rear, tables_.rear.peak_slip(peak_reach)) / load_[1];
    belief_.trusted = seen_ >= settling;
  }

  static constexpr int settling = 50;  // samples before the innovations are taken as evidence

  Params params_;
  Car car_;
  StraightDrive drive_;
  std::array<Tyres, 2> tyres_;  // front, rear
  std::array<TabulatedLayer, 2> nodes_;
  Eigen::Index n_;  // unknowns of an axle
  DifferenceRls rls_;
  std::array<double, 2> load_;  // static axle loads [N]
  double expected_, gyration_;
  FrictionEllipse ellipse_;
  PeakForces peaks_;
  std::array<double, channels> largest_sigma_, sigma_ = {}, misfit_ = {}, sharing_misfit_ = {}, last_error_ = {},
                                               rates_ = {};
  Eigen::MatrixXd rows_;
  Eigen::VectorXd prior_mean_;  // of both axles' theta
  Eigen::MatrixXd prior_covariance_;
  AxleTables tables_;
  ResistanceForce resistance_;
  DriveGains gains_;
  Belief belief_;
  double score_ = 0, score_variance_ = 0;
  double side_used_ = 0;  // side force over the largest that drive and brakes leave
  double since_change_ = INFINITY;  // [s] of samples
  std::int64_t seen_ = 0;
  bool continues_ = false;
};

/// The same learned tyres, but the friction that plans are made for is the true one: the upper bound for a world whose
/// car is a black box.
class ToldElmRls final : public ElmRls {
 public:
  ToldElmRls(const PluginContext& context, const Params& params) : ElmRls(context, params), truth_(context.truth) {
    if (truth_ == nullptr) throw std::runtime_error("elm_rls_told needs the truth of a world; there is none here");
  }
  Belief belief() const override {
    return {truth_->mu(Axle::front), truth_->mu(Axle::rear), 0, 0, ElmRls::belief().trusted};
  }

 private:
  const Truth* truth_;
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<ElmRls>("elm_rls", "1.0", "generic tyres per axle by recursive least squares"),
    gripline::describe<ToldElmRls>("elm_rls_told", "1.0", "as elm_rls, told the true friction").needs_truth())
