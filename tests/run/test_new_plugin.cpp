// gripline plugins new: what it writes builds, passes the conformance kit and races, for every kind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_new_plugin {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;

class NewPlugin : public testing::TestWithParam<std::string> {
 protected:
  Outcome run(const std::vector<std::string>& words) {
    return run_program(words, {.folder = folder_.path(), .environment = {{"PATH", path()}}});
  }
  /// As for a user who put the program on the PATH.
  static std::string path() {
    return gripline_program().parent_path().string() + ":" +
           (std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
  }
  /// Speeds of the car my_first, which begins at rest and is braked for a second [m/s].
  std::vector<double> braked_from_rest() {
    write_text(folder_ / "brakes.json", R"({
      "world": {"extends": "worlds/ethz.json", "laps": null, "timeout": null, "duration": "1 s", "start": {"speed": 0},
                "plant": {"plugin": "my_first", "params": null, "integrator": null, "note": null},
                "time_optimal_laps": null},
      "base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}},
               "controller": {"plugin": "spy.constant", "params": {"d": -1}}},
      "stacks": {"brakes": {}}})");
    const Outcome drove = run({"gripline", "run", "brakes.json", "--stack", "brakes", "--out", "braked", "--plugins",
                               "my_first/build", "--plugins", fixture_plugins("spies")});
    EXPECT_EQ(drove.code, 0) << drove.out << drove.err;
    return read_csv(folder_ / "braked/brakes/1/steps.csv").column("vx_true_mps");
  }
  Folder folder_;
};

TEST_P(NewPlugin, BuildsConformsAndRaces) {
  const Outcome made = run({"gripline", "plugins", "new", GetParam(), "my_first"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_LT(lines(folder_ / "my_first/my_first.cpp").size(), 60U);
  for (const char* file : {"my_first/my_first.cpp", "my_first/CMakeLists.txt", "my_first/try.json"}) {
    EXPECT_THAT(contents(folder_ / file), HasSubstr("my_first")) << file;
    EXPECT_THAT(contents(folder_ / file), testing::Not(HasSubstr("new_plugin"))) << file;
  }
  // The commands that it prints.
  const Outcome configured = run({"cmake", "-S", "my_first", "-B", "my_first/build"});
  ASSERT_EQ(configured.code, 0) << configured.out << configured.err;
  const Outcome built = run({"cmake", "--build", "my_first/build"});
  ASSERT_EQ(built.code, 0) << built.out << built.err;
  EXPECT_THAT(built.out + built.err, testing::Not(HasSubstr("warning")));
  const Outcome checked = run({"ctest", "--test-dir", "my_first/build", "--output-on-failure"});
  EXPECT_EQ(checked.code, 0) << checked.out;
  const Outcome described = run({"gripline", "plugins", "describe", "my_first", "--plugins", "my_first/build"});
  EXPECT_EQ(described.code, 0) << described.err;
  if (GetParam() != "planner") {
    EXPECT_THAT(described.out, testing::AnyOf(HasSubstr("    vx' = "), HasSubstr("    ax -= a (vx / v_ref)^2\n"),
                                              HasSubstr("    e_vx = "), HasSubstr("    delta = ")));
  }
  const Outcome raced = run({"gripline", "compare", "my_first/try.json", "--plugins", "my_first/build"});
  EXPECT_EQ(raced.code, 0) << raced.out << raced.err;
  EXPECT_EQ(lines(folder_ / "out/try/table.csv").size(), 3U);
  EXPECT_THAT(contents(folder_ / "out/try/runs.csv"), HasSubstr(",1,finished,"));
  EXPECT_THAT(contents(folder_ / "out/try/runs.csv"), testing::Not(HasSubstr("error"))) << raced.err;
  if (GetParam() == "vehicle" || GetParam() == "plant") {
    const std::vector<double> speeds = braked_from_rest();
    EXPECT_GT(speeds.size(), 49U);
    EXPECT_THAT(speeds, testing::Each(testing::DoubleNear(0.0, 0.05)));
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, NewPlugin,
                         testing::Values("vehicle", "effect", "estimator", "planner", "controller", "plant"),
                         [](const auto& info) { return info.param; });

TEST(NewPluginRefused, WrongWords) {
  const Folder folder;
  const Call here{.folder = folder.path(), .environment = {}};
  const auto refused = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"plugins", "new"});
    const Outcome outcome = gripline_with(words, here);
    EXPECT_EQ(outcome.code, 2);
    return outcome.err;
  };
  EXPECT_THAT(refused({"estimater", "x"}), HasSubstr("did you mean \"estimator\"?"));
  EXPECT_THAT(refused({"estimator", "My-Drag"}), HasSubstr("cannot be a plugin's name"));
  EXPECT_THAT(refused({"estimator"}), HasSubstr("plugins new KIND NAME"));
  fs::create_directory(folder / "there");
  EXPECT_THAT(refused({"estimator", "there"}), HasSubstr("is there already; --out names another folder"));
}

TEST(NewPluginBuild, IsOptimisedWhereNoTypeIsGiven) {
  const Folder folder;
  ASSERT_EQ(gripline_with({"plugins", "new", "effect", "my_drag"}, {.folder = folder.path(), .environment = {}}).code,
            0);
  const std::string prefix = "-DCMAKE_PREFIX_PATH=" + build_dir().string();
  for (const auto& [type, wanted, other] :
       {std::tuple{"", " -O2 ", " -g "}, std::tuple{"-DCMAKE_BUILD_TYPE=Debug", " -g ", " -O2 "}}) {
    std::vector<std::string> words = {"cmake",
                                      "-S",
                                      folder / "my_drag",
                                      "-B",
                                      folder / (std::string("b") + type),
                                      "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
                                      prefix};
    if (*type != '\0') words.emplace_back(type);
    const Outcome configured = run_program(words);
    ASSERT_EQ(configured.code, 0) << configured.err;
    EXPECT_THAT(configured.out + configured.err, testing::Not(HasSubstr("version: unknown")));
    const std::string commands = contents(folder / (std::string("b") + type) / "compile_commands.json");
    EXPECT_THAT(commands, HasSubstr(wanted));
    EXPECT_THAT(commands, testing::Not(HasSubstr(other)));
  }
}

}  // namespace test_new_plugin
}  // namespace gripline
