// The documentation says what is there: links between pages resolve, and commands name sub-commands, files and stacks
// that exist. Nothing that a page shows is run here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "config/json_file.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_documentation {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::ElementsAre;
using testing::IsEmpty;

const fs::path root = source_dir();

/// A page in two parts, lines numbered from 1: prose, and lines of code blocks with continued ones joined.
struct Page {
  std::vector<std::pair<int, std::string>> prose, code;
};

Page split(const std::string& text) {
  Page page;
  bool in_code = false, continued = false;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.starts_with("```")) {
      in_code = !in_code;
      continued = false;
    } else if (in_code && continued) {
      page.code.back().second += line;
      continued = line.ends_with('\\');
    } else if (in_code || line.starts_with("    ")) {
      page.code.emplace_back(number, line);
      continued = line.ends_with('\\');
    } else {
      page.prose.emplace_back(number, line);
    }
    if (continued) page.code.back().second.back() = ' ';
  }
  return page;
}

std::vector<std::smatch> matches(const std::string& text, const std::regex& pattern) {
  return {std::sregex_iterator(text.begin(), text.end(), pattern), {}};
}

/// The anchor that GitHub gives a heading.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const unsigned char c : heading)
    if (std::isalnum(c) != 0 || c == '_' || c == '-' || c >= 0x80)
      anchor += static_cast<char>(std::tolower(c));
    else if (c == ' ')
      anchor += '-';
  return anchor;
}

bool has_anchor(const fs::path& file, const std::string& anchor) {
  static const std::regex heading("#+ (.*)");
  const Page page = split(contents(file));
  return std::any_of(page.prose.begin(), page.prose.end(), [&](const auto& line) {
    std::smatch found;
    return std::regex_match(line.second, found, heading) && anchor_of(found[1]) == anchor;
  });
}

/// Links of a page that lead nowhere, with their lines.
std::vector<std::string> broken_links(const fs::path& file, const std::string& text) {
  static const std::regex link(R"(\]\(([^)\s#]*)(#[^)\s]*)?\))"), elsewhere("[a-z]+:.*");
  std::vector<std::string> broken;
  const Page page = split(text);
  for (const auto& [number, line] : page.prose)
    for (const std::smatch& found : matches(line, link)) {
      const std::string path = found[1], anchor = found[2];
      if (std::regex_match(path, elsewhere)) continue;
      const fs::path target = path.empty() ? file : file.parent_path() / path;
      const bool good = fs::exists(target) && (anchor.empty() || has_anchor(target, anchor.substr(1)));
      if (!good) broken.push_back(std::to_string(number) + ": " + path + anchor);
    }
  return broken;
}

/// Commands of the program, as its help lists them.
std::set<std::string> sub_commands() {
  static const std::regex entry(R"(\n  ([a-z]+)  )");
  std::set<std::string> names = {"--help", "--version", "help"};
  const std::string help = gripline_with({"--help"}).out;
  for (const std::smatch& found : matches(help, entry)) names.insert(found[1]);
  return names;
}

/// Stacks named by --only and --stack that the experiment of the same line does not have.
std::vector<std::string> unknown_stacks(const std::string& command) {
  static const std::regex experiment(R"( (experiments/[\w./-]+\.json))"), option(R"( --(?:only|stack) ([\w,-]+))");
  std::smatch file, names;
  if (!std::regex_search(command, file, experiment) || !std::regex_search(command, names, option)) return {};
  if (!fs::exists(root / file[1].str())) return {};  // told already
  const Node tree = load_json(root / file[1].str());
  std::vector<std::string> unknown;
  std::istringstream rest(names[1].str());
  for (std::string name; std::getline(rest, name, ',');) {
    const Node* const stack = tree.find("stacks") == nullptr ? nullptr : tree.find("stacks")->find(name);
    if (stack == nullptr || stack->is_null()) unknown.push_back(name);
  }
  return unknown;
}

/// What a command names that is not there.
std::vector<std::string> wrong_in(const std::string& command, const std::set<std::string>& known) {
  static const std::regex program(R"((?:^|[\s;&])(?:build/bin/)?gripline ([\w-]+))");
  static const std::regex file(R"((?:^|[\s="'])((?:experiments|worlds|tests|plugins|framework|tools)/[\w./-]+\.\w+))");
  std::vector<std::string> wrong;
  const auto is_placeholder = [](const std::string& name) { return std::isupper(static_cast<unsigned char>(name[0])); };
  for (const std::smatch& found : matches(command, program))
    if (known.count(found[1]) == 0 && !is_placeholder(found[1])) wrong.push_back("no command " + found[1].str());
  for (const std::smatch& found : matches(command, file))
    if (!fs::exists(root / found[1].str())) wrong.push_back("no file " + found[1].str());
  for (const std::string& stack : unknown_stacks(command)) wrong.push_back("no stack " + stack);
  return wrong;
}

/// The same of a page's code blocks that start with the program, and of such inline code.
std::vector<std::string> wrong_commands(const std::string& text, const std::set<std::string>& known) {
  static const std::regex start(R"(\s*(build/bin/)?gripline .*)"), inline_code("`((?:build/bin/)?gripline [^`]*)`");
  const Page page = split(text);
  std::vector<std::string> wrong;
  const auto check = [&](int number, const std::string& command) {
    for (const std::string& one : wrong_in(command, known)) wrong.push_back(std::to_string(number) + ": " + one);
  };
  for (const auto& [number, line] : page.code)
    if (std::regex_match(line, start)) check(number, line);
  for (const auto& [number, line] : page.prose)
    for (const std::smatch& found : matches(line, inline_code)) check(number, found[1]);
  return wrong;
}

/// Files of the tree that inline code of a page names and that are not there.
std::vector<std::string> absent_files(const std::string& text) {
  static const std::regex path(R"(`((?:framework|plugins|tests|worlds|experiments|tools)/[\w./-]+)`)");
  std::vector<std::string> absent;
  const Page page = split(text);
  for (const auto& [number, line] : page.prose)
    for (const std::smatch& found : matches(line, path))
      if (!fs::exists(root / found[1].str())) absent.push_back(std::to_string(number) + ": " + found[1].str());
  return absent;
}

/// Pages of framework/doc that a source cites and that are not there.
std::vector<std::string> absent_pages(const std::string& text) {
  static const std::regex cited(R"(framework/doc/[\w-]+\.md)");
  std::vector<std::string> absent;
  for (const std::smatch& found : matches(text, cited))
    if (!fs::exists(root / found.str())) absent.push_back(found.str());
  return absent;
}

/// Every file of the repository with one of these endings that people write.
std::vector<fs::path> written(const std::set<std::string>& endings) {
  static const std::set<std::string> left_out = {"node_modules", "dist", "out", ".git"};
  std::vector<fs::path> found;
  for (auto at = fs::recursive_directory_iterator(root); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && (left_out.count(name) > 0 || fs::exists(at->path() / "CMakeCache.txt")))
      at.disable_recursion_pending();
    else if (endings.count(at->path().extension().string()) > 0)
      found.push_back(at->path());
  }
  return found;
}

std::vector<fs::path> pages() { return written({".md"}); }

TEST(Documentation, LinksResolve) {
  ASSERT_GT(pages().size(), 10U);
  for (const fs::path& page : pages()) EXPECT_THAT(broken_links(page, contents(page)), IsEmpty()) << page;
}

TEST(Documentation, CommandsNameWhatExists) {
  const std::set<std::string> known = sub_commands();
  ASSERT_EQ(known.count("compare"), 1U);
  for (const fs::path& page : pages()) EXPECT_THAT(wrong_commands(contents(page), known), IsEmpty()) << page;
}

TEST(Documentation, FilesNamedInProseExist) {
  for (const fs::path& page : pages()) EXPECT_THAT(absent_files(contents(page)), IsEmpty()) << page;
  EXPECT_THAT(absent_files("`tests/run` and\n`tests/absent.hpp`, `worlds/full_size*.json`, `out/table1`\n"),
              ElementsAre("2: tests/absent.hpp"));
}

TEST(Documentation, PagesThatSourcesCiteExist) {
  const std::vector<fs::path> sources = written({".cpp", ".hpp", ".h", ".json"});
  ASSERT_GT(sources.size(), 100U);
  for (const fs::path& source : sources) {
    if (source.filename() == "test_documentation.cpp") continue;  // it names one that is absent
    EXPECT_THAT(absent_pages(contents(source)), IsEmpty()) << source;
  }
  EXPECT_THAT(absent_pages("// framework/doc/effects.md, framework/doc/absent.md"),
              ElementsAre("framework/doc/absent.md"));
}

TEST(Documentation, ABrokenLinkIsSeen) {
  const fs::path page = root / "README.md";
  EXPECT_THAT(broken_links(page,
                           "[a](absent.md)\n\n```\n[b](absent.md)\n```\n[c](https://example.org) [d](LICENSE)\n"
                           "[e](tests/README.md#no-such-heading) [f](tests/README.md#tests)\n"),
              ElementsAre("1: absent.md", "7: tests/README.md#no-such-heading"));
}

TEST(Documentation, AWrongCommandIsSeen) {
  const std::string text =
      "`gripline race experiments/table1.json`, `gripline report out/table1`\n"
      "```sh\n"
      "gripline compare experiments/absent.json\n"
      "gripline compare experiments/table1.json \\\n"
      "  --only elm,best --set '/world=\"worlds/absent.json\"'\n"
      "gripline compare experiments/table1.json --only elm,oracle\n"
      "```\n";
  EXPECT_THAT(wrong_commands(text, {"compare", "report"}),
              testing::UnorderedElementsAre("1: no command race", "3: no file experiments/absent.json",
                                            "4: no file worlds/absent.json", "4: no stack best"));
}

}  // namespace test_documentation
}  // namespace gripline
