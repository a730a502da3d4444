#include "plugin/registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <clocale>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>

#include <gripline/abi_layout.hpp>

#include "config/units.hpp"
#include "plugin/library_probe.hpp"
#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_registry {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

/// The reason why the only library of a fixture folder cannot be used.
std::string reason(const std::string& fixture) {
  const Registry registry({fixture_plugins(fixture)});
  if (registry.unusable().size() != 1 || !registry.entries().empty()) return "usable";
  return registry.unusable()[0].reason;
}
std::string reason_of_file(std::string_view bytes) {
  const Folder folder;
  write_text(folder / "file.so", bytes);
  const Registry registry({folder.path()});
  return registry.unusable().size() == 1 ? registry.unusable()[0].reason : "usable";
}

TEST(Registry, LoadsEveryPluginOfTheProduct) {
  const Registry registry({plugin_dir()});
  EXPECT_TRUE(registry.unusable().empty()) << registry.unusable()[0].library << registry.unusable()[0].reason;
  for (const auto& [kind, id] : {std::pair{abi::Kind::vehicle, "dynamic"},
                                 {abi::Kind::effect, "relaxation"},
                                 {abi::Kind::estimator, "none"},
                                 {abi::Kind::planner, "friction_speed"},
                                 {abi::Kind::controller, "pure_pursuit"},
                                 {abi::Kind::plant, "double_track"}})
    EXPECT_EQ(registry.find(kind, id).decl->id, std::string(id));
  EXPECT_TRUE(registry.find(abi::Kind::estimator, "oracle").needs_truth());
  EXPECT_FALSE(registry.find(abi::Kind::estimator, "none").needs_truth());
}

TEST(Registry, DeclaredDataArrivesWhole) {
  const PluginEntry& entry = plugins().find(abi::Kind::effect, "spy.declared");
  EXPECT_EQ(entry.decl->precedence, 7);
  EXPECT_STREQ(entry.decl->advice, "drive a lap");
  ASSERT_EQ(entry.params().size(), 2u);
  const abi::ParamDecl &strength = entry.params()[0], &place = entry.params()[1];
  EXPECT_EQ(strength.default_value, 0.25);
  EXPECT_TRUE(strength.fit);
  EXPECT_EQ(std::tuple(strength.neutral, strength.start, strength.scale), std::tuple(0.0, 0.1, 0.2));
  EXPECT_FALSE(strength.periodic);
  EXPECT_TRUE(place.fit);
  EXPECT_TRUE(place.periodic);
  EXPECT_EQ(std::tuple(place.neutral, place.start, place.scale), std::tuple(0.5, 0.4, 0.05));
  EXPECT_STREQ(plugins().find(abi::Kind::effect, "spy.blind").decl->advice, "");
}

/// Conditions of every declared parameter: documented, with a unit, its default inside its range.
TEST(Registry, EveryParameterIsDeclaredWhole) {
  ASSERT_FALSE(plugins().entries().empty());
  for (const PluginEntry& entry : plugins().entries()) {
    EXPECT_STRNE(entry.decl->summary, "") << entry.decl->id;
    EXPECT_STRNE(entry.decl->version, "") << entry.decl->id;
    for (const abi::ParamDecl& p : entry.params()) {
      const std::string what = std::string(entry.decl->id) + "." + p.name;
      EXPECT_STRNE(p.doc, "") << what;
      EXPECT_STRNE(p.unit, "") << what;
      EXPECT_NO_THROW((void)Unit::parse(p.unit)) << what;
      EXPECT_LE(p.lo, p.hi) << what;
      if (p.type == abi::ParamType::table) continue;
      EXPECT_GE(p.default_value, p.lo) << what;
      EXPECT_LE(p.default_value, p.hi) << what;
    }
  }
}

TEST(Registry, AnotherAbiIsRefusedBeforeItsCodeRuns) {
  EXPECT_EQ(reason("other_abi"),
            "built for plugin ABI 7, this gripline has ABI 6; rebuild the plugin against the installed headers");
  EXPECT_EQ(reason("stated_abi"),
            "states plugin ABI 7, this gripline has ABI 6; rebuild the plugin against the installed headers");
  EXPECT_EQ(
      reason("other_layout"),
      "its types (built by another compiler) differ from this gripline's; rebuild the plugin against the installed "
      "headers");
}

TEST(Registry, WhatIsNoPluginSaysSo) {
  EXPECT_EQ(reason("not_a_plugin"),
            "is not a gripline plugin: it has no symbol gripline_plugins_abi6; write "
            R"(GRIPLINE_PLUGINS(gripline::describe<Class>("id", "1.0", "what it is")) in its source)");
  EXPECT_EQ(reason_of_file("just text\n"), "is not a shared library");
  EXPECT_EQ(reason_of_file(""), "is not a shared library");
  EXPECT_EQ(reason_of_file("\x7f"
                           "ELF"),
            "is not a shared library");
}

/// A copy that was interrupted, at any length.
TEST(Registry, ATruncatedLibraryIsRefused) {
  const std::string whole = contents(fixture_plugins("duplicate") / "duplicate.so");
  ASSERT_GT(whole.size(), 4000u);
  for (const std::size_t size :
       {std::size_t{20}, std::size_t{64}, std::size_t{200}, whole.size() / 4, whole.size() / 2, whole.size() - 1000})
    EXPECT_NE(reason_of_file(std::string_view(whole).substr(0, size)), "usable") << size;
}

/// A bit that flipped on the disk, anywhere in the file: at worst a library that cannot be used.
TEST(Registry, AFlippedBitCostsItsFileOnly) {
  const std::string whole = contents(fixture_plugins("duplicate") / "duplicate.so");
  const Folder folder;
  std::mt19937_64 random(13);
  std::vector<std::filesystem::path> files;
  for (int i = 0; i < 200; ++i) {
    std::string bytes = whole;
    // Half of them in the headers and the dynamic section, where most of the harm is.
    const std::size_t at = random() % (i % 2 == 0 ? whole.size() : 4096);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
    files.push_back(folder / ("flip" + std::to_string(i) + ".so"));
    write_text(files.back(), bytes);
  }
  const std::vector<std::string> problems = probe_libraries(files, 2.0);
  ASSERT_EQ(problems.size(), files.size());
  const auto refused = std::count_if(problems.begin(), problems.end(), [](const std::string& p) { return !p.empty(); });
  EXPECT_GT(refused, 20);
  EXPECT_LT(refused, 180);
}

/// What a library does when it is opened, it does in a process that was made for it.
TEST(Registry, ALibraryThatEndsItsProcessCostsItselfOnly) {
  const auto constructors = [](const char* mode) { return fixture_plugins("constructors") / mode; };
  const Registry registry({constructors("exits"), constructors("aborts"), fixture_plugins("spies"),
                           constructors("segfaults"), constructors("throws"), constructors("prints"),
                           constructors("meddles")});
  std::vector<std::string> reasons;
  for (const Registry::Unusable& one : registry.unusable())
    reasons.push_back(one.library.filename().string() + ": " + one.reason);
  const std::string tried = ".so: cannot be opened: the process that tried ";
  const std::string aborted = tried + "was ended by signal 6 (Aborted)";
  // Whether an exception finds its way through the dynamic linker is the linker's affair.
  EXPECT_THAT(reasons,
              testing::UnorderedElementsAre("exits" + tried + "ended with exit code 0", "aborts" + aborted,
                                            "segfaults" + tried + "was ended by signal 11 (Segmentation fault)",
                                            testing::AnyOf("throws" + tried + "threw no fuel", "throws" + aborted)));
  EXPECT_EQ(registry.find(abi::Kind::controller, "spy.constant").decl->id, std::string("spy.constant"));
  EXPECT_EQ(registry.find(abi::Kind::effect, "constructor.prints").decl->id, std::string("constructor.prints"));
}

TEST(Registry, ALibraryThatNeverOpensIsGivenUp) {
  const auto file = [](const std::string& mode) { return fixture_plugins("constructors") / mode / (mode + ".so"); };
  const std::vector<std::filesystem::path> files = {file("loops"), file("stops"), file("prints")};
  const std::string gave_up = "cannot be opened: the process that tried did not come back within 2 s";
  EXPECT_THAT(probe_libraries(files, 2.0), testing::ElementsAre(gave_up, gave_up, ""));
}

/// Whoever opens a library keeps the folder, the locale and the signals it had.
TEST(Registry, ALibraryThatMeddlesChangesNothingHere) {
  const std::filesystem::path before = std::filesystem::current_path();
  const std::string locale = std::setlocale(LC_ALL, nullptr);
  const Registry registry({fixture_plugins("constructors") / "meddles"});
  EXPECT_EQ(registry.entries().size(), 1u);
  EXPECT_EQ(std::filesystem::current_path(), before);
  EXPECT_EQ(std::setlocale(LC_ALL, nullptr), locale);
  EXPECT_EQ(std::signal(SIGCHLD, SIG_DFL), SIG_DFL);
  EXPECT_EQ(std::signal(SIGINT, SIG_DFL), SIG_DFL);
  const Folder folder;
  write_text(folder / "made", "with the usual mode");
  EXPECT_EQ(contents(folder / "made"), "with the usual mode");
}

/// A pipe is not waited for, whoever named it like a library.
TEST(Registry, APipeIsNoLibrary) {
  const Folder folder;
  ASSERT_EQ(mkfifo((folder / "pipe.so").c_str(), 0600), 0);
  const Registry registry({folder.path(), fixture_plugins("spies")});
  ASSERT_EQ(registry.unusable().size(), 1u);
  EXPECT_EQ(registry.unusable()[0].reason, "is not a file: a pipe, a device or a folder");
}

TEST(Registry, WhatADeclarationSaysMustBeWords) {
  EXPECT_EQ(reason("odd_id"), "declares a plugin whose id is not plain text: \"\\x1b[2J\"");
  EXPECT_EQ(reason("odd_unit"),
            "effect \"odd_unit\" is declared with the parameter \"a\" with an invalid unit: unknown unit "
            "\"furlong\"");
}

/// What a library may declare that was built without the SDK's own checks.
TEST(Registry, WholeNumbersAreInts) {
  const auto problem = [](double lo, double hi, double fallback) {
    abi::ParamDecl n{};
    n.name = "n", n.unit = "1", n.doc = "a count", n.type = abi::ParamType::integer;
    n.lo = lo, n.hi = hi, n.default_value = fallback;
    abi::PluginDecl decl = *plugins().find(abi::Kind::effect, "aero_drag").decl;
    decl.params = &n;
    decl.param_count = 1;
    return manifest_problem(
        {abi::number, sizeof(abi::Manifest), abi::layout_hash(), &abi::virtual_slots, "a compiler", &decl, 1});
  };
  EXPECT_EQ(problem(-2147483648.0, 2147483647.0, 3), "");
  const std::string refused =
      "effect \"aero_drag\" is declared with the parameter \"n\", whose range or default is beyond what an int holds";
  EXPECT_EQ(problem(0, 1e12, 3), refused);
  EXPECT_EQ(problem(-INFINITY, 9, 3), refused);
  EXPECT_EQ(problem(0, 9, 1e300), refused);
}

TEST(Registry, AFolderThatEverybodyMayWriteIsWarnedOf) {
  const Folder folder;
  std::filesystem::copy_file(fixture_plugins("spies") / "spies.so", folder / "spies.so");
  EXPECT_TRUE(Registry({folder.path()}).warnings().empty());
  ASSERT_EQ(chmod(folder.path().c_str(), 0777), 0);
  const Registry registry({folder.path()});
  EXPECT_FALSE(registry.entries().empty());
  EXPECT_THAT(registry.warnings(),
              testing::ElementsAre(folder.path().string() +
                                   " can be written by everybody on this machine: a plugin that another user "
                                   "puts there runs as you"));
}

TEST(Registry, AMissingDependencyIsToldInTheLoadersWords) {
  EXPECT_THAT(reason("needs_absent"),
              AllOf(HasSubstr("libgripline_absent.so"), HasSubstr("cannot open shared object file")));
}

TEST(Registry, TwoLibrariesWithOneIdAreAnError) {
  const std::string message = refusal([] { Registry({fixture_plugins("duplicate"), plugin_dir()}); });
  EXPECT_THAT(message, AllOf(HasSubstr("effect \"aero_drag\" is offered twice: by "), HasSubstr("duplicate.so and by "),
                             EndsWith("body.so")));
}

TEST(Registry, OneIdMayNamePluginsOfTwoKinds) {
  const Registry registry({fixture_plugins("spies")});
  EXPECT_EQ(registry.find(abi::Kind::estimator, "spy.order").decl->kind, abi::Kind::estimator);
  EXPECT_EQ(registry.find(abi::Kind::planner, "spy.order").decl->kind, abi::Kind::planner);
}

TEST(Registry, AFolderNamedTwiceIsSearchedOnce) {
  const Folder folder;
  const std::filesystem::path spies = fixture_plugins("spies");
  std::filesystem::create_directory_symlink(spies, folder / "link");
  const std::size_t once = Registry({spies}).entries().size();
  EXPECT_EQ(Registry({spies, spies}).entries().size(), once);
  EXPECT_EQ(Registry({spies, spies / ".." / "spies", folder / "link"}).entries().size(), once);
}

TEST(Registry, OtherFilesAndMissingFoldersAreNoMatter) {
  const Folder folder;
  write_text(folder / "readme.txt", "no library");
  std::filesystem::create_directory(folder / "folder.so");
  std::filesystem::create_symlink(fixture_plugins("spies") / "spies.so", folder / "spies.so");  // links are followed
  const Registry registry({folder.path(), folder / "absent"});
  EXPECT_TRUE(registry.unusable().empty());
  EXPECT_EQ(registry.entries().size(), Registry({fixture_plugins("spies")}).entries().size());
}

TEST(Registry, AMissingPluginNamesTheNearestEveryFolderAndEveryReason) {
  const std::filesystem::path spies = fixture_plugins("spies"), broken = fixture_plugins("needs_absent"),
                              nowhere = "/no/folder";
  const Registry registry({spies, broken, nowhere});
  const std::string message = refusal([&] { registry.find(abi::Kind::controller, "spy.constnat"); });
  EXPECT_THAT(message, AllOf(HasSubstr("no controller plugin \"spy.constnat\"; did you mean \"spy.constant\"?"),
                             HasSubstr("searched " + spies.string() + " " + broken.string() + " /no/folder"),
                             HasSubstr("needs_absent.so: libgripline_absent.so: cannot open shared object file")));
  EXPECT_THAT(message, Not(HasSubstr("\n")));
  EXPECT_THAT(refusal([&] { registry.find(abi::Kind::vehicle, "spy.constant"); }),
              HasSubstr("no vehicle plugin \"spy.constant\"; \"spy.constant\" is of kind controller"));
}

TEST(Registry, APluginOneFolderBelowIsPointedAt) {
  const Folder folder;
  write_text(folder / "my_drag/build/my_drag.so", "not built yet\n");
  write_text(folder / "my_drag/my_drag.cpp", "");
  const auto why = [](const std::filesystem::path& searched) {
    return refusal([&] { Registry({searched}).find(abi::Kind::estimator, "my_drag"); });
  };
  EXPECT_THAT(why(folder / "my_drag"),
              EndsWith("searched " + (folder / "my_drag").string() + " (without a plugin; one is in " +
                       (folder / "my_drag/build").string() + ")"));
  EXPECT_THAT(why(folder / "my_drag/build"), Not(HasSubstr("without a plugin")));
}

TEST(Registry, AReasonThatManyLibrariesShareIsSaidOnce) {
  const Folder folder;
  for (const char* name : {"a.so", "b.so", "c.so"}) std::ofstream(folder / name) << "no library";
  const Registry registry({folder.path()});
  ASSERT_EQ(registry.unusable().size(), 3u);
  const std::string message = refusal([&] { registry.find(abi::Kind::controller, "mpc"); });
  EXPECT_THAT(message, HasSubstr((folder / "a.so").string() + " and 2 more: "));
  EXPECT_THAT(message, Not(HasSubstr("b.so")));
}

TEST(Registry, SearchesOptionsThenTheEnvironmentThenTheProgramsOwn) {
  setenv("GRIPLINE_PLUGIN_PATH", "/one:/two::", 1);
  const std::vector<std::string> extra = {"/first", "/second"};
  const auto path = Registry::search_path(extra);
  unsetenv("GRIPLINE_PLUGIN_PATH");
  ASSERT_EQ(path.size(), 5u);
  EXPECT_EQ(path[0], "/first");
  EXPECT_EQ(path[1], "/second");
  EXPECT_EQ(path[2], "/one");
  EXPECT_EQ(path[3], "/two");
  EXPECT_THAT(path[4].string(), EndsWith("lib/gripline"));
  EXPECT_EQ(Registry::search_path({}).size(), 1u);
}

TEST(Registry, AConstructorThatThrowsIsAPluginError) {
  const PluginEntry& entry = plugins().find(abi::Kind::controller, "fault.throws_at_start");
  EXPECT_EQ(refusal([&] { create<Controller>(entry, PluginContext{}, {}); }), "fault.throws_at_start: no fuel");
}

TEST(Registry, KindsHaveTheirNames) {
  EXPECT_EQ(kind_name(abi::Kind::vehicle), "vehicle");
  EXPECT_EQ(kind_name(abi::Kind::plant), "plant");
}

}  // namespace test_registry
}  // namespace gripline
