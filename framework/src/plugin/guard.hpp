// Exceptions of plugins are caught here and thrown again as PluginFailure, with the plugin's name.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#if defined(__SSE2__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

#include "util/numbers.hpp"

namespace gripline {

/// A plugin threw, or returned something that is not a number: the run ends with status plugin_error.
class PluginFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws a PluginFailure that says who, when and what it returned unless all numbers are finite.
void require_finite(const std::string& who, double t, const char* what, std::initializer_list<double> numbers);

/// A short text that one process writes and another may read at any time (shared memory); longer ones are cut.
class SharedText {
 public:
  void set(std::string_view text) {
    const std::size_t size = std::min(text.size(), letters_.size() - 1);
    for (std::size_t i = 0; i < size; ++i) letters_[i].store(text[i], std::memory_order_relaxed);
    letters_[size].store('\0', std::memory_order_relaxed);
  }
  /// Copies at most `size` characters, the final zero included. Safe in a signal handler.
  void copy(char* text, std::size_t size) const {
    std::size_t i = 0;
    for (; i + 1 < std::min(size, letters_.size()); ++i) {
      text[i] = letters_[i].load(std::memory_order_relaxed);
      if (text[i] == '\0') return;
    }
    text[i] = '\0';
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

/// What a process did with a plugin last: for the message when that ends the process. One process writes it and another
/// may read it at any time (shared memory), also after the first was killed.
struct LastCall {
  enum class Phase : std::uint8_t { being_made, made, called, being_destroyed };

  SharedText who;
  std::atomic<Phase> phase{Phase::being_made};
  std::atomic<double> t{0.0};  // [s] of the world, where the phase is `called`

  /// What has no name is not noted: a stack without an estimator calls one.
  void note(std::string_view name, Phase reached) {
    if (name.empty()) return;
    who.set(name);
    phase.store(reached, std::memory_order_relaxed);
  }
  void note_call(std::string_view name, double time) {
    if (!name.empty()) t.store(time, std::memory_order_relaxed);
    note(name, Phase::called);
  }
};
static_assert(std::atomic<LastCall::Phase>::is_always_lock_free && std::atomic<double>::is_always_lock_free);

/// Where guard() notes each call, in memory shared with the waiting process; null: not at all. A process runs one race.
inline LastCall*& last_call() {
  static LastCall* place = nullptr;
  return place;
}

/// " at t = 0.4 s; the plugin called last was elm", " while elm was made", " while elm was destroyed", "; the plugin
/// made last was elm": where a process was, after words on how it ended; empty when it called no plugin.
std::string describe_place(const LastCall& last);

/// Rounding mode and treatment of subnormal numbers of this thread: results depend on both.
inline unsigned arithmetic_mode() {
#if defined(__SSE2__)
  return _mm_getcsr() & 0xffc0U;  // without the flags that say what happened
#else
  return static_cast<unsigned>(std::fegetround());
#endif
}
/// Restores a mode that arithmetic_mode() returned.
inline void set_arithmetic_mode(unsigned mode) {
#if defined(__SSE2__)
  _mm_setcsr((_mm_getcsr() & ~0xffc0U) | mode);
#else
  std::fesetround(static_cast<int>(mode));
#endif
}

/// Calls f; an exception becomes a PluginFailure that says who and when,
/// and so does a changed arithmetic mode, which is restored first.
template <class F>
decltype(auto) guard(const std::string& who, double t, F&& f) {
  if (LastCall* const call = last_call(); call != nullptr) call->note_call(who, t);
  const auto fail = [&](const std::string& what) -> PluginFailure {
    return PluginFailure(who + format(" at t = %f s: ", t) + what);
  };
  const unsigned mode = arithmetic_mode();
  const auto check = [&] {
    if (arithmetic_mode() == mode) return;
    set_arithmetic_mode(mode);
    throw fail("changed how this process rounds numbers");
  };
  try {
    if constexpr (std::is_void_v<decltype(f())>) {
      std::forward<F>(f)();
      check();
    } else {
      decltype(auto) result = std::forward<F>(f)();
      check();
      return result;
    }
  } catch (const PluginFailure&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw fail("ran out of memory");
  } catch (const std::exception& e) {
    throw fail(e.what());
  } catch (...) {
    throw fail("threw something that is not a std::exception");
  }
}

}  // namespace gripline
