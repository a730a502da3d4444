#include <gripline/params.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include <gripline/plugin.hpp>

namespace gripline {
namespace test_params {

/// Parameters of every kind beside each other, as an effect has them: numbers carry derivatives.
class Mixed final : public AutoDiffEffect<Mixed> {
 public:
  template <class T>
  struct Params {
    T k = T(2);
    std::array<T, 3> c = {T(1), T(2), T(3)};
    int mode = 1;
    bool on = true;
    Table curve;
    T last = T(0.5);
  };
  static constexpr auto parameters() {
    using P = Params<double>;
    return std::tuple{param("k", &P::k, "1", {-9, 9}, "a factor").fit(0, 0.1, 0.2),
                      param({"c_a", "c_b", "c_c"}, &P::c, "m", {-5, 5}, "three lengths").fit(1, 2, 3),
                      choice("mode", &P::mode, "slow|fast", "one of two"),
                      param("on", &P::on, "1", {0, 1}, "a switch"),
                      param("curve", &P::curve, "1", {-10, 10}, "a table"),
                      param("last", &P::last, "1", {0, 1}, "after the table").periodic()};
  }
  Stage stage() const noexcept override { return Stage::body; }
  template <class T>
  void act(Point<T>& p, const Params<T>& k) const {
    p.q.ax = k.k * (k.c[0] + 10.0 * k.c[1] + 100.0 * k.c[2]) + k.last;
    p.q.ay = T(k.curve.rows > 0 ? k.curve.at(1, 1) : -1.0);
    p.q.aw = T(k.mode + (k.on ? 10 : 0));
  }
};

/// An instance as the host makes it.
template <class Interface>
class Made {
 public:
  Made(const Description& described, const std::vector<abi::ParamValue>& values, const PluginContext& context = {})
      : destroy_(described.decl.destroy) {
    char error[200] = "";
    raw_ = static_cast<Interface*>(described.decl.create(&context, values.data(), error, sizeof error));
    EXPECT_STREQ(error, "");
  }
  ~Made() { destroy_(raw_); }
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;
  Interface* operator->() const { return raw_; }

 private:
  Interface* raw_;
  void (*destroy_)(void*);
};

const double curve[] = {0, 4, 1, 7};
constexpr Description mixed = describe<Mixed>("mixed", "1.0", "parameters of every kind");
const std::vector<abi::ParamValue> mixed_values = {
    {3, {}}, {1, {}}, {2, {}}, {4, {}}, {0, {}}, {1, {}}, {0, {curve, 2, 2}}, {0.25, {}}};

template <class T>
Quantities<T> applied(const Effect& effect, const std::vector<T>& params) {
  Quantities<T> q{};
  const Place at;
  Points<T> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  points.params = params.data();
  effect.apply(points);
  return q;
}

TEST(Params, AreDeclaredOneByOneInOrder) {
  const std::span<const abi::ParamDecl> decls(mixed.decl.params, mixed.decl.param_count);
  const char* const names[] = {"k", "c_a", "c_b", "c_c", "mode", "on", "curve", "last"};
  const abi::ParamType types[] = {abi::ParamType::number, abi::ParamType::number, abi::ParamType::number,
                                  abi::ParamType::number, abi::ParamType::choice, abi::ParamType::boolean,
                                  abi::ParamType::table,  abi::ParamType::number};
  const double defaults[] = {2, 1, 2, 3, 1, 1, 0, 0.5};
  ASSERT_EQ(decls.size(), std::size(names));
  for (std::size_t i = 0; i < decls.size(); ++i) {
    EXPECT_STREQ(decls[i].name, names[i]);
    EXPECT_EQ(decls[i].type, types[i]) << names[i];
    EXPECT_EQ(decls[i].default_value, defaults[i]) << names[i];
    EXPECT_EQ(decls[i].fit, i < 4) << names[i];
    EXPECT_EQ(decls[i].periodic, i == 7) << names[i];
  }
  EXPECT_STREQ(decls[2].unit, "m");
  EXPECT_STREQ(decls[4].choices, "slow|fast");
  EXPECT_EQ(std::tuple(decls[3].neutral, decls[3].start, decls[3].scale), std::tuple(1.0, 2.0, 3.0));
}

TEST(Params, ReachTheirMembersWhateverTheirKind) {
  const Made<Effect> effect(mixed, mixed_values);
  const auto q = applied<double>(*effect.operator->(), {3, 1, 2, 4, 0, 1, 0, 0.25});
  EXPECT_EQ(q.ax, 3 * (1 + 20 + 400) + 0.25);
  EXPECT_EQ(q.ay, 7);
  EXPECT_EQ(q.aw, 10);
}

TEST(Params, CarryDerivativesInArraysAndBehindTables) {
  const Made<Effect> effect(mixed, mixed_values);
  std::vector<Dual8> params;
  int direction = 0;
  for (const double value : {3.0, 1.0, 2.0, 4.0, 1.0, 0.0, 0.0, 0.25})
    params.push_back(Dual8::variable(value, direction++));
  const auto q = applied<Dual8>(*effect.operator->(), params);
  EXPECT_EQ(q.ax.v, 3 * 421 + 0.25);
  const double slopes[] = {421, 3, 30, 300, 0, 0, 0, 1};
  for (int i = 0; i < 8; ++i) EXPECT_EQ(q.ax.d[i], slopes[i]) << i;
  EXPECT_EQ(q.ay.v, 7);
  EXPECT_EQ(q.aw.v, 1);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(q.ay.d[i] + q.aw.d[i], 0) << i;
}

/// A plain struct: any order, arrays too, from values given once.
class Plain final : public Controller {
 public:
  struct Params {
    Table curve;
    std::array<int, 2> counts = {1, 2};
    double gain = 0.5;
  };
  static constexpr auto parameters() {
    return std::tuple{param("gain", &Params::gain, "1", {0, 9}, "a gain"),
                      param({"first", "second"}, &Params::counts, "1", {0, 9}, "two counts"),
                      param("curve", &Params::curve, "1", {0, 9}, "a table")};
  }
  Plain(const PluginContext&, const Params& params) : params_(params) {}
  int horizon() const noexcept override { return params_.counts[0] + 100 * params_.counts[1]; }
  Command control(const Observation&, std::span<const RefPoint>, Prediction&) override { return {}; }
  std::span<const State> predicted() const override { return std::span(states_).first(params_.curve.rows); }

 private:
  Params params_;
  std::array<State, 4> states_;
};

TEST(Params, APlainStructMayHaveAnyOrder) {
  const Made<Controller> controller(describe<Plain>("plain", "1.0", "a plain struct"),
                                    {{4, {}}, {5, {}}, {6, {}}, {0, {curve, 2, 2}}});
  EXPECT_EQ(controller->horizon(), 605);
  EXPECT_EQ(controller->predicted().size(), 2u);
}

}  // namespace test_params
}  // namespace gripline
