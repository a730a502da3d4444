// No learning: the correction is zero and the belief stays the stack's mu_init.
#include <gripline/plugin.hpp>

namespace {

class None final : public gripline::AutoDiffEffect<None, gripline::Estimator> {
 public:
  explicit None(const gripline::PluginContext& context) : belief_{context.mu_init, context.mu_init} {}
  void update(const gripline::Sample&) override {}
  gripline::Belief belief() const override { return belief_; }
  template <class T>
  void act(gripline::Point<T>&) const {}

 private:
  gripline::Belief belief_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<None>("none", "1.0", "no learning: the nominal model and mu_init throughout"))
