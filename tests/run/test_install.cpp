// What `cmake --install` and tools/package leave: a program that finds its plugins, worlds and experiments from
// anywhere, a man page, bash completion, a Debian package; and the systems whose packages tools/quickstart knows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_install {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;

/// Links of the installed pages that lead nowhere.
std::vector<std::string> broken_links(const fs::path& pages) {
  static const std::regex link(R"(\]\(([^)\s#:]+)(#[^)\s]*)?\))");
  std::vector<std::string> broken;
  for (const auto& page : fs::directory_iterator(pages)) {
    if (page.path().extension() != ".md") continue;
    const std::string text = contents(page.path());
    for (std::sregex_iterator found(text.begin(), text.end(), link), end; found != end; ++found)
      if (!fs::exists(pages / (*found)[1].str()))
        broken.push_back(page.path().filename().string() + ": " + (*found)[1].str());
  }
  return broken;
}

/// A program under `prefix` does a user's first steps in an empty folder.
void expect_works(const fs::path& prefix, const Folder& folder) {
  const std::string program = prefix / "bin/gripline";
  const Call here{.folder = folder.path(), .environment = {}};
  EXPECT_THAT(run_program({program, "--version"}, here).out, HasSubstr("gripline 0."));
  const Outcome listed = run_program({program, "plugins", "list"}, here);
  EXPECT_THAT(listed.out, HasSubstr("mpc_sqp"));
  EXPECT_THAT(listed.out, testing::Not(HasSubstr("unusable")));
  const Outcome raced = run_program(
      {program, "run", "first_race", "--stack", "none", "--set", "/world/duration=0.2", "--set", "/world/laps=0"},
      here);
  EXPECT_EQ(raced.code, 0) << raced.err;
  EXPECT_TRUE(fs::exists(folder / "out/first_race/none/1/steps.csv"));
  write_text(folder / "own.json", R"({"extends": "experiments/first_race.json", "note": "mine", "claims": []})");
  EXPECT_EQ(run_program({program, "validate", "own.json"}, here).code, 0);
  EXPECT_THAT(run_program({program, "plugins", "check", "--list"}, here).out, HasSubstr("derivatives"));
  EXPECT_TRUE(fs::exists(prefix / "share/man/man1/gripline.1"));
  EXPECT_TRUE(fs::exists(prefix / "share/bash-completion/completions/gripline"));
  EXPECT_TRUE(fs::exists(prefix / "lib/cmake/gripline/griplineConfigVersion.cmake"));
  EXPECT_GT(contents(prefix / "share/doc/gripline/commands.md").size(), 1000U);
  EXPECT_THAT(broken_links(prefix / "share/doc/gripline"), testing::IsEmpty());
  if (!fs::exists(build_dir() / "python/gripline")) return;
  const Outcome python =
      run_program({"/usr/bin/python3", "-c", "import gripline; print(gripline.Race('first_race').reset()[0][0])"},
                  {.folder = folder.path(), .environment = {{"PYTHONPATH", prefix / "lib/python3/dist-packages"}}});
  EXPECT_EQ(python.out, "0.1\n") << python.err;
}

TEST(Install, WorksFromAnywhere) {
  const Folder folder;
  const Outcome installed = run_program({"cmake", "--install", build_dir(), "--prefix", folder / "usr"});
  ASSERT_EQ(installed.code, 0) << installed.err;
  expect_works(folder / "usr", folder);
}

TEST(Install, ThePackageUnpackedElsewhereWorks) {
  if (build_dir() != source_dir() / "build") GTEST_SKIP() << "tools/package packs build/";
  const Folder folder;
  const Outcome packed = run_program({source_dir() / "tools/package", "--no-build"});
  ASSERT_EQ(packed.code, 0) << packed.out << packed.err;
  const std::string package = packed.out.substr(0, packed.out.find('\n'));
  EXPECT_THAT(package, HasSubstr("build/gripline_0."));
  const std::string fields = run_program({"dpkg-deb", "-f", package}).out;
  EXPECT_THAT(fields, HasSubstr("Package: gripline"));
  EXPECT_THAT(fields, HasSubstr("coinor-libipopt"));  // found by dpkg-shlibdeps
  ASSERT_EQ(run_program({"dpkg-deb", "-x", package, folder / "root"}).code, 0);
  expect_works(folder / "root/usr", folder);
}

TEST(Install, PluginsOfTheUserAreFound) {
  const Folder folder;
  const fs::path own = folder / "data/gripline/plugins";
  fs::create_directories(own);
  fs::copy(fixture_plugins("spies") / "spies.so", own / "spies.so");
  const Call call{.folder = folder.path(), .environment = {{"XDG_DATA_HOME", folder / "data"}}};
  EXPECT_THAT(gripline_with({"plugins", "list"}, call).out, HasSubstr("spy.declared"));
  EXPECT_THAT(gripline_with({"plugins", "list"}).out, testing::Not(HasSubstr("spy.declared")));
}

TEST(Install, TheManPageIsWellFormedAndNamesEveryCommand) {
  const fs::path page = source_dir() / "framework/doc/gripline.1";
  const Outcome set = run_program({"groff", "-man", "-Tutf8", "-ww", "-z", page});
  if (set.code == 127) GTEST_SKIP() << "no groff";
  EXPECT_EQ(set.err, "");
  const std::string text = contents(page);
  int commands = 0;
  std::istringstream help(gripline_with({"--help"}).out);
  for (std::string line; std::getline(help, line);) {
    std::istringstream words(line);
    std::string command;
    if (!line.starts_with("  ") || !(words >> command) || command.starts_with("-")) continue;
    ++commands;
    EXPECT_THAT(text, testing::ContainsRegex("\n\\.BI? \"?" + command)) << command;
  }
  EXPECT_GE(commands, 8);
}

TEST(Completion, KnowsCommandsOptionsAndShippedFiles) {
  const Folder folder;
  const auto complete = [&](const std::string& words, int at) {
    const std::string script = "source " + (source_dir() / "tools/completion/gripline").string() + "\nCOMP_WORDS=(" +
                               words + ")\nCOMP_CWORD=" + std::to_string(at) +
                               "\n_gripline\nprintf '%s\\n' \"${COMPREPLY[@]}\"";
    return run_program(
               {"bash", "-c", script},
               {.folder = folder.path(),
                .environment = {{"PATH", gripline_program().parent_path().string() + ":" + std::getenv("PATH")}}})
        .out;
  };
  EXPECT_EQ(complete("gripline comp", 1), "compare\n");
  EXPECT_EQ(complete("gripline plugins n", 2), "new\n");
  EXPECT_EQ(complete("gripline plugins describe pure_p", 3), "pure_pursuit\n");
  EXPECT_EQ(complete("gripline plugins new es", 3), "estimator\n");
  EXPECT_EQ(complete("gripline compare first_r", 2), "first_race\n");
  EXPECT_THAT(complete("gripline compare x --for", 3), HasSubstr("--force"));
  EXPECT_EQ(complete("gripline plugins check x.so --only deri", 5), "derivatives\n");
}

TEST(Quickstart, KnowsTheSystemsWhosePackagesItNames) {
  const Folder folder;
  const auto require = [&](const std::string& id, const std::string& version) {
    write_text(folder / "os-release", "ID=" + id + "\nVERSION_ID=\"" + version + "\"\n");
    return run_program({"bash", "-c", ". tools/lib.sh; require_known_system; echo \"$build_packages\""},
                       {.folder = source_dir(), .environment = {{"OS_RELEASE", folder / "os-release"}}});
  };
  for (const auto& [id, version] : {std::pair{"debian", "13"}, {"ubuntu", "22.04"}, {"ubuntu", "24.04"}}) {
    const Outcome known = require(id, version);
    EXPECT_EQ(known.code, 0) << known.err;
    EXPECT_THAT(known.out, HasSubstr("coinor-libipopt-dev"));
  }
  EXPECT_THAT(require("ubuntu", "22.04").out, HasSubstr("g++-12 "));
  for (const char* version : {"22.04", "24.04"})  // what their Ipopt links is only recommended by it
    EXPECT_THAT(require("ubuntu", version).out, HasSubstr("liblapack-dev"));
  const Outcome unknown = require("fedora", "41");
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("fedora 41"));
  EXPECT_THAT(unknown.err, HasSubstr("cmake -S . -B build"));
}

}  // namespace test_install
}  // namespace gripline
