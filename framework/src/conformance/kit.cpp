#include "conformance/kit.hpp"

#include <algorithm>
#include <chrono>

#include "config/errors.hpp"
#include "plugin/registry.hpp"
#include "util/numbers.hpp"
#include "util/temporary_folder.hpp"

namespace gripline::conformance {
namespace fs = std::filesystem;
namespace {

constexpr double slow_opening_s = 0.1;  // [s of CPU]: a hundred libraries in a folder still open in ten

/// Where the library stands alone, and a cache of one's own.
class LibraryFolder {
 public:
  explicit LibraryFolder(const fs::path& library) {
    fs::create_directory(cache());
    fs::create_directory(alone());
    fs::create_symlink(fs::canonical(library), alone() / "plugin.so");
  }
  fs::path alone() const { return folder_.path() / "library"; }
  fs::path cache() const { return folder_.path() / "cache"; }

 private:
  TemporaryFolder folder_{"check"};
};

/// Gives verdicts, and keeps them.
class Judge {
 public:
  explicit Judge(const std::function<void(const Verdict&)>& tell) : tell_(tell) {}
  void ask(const std::string& plugin, const std::string& check, const std::function<std::string()>& question) {
    Verdict verdict{plugin, check, true, {}, 0};
    const auto begin = std::chrono::steady_clock::now();
    try {
      verdict.words = question();
    } catch (const Broken& broken) {
      verdict.passed = false;
      verdict.words = broken.what();
    }
    verdict.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::replace(verdict.words.begin(), verdict.words.end(), '\n', ' ');
    tell_(verdict);
    verdicts_.push_back(verdict);
  }
  std::vector<Verdict> take() { return std::move(verdicts_); }

 private:
  const std::function<void(const Verdict&)>& tell_;
  std::vector<Verdict> verdicts_;
};

void require_checks(const std::vector<std::string>& names) {
  std::vector<std::string> known = {"loads"};
  for (const Check& check : checks()) known.emplace_back(check.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("no check \"" + name + "\"" + did_you_mean(name, known));
}

std::string opens_fast(const Workshop& workshop) {
  const double spent = opening_time(workshop);
  std::string words = format("opened in %.1f ms", 1e3 * spent);
  if (spent > slow_opening_s)
    throw Broken(words + " of CPU, at most 100 are expected: no work before the first instance is made");
  return words;
}

}  // namespace

std::vector<Verdict> check_library(const fs::path& library, const KitOptions& options,
                                   const std::function<void(const Verdict&)>& tell) {
  std::error_code failed;
  if (!fs::is_regular_file(library, failed))
    throw InputError(library.string() + ": no such library; expected what gripline_add_plugin builds, name.so");
  require_checks(options.only);
  const LibraryFolder folder(library);
  const Workshop workshop{folder.alone(), folder.cache(), options.allocations};
  const auto wanted = [&](const std::string& name) {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  };
  Judge judge(tell);
  std::vector<Subject> subjects;
  judge.ask("", "loads", [&] {
    subjects = subjects_in(workshop);
    return wanted("loads") ? opens_fast(workshop) : std::string();
  });
  for (const Subject& subject : subjects)
    for (const Check& check : checks())
      if (wanted(check.name) && (check.kinds >> static_cast<unsigned>(subject.kind) & 1u) != 0)
        judge.ask(std::string(kind_name(subject.kind)) + " " + subject.id, check.name,
                  [&] { return check.run(workshop, subject); });
  return judge.take();
}

}  // namespace gripline::conformance
