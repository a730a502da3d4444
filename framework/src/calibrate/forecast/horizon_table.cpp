#include "calibrate/forecast/horizon_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <random>

#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace {

constexpr double block = 10.0;  // [s]

/// Squared errors of one model. At least one in every block.
struct SquareSum {
  double square = 0;
  std::size_t count = 0;
  double figure() const { return std::sqrt(square / static_cast<double>(count)); }
  void add(const SquareSum& b) { square += b.square, count += b.count; }
};

/// Squared errors of two models at the same starts.
struct PairedSum {
  double one = 0, two = 0;
  std::size_t count = 0;
  double figure() const {
    return (std::sqrt(two) - std::sqrt(one)) / std::sqrt(static_cast<double>(std::max<std::size_t>(1, count)));
  }
  void add(const PairedSum& b) { one += b.one, two += b.two, count += b.count; }
};

/// Squared error of a quantity of one start; NaN where it was not measured.
double square_of(std::size_t quantity, const double* predicted, const double* truth) {
  if (quantity == 0) {
    const double dx = predicted[0] - truth[0], dy = predicted[1] - truth[1];
    return dx * dx + dy * dy;
  }
  const std::size_t c = quantity + 1;
  const double e = measured::difference_of(c, predicted[c], truth[c]);
  return e * e;
}

/// The 95 % interval of a figure of sums, by sums of blocks drawn with replacement.
template <class Sum>
void set_interval(HorizonError& out, const std::map<long, Sum>& blocks) {
  constexpr int draws = 400;
  std::vector<Sum> all;
  all.reserve(blocks.size());
  for (const auto& [when, sum] : blocks) all.push_back(sum);
  std::mt19937 random(1);
  std::vector<double> drawn;
  for (int i = 0; i < draws; ++i) {
    Sum some;
    for (std::size_t b = 0; b < all.size(); ++b) some.add(all[random() % all.size()]);
    drawn.push_back(some.figure());
  }
  std::sort(drawn.begin(), drawn.end());
  out.low = drawn[draws / 40];
  out.high = drawn[draws - 1 - draws / 40];
}

HorizonError error_of(const std::map<long, SquareSum>& blocks) {
  HorizonError out;
  SquareSum total;
  for (const auto& [when, sum] : blocks) total.add(sum);
  out.count = total.count;
  if (total.count == 0) {
    out.rms = out.low = out.high = NAN;
    return out;
  }
  out.rms = total.figure();
  set_interval(out, blocks);
  return out;
}

}  // namespace

HorizonRow horizon_row(std::string name, std::span<const double> start_time, std::span<const double> predicted,
                       std::span<const double> truth) {
  HorizonRow row;
  row.name = std::move(name);
  for (std::size_t q = 0; q < quantities; ++q) {
    std::map<long, SquareSum> blocks;
    for (std::size_t i = 0; i < start_time.size(); ++i) {
      const double square = square_of(q, predicted.data() + i * channels, truth.data() + i * channels);
      if (std::isnan(square)) continue;
      blocks[std::lround(std::floor((start_time[i] - start_time.front()) / block))].add({square, 1});
    }
    row.error[q] = error_of(blocks);
  }
  return row;
}

HorizonError paired_change(std::span<const double> start_time, std::span<const double> predicted,
                           std::span<const double> other, std::span<const double> truth, std::size_t quantity) {
  std::map<long, PairedSum> blocks;
  PairedSum total;
  for (std::size_t i = 0; i < start_time.size(); ++i) {
    const double one = square_of(quantity, predicted.data() + i * channels, truth.data() + i * channels);
    const double two = square_of(quantity, other.data() + i * channels, truth.data() + i * channels);
    if (std::isnan(one + two)) continue;
    const PairedSum here{one, two, 1};
    blocks[std::lround(std::floor((start_time[i] - start_time.front()) / block))].add(here);
    total.add(here);
  }
  HorizonError out;
  out.count = total.count;
  out.rms = out.low = out.high = total.count > 0 ? total.figure() : NAN;
  if (total.count == 0) return out;
  set_interval(out, blocks);
  return out;
}

void print_horizon_table(std::ostream& out, std::span<const HorizonRow> rows) {
  std::size_t width = 8;
  for (const HorizonRow& row : rows) width = std::max(width, row.name.size());
  out << std::string(width, ' ');
  for (const char* name : quantity_names) out << format("  %-24s", name);
  out << '\n';
  for (const HorizonRow& row : rows) {
    out << row.name << std::string(width - row.name.size(), ' ');
    for (const HorizonError& e : row.error) {
      // One wild reading in a log makes errors of any size.
      const bool wide = std::max(e.rms, e.high) >= 1e5;
      const char* const pattern = wide ? "  %7.3g (%.3g..%.3g)" : "  %7.4f (%.4f..%.4f)";
      const std::string cell = e.count == 0 ? "  -" : format(pattern, e.rms, e.low, e.high);
      out << format("%-26s", cell.c_str());
    }
    out << '\n';
  }
}

}  // namespace gripline::calibrate
