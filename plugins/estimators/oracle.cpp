// The upper bound: the nominal model is corrected to the true car, e_pred = f_true - f_nom, and friction is known.
// The true car answers to what acts of a command: delays, lags and gains of actuators are the nominal model's to know.
#include <stdexcept>

#include <gripline/plugin.hpp>

namespace {

class Oracle final : public gripline::Estimator {
 public:
  explicit Oracle(const gripline::PluginContext& context) : truth_(context.truth) {
    if (truth_ == nullptr) throw std::runtime_error("oracle needs the truth of a world; there is none here");
  }

  void update(const gripline::Sample&) override {}
  gripline::Belief belief() const override {
    return {truth_->mu(gripline::Axle::front), truth_->mu(gripline::Axle::rear)};
  }

  // A world whose car is a black box leaves the nominal model as it is: then only friction is known.
  void apply(const gripline::Points<double>& points) const override { truth_->accelerations(points); }
  void apply(const gripline::Points<gripline::Dual8>& points) const override { truth_->accelerations(points); }

  bool tyre_force(gripline::Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = truth_->tyre_force(axle, slip[i]);
    for (double& one : sigma) one = 0.0;
    return true;
  }

 private:
  const gripline::Truth* truth_;
};

}  // namespace

GRIPLINE_PLUGINS(
    gripline::describe<Oracle>("oracle", "1.0", "ground truth: the true car and the true friction").needs_truth())
