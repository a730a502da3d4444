// The guessed map of a log of columns by their names.
#pragma once

#include <algorithm>
#include <fstream>
#include <string>

#include "measured/session/log_guess.hpp"
#include "support/scratch.hpp"

namespace gripline::test {

/// The map of a log of these columns, each with the values 0, 0.01, 0.02 and so on.
inline measured::Guess guess_of_columns(const std::string& header) {
  const auto file = testing_support::scratch("columns.csv");
  std::ofstream out(file);
  out << header << '\n';
  const auto columns = std::count(header.begin(), header.end(), ',') + 1;
  for (int k = 0; k < 100; ++k)
    for (int c = 0; c < columns; ++c) out << 0.01 * k << (c + 1 < columns ? ',' : '\n');
  out.close();
  return measured::guess_map(read_delimited(file));
}

}  // namespace gripline::test
