#include "report/figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "report/plot.hpp"
#include "report/report.hpp"
#include "support/report_files.hpp"
#include "support/report_sample.hpp"

namespace gripline::report {
namespace test_report_figures {

using testing::HasSubstr;
using testing::Not;

TEST(ReportFigures, AreWholeDrawings) {
  const Folder race, validation, diagnosis;
  sample::write_sample(race.path() / "race");
  sample::write_validation_sample(race.path() / "validation");
  sample::write_diagnosis_sample(race.path() / "diagnosis");
  std::map<std::string, std::vector<std::string>> expected{
      {"race", {"trajectories", "speed", "friction", "tyre_curves", "g_g", "laps", "step_times", "pareto"}},
      {"validation", {"offline_validation", "force_validation"}},
      {"diagnosis", {"diagnosis_gap", "diagnosis_residual", "diagnosis_traces"}}};
  for (const auto& [kind, names] : expected) {
    const Written written = write_report({race.path() / kind, {}, true, {}, {}});
    std::vector<std::string> found;
    for (const fs::path& figure : written.figures) {
      found.push_back(figure.stem().string());
      const std::string svg = bytes_of(figure);
      EXPECT_TRUE(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"")) << figure;
      EXPECT_TRUE(svg.ends_with("</svg>\n"));
      EXPECT_THAT(svg, Not(testing::ContainsRegex("nan|inf[^o]")));
      EXPECT_THAT(svg, HasSubstr("<path d=\"M"));
      EXPECT_THAT(svg, Not(testing::ContainsRegex(">-[0-9]"))) << figure << ": a hyphen for a minus";
      if (figure.stem() == "step_times") {
        EXPECT_THAT(svg, Not(HasSubstr(">0.0001<"))) << "no step of the sample is that short";
      }
    }
    EXPECT_THAT(found, testing::UnorderedElementsAreArray(names)) << kind;
  }
}

/// Rows over several runs show how sure their medians are.
TEST(ReportFigures, IntervalsOfTheTableAreDrawn) {
  const Folder folder;
  const auto lines_of = [&](const std::string& figure, const std::string& more_names, const std::string& more_cells) {
    std::ofstream(folder.path() / "table.csv")
        << "stack,lap0_s,violation_s,pace_ratio0" << more_names << "\nelm,8.5,0.2,1.05" << more_cells << "\n";
    std::ofstream(folder.path() / "runs.csv") << "stack,seed,status\nelm,1,finished\n";
    (void)write_report({folder.path(), {}, true, {}, {}});
    const std::string svg = bytes_of(folder.path() / "figures" / (figure + ".svg"));
    const std::regex path(series_colour(0));
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), path), std::sregex_iterator());
  };
  const std::string names = ",lap0_s_lo,lap0_s_hi,violation_s_lo,violation_s_hi,pace_ratio0_lo,pace_ratio0_hi";
  EXPECT_EQ(lines_of("laps", names, ",8.4,8.7,0.1,0.4,1.04,1.07"), lines_of("laps", "", "") + 1);
  EXPECT_EQ(lines_of("pareto", names, ",8.4,8.7,0.1,0.4,1.04,1.07"), lines_of("pareto", "", "") + 2);
  EXPECT_EQ(lines_of("laps", names, ",,,,,,"), lines_of("laps", "", ""));
}

/// What all rows share stands behind them in the legend, and the true tyre curve is drawn on top of the learned ones.
TEST(ReportFigures, LimitAndTruthComeLast) {
  const Folder folder;
  sample::write_sample(folder.path());
  const Written written = write_report({folder.path(), {}, true, {}, {}});
  int seen = 0;
  for (const fs::path& figure : written.figures) {
    const std::string name = figure.stem().string(), svg = bytes_of(figure);
    if (name != "laps" && name != "tyre_curves") continue;
    ++seen;
    const std::size_t shared = svg.find(name == "laps" ? ">limit at that friction<" : ">true<");
    ASSERT_NE(shared, svg.npos) << name;
    for (const char* row : {">none<", ">elm<"}) {
      ASSERT_NE(svg.find(row), svg.npos) << name << row;
      EXPECT_LT(svg.find(row), shared) << name << row;
    }
  }
  EXPECT_EQ(seen, 2);
}

/// Of more rows than can be told apart one is in colour, on top: here the fastest of those that stayed inside.
TEST(ReportFigures, OfManyRowsOneIsInColour) {
  const Folder folder;
  sample::write_sample(folder.path());
  std::ofstream(folder.path() / "table.csv") << "stack,needs_truth,finished,lap0_s,violation_s\n"
                                                "none,0,1,7,2\n"
                                                "constant_speed,0,1,12,0\n"
                                                "elm,0,1,8,0\n"
                                                "gp,1,1,6,0\n"
                                                "oracle,1,1,6,0\n";
  (void)write_report({folder.path(), {}, true, {}, {}});
  const std::string svg = bytes_of(folder.path() / "figures" / "speed.svg");
  EXPECT_THAT(svg, testing::AllOf(HasSubstr(">elm<"), HasSubstr(">other rows<"), Not(HasSubstr(">none<"))));
  EXPECT_LT(svg.rfind("#c9ccd1"), svg.rfind(series_colour(2))) << "elm is the third row";
  for (const std::size_t other : {0, 1, 3, 4}) EXPECT_THAT(svg, Not(HasSubstr(series_colour(other)))) << other;
}

/// A world without a limit has columns of ratios to it, which are empty.
TEST(ReportFigures, NoLimitStandsInTheLegendWithoutOne) {
  const Folder folder;
  const auto drawn = [&](const std::string& ratio) {
    const fs::path out = folder.path() / ("ratio" + ratio);
    fs::create_directories(out);
    std::ofstream(out / "table.csv") << "stack,lap0_s,violation_s,pace_ratio0\nelm,8.5,0.2," + ratio + "\n";
    std::ofstream(out / "runs.csv") << "stack,seed,status\nelm,1,finished\n";
    (void)write_report({out, {}, true, {}, {}});
    return out / "figures";
  };
  const fs::path with = drawn("1.05"), without = drawn("");
  EXPECT_THAT(bytes_of(with / "laps.svg"), testing::AllOf(HasSubstr("against the limit"), HasSubstr(">limit at that")));
  EXPECT_THAT(bytes_of(without / "laps.svg"), testing::AllOf(HasSubstr("Lap times"), Not(HasSubstr("limit"))));
  EXPECT_TRUE(fs::exists(with / "pareto.svg"));
  EXPECT_FALSE(fs::exists(without / "pareto.svg"));
}

/// A quarter of this car's static load is on the front axle.
TEST(ReportFigures, TheBandOfFrictionIsThatOfTheWholeCar) {
  const Folder folder;
  const auto drawn = [&](const std::string& name, const std::string& sigmas) {
    const fs::path run = folder.path() / name / "only" / "1";
    fs::create_directories(run);
    std::ofstream(folder.path() / name / "scene.json") << R"({"name": "band", "car": {"m": 1, "lf": 3, "lr": 1}})";
    std::ofstream(run / "steps.csv")
        << "t_s,vx_mps,mu_belief_front,mu_belief_rear\n0,1,1,1\n0.02,1,1,1\n0.1,1,1,1\n0.2,1,1,1\n";
    std::ofstream(run / "replay.csv") << "t_s,mu_sigma_front,mu_sigma_rear\n0," + sigmas + "\n0.1," + sigmas +
                                             "\n0.2," + sigmas + "\n";
    (void)write_report({folder.path() / name, {}, true, {}, {}});
    return bytes_of(folder.path() / name / "figures" / "friction.svg");
  };
  const std::string axles_differ = drawn("differ", "0.125,0.375");
  EXPECT_EQ(axles_differ, drawn("same", "0.3125,0.3125"));
  EXPECT_NE(axles_differ, drawn("less", "0.25,0.25"));
}

TEST(ReportFigures, DrivesOfTheirOwnHavePanelsOfTheirOwn) {
  const Folder folder;
  const auto panels = [&](const std::string& name, bool own_drives) {
    sample::write_validation_sample(folder.path() / name, own_drives);
    const Written written = write_report({folder.path() / name, {}, true, {}, {}});
    const std::string svg = bytes_of(folder.path() / name / "figures" / "offline_validation.svg");
    std::size_t count = 0;
    for (std::size_t at = 0; (at = svg.find("<clipPath", at)) != svg.npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(panels("one", false), 3u);
  EXPECT_EQ(panels("own", true), 6u);
}

}  // namespace test_report_figures
}  // namespace gripline::report
