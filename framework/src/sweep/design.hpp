// Which settings a sweep has: values of factors, each a JSON pointer into the expanded experiment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/node.hpp"

namespace gripline::sweep {

struct Factor {
  std::string pointer;              // "/base/planner/params/pace"
  std::vector<std::string> levels;  // as `--set` takes them, JSON or text; empty for a range
  double lo = 0, hi = 0;            // of a range, "lo..hi"
  bool range() const { return levels.empty(); }
};

/// "a,b,c" at commas that no bracket and no quote encloses. Throws InputError when a level is empty.
std::vector<std::string> split_levels(std::string_view text);
/// "/pointer=a,b,c" or "/pointer=lo..hi". Throws InputError.
Factor parse_factor(const std::string& assignment);
/// "1..50", "1,2,7", "1..3,10": ascending within each part, in the order given. Throws InputError,
/// also for a seed given twice.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

/// Where a value stands in a CSV file.
struct ListPlace {
  std::string file;  ///< as shown to the user
  int line = 0, column = 0;
};

/// Numbered settings, each computed from its number alone, so that memory does not grow with their count (except for a
/// list).
class Design {
 public:
  enum class Kind { factorial, latin, list };
  /// Every combination; the last factor changes fastest. Ranges are refused (InputError).
  static Design factorial(std::vector<Factor> factors);
  /// Latin hypercube (McKay, Beckman, Conover, Technometrics 21, 1979): of `count` equal parts of every factor's range
  /// each is taken once, at a place drawn within it. Levels share the parts between them.
  static Design latin(std::vector<Factor> factors, std::size_t count, std::uint64_t seed);
  /// A CSV file: JSON pointers in its header, a setting in every row. Throws InputError with file and line.
  static Design list(const std::filesystem::path& file);

  Kind kind() const { return kind_; }
  const std::vector<Factor>& factors() const { return factors_; }
  std::size_t size() const { return size_; }
  /// The value of every factor in setting `index`, in the order of factors().
  std::vector<std::string> setting(std::size_t index) const;
  /// Where the value of factor `factor` in setting `index` stands; only of a list(), not of one read back from a node.
  std::optional<ListPlace> place(std::size_t index, std::size_t factor) const;

  Node to_node() const;
  /// Throws std::exception where something is missing or of another type.
  static Design from_node(const Node& node);

 private:
  Kind kind_ = Kind::factorial;
  std::vector<Factor> factors_;
  std::size_t size_ = 1;
  std::uint64_t seed_ = 0;
  std::vector<std::string> rows_;  // of a list
  std::string file_;               // that was read, as shown to the user
  std::vector<int> lines_;         // of its rows
};

/// Assignments of a sweep stand in the order in which they are carried out: "/pointer=VALUE" is the same in every
/// setting, a pointer alone is a factor, which has the setting's value; factors that are not named follow. This gives
/// all of them with these values of the factors. Throws InputError where no factor has such a pointer.
std::vector<std::string> assignments_of(const std::vector<std::string>& given, const Design& design,
                                        const std::vector<std::string>& values);
std::vector<std::string> assignments_of(const std::vector<std::string>& given, const Design& design,
                                        std::size_t setting);
/// How many of them stand before the first factor.
std::size_t constants_before_factors(const std::vector<std::string>& given);
/// Throws InputError where one would replace what a factor before it sets, and where a list, whose columns are carried
/// out last, would replace what one of them sets.
void require_effect(const std::vector<std::string>& given, const Design& design);

/// Position of `index` in a permutation of 0 .. count - 1 that `seed` chooses: a Feistel network over the next power of
/// four, walked until it stays below `count` (Black, Rogaway, "Ciphers with arbitrary finite domains", 2002).
std::uint64_t permuted(std::uint64_t index, std::uint64_t count, std::uint64_t seed);

}  // namespace gripline::sweep
