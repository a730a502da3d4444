// An estimator from outside: built against the SDK's headers alone, and against an install tree, then raced through
// --plugins without any rebuild of ours.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_external_plugin {

using testing::HasSubstr;
using namespace testing_support;
namespace fs = std::filesystem;

class ExternalPlugin : public testing::Test {
 protected:
  ExternalPlugin() { fs::copy(source_dir() / "tests/external", folder_ / "mine"); }

  /// Configures and builds the copy outside our tree; the folder of the plugin.
  fs::path build(std::vector<std::string> settings) {
    const fs::path tree = folder_ / "mine/build";
    std::vector<std::string> configure = {"cmake", "-S", folder_ / "mine", "-B", tree, "-DCMAKE_BUILD_TYPE=Release"};
    configure.insert(configure.end(), settings.begin(), settings.end());
    const Outcome configured = run_program(configure);
    EXPECT_EQ(configured.code, 0) << configured.out << configured.err;
    const Outcome built = run_program({"cmake", "--build", tree});
    EXPECT_EQ(built.code, 0) << built.out << built.err;
    EXPECT_TRUE(fs::exists(tree / "my_estimator.so"));
    return tree;
  }

  /// It learns the drag that the world has and the nominal model lacks: races, and shows it in the files.
  void race(const fs::path& plugin_folder) {
    const Outcome listed = gripline_with({"plugins", "describe", "demo.learned_drag", "--plugins", plugin_folder});
    EXPECT_EQ(listed.code, 0) << listed.err;
    EXPECT_THAT(listed.out, HasSubstr("rate [1] = 0.05  [0, 2]  step of normalised LMS"));
    const std::string out = folder_ / "out";
    const Outcome raced =
        gripline_with({"compare", "experiments/good.json", "--plugins", plugin_folder, "--out", out, "--set",
                       "/seeds/count=1", "--set", R"(/stacks/mine={"estimator": {"plugin": "demo.learned_drag"}})"});
    EXPECT_EQ(raced.code, 0) << raced.err;
    EXPECT_THAT(contents(out + "/runs.csv"), HasSubstr("mine,1,finished,0,"));
    EXPECT_EQ(read_csv(out + "/mine/1/steps.csv").rows(), 51u);
    EXPECT_THAT(contents(out + "/provenance.json"), HasSubstr("demo.learned_drag 1.0"));
  }
  Folder folder_;
};

TEST_F(ExternalPlugin, AgainstTheHeadersAlone) {
  const fs::path built = build({"-DGRIPLINE_INCLUDE=" + source_dir().string() + "/framework/include"});
  race(built);
  // What it learned, asked for in this process.
  const Registry registry({built});
  const PluginEntry& entry = registry.find(abi::Kind::estimator, "demo.learned_drag");
  const std::vector<abi::ParamValue> values = {{0.5, {}}};
  const auto estimator = create<Estimator>(entry, PluginContext{}, values);
  for (int i = 0; i < 50; ++i) {
    Sample sample;
    sample.x.vx = 1.0 + 0.02 * i;
    sample.e_vx = -0.3 * sample.x.vx * sample.x.vx;
    estimator->update(sample);
  }
  Quantities<Dual8> q{};
  q.vx = Dual8::variable(2.0, 0);
  const Place at;
  Points<Dual8> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  estimator->apply(points);
  EXPECT_NEAR(q.ax.v, -0.3 * 4, 1e-6);
  EXPECT_NEAR(q.ax.d[0], -0.3 * 4, 1e-6);
}

TEST_F(ExternalPlugin, AgainstAnInstallTree) {
  const fs::path prefix = folder_ / "installed";
  const Outcome installed = run_program({"cmake", "--install", build_dir() / "framework", "--prefix", prefix});
  ASSERT_EQ(installed.code, 0) << installed.out << installed.err;
  race(build({"-DCMAKE_PREFIX_PATH=" + prefix.string()}));
}

}  // namespace test_external_plugin
}  // namespace gripline
