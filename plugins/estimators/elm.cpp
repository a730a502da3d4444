// The paper's learner: an extreme learning machine per axle for the lateral force, and the resistance Cr0 + Cd vx^2.
//
//   F_axle(slip) = m g sum_j beta_j h_j(slip),   h fixed at random (hidden_layer.hpp)
//
// The unknowns z = (beta_front, beta_rear, Cr0, Cd) enter the equations of step_path.hpp linearly, hence the loss over
// the window, L(z) = mean of squared errors of the rates, is a quadratic with the window's Gram matrix, and the paper's
// iterations of gradient descent with momentum,
//   v <- momentum v + dL/dz,   z <- z - rate v,
// run on that matrix: exact, and independent of the window's length. Everything is dimensionless: accelerations in g,
// yaw acceleration times the radius of gyration sqrt(Iz/m) in g, forces in m g, speed in v_ref. The published rate
// belongs to a loss on increments of the 1:43 car, whose curvature is (dt lf / Iz)^2 2/3 = 290 per squared newton;
// `rate` keeps its published value by being multiplied with that number, and the resistance its published slowness by
// the ratio of the two sensitivities, (dt / m) / (dt lf / Iz) = 0.023 there. Momentum as in the published code: the
// gradient is not multiplied by (1 - momentum).
//
// Beyond the slips a car visits (slip_cap) hardly anything is measured; a weak penalty on the slope there holds the
// curve level.
//
// Source: Kalaria, Lin, Dolan, their extreme learning machine with its prediction of the error, its loss and its
// friction, corrected as in step_path.hpp and tyre_correction.hpp; mu = (max Ff + max Fr) / (m g) over the slips
// visited, per axle here. The published code takes 0.45 rad as visited from the start; a rear axle that is driven well
// does not get there, and the curve beyond is extrapolated.
#include <Eigen/Cholesky>
#include <gripline/plugin.hpp>

#include "common/learning/axle_table.hpp"
#include "common/learning/hidden_layer.hpp"
#include "common/learning/step_path.hpp"
#include "common/learning/tyre_correction.hpp"
#include "common/learning/window_gram.hpp"
#include "common/vehicle/axle_loads.hpp"

namespace {

using namespace gripline;
using namespace gripline::learning;

constexpr double published_curvature = 290.0;
constexpr double resistance_scale = 0.023;
constexpr double least_mu = 0.2;  // for the friction ellipse while little is learned
// Nodes overlap: the window's matrix is singular to rounding, which is 1e-14 of its largest eigenvalue, about 1.
constexpr double least_ridge = 1e-12;

class Elm final : public AutoDiffEffect<Elm, Estimator> {
 public:
  struct Params {
    int hidden = 40;
    double rate = 0.002, momentum = 0.9;
    int window = 300, iterations = 50;
    double retain = 0.97;
    double slip_start = 0.3, slip_cap = 0.6;
    double level = 3e-3, ridge = 1e-9;
    int solver = 0;
    double ellipse = 0, drive_front = 0, brake_front = 0;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple_cat(
        std::tuple{
            param("hidden", &P::hidden, "1", {1, 1000}, "hidden nodes per axle"),
            param("rate", &P::rate, "1", {0, 1}, "rate of gradient descent, in the published code's units"),
            param("momentum", &P::momentum, "1", {0, 0.999}, "share of the last update that is kept"),
            param("window", &P::window, "1", {1, 100000}, "samples learned from (K_batch)"),
            param("iterations", &P::iterations, "1", {0, 10000}, "descents per control step"),
            param("retain", &P::retain, "1", {0.5, 1},
                  "weight of a sample relative to the next one; 1: all count equally"),
            param("slip_start", &P::slip_start, "rad", {0, 1.5}, "slip range assumed visited at the start, for mu"),
            param("slip_cap", &P::slip_cap, "rad", {0.01, 1.5}, "largest slip of interest: nodes lie below, and mu"),
            param("level", &P::level, "1", {0, 1e3}, "weight of a level curve beyond the slips that are visited"),
            param("ridge", &P::ridge, "1", {0, 1},
                  "weight on the squared unknowns in the pseudo-inverse; at least 1e-12"),
            choice("solver", &P::solver, "momentum|pseudo_inverse", "how the window's loss is minimised")},
        ellipse_parameters<P>());
  }

  Elm(const PluginContext& context, const Params& params)
      : params_(params),
        car_(context.car),
        drive_(context),
        random_(context.seed),
        front_layer_(params.hidden, params.slip_cap, random_),
        rear_layer_(params.hidden, params.slip_cap, random_),
        front_nodes_(front_layer_),
        rear_nodes_(rear_layer_),
        gram_(unknowns(), 3, params.window, params.retain),
        mu_init_(context.mu_init),
        terms_{.model_has_tyres = drive_.model_has_tyres(),
               .v_min = car_.v_min,
               .ellipse = {params.ellipse, params.drive_front, params.brake_front}},
        visited_{std::min(params.slip_start, params.slip_cap), std::min(params.slip_start, params.slip_cap)} {
    for (auto* vector : {&weights_, &velocity_, &gradient_}) vector->setZero(unknowns());
    rows_.setZero(unknowns(), 3);
    normal_.setZero(unknowns(), unknowns());
    factors_ = Eigen::LLT<Eigen::MatrixXd>(normal_);
    level_.setZero(unknowns(), unknowns());
    penalise_slopes(front_nodes_, 0);
    penalise_slopes(rear_nodes_, params.hidden);
  }

  void update(const Sample& k) override {
    if (std::min(k.x.vx, k.x_next.vx) < car_.v_min || k.dt <= 0.0) return;
    const auto force = [this](Axle axle, double slip) { return tyres_.of(axle).at(slip).force; };
    const LearnedCar car{car_, drive_, terms_, force};
    const StepPath path = step_path(k, car, learned());
    fill_rows(path);
    gram_.add(rows_, targets_);
    visit(path);
    if (params_.solver == 0)
      descend();
    else
      solve();
    read_weights();
  }

  Belief belief() const override {
    if (!learned()) return {mu_init_, mu_init_};
    const double L = car_.lf + car_.lr, weight = car_.m * gravity;
    return {tyres_.front.peak(visited_.front) * L / (weight * car_.lr),
            tyres_.rear.peak(visited_.rear) * L / (weight * car_.lf), misfit_, misfit_};
  }

  bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    if (!learned()) return false;
    tyres_.forces(axle, slip, force);
    const double share = (axle == Axle::front ? car_.lr : car_.lf) / (car_.lf + car_.lr);
    for (double& one : sigma) one = misfit_ * share * car_.m * gravity;
    return true;
  }

  template <class T>
  void act(Point<T>& p) const {
    if (!learned()) return;
    correct_body(p.q, p.at, terms_, [this](Axle axle, const T& slip) { return tyres_.of(axle).force(slip); });
  }

 private:
  Eigen::Index unknowns() const { return 2 * static_cast<Eigen::Index>(params_.hidden) + 2; }
  /// Whether enough was seen to speak of friction, and to correct: 50 samples, a second at 20 ms, or a window of fewer.
  bool learned() const { return gram_.count() >= std::min(params_.window, 50); }

  /// Adds the penalty on slopes beyond slip_cap to the unknowns from `first` on.
  void penalise_slopes(const TabulatedLayer& nodes, Eigen::Index first) {
    const Eigen::Index n = params_.hidden;
    for (std::ptrdiff_t i = 0; i < table_knots; ++i) {
      if (std::abs(table_slip(i)) <= params_.slip_cap) continue;
      const Eigen::VectorXd h = nodes.slopes(i);
      level_.block(first, first, n, n) += params_.level * table_step * h * h.transpose();
    }
  }

  /// The three equations of step_path.hpp, dimensionless.
  void fill_rows(const StepPath& path) {
    const Eigen::Index n = params_.hidden;
    const double gyration = std::sqrt(car_.Iz / car_.m);
    const double weight = car_.m * gravity;
    rows_.setZero();
    double* const h = rows_.data();  // column 0: mean features of both axles, to be scaled per equation
    for (int i = 0; i < path_points; ++i) {
      const double w = path_weights[i];
      front_layer_.add(path.slip[i].front, w * path.load_front, {h, static_cast<std::size_t>(n)});
      rear_layer_.add(path.slip[i].rear, w * path.load_rear, {h + n, static_cast<std::size_t>(n)});
    }
    rows_.col(1).head(n) = path.cosine * rows_.col(0).head(n);
    rows_.col(1).segment(n, n) = rows_.col(0).segment(n, n);
    rows_.col(2).head(n) = car_.lf / gyration * path.cosine * rows_.col(0).head(n);
    rows_.col(2).segment(n, n) = -car_.lr / gyration * rows_.col(0).segment(n, n);
    rows_.col(0).head(n) *= -path.sine;
    rows_.col(0).segment(n, n).setZero();
    rows_(2 * n, 0) = -resistance_scale;
    rows_(2 * n + 1, 0) = -resistance_scale * path.mean_square_speed() / square(car_.v_ref);
    targets_ = {path.drive_loss / weight, path.side / weight, path.moment / (gyration * weight)};
  }

  void visit(const StepPath& path) {
    for (const auto& slip : {path.slip.front(), path.slip.back()}) {
      visited_.front = std::max(visited_.front, std::min(params_.slip_cap, std::abs(slip.front)));
      visited_.rear = std::max(visited_.rear, std::min(params_.slip_cap, std::abs(slip.rear)));
    }
  }

  /// Second derivative of the loss: mean over the samples and the three equations, as in the published code.
  void form_normal() { normal_ = gram_.gram() * (2.0 / (3.0 * gram_.weight())) + level_; }

  void descend() {
    form_normal();
    const double slope_scale = 2.0 / (3.0 * gram_.weight());
    // The step may not exceed the stability limit 2 (1 + momentum) / largest eigenvalue; the trace bounds that value.
    const double limit = 1.9 * (1.0 + params_.momentum) / std::max(1e-12, normal_.trace());
    const double rate = std::min(params_.rate * published_curvature, limit);
    for (int i = 0; i < params_.iterations; ++i) {
      gradient_.noalias() = normal_ * weights_;
      gradient_ -= slope_scale * gram_.moment();
      velocity_ = params_.momentum * velocity_ + gradient_;
      weights_ -= rate * velocity_;
    }
  }

  void solve() {
    form_normal();
    normal_.diagonal().array() += std::max(params_.ridge, least_ridge);
    factors_.compute(normal_);
    if (factors_.info() != Eigen::Success) return;  // the weights of the step before stay
    gradient_ = gram_.moment() * (2.0 / (3.0 * gram_.weight()));
    weights_ = factors_.solve(gradient_);
  }

  void read_weights() {
    const Eigen::Index n = params_.hidden;
    const double weight = car_.m * gravity;
    front_nodes_.fill(tyres_.front, weights_.segment(0, n), weight);
    rear_nodes_.fill(tyres_.rear, weights_.segment(n, n), weight);
    terms_.resistance = {resistance_scale * weight * weights_[2 * n],
                         resistance_scale * weight * weights_[2 * n + 1] / square(car_.v_ref)};
    const vehicle::AxleLoads least = vehicle::axle_loads(least_mu * weight, car_);
    terms_.peaks = {std::max(tyres_.front.peak(visited_.front), least.front),
                    std::max(tyres_.rear.peak(visited_.rear), least.rear)};
    misfit_ = std::sqrt(gram_.residual(weights_, gradient_) / (3.0 * gram_.weight()));
  }

  Params params_;
  Car car_;
  StraightDrive drive_;
  SplitMix64 random_;
  HiddenLayer front_layer_, rear_layer_;
  TabulatedLayer front_nodes_, rear_nodes_;
  WindowGram gram_;
  double mu_init_;
  CorrectionTerms terms_;
  Slips visited_;
  Eigen::MatrixXd rows_, normal_, level_;
  Eigen::VectorXd weights_, velocity_, gradient_;
  Eigen::Vector3d targets_ = Eigen::Vector3d::Zero();
  Eigen::LLT<Eigen::MatrixXd> factors_;
  AxleTables tyres_;
  double misfit_ = 0;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<Elm>("elm", "1.0", "extreme learning machine per axle, by momentum descent"))
