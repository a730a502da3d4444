// Everything that fuzzers found or begin with, and seeded mutations of it: taken or refused with a place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"
#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_fuzz_corpus {

using namespace testing_support;
namespace fs = std::filesystem;

struct Seed {
  std::string name, bytes;
};
std::vector<Seed> corpus(const std::string& target) {
  std::vector<Seed> seeds;
  const fs::path folder = fixture_dir().parent_path() / "fuzz/corpus" / target;
  for (const auto& entry : fs::directory_iterator(folder))
    seeds.push_back({entry.path().filename().string(), contents(entry.path())});
  std::sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.name < b.name; });
  return seeds;
}

/// One to four of: a flipped bit, a byte of another place, a piece cut out, a piece repeated, a number or sign put in.
std::string mutated(std::string bytes, std::mt19937_64& random) {
  static const std::vector<std::string> words = {"null", "1e308", "-1",  "nan", "\"\"",   "{}", "[]", ",",
                                                 "\n",   "\x00",  "0.0", "\"",  "999999", ";",  "-",  "1e-320"};
  const auto place = [&] { return bytes.empty() ? 0 : random() % bytes.size(); };
  for (std::uint64_t count = 1 + random() % 4; count > 0; --count) {
    const std::size_t at = place(), size = std::min<std::size_t>(random() % 40, bytes.size() - at);
    switch (random() % 5) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
        break;
      case 1:
        if (!bytes.empty()) bytes[at] = bytes[place()];
        break;
      case 2:
        bytes.erase(at, size);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, size));
        break;
      default:
        bytes.replace(at, std::min<std::size_t>(size, random() % 4), words[random() % words.size()]);
    }
  }
  return bytes;
}

/// How many are tried of each target: a second of them, or as many as somebody with more time asks for.
int mutations() {
  const char* const asked = std::getenv("GRIPLINE_FUZZ_INPUTS");
  return asked != nullptr ? std::atoi(asked) : 300;
}

class FuzzCorpus : public testing::TestWithParam<fuzz::Target> {};

TEST_P(FuzzCorpus, IsTakenOrRefused) {
  const fuzz::Target& target = GetParam();
  const std::vector<Seed> seeds = corpus(target.name);
  ASSERT_FALSE(seeds.empty());
  const auto run = [&](const std::string& bytes, const std::string& what) {
    try {
      target.run(bytes);
    } catch (const std::exception& error) {
      ADD_FAILURE() << target.name << ", " << what << ": " << error.what() << "\n" << bytes;
    }
  };
  for (const Seed& seed : seeds) run(seed.bytes, seed.name);
  std::mt19937_64 random(20);
  const int count = mutations() / (std::string_view(target.name) == "library" ? 15 : 1);  // each of those is a process
  for (int i = 0; i < count && !HasFailure(); ++i) {
    const Seed& seed = seeds[random() % seeds.size()];
    run(mutated(seed.bytes, random), seed.name + " mutated, number " + std::to_string(i));
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzCorpus, testing::ValuesIn(fuzz::targets().begin(), fuzz::targets().end()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace test_fuzz_corpus
}  // namespace gripline
