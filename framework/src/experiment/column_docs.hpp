// Unit and meaning of every column of the tables of a race, for `gripline columns` and framework/doc/columns.md.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace gripline {

struct ColumnDoc {
  const char* files;    ///< where it stands, with blanks between: "runs.csv table.csv"
  const char* name;     ///< K stands for a number from 0
  const char* unit;     ///< "1" when pure, "" where it is not a quantity
  const char* of_rows;  ///< how table.csv sums up the runs of a row: "median", "sum", "largest"; else ""
  const char* meaning;  ///< one sentence
};

/// In the order of the files' headers.
std::span<const ColumnDoc> column_docs();
/// The files that have columns here, in the order of the documentation.
std::vector<std::string> documented_files();
std::vector<const ColumnDoc*> columns_of(const std::string& file);
/// A column of a header as it is documented: "lap12_s" as "lapK_s", "lap0_s_lo" as "COLUMN_lo".
std::string documented_name(const std::string& column);
/// framework/doc/columns.md.
std::string columns_page();

}  // namespace gripline
