// Every command of the program that the documentation shows, run as it stands or shortened by the rules below: a race
// lasts 20 control steps of one seed and two rows. What has a test of its own is named here with that test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "config/json_file.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_doc_commands {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::IsEmpty;

struct Shown {
  std::string page, command;
};

/// Lines of the pages' code blocks that call the program, continued ones joined, comments dropped.
std::vector<Shown> shown_commands() {
  std::vector<fs::path> pages = {source_dir() / "README.md"};
  for (const auto& entry : fs::directory_iterator(source_dir() / "framework/doc"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  std::sort(pages.begin() + 1, pages.end());
  std::vector<Shown> all;
  for (const fs::path& page : pages) {
    std::istringstream lines(contents(page));
    bool code = false, continued = false;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("```")) code = !code;
      const bool indented = line.starts_with("    ");
      if (indented) line.erase(0, line.find_first_not_of(' '));
      if (!continued && !((code || indented) && line.starts_with("gripline "))) continue;
      if (const std::size_t comment = line.find("  #"); comment != line.npos) line.erase(comment);
      if (continued)
        all.back().command.append(line);
      else
        all.push_back({page.filename().string(), line});
      continued = line.ends_with('\\');
      if (continued) all.back().command.back() = ' ';
    }
  }
  return all;
}

/// Commands with a test of their own, by a pattern of the whole line; that test's file.
struct Elsewhere {
  const char *pattern, *test;
};
constexpr Elsewhere elsewhere[] = {
    {".*(my_drag|out/spread).*", "test_tutorial.cpp"},
    {".*my_plugins.*", "test_external_plugin.cpp"},
    {"gripline plugins check.*", "test_conformance.cpp"},
    {"gripline bench.*", "test_bench_program.cpp"},
    {".*--engine slurm.*|.*/shared/me/mu.*", "test_sweep_slurm.cpp"},
    {"gripline (import|fit|predict) .*(LOG|WORLD|NEXT|fitted|av21_).*", "test_real_cars.cpp"},
    {"gripline import .*drive\\.bag.*", "test_import_bags.cpp"},
    {"gripline diagnose .*(LOG|CASE).*", "test_diagnose_program.cpp"},
    {"gripline (predict|diagnose) .*out/hidden_1_43.*", "test_diagnose_measured.cpp"},
    {"gripline compare experiments/diagnose/.*", "test_diagnose_program.cpp"},
    {"gripline limit .*", "../unit/limit/test_lap_limit.cpp"},
    {"gripline export .*--video.*", "test_export.cpp"},
};

bool is_tested_elsewhere(const std::string& command) {
  return std::any_of(std::begin(elsewhere), std::end(elsewhere),
                     [&](const Elsewhere& e) { return std::regex_match(command, std::regex(e.pattern)); });
}

/// Names of an experiment's first two rows, as --only takes them.
std::string two_rows(const std::string& experiment) {
  const Node tree = load_json(source_dir() / experiment);
  std::string names;
  int named = 0;
  for (const Member& stack : tree.find("stacks")->object())
    if (!stack.value.is_null() && named < 2) names.append(named++ > 0 ? "," : "").append(stack.key);
  return names;
}

/// The command as it is run here.
std::string shortened(const std::string& command) {
  static const std::regex race("gripline (compare|run|sweep) (\\S+\\.json).*"), many("--seeds 1\\.\\.5");
  std::smatch found;
  if (!std::regex_match(command, found, race)) return command;
  // Given before what the line itself sets, which so wins.
  std::string text = std::regex_replace(command, many, "--seeds 1");
  if (!text.starts_with("gripline sweep")) text += " --set /seeds/count=1";
  // Hundreds of runs: settings are read and one run is driven.
  if (text.starts_with("gripline sweep experiments/circuits")) text += " --dry-run";
  if (text.starts_with("gripline compare") && text.find("--only") == text.npos) text += " --only " + two_rows(found[2]);
  return text + " --set /world/laps=0 --set /world/duration=0.4 --set '/claims=[]'";
}

/// A full-size road as TUM's database has them, times `scale`: two straights of 300 m, two half circles of 80 m.
void write_oval(const fs::path& file, double scale = 1) {
  std::ofstream out(file);
  out << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  const double straight = 300 * scale, radius = 80 * scale, step = 5 * scale;
  const double bend = std::numbers::pi * radius, lap = 2 * (straight + bend);
  for (double s = 0; s < lap; s += step) {
    const double side = s < lap / 2 ? 1 : -1, along = std::fmod(s, lap / 2),
                 angle = std::max(along - straight, 0.0) / radius;
    const double x = std::min(along, straight) - straight / 2 + radius * std::sin(angle), y = -radius * std::cos(angle);
    out << side * x << ',' << side * y << ',' << 6 * scale << ',' << 6 * scale << '\n';
  }
}

/// The roads of TUM's database, by the names in which a sweep lists them.
std::set<std::string> listed_roads() {
  std::istringstream lines(contents(source_dir() / "experiments/sweeps/tum.csv"));
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("roads")) names.insert(fs::path(line.substr(0, line.find(','))).stem());
  return names;
}

class DocCommands : public testing::Test {
 protected:
  /// An empty folder that looks like the tree to a command: results go to its own `out`.
  DocCommands() {
    for (const char* name : {"experiments", "worlds", "tests", "framework", "tools", "plugins", "python"})
      fs::create_directory_symlink(source_dir() / name, folder_ / name);
    // What the pages call a user's own roads (circuits.md).
    const fs::path roads = folder_ / "roads", small = folder_ / "roads_43", bridges = folder_ / "roads_bridges",
                   drawn = folder_ / "roads_drawn";
    for (const fs::path& folder : {roads, small, bridges, drawn}) fs::create_directory(folder);
    for (const char* name : {"narrow_5", "hairpins_3", "hairpins_5"}) write_oval(drawn / (std::string(name) + ".csv"));
    for (const std::string& name : listed_roads()) {
      write_oval(roads / (name + ".csv"));
      write_text(bridges / (name + ".json"), R"({"centre": "../roads/)" + name + R"(.csv", "bridges": true})");
      write_oval(small / (name + ".csv"), 1.0 / 43);
      write_text(small / (name + ".json"), R"({"centre": ")" + name + R"(.csv"})");
    }
    const char* const before = std::getenv("PATH");
    path_ = gripline_program().parent_path().string();
    path_.append(":").append(before != nullptr ? before : "");
  }
  /// One race in each of the folders that circuits.md draws races into.
  void draw_races() const {
    for (const std::string set : {"full", "full_0.8", "small", "small_1.4", "poses", "small_poses"})
      (void)run("tools/draw_races 1 1 out/drawn/" + set + (set.starts_with("small") ? " --scale 1:43" : "") +
                (set.ends_with("poses") ? " --poses" : ""));
  }
  Outcome run(const std::string& command) const {
    return run_program({"bash", "-c", command}, {.folder = folder_.path(), .environment = {{"PATH", path_}}});
  }
  Folder folder_;
  std::string path_;
};

TEST_F(DocCommands, Run) {
  std::size_t count = 0;
  std::vector<std::string> done;
  for (const Shown& shown : shown_commands()) {
    if (is_tested_elsewhere(shown.command)) continue;
    const std::string command = shortened(shown.command);
    if (std::find(done.begin(), done.end(), command) != done.end()) continue;
    done.push_back(command);
    // What a page asks of a race that another page drove, it finds there.
    if (command.find("out/table1") != command.npos && !fs::exists(folder_ / "out/table1"))
      (void)run(
          "gripline compare experiments/table1.json --only elm --set /world/laps=0 --set /world/duration=4 "
          "--set '/claims=[]'");
    if (command.find("out/drawn") != command.npos) draw_races();
    const Outcome outcome =
        run(command + (command.find("--out") == command.npos && command.starts_with("gripline compare")
                           ? " --out out/doc" + std::to_string(++count)
                           : ""));
    EXPECT_EQ(outcome.code, 0) << shown.page << ": " << command << "\n" << outcome.err << outcome.out;
  }
  EXPECT_GT(done.size(), 15U);
}

/// Every option that a shown command has is one of its sub-command's.
TEST_F(DocCommands, HaveOptionsThatExist) {
  static const std::regex option("(?:^|\\s)(--[a-z][a-z-]*)");
  std::vector<std::string> wrong;
  std::map<std::string, std::string> help;
  for (const Shown& shown : shown_commands()) {
    std::istringstream words(shown.command);
    std::string program, sub, more;
    words >> program >> sub >> more;
    if (sub.starts_with("--")) continue;
    std::vector<std::string> asked = {sub};
    if (sub == "plugins") asked.push_back(more);
    if (sub == "plugins") sub += " " + more;
    asked.emplace_back("--help");
    if (help.count(sub) == 0) help[sub] = gripline_with(asked).out;
    for (std::sregex_iterator at(shown.command.begin(), shown.command.end(), option), end; at != end; ++at) {
      const std::regex listed((*at)[1].str() + "(?![a-z-])");
      if (!std::regex_search(help[sub], listed)) wrong.push_back(shown.page + ": " + sub + " " + (*at)[1].str());
    }
  }
  EXPECT_THAT(wrong, IsEmpty());
}

TEST(DocCommandsElsewhere, TestsThatAreNamedExist) {
  for (const Elsewhere& e : elsewhere) EXPECT_TRUE(fs::exists(source_dir() / "tests/run" / e.test)) << e.test;
}

}  // namespace test_doc_commands
}  // namespace gripline
