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
  const double t = last.t.load(std::memory_order_relaxed);
  if (who.empty()) return {};
  if (std::isnan(t)) return " while " + who + " was made";
  if (std::isinf(t) && t < 0) return "; the plugin made last was " + who;
  if (std::isinf(t)) return " while " + who + " was destroyed";
  return format(" at t = %f s; the plugin called last was ", t) + who;
}

}  // namespace gripline
