// The one place where a plugin's exception becomes ours.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace gripline {

/// A plugin threw, or returned something that is no number: the run ends with status plugin_error.
class PluginFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Calls f; an exception becomes a PluginFailure that says who and when.
template <class F>
decltype(auto) guard(const std::string& who, double t, F&& f) {
  const auto fail = [&](const std::string& what) -> PluginFailure {
    return PluginFailure(who + " at t = " + std::to_string(t) + " s: " + what);
  };
  try {
    return std::forward<F>(f)();
  } catch (const PluginFailure&) {
    throw;
  } catch (const std::exception& e) {
    throw fail(e.what());
  } catch (...) {
    throw fail("threw something that is not a std::exception");
  }
}

}  // namespace gripline
