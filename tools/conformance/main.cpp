// gripline-check, the program behind `gripline plugins check`: a separate one, because it replaces malloc.
#include <algorithm>
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "conformance/kit.hpp"
#include "util/allocation_counter.hpp"
#include "util/numbers.hpp"

namespace gripline::tools {
namespace {

namespace po = boost::program_options;
using conformance::Verdict;

std::int64_t count_allocations() { return allocations.load(std::memory_order_relaxed); }

void list_checks() {
  std::cout << "loads          the library is a plugin's, and opens in 0.1 s of CPU\n";
  for (const conformance::Check& check : conformance::checks())
    std::cout << check.name << std::string(15 - std::string(check.name).size(), ' ') << check.asks << '\n';
}

/// Prints verdicts as they come, under the plugin's name.
class Printer {
 public:
  void operator()(const Verdict& verdict) {
    if (verdict.plugin != plugin_) std::cout << verdict.plugin << '\n';
    plugin_ = verdict.plugin;
    std::cout << format("  %-6s  %-13s  %5.1f s  ", verdict.passed ? "passed" : "FAILED", verdict.check.c_str(),
                        verdict.seconds)
              << verdict.words << std::endl;
  }

 private:
  std::string plugin_;
};

int run(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("only", po::value<Words>()->composing(), "this check only; may be repeated");
  add("list", "the checks, and what each asks");
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "plugins check LIBRARY.so [options]", "library");
  if (!given) return good;
  if (given->count("list") > 0) {
    list_checks();
    return good;
  }
  const Words libraries = words_of(*given, "library");
  if (libraries.size() != 1) throw InputError("which library? plugins check LIBRARY.so, one at a time");
  conformance::KitOptions options;
  options.only = words_of(*given, "only");
  if (counts_allocations) options.allocations = count_allocations;
  Printer print;
  const std::vector<Verdict> verdicts =
      conformance::check_library(libraries[0], options, [&](const Verdict& verdict) { print(verdict); });
  const auto failed = std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.passed; });
  std::cout << verdicts.size() - static_cast<std::size_t>(failed) << " of " << verdicts.size() << " checks passed\n";
  if (!verdicts.front().passed) return plugin_unusable;
  return failed == 0 ? good : claim_failed;
}

}  // namespace
}  // namespace gripline::tools

int main(int argc, char** argv) {
  return gripline::tools::run_program(argc, argv, gripline::tools::run, "gripline plugins check");
}
