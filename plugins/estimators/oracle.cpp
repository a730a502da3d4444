// The upper bound: the nominal model is corrected to the true car, e_pred = f_true - f_nom, and friction is known.
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
    return {truth_->mu(gripline::Axle::front), truth_->mu(gripline::Axle::rear), 0, 0, true};
  }

  void apply(const gripline::Points<double>& points) const override { correct(points); }
  void apply(const gripline::Points<gripline::Dual8>& points) const override { correct(points); }

  bool tyre_force(gripline::Axle axle, std::span<const double> slip, std::span<double> force,
                  std::span<double> sigma) const override {
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = truth_->tyre_force(axle, slip[i]);
    for (double& one : sigma) one = 0.0;
    return true;
  }

 private:
  /// A world whose car is a black box leaves the nominal model as it is: then only friction is known.
  template <class T>
  void correct(const gripline::Points<T>& points) const {
    if (!truth_->accelerations(points)) return;
    for (std::size_t i = 0; i < points.n; ++i) {
      points.q[i].grade = T(points.at[i].grade);
      points.q[i].bank = T(points.at[i].bank);
    }
  }

  const gripline::Truth* truth_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<Oracle>("oracle", "1.0", "knows the true car and the true friction").needs_truth())
