// Arithmetic over the columns of a table: how a map makes a channel of what a logger wrote.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tables/delimited_table.hpp"

namespace gripline::measured {

/// A formula that was read. Names are columns; a name with blanks or signs stands in backquotes, `Steering Angle`.
///
///   numbers, + - * / ^, brackets, comparisons and && || ! (1 or 0), pi,
///   abs sqrt sin cos tan atan exp log sign rad deg (one argument), min max atan2 mod (two), clamp(x, lo, hi),
///   if(condition, then, else), rate(x) (change per second of x, backward difference of rows),
///   hold(x) (the last value where cells are empty)
///
/// A missing cell makes the result missing, except in the branch that `if` does not choose and beside what decides
/// `&&` or `||` already.
class Formula {
 public:
  /// Throws InputError with the place in the text: unknown column (with the nearest name), syntax.
  /// `what` names the formula in messages.
  Formula(std::string_view text, const DelimitedTable& table, const std::string& what);

  /// One value per row. `time`: of the rows [s], for rate(); may be empty where rate() is not used.
  std::vector<double> evaluate(const DelimitedTable& table, const std::vector<double>& time) const;
  /// The columns it reads.
  const std::vector<std::size_t>& columns() const { return columns_; }

 private:
  using Values = std::vector<double>;
  struct Context {
    const DelimitedTable& table;
    const std::vector<double>& time;
  };
  using Step = std::function<Values(const Context&)>;
  friend class FormulaParser;

  Step root_;
  std::vector<std::size_t> columns_;
};

/// What a formula names in backquotes, in the order of writing.
std::vector<std::string> quoted_names(std::string_view formula);

}  // namespace gripline::measured
