// A map in the making: what is guessed so far of a logger's table, and what its columns are by name, unit and range.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "config/node.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::measured {

/// Columns are indices into the table, -1 for none.
struct GuessDraft {
  explicit GuessDraft(const DelimitedTable& of) : table(of) {}

  /// The column that is called as this channel or other quantity (names_of) and is not zero throughout, or -1. By its
  /// whole name, or where none is, by the last words of a path: of commands first those that a path calls so.
  int column(const char* channel) const;
  /// Whether u and v are the forward and the lateral velocity: v alone is a speed, and u beside a v may be an input.
  bool has_u_and_v() const;
  const std::vector<double>& values(int c) const { return table.column[static_cast<std::size_t>(c)]; }
  const std::string& name(int c) const { return table.name[static_cast<std::size_t>(c)]; }
  /// The name as a formula has it: in backquotes where it is not a word.
  std::string quoted(int c) const;
  /// What the source says that a column is, or its name.
  const std::string& known_as(std::size_t c) const;
  /// The unit that the name ends with, if it is one of the kind wanted; else "".
  std::string unit_of_name(int c, const char* wanted) const;
  /// The unit in the header, or in the name's ending, if it is one of the kind wanted; else that, with a remark.
  std::string unit_of(int c, const char* wanted);
  /// Of the finite values; the first is the larger where there are none.
  std::pair<double, double> range(std::size_t c) const;
  bool varies(std::size_t c) const;
  /// In how many rows a value repeats (rows_between_new); 1 without a time or such a column.
  double rows_between_new_values(int c) const;

  bool found(const char* channel) const { return channels.find(channel) != nullptr; }
  /// Whether the time or a channel has this column.
  bool taken(int c) const;
  /// Guesses a channel whose column needs no look at its numbers.
  void guess_column(const char* channel, const char* unit);
  /// A channel that the map must have, and nothing here looks like: `what` it is, in words. `rising`: its values never
  /// fall.
  Node unnamed(const char* channel, const char* what, const char* unit, bool rising = false);

  const DelimitedTable& table;
  Node time, channels{Node::Object{}};     // of the map
  std::vector<std::string> remarks, open;  // as Guess has them

 private:
  int column_by_name(const char* channel) const;
  int column_by_path(const char* channel) const;
  bool is_zero(std::size_t c) const;
  bool falls(std::size_t c) const;
  std::string candidates(bool rising) const;
};

/// A channel of the map: `key` is "column" or "formula"; `delay`: its delay is to be found.
Node guessed_channel(const std::string& key, const std::string& what, const std::string& unit, bool delay = true);

/// Quantile of the sizes of the values that are there; 0 where none are.
double quantile_of_size(const std::vector<double>& values, double q);

}  // namespace gripline::measured
