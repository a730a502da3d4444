#include "measured/session/guess_heading.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "config/units.hpp"
#include "measured/table/formula.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;

/// By row, as the map makes it [rad]; empty without one.
Values heading_of(const GuessDraft& draft) {
  const Node* const yaw = draft.channels.find("yaw");
  if (yaw == nullptr) return {};
  const Node* const made = yaw->find("formula");
  const int c = draft.column("yaw");
  if (made != nullptr && c >= 0 && draft.name(c).find('`') != std::string::npos) return {};  // no formula can name it
  Values out = made != nullptr ? Formula(made->text(), draft.table, "yaw").evaluate(draft.table, {}) : draft.values(c);
  const double radian = to_si("1 " + yaw->find("unit")->text(), "rad");
  for (double& v : out) v *= radian;
  return out;
}

}  // namespace

Correlation heading_follows(const GuessDraft& draft, int column) {
  constexpr std::size_t long_enough = 10;  // rows
  Correlation out;
  const Values &follower = draft.values(column), yaw = heading_of(draft);
  double last = not_a_number, turned = 0.0, sum = 0.0, count = 0.0;
  std::size_t from = 0;
  for (std::size_t i = 0; i < yaw.size(); ++i) {
    if (!std::isnan(follower[i])) sum += follower[i], count += 1.0;
    if (std::isnan(yaw[i])) continue;
    turned += std::remainder(yaw[i] - last, 2.0 * std::numbers::pi);
    last = yaw[i];
    if (i - from < long_enough) continue;
    if (std::isfinite(turned) && count > 0.0) out.add(sum / count, turned / static_cast<double>(i - from));
    from = i;
    turned = sum = count = 0.0;
  }
  return out;
}

}  // namespace gripline::measured
