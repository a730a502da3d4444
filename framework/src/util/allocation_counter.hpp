// Counts what a stretch of code allocates, plugins included: malloc itself is counted, since Eigen goes past new.
// Include in one source file of a program: it replaces malloc. AddressSanitizer has its own: then nothing is counted.
#pragma once

#include <atomic>
#include <cstddef>

namespace gripline {

inline std::atomic<long> allocations{0};

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool counts_allocations = false;
#else
inline constexpr bool counts_allocations = true;
#endif

}  // namespace gripline

#if !defined(__SANITIZE_ADDRESS__)
extern "C" {
void* __libc_malloc(std::size_t size);                       // NOLINT(bugprone-reserved-identifier): glibc's own name
void* __libc_memalign(std::size_t align, std::size_t size);  // NOLINT(bugprone-reserved-identifier)
void* malloc(std::size_t size) noexcept {
  gripline::allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* aligned_alloc(std::size_t align, std::size_t size) noexcept {
  gripline::allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(align, size);
}
}
#endif
