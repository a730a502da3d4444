// Ends the program with one message, instead of an illegal instruction, on a CPU that lacks what it was built for.
// Compiled for the oldest x86-64 CPU (tools/CMakeLists.txt) and run before any other code of the program.
#include <unistd.h>

#include <cstring>

#ifdef GRIPLINE_NEEDS_X86_64_V3
namespace {

// 101 is the first priority that is not reserved: before the constructors of C++ objects with static lifetime.
[[gnu::constructor(101)]] void refuse_older_cpu() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
  constexpr char message[] =
      "gripline: built for x86-64-v3 (AVX2, FMA, BMI2), which this CPU lacks; configure with -DGRIPLINE_ARCH=x86-64\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message, std::strlen(message));
  _exit(2);
}

}  // namespace
#endif
