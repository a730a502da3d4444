#include "plugin/guard.hpp"

namespace gripline {

void require_finite(const std::string& who, double t, const char* what, std::initializer_list<double> numbers) {
  for (const double number : numbers)
    if (!std::isfinite(number))
      throw PluginFailure(who + format(" at t = %f s: returned %s that is not ", t, what) +
                          (std::isnan(number) ? "a number" : "finite"));
}

std::string describe_place(const LastCall& last) {
  const std::string who = last.who.get();
  if (who.empty()) return {};
  switch (last.phase.load(std::memory_order_relaxed)) {
    case LastCall::Phase::being_made:
      return " while " + who + " was made";
    case LastCall::Phase::made:
      return "; the plugin made last was " + who;
    case LastCall::Phase::being_destroyed:
      return " while " + who + " was destroyed";
    case LastCall::Phase::called:
      break;
  }
  return format(" at t = %f s; the plugin called last was ", last.t.load(std::memory_order_relaxed)) + who;
}

}  // namespace gripline
