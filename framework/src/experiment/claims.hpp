// Claims that must hold between the rows of a table: "elm.violation_s <= none.violation_s".
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/reader.hpp"

namespace gripline {

/// One side: factor * stack.column + offset; a plain number has no stack.
struct ClaimTerm {
  double factor = 1.0;
  std::string stack, column;
  double offset = 0.0;
};
struct Claim {
  enum class Relation { less, less_equal, greater, greater_equal, equal };
  std::string text;
  Origin at;  // where it is written
  ClaimTerm left, right;
  Relation relation = Relation::less_equal;
  /// About CPU time: only meaningful when runs do not share the machine.
  bool about_time() const;
  /// Names an end of an interval over runs, which single runs do not have.
  bool about_interval() const;
  /// Whether it can be asked of each run: it names no end of an interval and no sum or largest value over runs. Five
  /// runs that finished are "a.finished == 5", of which none alone is.
  bool about_single_runs() const;
};

/// Parses "[number *] stack.column [+|- number] <relation> ..." and checks rows and columns; errors go to the node's
/// place with the nearest known name.
/// `columns`: what a table of another kind has instead of the columns of a race (race_columns.hpp).
std::optional<Claim> read_claim(const Node& node, std::span<const std::string> stacks, Errors& errors,
                                std::span<const std::string> columns = {});

/// Looks a value up: (stack, column, run); a run of -1 is the median over runs. Empty when it was not measured.
using ClaimLookup = std::function<std::optional<double>(const std::string&, const std::string&, int)>;

struct ClaimResult {
  std::string text;
  std::optional<bool> holds;  // empty: skipped
  std::string why_skipped;
  std::string note;                   // what else a reader must know of it; may be empty
  std::optional<double> left, right;  // medians
  bool medians_hold = false;
  int runs_held = 0, runs = 0;
  double share = 0.0;  // of the runs in which it must hold
};
/// A claim holds if it holds for the medians and in at least `share` of the runs; one about the end of an interval, a
/// sum or a largest value over runs, if it holds for that.
ClaimResult judge(const Claim& claim, int runs, double share, const ClaimLookup& lookup);

}  // namespace gripline
