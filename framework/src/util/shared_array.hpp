// Memory that this process shares with the processes forked from it.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace gripline {

/// `count` values of T, made before the fork; use atomics in T. What a process writes the others read, also after its
/// end.
template <class T>
class SharedArray {
 public:
  /// Throws std::runtime_error with the system's reason.
  explicit SharedArray(std::size_t count) : size_(count) {
    void* const memory = mmap(nullptr, bytes(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error(std::string("no shared memory: ") + std::strerror(errno));
    values_ = static_cast<T*>(memory);
    for (std::size_t i = 0; i < size_; ++i) new (values_ + i) T;
  }
  ~SharedArray() {
    std::destroy_n(values_, size_);
    munmap(values_, bytes());
  }
  SharedArray(const SharedArray&) = delete;
  SharedArray& operator=(const SharedArray&) = delete;

  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }

 private:
  std::size_t bytes() const { return std::max<std::size_t>(size_, 1) * sizeof(T); }  // mmap refuses none

  std::size_t size_;
  T* values_ = nullptr;
};

}  // namespace gripline
