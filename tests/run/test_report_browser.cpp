// The report in a real browser, and its bundle rebuilt from source. Needs Chromium, Node and `npm ci` in tools/report;
// without them these tests are skipped, unless GRIPLINE_REQUIRE_BROWSER=1.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "report/columns.hpp"
#include "report/report.hpp"
#include "support/paths.hpp"
#include "support/report_sample.hpp"

namespace gripline::report {
namespace test_report_browser {

namespace fs = std::filesystem;

const fs::path source = testing_support::source_dir() / "tools" / "report";

struct Outcome {
  int code;
  std::string output;
};

/// Runs a command of the shell with stderr in its output.
Outcome shell(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, "popen failed"};
  std::string output;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) output.append(buffer.data(), n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

std::string chromium() {
  if (const char* named = std::getenv("GRIPLINE_CHROMIUM")) return named;
  std::string found = shell("command -v chromium || command -v chromium-browser || command -v google-chrome").output;
  while (!found.empty() && found.back() == '\n') found.pop_back();
  return found;
}

/// What is missing to run the scripts; empty if nothing is.
std::string missing(bool browser) {
  if (shell("command -v node").code != 0) return "Node is not installed";
  if (!fs::exists(source / "node_modules" / "esbuild")) return "tools/report/node_modules is not there (npm ci)";
  if (browser && chromium().empty()) return "Chromium is not installed";
  return "";
}

class Browser : public testing::Test {
 protected:
  void require(bool browser) {
    const std::string lack = missing(browser);
    if (lack.empty()) return;
    const char* required = std::getenv("GRIPLINE_REQUIRE_BROWSER");
    if (required != nullptr && std::string(required) == "1") FAIL() << lack;
    GTEST_SKIP() << lack;
  }
};

std::string quoted_path(const fs::path& path) { return "'" + path.string() + "'"; }

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Where the log says that cars were, at some of its instants.
nlohmann::json logged_poses(const fs::path& folder, const sample::SampleOptions& options) {
  nlohmann::json poses = nlohmann::json::array();
  for (const sample::StackPlan& stack : options.stacks) {
    const Columns steps = Columns::read(folder / stack.name / "1" / "steps.csv");
    for (std::size_t row = 40; row < steps.rows(); row += steps.rows() / 5)
      poses.push_back({{"stack", stack.name},
                       {"t", steps.number("t_s", row)},
                       {"x", steps.number("x_true_m", row)},
                       {"y", steps.number("y_true_m", row)}});
  }
  return poses;
}

/// Pages of one kind, which a browser opens one after the other: each test starts one.
class Pages : public Browser {
 protected:
  void SetUp() override {
    require(true);
    if (IsSkipped() || HasFatalFailure()) return;
    work_ =
        testing_support::build_dir() / "report_browser" / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(work_);
    fs::create_directories(work_);
    if (const char* shots = std::getenv("GRIPLINE_SCREENSHOTS")) job_["shots"] = shots;
  }
  /// Writes the report of a folder and describes it for the script.
  nlohmann::json page(const std::string& name, const std::string& kind = "other", double cpu_s = 1.0) const {
    return {{"name", name},
            {"kind", kind},
            {"cpu_s", cpu_s},
            {"file", write_report({work_ / name, {}, false, {}, {}}).page.string()}};
  }
  void add(const nlohmann::json& page) { job_["pages"].push_back(page); }
  void expect_good() const {
    std::ofstream(work_ / "job.json") << job_.dump(1);
    const Outcome outcome =
        shell("node " + quoted_path(source / "test" / "browser.mjs") + " " + quoted_path(work_ / "job.json"));
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_THAT(outcome.output, testing::HasSubstr("all checks passed"));
  }
  /// One short race, of which the first snapshot of tyres is late.
  static sample::SampleOptions one_lap() {
    sample::SampleOptions options;
    options.laps = 1;
    options.tyres_from = 2;
    options.stacks = {{"elm", false, 1, 0.9, 0.8}};
    return options;
  }

  fs::path work_;
  nlohmann::json job_ = {{"chromium", chromium()}, {"shots", ""}, {"pages", nlohmann::json::array()}};
};

TEST_F(Pages, ARaceIsShownAsItsLogSays) {
  const sample::SampleOptions five;
  sample::write_sample(work_ / "race", five);
  nlohmann::json race = page("race", "race");
  race["poses"] = logged_poses(work_ / "race", five);
  race["texts"] = {"oracle *",
                   "elm.violation_s <= none.violation_s",
                   "0.46 against 4.32 s, in 5 of 5 runs",
                   "0.083 against 0.071 m, in 1 of 5 runs",
                   "0.48 against 0.54 s at the median, but holds in 3 of 5 runs, 80 % wanted",
                   "best among the others",
                   "One seed:",
                   "4 laps"};
  race["absent"] = {"asked", "e\xe2\x88\x92"};
  race["phone_height"] = 3500;
  add(race);
  expect_good();
}

TEST_F(Pages, RacesOfEverySizeAndEndAreShown) {
  sample::SampleOptions many;
  many.seeds = 10;
  many.stacks.push_back({"elm_rls", false, 1, 0.92, 0.4});
  many.stacks.push_back({"best", false, 1, 0.96, 0.5});
  sample::write_sample(work_ / "many", many);
  add(page("many", "other", 2.0));

  sample::SampleOptions crash;
  crash.stacks = {{"lost", false, 0, 0.93, 0.7, 5.0}, {"elm", false, 1, 0.9, 0.8}, {"gp", true, 0.9, 0.92, 4.2}};
  sample::write_sample(work_ / "crash", crash);
  // A lap of the row that did not finish, far beyond the axis.
  std::string table = bytes_of(work_ / "crash" / "table.csv");
  const std::string row = "\nlost,0,1,0,1,";
  ASSERT_NE(table.find(row + ","), table.npos) << table;
  std::ofstream(work_ / "crash" / "table.csv") << table.insert(table.find(row) + row.size(), "99.5");
  nlohmann::json lost = page("crash");
  lost["svgs"] = {{"laps", "99.5 s"}};
  const Columns longest = Columns::read(work_ / "crash" / "elm" / "1" / "steps.csv");
  lost["lost"] = {{"end", longest.number("t_s", longest.rows() - 1)}, {"offset", 1.0}};
  add(lost);

  sample::write_sample(work_ / "late", one_lap());
  // A world without a limit: the ratio to it, which is the last column, is empty.
  std::string no_limit = bytes_of(work_ / "late" / "table.csv");
  no_limit.resize(no_limit.rfind(',') + 1);
  std::ofstream(work_ / "late" / "table.csv") << no_limit << '\n';
  nlohmann::json late = page("late");
  late["late_tyres"] = 2.0;
  late["texts"] = {"Lap by lap"};
  late["absent"] = {"among the others", "Bold and marked", "against the limit", "Black bars"};
  add(late);

  sample::SampleOptions twenty;
  twenty.laps = 20;
  twenty.stacks = {{"elm", false, 1, 0.9, 0.8}};
  sample::write_sample(work_ / "laps", twenty);
  nlohmann::json many_laps = page("laps");
  many_laps["many_laps"] = 20;
  add(many_laps);
  expect_good();
}

TEST_F(Pages, DrivesOfAValidationAreShown) {
  sample::write_validation_sample(work_ / "validation");
  add(page("validation"));
  sample::write_validation_sample(work_ / "drives", true);
  nlohmann::json drives = page("drives");
  drives["chosen"] = {{"figure", "validation-e_vx"}, {"first", "elm"}, {"other", "gp"}};
  add(drives);
  expect_good();
}

/// What is damaged, cut off or hostile does no harm to a page.
TEST_F(Pages, WhatIsBrokenIsShownAsFarAsItGoes) {
  sample::SampleOptions nasty;
  nasty.laps = 1;
  nasty.stacks = {{"<img src=x onerror=alert(1)> \"\xc3\xbc\" 'b'", false, 1, 0.9, 0.8},
                  {"--> ]]>", true, 0, 0.9, 0.8}};
  sample::write_sample(work_ / "nasty", nasty);
  std::ofstream(work_ / "nasty" / "claims.json")
      << R"({"claims": [{"text": "</script><script>alert(1)</script>", "holds": true, "values": {"left": 1e308, "right": -1e308}}]})";
  nlohmann::json harmless = page("nasty");
  harmless["texts"] = {nasty.stacks[0].name, "</script><script>alert(1)</script>"};
  add(harmless);

  sample::write_broken_sample(work_ / "broken");
  nlohmann::json broken = page("broken");
  broken["texts"] = {"none of 4 laps finished", "2 of 2 runs did not finish",
                     "One base row, and a gain of \xe2\x88\x92"
                     "3."};
  broken["absent"] = {"among the others", "`", "NaN", "Infinity", "undefined"};
  add(broken);

  sample::write_sample(work_ / "cut", one_lap());
  for (const char* table : {"runs.csv", "table.csv", "claims.json"}) fs::remove(work_ / "cut" / table);
  fs::copy(work_ / "cut" / "elm" / "1", work_ / "cut" / "elm" / ".2.partial");
  nlohmann::json cut = page("cut");
  cut["absent"] = {"partial", "Comparison"};
  add(cut);

  sample::write_sample(work_ / "undrawable", one_lap());
  std::ofstream(work_ / "undrawable" / "scene.json") << R"({"note": {"not": "a text"}})";
  job_["undrawable"] = page("undrawable")["file"];
  expect_good();
}

TEST_F(Pages, DiagnosesAreToldInWordsFirst) {
  sample::write_diagnosis_sample(work_ / "diagnosis");
  nlohmann::json found = page("diagnosis");
  // In words first, ids after that.
  found["before"] = {{"Friction differs on one stretch of the lap", "With it the model closes 99 % of its gap"},
                     {"With it the model closes 99 % of its gap", "friction_patch"}};
  add(found);

  sample::write_cases_sample(work_ / "cases");
  nlohmann::json cases = page("cases");
  cases["texts"] = {"hidden_things", "Unknown effect",
                    "aero_drag (a = \xe2\x88\x92"
                    "0.42 m/s\xc2\xb2) is missing.",
                    "> 99.9 %", "\xe2\x9c\x97 no"};
  cases["pictures"] = false;
  cases["links"] = {"drag/report.html"};
  add(cases);
  expect_good();
}

/// Diagnoses of logs of real cars: what calibration took off leads, then effects; that the rest is unknown comes after
/// them.
class RealCarPages : public Pages {
 protected:
  /// `effects`: what they change, as JSON that may go on with further keys of "gap".
  nlohmann::json real(const std::string& name, const std::string& named, const std::string& effects,
                      const std::string& ranking = "[]") const {
    constexpr const char* gap =
        R"("gap": {"horizon_s": 1.0, "before": 6.5, "after": 1.17, "closure": 0.96, "closure_ci95": [0.94, 0.97],
      "calibrated": 1.33, "noise": 0.95, "calibration": {"change": -0.8, "ci95": [-0.82, -0.78]}, "effects": )";
    fs::create_directories(work_ / name);
    std::ofstream(work_ / name / "diagnosis.json")
        << R"({"verdict": "unknown", "unknown": {"where": "state", "interval": null}, "nominal_fit": {"Bf": 1.2}, "named": )"
        << named << ", " << gap << effects << R"(}, "ranking": )" << ranking << R"(, "manoeuvre": null})";
    std::ofstream(work_ / name / "diagnosis_report.json")
        << R"({"sentence": "As above.", "log": "a.csv", "world": "w.json",
               "calibrated": [{"param": "/plant/params/Bf", "given": 2, "found": 1.2, "ci95": [1.05, 1.37]}]})";
    nlohmann::json one = page(name);
    one["pictures"] = false;
    return one;
  }
};

TEST_F(RealCarPages, CalibrationLeads) {
  nlohmann::json calibrated = real("calibrated", "[]", "null");
  calibrated["before"]["Calibrating the world takes 80 % (78 % to 82 %) off"] = "The rest is not known.";
  calibrated["before"]["as given"] = "1.05 to 1.37";
  calibrated["absent"] = {"Something is missing", "NaN", "/plant/params"};
  add(calibrated);

  nlohmann::json late_sensor = real(
      "late_sensor",
      R"([{"effect": "yaw_rate_delay", "class": "measurement", "params": {"T": 0.286}, "units": {"T": "s"}, "ci95": {"T": [0.23, 0.35]}, "confidence": 0.5}])",
      R"({"change": -0.12, "ci95": [-0.2, -0.04]})");
  late_sensor["before"] = {{"Calibrating the world takes", "The yaw-rate channel is 0.286 s late."},
                           {"The yaw-rate channel is", "The rest is not known."},
                           {"The rest is not known.", "take 12 % (4 % to 20 %) off what is left then"}};
  late_sensor["texts"] = {"The yaw-rate channel is late", "0.286 s"};
  late_sensor["absent"] = {"Something is missing", "NaN", "Confidence"};
  add(late_sensor);

  // What is left is noise of the sensors; candidates that were not fitted have no error.
  nlohmann::json noise = real("noise_left", "[]", R"(null, "at_noise": true, "judged": 1.3)",
                              R"([{"effect": "aero_drag", "less_error": 0.25, "held_out": 1.2, "selected_fraction": 0.9,
       "rollout": {"change": -0.08, "ci95": [-0.1, -0.05], "says": "helps"}},
      {"effect": "back_emf", "less_error": 0.02, "held_out": null, "selected_fraction": 0,
       "rollout": {"change": 0, "ci95": [0, 0], "says": "cannot tell"}}])");
  noise["texts"] = {"these logs tell nothing more", "squared error, fitted", "not tried", "1.30 \xcf\x83 without any",
                    "\xe2\x88\x92"
                    "25.0 %"};
  noise["absent"] = {"The rest is not known", "Unknown effect", "evidence gained", "NaN"};
  add(noise);
  expect_good();
}

/// The whole gap is closed: nothing says that a rest of it is not known.
TEST_F(RealCarPages, ErrorsBelowTheNoiseLeaveNoRest) {
  nlohmann::json within = real("within_noise", "[]", R"(null, "noise": 1.3, "closure": 1)");
  within["texts"] = {"What is left is in sum no more than sensor noise alone would leave.", "100 % of the gap"};
  within["absent"] = {"The rest is not known", "Unknown effect", "What is left shows"};
  add(within);
  expect_good();
}

/// Effects that were tried stand on the page wherever they rank; others fill it up.
TEST_F(RealCarPages, EffectsThatWereTriedAreRanked) {
  std::string ranking = "[";
  for (int i = 0; i < 22; ++i)
    ranking += R"({"effect": "other_)" + std::to_string(i) +
               R"(", "less_error": 0.02, "held_out": null, "selected_fraction": 0,
      "rollout": {"change": 0, "ci95": [-1, 1], "says": "cannot tell"}}, )";
  ranking += R"({"effect": "pose_lever", "less_error": 0.01, "held_out": 1.12, "selected_fraction": 0.2,
      "rollout": {"change": 0.004, "ci95": [-0.006, 0.015], "says": "cannot tell"}}])";
  nlohmann::json ranked = real("ranked", "[]", "null", ranking);
  ranked["texts"] = {"other_18", "pose_lever", "Left out: 3 more that were not tried."};
  ranked["absent"] = {"other_19"};
  add(ranked);
  expect_good();
}

TEST_F(Browser, NumbersAreWrittenAsPeopleReadThem) {
  require(false);
  if (IsSkipped() || HasFatalFailure()) return;
  const Outcome outcome = shell("node " + quoted_path(source / "test" / "numbers.mjs"));
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, testing::HasSubstr("all checks passed"));
}

TEST_F(Browser, TheCommittedBundleIsWhatTheSourceGives) {
  require(false);
  if (IsSkipped() || HasFatalFailure()) return;
  const fs::path rebuilt = testing_support::build_dir() / "report_rebuilt";
  const Outcome outcome = shell("node " + quoted_path(source / "build.mjs") + " --to " + quoted_path(rebuilt));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  for (const char* name : {"report.js", "report.css"})
    EXPECT_EQ(bytes_of(rebuilt / name), bytes_of(source / "dist" / name))
        << name << ": run npm run build in tools/report";
}

TEST_F(Browser, TheSourceHasItsTypesRight) {
  require(false);
  if (IsSkipped() || HasFatalFailure()) return;
  const Outcome outcome = shell("cd " + quoted_path(source) + " && node node_modules/typescript/bin/tsc --noEmit");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
}

}  // namespace test_report_browser
}  // namespace gripline::report
