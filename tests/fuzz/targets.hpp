// What the fuzzers feed with bytes of any kind: each reads them as one kind of input and demands that they are taken or
// refused with a place. Plain functions, so that a fuzzer and a test that replays what fuzzers found call the same.
#pragma once

#include <span>
#include <stdexcept>
#include <string_view>

namespace gripline::fuzz {

/// Bytes that were neither taken nor refused as they should be.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

struct Target {
  const char* name;
  /// Throws Finding; any other exception is one as well.
  void (*run)(std::string_view bytes);
};

std::span<const Target> targets();
/// Null when there is none of that name.
const Target* find_target(std::string_view name);

}  // namespace gripline::fuzz
