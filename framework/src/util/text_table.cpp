#include "util/text_table.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "util/numbers.hpp"

namespace gripline {

std::string cell_text(const std::optional<double>& value, const char* pattern) {
  if (!value || std::isnan(*value)) return "-";
  std::string shown = pattern;
  // A car that left the plane by light years fills no line with digits.
  if (const std::size_t digits = shown.find('.'); std::abs(*value) >= 1e6 && shown.find('f') == digits + 2)
    shown.replace(digits, 3, ".4g");
  return format(shown.c_str(), *value);
}

void print_aligned(std::ostream& out, const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string pad(width[i] - row[i].size(), ' ');
      line += i == 0 ? row[i] + pad : "  " + pad + row[i];
    }
    out << line << '\n';
  }
}

}  // namespace gripline
