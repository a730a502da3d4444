#include "report/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "report/columns.hpp"
#include "report/inputs.hpp"
#include "report/packing.hpp"
#include "report/report.hpp"
#include "report/tables.hpp"
#include "support/report_files.hpp"
#include "support/report_sample.hpp"

namespace gripline::report {
namespace test_report_page {

using testing::HasSubstr;
using testing::Not;

TEST(ReportPage, DetailStaysWithinTheBudget) {
  EXPECT_EQ(choose_detail({22 * 9000.0, 9e4, 1e4}).stride, 1u);
  EXPECT_EQ(choose_detail({22 * 9000.0, 9e4, 1e4}).precision, Precision::single);
  // Steps of all runs; a snapshot of the curves, 82 rows of four numbers, comes once in 50 of them.
  for (const double rows : {5e4, 1.3e5, 6.1e5, 5e6}) {
    const Cells cells = {22 * rows, 48 * rows / 5, 328 * rows / 50};
    const Detail detail = choose_detail(cells);
    EXPECT_EQ(detail.precision, Precision::half);
    EXPECT_EQ(detail.stride, detail.replay_stride);
    const double kept = (cells.steps + cells.replay) / static_cast<double>(detail.stride) +
                        cells.tyres / static_cast<double>(detail.tyre_stride);
    EXPECT_LE(kept * 8 / 3, page_budget);
    EXPECT_LT(detail.stride, 1.5 + 1.2 * (cells.steps + cells.replay) * 8 / 3 / page_budget)
        << "more is lost than needs be";
  }
}

TEST(ReportPage, ThinnedTyreCurvesKeepTheFirstAndTheLast) {
  const Folder folder;
  sample::SampleOptions options;
  options.seeds = 30;
  sample::write_sample(folder.path(), options);
  const std::string html = bytes_of(write_report({folder.path(), {}, false, {}, {}}).page);
  EXPECT_LT(html.size(), 15u << 20);
  const Columns tyres = Columns::read(folder.path() / "elm" / "1" / "tyres.csv", true);
  const nlohmann::json front = block(html, "run-60")["tyres"]["front"];
  EXPECT_EQ(front["t"].front(), 0.0);
  EXPECT_EQ(front["t"].back(), tyres.number("t_s", tyres.rows() - 1));
  EXPECT_LT(front["t"].size(), tyres.rows() / 82) << "thinned";
  EXPECT_EQ(front["start"].size(), front["t"].size());
  EXPECT_EQ(front["slip"]["n"], 41 * front["t"].size());
}

TEST(ReportPage, HoldsTheLogAndNothingFromOutside) {
  const Folder folder;
  sample::write_sample(folder.path());
  const Written written = write_report({folder.path(), {}, false, {}, {}});
  const std::string html = bytes_of(written.page);
  EXPECT_EQ(html.size(), written.bytes);
  EXPECT_LT(html.size(), 6u << 20);  // five rows, four laps
  EXPECT_FALSE(std::regex_search(html, std::regex(R"((src|href)\s*=\s*["']?(https?:)?//)")));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));

  const nlohmann::json meta = block(html, "meta");
  EXPECT_EQ(meta["title"], "sample");
  EXPECT_EQ(meta["stacks"].size(), 5u);
  EXPECT_EQ(meta["stacks"][3]["truth"], true);
  EXPECT_EQ(meta["table"]["rows"].size(), 5u);
  const Columns steps = Columns::read(folder.path() / "elm" / "1" / "steps.csv");
  const nlohmann::json run = block(html, "run-2");
  const std::vector<double> x = unpacked(run["steps"]["x"]), t = unpacked(run["steps"]["t"]);
  ASSERT_EQ(x.size(), steps.rows());
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_NEAR(x[i], steps.number("x_true_m", i), 1e-6);
    ASSERT_NEAR(t[i], steps.number("t_s", i), 1e-6);
  }
}

/// Weighted by the static loads of the sample's car, lf 0.029 m and lr 0.033 m.
TEST(ReportPage, HoldsTheDeviationOfTheWholeCarsFriction) {
  const Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  sample::write_sample(folder.path(), options);
  const std::string html = bytes_of(write_report({folder.path(), {}, false, {}, {}}).page);
  const nlohmann::json held = block(html, "run-2")["replay"];
  const Columns replay = Columns::read(folder.path() / "elm" / "1" / "replay.csv");
  const std::vector<double> sigma = unpacked(held["mu_sigma"]);
  ASSERT_EQ(sigma.size(), replay.rows());
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    const double front = replay.number("mu_sigma_front", i), rear = replay.number("mu_sigma_rear", i);
    ASSERT_NEAR(sigma[i], (0.033 * front + 0.029 * rear) / 0.062, 1e-6) << i;
  }
  EXPECT_FALSE(held.contains("mu_sigma_front")) << "nothing on the page reads it";
}

TEST(ReportPage, SameFolderSameBytes) {
  const Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  sample::write_sample(folder.path(), options);
  const std::string first = bytes_of(write_report({folder.path(), folder.path() / "a.html", false, {}, {}}).page);
  EXPECT_EQ(first, bytes_of(write_report({folder.path(), folder.path() / "b.html", false, {}, {}}).page));
}

TEST(ReportPage, NamesAndNumbersDoNoHarm) {
  const Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  options.stacks = {{"a \"b\" <i>\xc3\xbc, 'c' & d", false, 1, 0.9, 0.8}, {"--> ]]>", false, 0, 0.9, 0.8}};
  sample::write_sample(folder.path(), options);
  std::ofstream(folder.path() / "scene.json")
      << R"({"name": "</title></script><script>alert(1)</script>", "note": "<!-- </SCRIPT > \u2028 --!>"})";
  std::ofstream(folder.path() / "claims.json")
      << R"({"claims": [{"text": "</script><img src=x onerror=alert(1)>", "holds": true, "values": {"left": 1e308, "right": -1e308}}]})";
  // One value beyond everything, in the middle of the speed.
  const fs::path steps = folder.path() / "--> ]]>" / "1" / "steps.csv";
  std::string text = bytes_of(steps);
  const std::size_t line = text.find('\n', text.size() / 2) + 1;
  std::size_t cell = line;
  for (int i = 0; i < 12; ++i) cell = text.find(',', cell) + 1;
  text.replace(cell, text.find(',', cell) - cell, "1e308");
  std::ofstream(steps) << text;

  const std::string html = bytes_of(write_report({folder.path(), {}, false, {}, {}}).page);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_EQ(block(html, "meta")["stacks"][0]["name"], options.stacks[0].name);
  const nlohmann::json run = block(html, "run-1");
  EXPECT_GE(run["undrawable"].get<int>(), 1);
  for (const double v : unpacked(run["steps"]["vx"])) EXPECT_TRUE(std::isnan(v) || std::abs(v) < 10);
}

TEST(ReportPage, LeavesOutWhatIsMissing) {
  const Folder folder;
  const fs::path run = folder.path() / "only" / "1";
  fs::create_directories(run);
  std::ofstream(run / "steps.csv") << "t_s,x_m,y_m\n0,0,0\n0.02,0.1,0\n0.04,0.2,";
  EXPECT_THROW(write_report({folder.path(), {}, true, {}, {}}), InputError);  // somebody's drives, of no race
  std::ofstream(folder.path() / "scene.json") << "{}";
  const std::string html = bytes_of(write_report({folder.path(), {}, true, {}, {}}).page);
  EXPECT_EQ(block(html, "meta")["stacks"][0]["name"], "only");
  EXPECT_EQ(unpacked(block(html, "run-0")["steps"]["x"]).size(), 2u);
}

std::string title_of_page(const fs::path& folder) {
  const std::string html = bytes_of(write_report({folder, {}, false, {}, {}}).page);
  const std::string title = block(html, "meta")["title"];
  EXPECT_THAT(html, HasSubstr("<title>" + title + " · gripline</title>"));
  return title;
}

TEST(ReportPage, AnExperimentThatWasCutShortHasItsRunsAndNoTable) {
  const Folder cut;
  const fs::path folder = cut.path();
  sample::write_sample(folder, sample::SampleOptions{});
  for (const char* table : {"runs.csv", "table.csv"}) fs::remove(folder / table);
  fs::copy(folder / "elm" / "1", folder / "elm" / ".2.partial");
  std::ofstream(folder / "elm" / "1" / "summary.json") << R"({"status": "crashed", "message": "hit a wall"})";
  const Inputs inputs = read_inputs(folder);
  ASSERT_EQ(inputs.runs.size(), 5u) << "the partial run is none";
  const auto elm =
      std::find_if(inputs.runs.begin(), inputs.runs.end(), [](const RunName& r) { return r.stack == "elm"; });
  EXPECT_EQ(elm->status, "crashed");
  EXPECT_EQ(elm->message, "hit a wall");
  EXPECT_EQ(table_json(inputs)["rows"].size(), 0u);
}

TEST(ReportPage, IsNamedAfterWhatItShowsAndNotAfterItsFolder) {
  const Folder folder;
  sample::write_validation_sample(folder.path() / "v");
  EXPECT_EQ(title_of_page(folder.path() / "v"), "v") << "nothing else to call it";
  std::ofstream(folder.path() / "v" / "scene.json")
      << R"({"name": "offline_validation", "kind": "offline_validation"})";
  EXPECT_EQ(title_of_page(folder.path() / "v"), "offline_validation");
  sample::write_diagnosis_sample(folder.path() / "d");
  EXPECT_EQ(title_of_page(folder.path() / "d"), "measured.csv");
  std::ofstream(folder.path() / "d" / "scene.json") << R"({"name": "drag of hidden", "kind": "diagnosis"})";
  EXPECT_EQ(title_of_page(folder.path() / "d"), "drag of hidden");
}

TEST(ReportPage, CasesOfADiagnoseExperimentAreAnOverview) {
  const Folder folder;
  sample::write_cases_sample(folder.path());
  const nlohmann::json meta = block(bytes_of(write_report({folder.path(), {}, false, {}, {}}).page), "meta");
  ASSERT_EQ(meta["cases"].size(), 2u);
  EXPECT_EQ(meta["cases"][0]["case"], "drag");
  EXPECT_EQ(meta["cases"][0]["verdict"], "named");
  EXPECT_EQ(meta["cases"][0]["sentence"], "aero_drag (a = -0.42 m/s2) is missing.");
  EXPECT_EQ(meta["cases"][0]["page"], true);
  EXPECT_DOUBLE_EQ(meta["cases"][0]["values"]["before"].get<double>(), 5.19);
  EXPECT_EQ(meta["cases"][1]["page"], false);
  EXPECT_EQ(meta["cases"][1]["sentence"], "");
  EXPECT_TRUE(meta["runs"].empty()) << "the drives of a case are no race";
}

/// What no gripline wrote: rows twice, names that lead elsewhere, trees without end.
TEST(ReportPage, EditedTablesAreDrawnOrRefusedWithTheirPlace) {
  const Folder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  const auto why = [&] {
    try {
      write_report({.folder = folder.path(), .page = {}, .figures = true, .figure_folder = {}, .progress = {}});
      return std::string("written");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  write("runs.csv", "stack,seed,status\nelm,1,finished\n");
  std::string rows = "stack,lap0_s,pace_ratio0,violation_s\n";
  for (int i = 0; i < 40; ++i) rows += "elm,7.5,1.01,0.2\n";
  write("table.csv", rows + "gp,7.6,1.02,0.1\n");
  EXPECT_EQ(why(), "written");
  write("table.csv", "stack,violation_s,pace_ratio0\nelm,5e-324,1e308\ngp,1e-310,1000000000.0000001\n");
  EXPECT_EQ(why(), "written");
  const std::string runs = (folder.path() / "runs.csv").string();
  write("runs.csv", "stack,seed,status\nelm,1,finished\n" + std::string(300, 'x') + ",1,finished\n");
  EXPECT_THAT(why(), testing::StartsWith(runs + ": row 2: \"xxx"));
  write("runs.csv", "stack,seed,status\nelm,../../elsewhere,finished\n");
  EXPECT_THAT(why(), HasSubstr("row 1: \"../../elsewhere\" is not a folder's name"));
  write("runs.csv", "stack,seed,status\nelm,1,finished\n");
  write("claims.json", std::string(100'000, '[') + std::string(100'000, ']'));
  EXPECT_EQ(why(), (folder.path() / "claims.json").string() + ": nested deeper than 200 levels");
}

TEST(ReportPage, RefusesAFolderWithoutResults) {
  const Folder folder;
  for (const fs::path& path : {folder.path(), folder.path() / "absent"}) {
    try {
      write_report({path, {}, false, {}, {}});
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      EXPECT_THAT(error.what(), HasSubstr("expected"));
    }
  }
}

TEST(ReportPage, ManySeedsStaySmallAndAreWrittenQuickly) {
  const Folder folder;
  sample::SampleOptions options;
  options.seeds = 10;
  options.stacks.push_back({"elm_rls", false, 1, 0.92, 0.4});
  options.stacks.push_back({"best", false, 1, 0.96, 0.5});
  sample::write_sample(folder.path(), options);
  const std::clock_t begin = std::clock();
  const Written written = write_report({folder.path(), {}, false, {}, {}});
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  EXPECT_LT(written.bytes, 15u << 20);
  // The cheapest stacks are to take two CPU-seconds a run: 5 % of seventy runs.
  EXPECT_LT(cpu_s, 0.05 * 70 * 2);
  RecordProperty("bytes", std::to_string(written.bytes));
}

}  // namespace test_report_page
}  // namespace gripline::report
