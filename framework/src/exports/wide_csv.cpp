#include "exports/wide_csv.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "util/csv_cell.hpp"
#include "util/csv_writer.hpp"

namespace gripline::exports {
namespace {

constexpr double same_instant = 1e-6;  // [s]

/// Every time at which any run has a step, ascending.
std::vector<double> all_times(std::span<const NamedRun> runs) {
  std::vector<double> times;
  for (const NamedRun& run : runs)
    for (const double t : run.steps.numbers("t_s"))
      if (std::isfinite(t)) times.push_back(t);
  std::sort(times.begin(), times.end());
  std::vector<double> apart;
  for (const double t : times)
    if (apart.empty() || t - apart.back() > same_instant) apart.push_back(t);
  return apart;
}

std::string header_line(std::span<const NamedRun> runs) {
  std::string text = "t_s";
  for (const NamedRun& run : runs)
    for (const std::string& column : run.steps.names())
      if (column != "t_s") text.append(",").append(csv_cell(run.name + "/" + column));
  return text;
}

void write_rows(std::span<const NamedRun> runs, std::string& text) {
  CsvWriter out(text, header_line(runs));
  std::vector<std::size_t> at(runs.size(), 0);
  for (const double t : all_times(runs)) {
    out << t;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const report::Columns& steps = runs[i].steps;
      const std::span<const double> times = steps.numbers("t_s");
      while (at[i] < times.size() && !(times[at[i]] >= t - same_instant)) ++at[i];
      const bool there = at[i] < times.size() && times[at[i]] <= t + same_instant;
      for (const std::string& column : steps.names())
        if (column != "t_s") out << (there ? steps.number(column, at[i]) : std::nan(""));
    }
    out.end_row();
  }
}

}  // namespace

std::string wide_csv(std::span<const NamedRun> runs) {
  std::string text;
  write_rows(runs, text);
  return text;
}

}  // namespace gripline::exports
