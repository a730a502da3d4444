// The one place where a plugin's exception becomes ours.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace gripline {

/// A plugin threw, or returned something that is no number: the run ends with status plugin_error.
class PluginFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A short text that one process writes and another may read at any time; never longer than its room.
class SharedText {
 public:
  void set(std::string_view text) {
    const std::size_t size = std::min(text.size(), letters_.size() - 1);
    for (std::size_t i = 0; i < size; ++i) letters_[i].store(text[i], std::memory_order_relaxed);
    letters_[size].store('\0', std::memory_order_relaxed);
  }
  std::string get() const {
    std::string text;
    for (const std::atomic<char>& letter : letters_) {
      const char c = letter.load(std::memory_order_relaxed);
      if (c == '\0') break;
      text += c;
    }
    return text;
  }

 private:
  std::array<std::atomic<char>, 64> letters_{};
};

/// Which plugin a process called last, and when on the world's clock: what is left to tell when it dies in there.
struct LastCall {
  SharedText who;
  std::atomic<double> t{NAN};  // [s]; NaN while an instance is made
  void note(std::string_view name, double time) {
    if (name.empty()) return;
    who.set(name);
    t.store(time, std::memory_order_relaxed);
  }
};

/// Where this process notes it; null: nowhere. A process runs one race, and its death leaves no other trace.
inline LastCall*& last_call() {
  static LastCall* place = nullptr;
  return place;
}

/// Calls f; an exception becomes a PluginFailure that says who and when.
template <class F>
decltype(auto) guard(const std::string& who, double t, F&& f) {
  if (LastCall* const call = last_call(); call != nullptr) call->note(who, t);
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
