// gripline columns [FILE]: what the columns of the results' tables mean.
#include <algorithm>
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "experiment/column_docs.hpp"
#include "gripline/command.hpp"

namespace gripline::tools {
namespace po = boost::program_options;

int run_columns(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("markdown", "as framework/doc/columns.md");
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(args, visible, "columns [FILE] [options]", "file");
  if (!given) return good;
  if (given->count("markdown") > 0) {
    std::cout << columns_page();
    return good;
  }
  const Words asked = words_of(*given, "file");
  const std::vector<std::string> known = documented_files();
  for (const std::string& file : asked)
    if (std::find(known.begin(), known.end(), file) == known.end())
      throw InputError("no table \"" + file + "\"" + did_you_mean(file, known));
  const Words& shown = asked.empty() ? known : asked;
  const auto padded = [](std::string text, std::size_t width) {
    return text.append(std::max<std::size_t>(2, width - std::min(width, text.size())), ' ');
  };
  for (const std::string& file : shown) {
    std::cout << (&file == &shown.front() ? "" : "\n") << file << '\n';
    for (const ColumnDoc* column : columns_of(file)) {
      const std::string meaning = column->meaning, over = column->of_rows;
      std::cout << "  " << padded(column->name, 29) << padded(column->unit, 11) << meaning
                << (file == "table.csv" && !over.empty() ? " (" + over + ")" : "") << '\n';
    }
  }
  return good;
}

}  // namespace gripline::tools
