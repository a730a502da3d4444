// A libFuzzer program for one target: fuzz_<target> [options] CORPUS...
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const gripline::fuzz::Target* const target = gripline::fuzz::find_target(GRIPLINE_FUZZ_TARGET);
  target->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
